"""Ashikhmin and Shirley's anisotropic highlight over a matte body.

    f_s = √((u+1)(v+1)) / (8π) (h · z)^((u hx² + v hy²) / (1 − hz²)) F(out · h) / ((out · h) max(cosθ_o, cosθ_i))
    f_d = 28 ρ / (23π) (1 − s) (1 − (1 − cosθ_o/2)⁵) (1 − (1 − cosθ_i/2)⁵),   F(c) = s + (1 − s)(1 − c)⁵

Slots: colour ρ, specular s, exponents u along the tangent and v across. Source: Ashikhmin, Shirley: "An Anisotropic
Phong BRDF Model", JGT 5(2), 2000, equations 4 to 10.
"""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.base.entry import entry
from isophote.kernels.base.jit import device
from isophote.kernels.base.vec import dot, normalise, vec3
from isophote.kernels.base.warp import INV_PI
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

__all__ = ["evaluate_ashikhmin_shirley", "sample_ashikhmin_shirley"]

_ZERO, _HALF, _ONE, _TWO, _FOUR = (np.float32(k) for k in (0, 0.5, 1, 2, 4))
_COLOUR, _SPECULAR, _ALONG, _ACROSS = np.int64(0), np.int64(1), np.int64(2), np.int64(3)
_TINY = np.float32(1e-30)
_BODY = np.float32(28 / (23 * math.pi))
_EIGHTH_INV_PI = np.float32(1 / (8 * math.pi))


@device
def _falling(cosine):
    """1 − (1 − cosθ/2)⁵."""
    x = _ONE - _HALF * cosine
    return _ONE - x * x * x * x * x


@device
def _chance(lobe, out):
    """Of the highlight, by what it reflects of light from above."""
    colour, specular = colour_slot(lobe, _COLOUR), colour_slot(lobe, _SPECULAR)
    return share_of(schlick(specular, out.z), colour - colour * specular)


@device
def _value(lobe, out, into):
    """(f cosθ, density)."""
    colour, specular = colour_slot(lobe, _COLOUR), colour_slot(lobe, _SPECULAR)
    u, v = number_slot(lobe, _ALONG), number_slot(lobe, _ACROSS)
    h = normalise(out + into)
    cosine = max(dot(out, h), _TINY)
    exponent = (u * h.x * h.x + v * h.y * h.y) / max(h.x * h.x + h.y * h.y, _TINY)
    lobes = math.sqrt((u + _ONE) * (v + _ONE)) * h.z**exponent * _EIGHTH_INV_PI / cosine
    body = (colour - colour * specular) * (_BODY * _falling(out.z) * _falling(into.z))
    value = (body + schlick(specular, cosine) * (lobes / max(out.z, into.z))) * into.z
    chance = _chance(lobe, out)
    return value, (_ONE - chance) * into.z * INV_PI + chance * lobes


@entry
def evaluate_ashikhmin_shirley(materials, node, scratch):
    """See contract.py."""
    lobe = open_lobe(materials, node, scratch)
    into = into_of(lobe)
    if into.z <= _ZERO:
        return answer(lobe, into * _ZERO, _ZERO)
    value, density = _value(lobe, out_of(lobe), into)
    return answer(lobe, value, density)


@device
def _half_direction(u, v, x, y):
    """h by the highlight's distribution, from a point of the unit disk, its angle stretched by √((u+1)/(v+1))."""
    r2 = x * x + y * y
    b = y * math.sqrt((u + _ONE) / (v + _ONE))
    size2 = max(x * x + b * b, _TINY)
    z = max(_ONE - r2, _TINY) ** (_ONE / ((u * x * x + v * b * b) / size2 + _ONE))
    s = math.sqrt(max(_ZERO, _ONE - z * z) / size2)
    return vec3(s * x, s * b, z)


@entry
def sample_ashikhmin_shirley(materials, node, scratch):
    """See contract.py."""
    lobe = open_lobe(materials, node, scratch)
    out = out_of(lobe)
    x, y, pick = point_of(lobe)
    into = cosine_direction(x, y)
    if pick < _chance(lobe, out):
        h = _half_direction(number_slot(lobe, _ALONG), number_slot(lobe, _ACROSS), x, y)
        into = h * (_TWO * dot(out, h)) - out
    if into.z <= _ZERO:
        return no_sample(lobe)
    value, density = _value(lobe, out, into)
    return answer_sample(lobe, into, value, density)
