"""Fresnel's equations of conductors, and Schlick's approximation."""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.base.jit import device
from isophote.kernels.base.vec import vec3

__all__ = ["fresnel_conductor", "schlick"]

_ZERO, _HALF, _ONE, _TWO, _FOUR = np.float32(0), np.float32(0.5), np.float32(1), np.float32(2), np.float32(4)


@device
def _channel(cosine, n, k):
    cos2 = cosine * cosine
    sin2 = max(_ZERO, _ONE - cos2)
    n2, k2 = n * n, k * k
    t = n2 - k2 - sin2
    both = math.sqrt(t * t + _FOUR * n2 * k2)
    a = math.sqrt(max(_ZERO, _HALF * (both + t)))
    across, along = both + cos2, _TWO * a * cosine
    perpendicular = (across - along) / (across + along)
    p, q = both * cos2 + sin2 * sin2, along * sin2
    return _HALF * perpendicular * (_ONE + (p - q) / (p + q))


@device
def fresnel_conductor(cosine, n, k):
    """Reflected share of unpolarised light at a smooth boundary of index n + ik, a channel each.

    R_perp = |(cosθ − m) / (cosθ + m)|², R_par = |(η² cosθ − m) / (η² cosθ + m)|², m² = η² − sin²θ, η = n + ik, in real
    numbers.
    """
    return vec3(_channel(cosine, n.x, k.x), _channel(cosine, n.y, k.y), _channel(cosine, n.z, k.z))


@device
def schlick(specular, cosine):
    """F = s + (1 − s) (1 − cosθ)⁵, s a colour (Schlick: "An Inexpensive BRDF Model", Eurographics 1994)."""
    x = max(_ZERO, _ONE - cosine)
    x5 = x * x * x * x * x
    return specular * (_ONE - x5) + x5 * vec3(_ONE, _ONE, _ONE)
