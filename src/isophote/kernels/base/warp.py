"""Maps from the unit square to other domains that keep areas in proportion, with their densities."""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.base.jit import device
from isophote.kernels.base.vec import vec3

__all__ = ["INV_PI", "PI", "to_cone", "to_disk", "to_triangle"]

PI = np.float32(math.pi)
INV_PI = np.float32(1 / math.pi)

_ZERO, _ONE, _TWO = np.float32(0), np.float32(1), np.float32(2)
_QUARTER_PI = np.float32(math.pi / 4)
# Minimax polynomials of sin x / x and cos x in x² on [−π/4, π/4], error below 1e-7.
_S1, _S2, _S3 = np.float32(-1.6666654611e-1), np.float32(8.3321608736e-3), np.float32(-1.9515295891e-4)
_C1, _C2, _C3 = np.float32(4.166664568298827e-2), np.float32(-1.388731625493765e-3), np.float32(2.443315711809948e-5)
_HALF = np.float32(0.5)


@device
def _sin_cos_octant(x):
    """Sine and cosine of |x| ≤ π/4, without a branch."""
    y = x * x
    sine = x + x * y * (_S1 + y * (_S2 + y * _S3))
    cosine = _ONE - _HALF * y + y * y * (_C1 + y * (_C2 + y * _C3))
    return sine, cosine


@device
def to_disk(u, v):
    """Unit square to unit disk by squares into rings, density 1/π (Shirley, Chiu: JGT 2(3), 1997)."""
    a, b = _TWO * u - _ONE, _TWO * v - _ONE
    wide = abs(a) > abs(b)
    radius = a if wide else b
    other = b if wide else a
    safe = radius if radius != _ZERO else _ONE
    sine, cosine = _sin_cos_octant(_QUARTER_PI * other / safe)
    along, across = radius * cosine, radius * sine
    return (along, across) if wide else (across, along)


@device
def to_cone(u, v, height):
    """Unit square to the directions within an angle of +z, density 1/(2π height), where `height` is 1 less the angle's
    cosine: given so, however narrow the cone is, nothing cancels."""
    below = u * height
    r = math.sqrt(max(_ZERO, below * (_TWO - below)))
    phi = _TWO * PI * v
    return vec3(r * math.cos(phi), r * math.sin(phi), _ONE - below)


@device
def to_triangle(u, v):
    """Unit square to weights of a triangle's corners 1 and 2, uniform in area, without a fold
    (Heitz: "A Low-Distortion Map Between Triangle and Square", 2019)."""
    if v > u:
        x = u * _HALF
        return x, v - x
    y = v * _HALF
    return u - y, y
