"""Metals: microfacets that reflect by Fresnel's equations of conductors, and the smooth mirror.

    f = F D G / (4 cosθ_o cosθ_i) + F_m (1 − E(θ_o)) (1 − E(θ_i)) / (π (1 − Ē)),   F_m = F̄² Ē / (1 − F̄ (1 − Ē))

The second term gives back what facets send to each other: E is what facets that reflect everything do at once, F̄ the
mean of F over the hemisphere. The entries whose names say single are without it. Slots: index n, extinction k, colour,
roughness along the tangent and across, F̄. Data: two tables A and B, whose sum is E (albedo.py). Source: Kulla, Conty:
"Revisiting Physically Based Shading at Imageworks", SIGGRAPH 2017 course.
"""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.base.entry import entry
from isophote.kernels.base.jit import device
from isophote.kernels.base.vec import dot, normalise, vec3
from isophote.kernels.base.warp import INV_PI
from isophote.kernels.brdf.albedo import TABLE_WORDS, mean_albedo, table_albedo
from isophote.kernels.brdf.contract import (
    answer,
    answer_branch,
    answer_sample,
    colour_slot,
    cosine_direction,
    into_of,
    no_sample,
    number_slot,
    open_lobe,
    out_of,
    point_of,
)
from isophote.kernels.brdf.fresnel import fresnel_conductor
from isophote.kernels.brdf.microfacet import alpha_of, density_of_normals, masking, visible_normal

__all__ = [
    "branch_smooth",
    "evaluate_conductor",
    "evaluate_nothing",
    "evaluate_single",
    "sample_conductor",
    "sample_single",
    "sample_smooth",
]

_ZERO, _ONE, _TWO, _QUARTER = np.float32(0), np.float32(1), np.float32(2), np.float32(0.25)
_N, _K, _COLOUR, _ALONG, _ACROSS, _MEAN = (np.int64(k) for k in range(6))
_A, _B = np.int64(0), np.int64(TABLE_WORDS)
_TINY = np.float32(1e-6)


@device
def _reflected(lobe, cosine):
    return colour_slot(lobe, _COLOUR) * fresnel_conductor(cosine, colour_slot(lobe, _N), colour_slot(lobe, _K))


@device
def _lobe_at(lobe, out, into, h):
    """(f cosθ, density): F D G / (4 cosθ_out) and G1(out) D / (4 cosθ_out)."""
    ax, ay = alpha_of(number_slot(lobe, _ALONG)), alpha_of(number_slot(lobe, _ACROSS))
    density = masking(out, ax, ay) * density_of_normals(h, ax, ay) * _QUARTER / out.z
    return _reflected(lobe, dot(out, h)) * (density * masking(into, ax, ay)), density


@device
def _roughness(lobe):
    """One for both ways, of the same area of slopes."""
    return math.sqrt(max(_ZERO, number_slot(lobe, _ALONG) * number_slot(lobe, _ACROSS)))


@device
def _lost(lobe, r, cosine):
    """1 − E."""
    return max(_ZERO, _ONE - table_albedo(lobe, _A, r, cosine) - table_albedo(lobe, _B, r, cosine))


@device
def _again(lobe, r, lost, into_z):
    """The second term's f cosθ, `lost` being 1 − E of `out`."""
    mean = mean_albedo(lobe, _A, r) + mean_albedo(lobe, _B, r)
    fresnel = colour_slot(lobe, _COLOUR) * colour_slot(lobe, _MEAN)
    matte = lost * _lost(lobe, r, into_z) * into_z * INV_PI * mean / max(_ONE - mean, _TINY)
    return fresnel * fresnel * matte / (_ONE - fresnel * (_ONE - mean))


@device
def _both(lobe, out, into, h):
    """(f cosθ, density)."""
    r = _roughness(lobe)
    lost = _lost(lobe, r, out.z)
    value, density = _lobe_at(lobe, out, into, h)
    return value + _again(lobe, r, lost, into.z), density * (_ONE - lost) + lost * into.z * INV_PI


@entry
def evaluate_conductor(materials, node, scratch):
    """See contract.py."""
    lobe = open_lobe(materials, node, scratch)
    out, into = out_of(lobe), into_of(lobe)
    if into.z <= _ZERO:
        return answer(lobe, into * _ZERO, _ZERO)
    value, density = _both(lobe, out, into, normalise(out + into))
    return answer(lobe, value, density)


@entry
def sample_conductor(materials, node, scratch):
    """See contract.py."""
    lobe = open_lobe(materials, node, scratch)
    out = out_of(lobe)
    x, y, pick = point_of(lobe)
    into = cosine_direction(x, y)
    if pick >= _lost(lobe, _roughness(lobe), out.z):
        ax, ay = alpha_of(number_slot(lobe, _ALONG)), alpha_of(number_slot(lobe, _ACROSS))
        h = visible_normal(out, ax, ay, x, y)
        into = h * (_TWO * dot(out, h)) - out
    if into.z <= _ZERO:
        return no_sample(lobe)
    value, density = _both(lobe, out, into, normalise(out + into))
    return answer_sample(lobe, into, value, density)


@entry
def evaluate_single(materials, node, scratch):
    """See contract.py."""
    lobe = open_lobe(materials, node, scratch)
    out, into = out_of(lobe), into_of(lobe)
    if into.z <= _ZERO:
        return answer(lobe, vec3(_ZERO, _ZERO, _ZERO), _ZERO)
    value, density = _lobe_at(lobe, out, into, normalise(out + into))
    return answer(lobe, value, density)


@entry
def sample_single(materials, node, scratch):
    """See contract.py."""
    lobe = open_lobe(materials, node, scratch)
    out = out_of(lobe)
    ax, ay = alpha_of(number_slot(lobe, _ALONG)), alpha_of(number_slot(lobe, _ACROSS))
    x, y, _ = point_of(lobe)
    h = visible_normal(out, ax, ay, x, y)
    into = h * (_TWO * dot(out, h)) - out
    if into.z <= _ZERO:
        return no_sample(lobe)
    value, density = _lobe_at(lobe, out, into, h)
    return answer_sample(lobe, into, value, density)


@entry
def evaluate_nothing(materials, node, scratch):
    """The `evaluate` of kinds that only branch."""
    return answer(open_lobe(materials, node, scratch), vec3(_ZERO, _ZERO, _ZERO), _ZERO)


@entry
def sample_smooth(materials, node, scratch):
    """See contract.py."""
    lobe = open_lobe(materials, node, scratch)
    out = out_of(lobe)
    return answer_sample(lobe, vec3(-out.x, -out.y, out.z), _reflected(lobe, out.z), _ZERO)


@entry
def branch_smooth(materials, node, scratch, k):
    """See contract.py."""
    lobe = open_lobe(materials, node, scratch)
    out = out_of(lobe)
    return answer_branch(lobe, vec3(-out.x, -out.y, out.z), _reflected(lobe, out.z))
