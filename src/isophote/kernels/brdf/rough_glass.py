"""Glass: microfacets that reflect and refract by Fresnel's equations, and the smooth boundary.

    reflected:  f = F D G / (4 cosθ_o cosθ_i)
    refracted:  f = (1 − F) D G |out · h| |into · h| / (cosθ_o cosθ_i (out · h + n into · h)²),  h ∝ ±(out + n into)

n is the index of the far side over that of the near one. Slots: index inside over outside, colour, roughness along the
tangent and across. Source: Walter et al.: "Microfacet Models for Refraction", EGSR 2007, equations 20 and 21, for
radiance.
"""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.base.entry import entry
from isophote.kernels.base.jit import device
from isophote.kernels.base.vec import dot, normalise, vec3
from isophote.kernels.brdf import contract
from isophote.kernels.brdf.contract import (
    answer,
    answer_branch,
    answer_sample,
    colour_slot,
    into_of,
    no_sample,
    number_slot,
    open_lobe,
    out_of,
    point_of,
)
from isophote.kernels.brdf.microfacet import alpha_of, density_of_normals, masking, visible_normal
from isophote.kernels.light.bsdf import fresnel_dielectric

__all__ = ["branch_glass", "evaluate_rough_glass", "sample_glass", "sample_rough_glass"]

_ZERO, _ONE, _TWO, _QUARTER = (np.float32(k) for k in (0, 1, 2, 0.25))
_IOR, _COLOUR, _ALONG, _ACROSS = np.int64(0), np.int64(1), np.int64(2), np.int64(3)
_TINY = np.float32(1e-12)


@device
def _index(lobe):
    """n, as looked at from the side that it is."""
    ior = number_slot(lobe, _IOR)
    return ior if lobe.scratch[contract.SIDE] > _ZERO else _ONE / ior


@device
def _value(lobe, out, into, h, n):
    """(f |cosθ| without colour, density) at the facet normal h, which faces out."""
    ax, ay = alpha_of(number_slot(lobe, _ALONG)), alpha_of(number_slot(lobe, _ACROSS))
    out_h, into_h = dot(out, h), dot(into, h)
    if out_h <= _ZERO or (into_h <= _ZERO) != (into.z <= _ZERO):
        return _ZERO, _ZERO
    share, _ = fresnel_dielectric(out_h, n)
    visible = masking(out, ax, ay) * density_of_normals(h, ax, ay) / out.z
    behind = masking(into, ax, ay)
    if into.z > _ZERO:
        density = share * visible * _QUARTER
        return density * behind, density
    # dω_h / dω_into = n² |into · h| / (out · h + n into · h)²; radiance spreads by 1 / n².
    across = out_h + n * into_h
    density = (_ONE - share) * visible * out_h * -into_h * n * n / max(across * across, _TINY)
    return density * behind / (n * n), density


@entry
def evaluate_rough_glass(materials, node, scratch):
    """See contract.py."""
    lobe = open_lobe(materials, node, scratch)
    out, into = out_of(lobe), into_of(lobe)
    n = _index(lobe)
    h = out + into * (_ONE if into.z > _ZERO else n)
    h = normalise(h * (_ONE if h.z > _ZERO else -_ONE))
    value, density = _value(lobe, out, into, h, n)
    return answer(lobe, colour_slot(lobe, _COLOUR) * value, density)


@device
def _refracted(out, h, cosine, inside, n):
    """The ray through a facet, cosines of the two sides given."""
    return normalise(h * (cosine / n - inside) - out / n)


@entry
def sample_rough_glass(materials, node, scratch):
    """See contract.py."""
    lobe = open_lobe(materials, node, scratch)
    out, n = out_of(lobe), _index(lobe)
    ax, ay = alpha_of(number_slot(lobe, _ALONG)), alpha_of(number_slot(lobe, _ACROSS))
    x, y, pick = point_of(lobe)
    h = visible_normal(out, ax, ay, x, y)
    cosine = dot(out, h)
    share, inside = fresnel_dielectric(cosine, n)
    into = h * (_TWO * cosine) - out if pick < share else _refracted(out, h, cosine, inside, n)
    if (into.z > _ZERO) != (pick < share):
        return no_sample(lobe)
    value, density = _value(lobe, out, into, h, n)
    if density <= _ZERO:
        return no_sample(lobe)
    return answer_sample(lobe, into, colour_slot(lobe, _COLOUR) * value, density)


@device
def _smooth(lobe, reflect):
    """(direction, share of light) of the reflected or the refracted ray of a smooth boundary."""
    out, n = out_of(lobe), _index(lobe)
    share, inside = fresnel_dielectric(out.z, n)
    if reflect:
        return vec3(-out.x, -out.y, out.z), share, share
    through = math.sqrt(max(_ZERO, _ONE - inside * inside))
    flat = math.sqrt(max(out.x * out.x + out.y * out.y, _TINY))
    into = vec3(-out.x * through / flat, -out.y * through / flat, -inside)
    return into, (_ONE - share) / (n * n), _ONE - share


@entry
def sample_glass(materials, node, scratch):
    """See contract.py."""
    lobe = open_lobe(materials, node, scratch)
    _, _, pick = point_of(lobe)
    share, _ = fresnel_dielectric(out_of(lobe).z, _index(lobe))
    into, value, chance = _smooth(lobe, pick < share)
    return answer_sample(lobe, into, colour_slot(lobe, _COLOUR) * (value / chance), _ZERO)


@entry
def branch_glass(materials, node, scratch, k):
    """See contract.py. The reflected ray is the first, the refracted the second."""
    lobe = open_lobe(materials, node, scratch)
    into, value, _ = _smooth(lobe, k == 0)
    return answer_branch(lobe, into, colour_slot(lobe, _COLOUR) * value)
