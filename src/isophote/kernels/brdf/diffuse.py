"""Matte surfaces: Lambert's, and rough ones after Oren and Nayar.

Lambert: f = ρ / π. Slot: colour.

Rough, with roughness r, s = out · into − cosθ_o cosθ_i, t = max(cosθ_o, cosθ_i) where s > 0, else 1:

    f = ρ/π A (1 + r s/t) + ρ_ms/π (1 − E(θ_o)) (1 − E(θ_i)) / (1 − Ē),   A = 1 / (1 + (1/2 − 2/(3π)) r)

Its first term is Oren and Nayar's model in Fujii's form; the second gives back, after Kulla and Conty, what bounces
between the facets, so that a white surface loses nothing. Slots: colour, roughness. Sources: Oren, Nayar:
"Generalization of Lambert's Reflectance Model", SIGGRAPH 1994; Portsmouth, Kutz, Hill: "EON: A Practical
Energy-Preserving Rough Diffuse BRDF", JCGT 14(1), 2025.
"""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.base.entry import entry
from isophote.kernels.base.jit import device
from isophote.kernels.base.vec import dot
from isophote.kernels.base.warp import INV_PI
from isophote.kernels.brdf.contract import (
    answer,
    answer_sample,
    colour_slot,
    cosine_direction,
    into_of,
    number_slot,
    open_lobe,
    out_of,
    point_of,
)

__all__ = ["evaluate_lambert", "evaluate_oren_nayar", "sample_lambert", "sample_oren_nayar"]

_ZERO, _ONE, _TWO_THIRDS = np.float32(0), np.float32(1), np.float32(2 / 3)
_COLOUR, _ROUGHNESS = np.int64(0), np.int64(1)
# E(0) less 1 and the mean of E less 1 over A, in parts of r.
_C1, _C2 = np.float32(0.5 - 2 / (3 * math.pi)), np.float32(2 / 3 - 28 / (15 * math.pi))
_TINY = np.float32(1e-6)


@entry
def evaluate_lambert(materials, node, scratch):
    """See contract.py."""
    lobe = open_lobe(materials, node, scratch)
    density = max(_ZERO, into_of(lobe).z) * INV_PI
    return answer(lobe, colour_slot(lobe, _COLOUR) * density, density)


@entry
def sample_lambert(materials, node, scratch):
    """See contract.py."""
    lobe = open_lobe(materials, node, scratch)
    x, y, _ = point_of(lobe)
    into = cosine_direction(x, y)
    density = max(into.z, _TINY) * INV_PI
    return answer_sample(lobe, into, colour_slot(lobe, _COLOUR) * density, density)


@device
def _albedo(cosine, r, a):
    """E(θ): what a white surface reflects at once."""
    sine = math.sqrt(max(_ZERO, _ONE - cosine * cosine))
    tangent = sine / max(cosine, _TINY)
    g = sine * (math.acos(min(cosine, _ONE)) - sine * cosine)
    g += _TWO_THIRDS * (tangent * (_ONE - sine * sine * sine) - sine)
    return a + r * a * INV_PI * g


@device
def _oren_nayar(lobe, out, into):
    """f cosθ."""
    colour, r = colour_slot(lobe, _COLOUR), number_slot(lobe, _ROUGHNESS)
    a = _ONE / (_ONE + _C1 * r)
    s = dot(out, into) - out.z * into.z
    s /= max(out.z, into.z) if s > _ZERO else _ONE
    mean = a * (_ONE + _C2 * r)
    lost = max(_ZERO, _ONE - _albedo(out.z, r, a)) * max(_ZERO, _ONE - _albedo(into.z, r, a))
    lost /= max(_ONE - mean, _TINY)
    again = colour * colour * mean / (_ONE - colour * (_ONE - mean))
    return (colour * (a * (_ONE + r * s)) + again * lost) * (into.z * INV_PI)


@entry
def evaluate_oren_nayar(materials, node, scratch):
    """See contract.py."""
    lobe = open_lobe(materials, node, scratch)
    into = into_of(lobe)
    if into.z <= _ZERO:
        return answer(lobe, into * _ZERO, _ZERO)
    return answer(lobe, _oren_nayar(lobe, out_of(lobe), into), into.z * INV_PI)


@entry
def sample_oren_nayar(materials, node, scratch):
    """See contract.py."""
    lobe = open_lobe(materials, node, scratch)
    x, y, _ = point_of(lobe)
    into = cosine_direction(x, y)
    density = max(into.z, _TINY) * INV_PI
    return answer_sample(lobe, into, _oren_nayar(lobe, out_of(lobe), into), density)
