"""Form factors between a point and a convex polygon, and samples of patches.

    F = 1/2π Σ θᵢ Γᵢ · n,   Γᵢ = aᵢ × bᵢ / |aᵢ × bᵢ|,   θᵢ the angle between aᵢ and bᵢ

over the edges of the part of the polygon above the point's horizon, a and b from the point to an edge's ends
(Lambert: "Photometria", 1760; Baum, Rushmeier, Winget: "Improving Radiosity Solutions Through the Use of Analytically
Determined Form-Factors", SIGGRAPH 1989).
"""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.base.double3 import Double3, cross3, difference, dot3, norm, scaled, total
from isophote.kernels.base.jit import device

__all__ = ["corner3", "on_patch", "point_to_polygon"]

_ZERO = np.float64(0)


@device
def corner3(corners, k, c):
    """Corner `c` of patch `k` of (n, 12) values."""
    return Double3(corners[k, 3 * c], corners[k, 3 * c + 1], corners[k, 3 * c + 2])


@device
def on_patch(corners, sides, k, u, v):
    """The place of the unit square's (u, v) on a parallelogram or, without a fold, on a triangle
    (Heitz: "A Low-Distortion Map Between Triangle and Square", 2019); both keep areas in proportion."""
    origin = corner3(corners, k, 0)
    along = difference(corner3(corners, k, 1), origin)
    across = difference(corner3(corners, k, sides[k] - 1), origin)
    if sides[k] == 3:
        if v > u:
            u = u * 0.5
            v = v - u
        else:
            v = v * 0.5
            u = u - v
    return total(origin, total(scaled(along, u), scaled(across, v)))


@device
def _edge(a, b, normal):
    """What the edge from a to b adds, both from the point."""
    c = cross3(a, b)
    size = norm(c)
    if size == _ZERO:
        return _ZERO
    return math.atan2(size, dot3(a, b)) * dot3(c, normal) / size


@device
def point_to_polygon(point, normal, corners, sides, k):
    """Form factor of a surface at a point to patch `k`, whatever side of it is seen: the part of the light that leaves
    the point evenly to all sides, ∫ cosθ cosθ' / (π r²) dA."""
    sum_ = _ZERO
    count = sides[k]
    a = difference(corner3(corners, k, count - 1), point)
    above_a = dot3(a, normal)
    leaving, entering = a, a
    clipped = False
    for c in range(count):
        b = difference(corner3(corners, k, c), point)
        above_b = dot3(b, normal)
        if above_a >= _ZERO and above_b >= _ZERO:
            sum_ += _edge(a, b, normal)
        elif above_a >= _ZERO or above_b >= _ZERO:
            crossing = total(a, scaled(difference(b, a), above_a / (above_a - above_b)))
            clipped = True
            if above_a >= _ZERO:
                sum_ += _edge(a, crossing, normal)
                leaving = crossing
            else:
                sum_ += _edge(crossing, b, normal)
                entering = crossing
        a, above_a = b, above_b
    if clipped:
        sum_ += _edge(leaving, entering, normal)
    return abs(sum_) / (2 * math.pi)
