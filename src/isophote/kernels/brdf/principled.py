"""glTF's metallic-roughness surface, with no energy lost: the mix of a metal and of a coated matte body.

    f = F D G / (4 cosθ_o cosθ_i) + ρ (1 − m) (1 − E_d(θ_o)) (1 − E_d(θ_i)) / (π (1 − Ē_d))
        + m F_m (1 − E(θ_o)) (1 − E(θ_i)) / (π (1 − Ē)),   F = f₀ + (1 − f₀)(1 − out · h)⁵,  f₀ = 0.04 (1 − m) + ρ m

E_d is what a dielectric of f₀ = 0.04 reflects and E what facets that reflect everything do; the last term gives back
what a metal's facets send to each other. Slots: colour ρ, metallic m, roughness (α = roughness²). Data: two tables A
and B as in albedo.py, for E = f₀ A + B. Sources: glTF 2.0, appendix B; Kulla, Conty: "Revisiting Physically Based
Shading at Imageworks", SIGGRAPH 2017 course.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.entry import entry
from isophote.kernels.base.jit import device
from isophote.kernels.base.vec import dot, normalise, vec3
from isophote.kernels.base.warp import INV_PI
from isophote.kernels.brdf.albedo import TABLE_WORDS, mean_albedo, table_albedo
from isophote.kernels.brdf.contract import (
    answer,
    answer_sample,
    colour_slot,
    cosine_direction,
    into_of,
    no_sample,
    number_slot,
    open_lobe,
    out_of,
    point_of,
    share_of,
)
from isophote.kernels.brdf.fresnel import schlick
from isophote.kernels.brdf.microfacet import alpha_of, density_of_normals, masking, visible_normal

__all__ = ["evaluate_principled", "sample_principled"]

_ZERO, _ONE, _TWO, _QUARTER = (np.float32(k) for k in (0, 1, 2, 0.25))
_COLOUR, _METALLIC, _ROUGHNESS = np.int64(0), np.int64(1), np.int64(2)
_A, _B = np.int64(0), np.int64(TABLE_WORDS)
_DIELECTRIC = np.float32(0.04)
# The mean of (1 − cosθ)⁵ over the hemisphere.
_MEAN_FIFTH = np.float32(1 / 21)
_TINY = np.float32(1e-6)


@device
def _white(value):
    return vec3(value, value, value)


@device
def _matte_parts(lobe, r, out_z, into_z):
    """π f of the body and of the light that a metal's facets send to each other."""
    colour, metallic = colour_slot(lobe, _COLOUR), number_slot(lobe, _METALLIC)
    a, b = table_albedo(lobe, _A, r, out_z), table_albedo(lobe, _B, r, out_z)
    a_into, b_into = table_albedo(lobe, _A, r, into_z), table_albedo(lobe, _B, r, into_z)
    mean_a, mean_b = mean_albedo(lobe, _A, r), mean_albedo(lobe, _B, r)
    body = (_ONE - _DIELECTRIC * a - b) * (_ONE - _DIELECTRIC * a_into - b_into)
    body *= (_ONE - metallic) / (_ONE - _DIELECTRIC * mean_a - mean_b)
    mean = mean_a + mean_b
    again = (_ONE - a - b) * (_ONE - a_into - b_into) * metallic / max(_ONE - mean, _TINY)
    fresnel = colour + (_ONE - colour) * _MEAN_FIFTH
    return colour * body + fresnel * fresnel * (mean * max(_ZERO, again)) / (_ONE - fresnel * (_ONE - mean))


@device
def _facing(lobe):
    """f₀."""
    metallic = number_slot(lobe, _METALLIC)
    return colour_slot(lobe, _COLOUR) * metallic + _white(_DIELECTRIC * (_ONE - metallic))


@device
def _chance(lobe, r, out):
    """Of the highlight, by what it reflects beside what the body does."""
    a, b = table_albedo(lobe, _A, r, out.z), table_albedo(lobe, _B, r, out.z)
    highlight = _facing(lobe) * a + _white(b)
    return share_of(
        highlight,
        colour_slot(lobe, _COLOUR) * (_ONE - a - b + (_ONE - _DIELECTRIC) * a * (_ONE - number_slot(lobe, _METALLIC))),
    )


@device
def _value(lobe, out, into, h, r):
    """(f cosθ, density)."""
    alpha = alpha_of(r)
    density = masking(out, alpha, alpha) * density_of_normals(h, alpha, alpha) * _QUARTER / out.z
    highlight = schlick(_facing(lobe), dot(out, h)) * (density * masking(into, alpha, alpha))
    matte = into.z * INV_PI
    chance = _chance(lobe, r, out)
    return highlight + _matte_parts(lobe, r, out.z, into.z) * matte, chance * density + (_ONE - chance) * matte


@entry
def evaluate_principled(materials, node, scratch):
    """See contract.py."""
    lobe = open_lobe(materials, node, scratch)
    out, into = out_of(lobe), into_of(lobe)
    if into.z <= _ZERO:
        return answer(lobe, into * _ZERO, _ZERO)
    value, density = _value(lobe, out, into, normalise(out + into), number_slot(lobe, _ROUGHNESS))
    return answer(lobe, value, density)


@entry
def sample_principled(materials, node, scratch):
    """See contract.py."""
    lobe = open_lobe(materials, node, scratch)
    out, r = out_of(lobe), number_slot(lobe, _ROUGHNESS)
    x, y, pick = point_of(lobe)
    into = cosine_direction(x, y)
    if pick < _chance(lobe, r, out):
        alpha = alpha_of(r)
        h = visible_normal(out, alpha, alpha, x, y)
        into = h * (_TWO * dot(out, h)) - out
    if into.z <= _ZERO:
        return no_sample(lobe)
    value, density = _value(lobe, out, into, normalise(out + into), r)
    return answer_sample(lobe, into, value, density)
