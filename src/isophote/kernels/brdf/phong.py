"""Phong's and Blinn's highlights over a matte body, normalised.

    Phong:  f = ρ (1 − s) / π + s (n + 2) / (2π) (r · into)^n,   r the mirror direction of `out`
    Blinn:  f = ρ (1 − s) / π + s (n + 2) (n + 4) / (8π (2^(−n/2) + n)) (h · z)^n,   h = (out + into) / |out + into|

With these factors a highlight alone reflects s, seen from above, and less from elsewhere; the body has what it leaves.
Slots: colour ρ, specular s, exponent n. Sources: Lafortune, Willems: "Using the Modified Phong Reflectance Model",
1994; Blinn: "Models of Light Reflection", SIGGRAPH 1977.
"""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.base.entry import entry
from isophote.kernels.base.jit import device
from isophote.kernels.base.vec import dot, normalise, orthonormal, vec3
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

__all__ = ["evaluate_blinn", "evaluate_phong", "sample_blinn", "sample_phong"]

_ZERO, _HALF, _ONE, _TWO, _FOUR, _EIGHT = (np.float32(k) for k in (0, 0.5, 1, 2, 4, 8))
_COLOUR, _SPECULAR, _EXPONENT = np.int64(0), np.int64(1), np.int64(2)
_TINY = np.float32(1e-30)
_HALF_INV_PI = np.float32(0.5 / math.pi)


@device
def _parts(lobe):
    """(what the body reflects, what the highlight does, the chance of the highlight)."""
    specular = colour_slot(lobe, _SPECULAR)
    colour = colour_slot(lobe, _COLOUR)
    body = colour - colour * specular
    return body, specular, share_of(specular, body)


@device
def _around(x, y, exponent):
    """A direction around z, density (n + 1) / (2π) cos^n, from a point of the unit disk."""
    r2 = x * x + y * y
    z = max(_ONE - r2, _TINY) ** (_ONE / (exponent + _ONE))
    s = math.sqrt(max(_ZERO, _ONE - z * z) / max(r2, _TINY))
    return vec3(s * x, s * y, z)


@device
def _phong(lobe, out, into):
    """(f cosθ, density)."""
    body, specular, chance = _parts(lobe)
    n = number_slot(lobe, _EXPONENT)
    power = max(_ZERO, into.z * out.z - into.x * out.x - into.y * out.y) ** n * _HALF_INV_PI
    value = (body * INV_PI + specular * (power * (n + _TWO))) * into.z
    return value, (_ONE - chance) * into.z * INV_PI + chance * power * (n + _ONE)


@entry
def evaluate_phong(materials, node, scratch):
    """See contract.py."""
    lobe = open_lobe(materials, node, scratch)
    into = into_of(lobe)
    if into.z <= _ZERO:
        return answer(lobe, into * _ZERO, _ZERO)
    value, density = _phong(lobe, out_of(lobe), into)
    return answer(lobe, value, density)


@entry
def sample_phong(materials, node, scratch):
    """See contract.py."""
    lobe = open_lobe(materials, node, scratch)
    out = out_of(lobe)
    x, y, pick = point_of(lobe)
    _, _, chance = _parts(lobe)
    if pick < chance:
        local = _around(x, y, number_slot(lobe, _EXPONENT))
        mirror = vec3(-out.x, -out.y, out.z)
        tangent, bitangent = orthonormal(mirror)
        into = tangent * local.x + bitangent * local.y + mirror * local.z
    else:
        into = cosine_direction(x, y)
    if into.z <= _ZERO:
        return no_sample(lobe)
    value, density = _phong(lobe, out, into)
    return answer_sample(lobe, into, value, density)


@device
def _blinn(lobe, out, into):
    """(f cosθ, density)."""
    body, specular, chance = _parts(lobe)
    n = number_slot(lobe, _EXPONENT)
    h = normalise(out + into)
    power = h.z**n * INV_PI
    norm = (n + _TWO) * (n + _FOUR) / (_EIGHT * (_TWO ** (-_HALF * n) + n))
    value = (body * INV_PI + specular * (power * norm)) * into.z
    highlight = power * _HALF * (n + _ONE) / (_FOUR * max(dot(out, h), _TINY))
    return value, (_ONE - chance) * into.z * INV_PI + chance * highlight


@entry
def evaluate_blinn(materials, node, scratch):
    """See contract.py."""
    lobe = open_lobe(materials, node, scratch)
    into = into_of(lobe)
    if into.z <= _ZERO:
        return answer(lobe, into * _ZERO, _ZERO)
    value, density = _blinn(lobe, out_of(lobe), into)
    return answer(lobe, value, density)


@entry
def sample_blinn(materials, node, scratch):
    """See contract.py."""
    lobe = open_lobe(materials, node, scratch)
    out = out_of(lobe)
    x, y, pick = point_of(lobe)
    _, _, chance = _parts(lobe)
    into = cosine_direction(x, y)
    if pick < chance:
        h = _around(x, y, number_slot(lobe, _EXPONENT))
        into = h * (_TWO * dot(out, h)) - out
    if into.z <= _ZERO:
        return no_sample(lobe)
    value, density = _blinn(lobe, out, into)
    return answer_sample(lobe, into, value, density)
