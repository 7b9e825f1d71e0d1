"""What sixteen hits on triangles say of the surface, as `surface_at` does for one (surface.py)."""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.surface import MOST_PULL, PLACE_ERROR, PULL, THIRD
from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import absolute, maximum, minimum, select, splat16, square_root
from isophote.kernels.base.wide import wide_cross, wide_dot, wide_select

__all__ = ["face_lanes", "place_lanes"]

_ZERO, _ONE = np.float32(0), np.float32(1)


@device
def _reach(p):
    return maximum(absolute(p.x), maximum(absolute(p.y), absolute(p.z)))


@device
def place_lanes(a, b, c, w1, w2):
    """(place, its error, unit normal) on triangles a, b, c that stand in the world's place, at weights of corners."""
    edge1, edge2 = b - a, c - a
    error = maximum(_reach(a), maximum(_reach(b), _reach(c))) * splat16(PLACE_ERROR)
    share = error / maximum(_reach(edge1), _reach(edge2))
    pull = minimum(share * splat16(PULL), splat16(MOST_PULL))
    w0, third = splat16(_ONE) - w1 - w2, splat16(THIRD)
    w0, w1, w2 = w0 + (third - w0) * pull, w1 + (third - w1) * pull, w2 + (third - w2) * pull
    normal = wide_cross(edge1, edge2)
    return a * w0 + b * w1 + c * w2, error, normal / square_root(wide_dot(normal, normal))


@device
def face_lanes(normal, blended, direction):
    """(normal, shading normal) on the side that rays come from: of blended normals, or of the true one where these are
    zero, or where a ray sees the front of the one and the back of the other."""
    zero, one = splat16(_ZERO), splat16(_ONE)
    size2 = wide_dot(blended, blended)
    shading = wide_select(size2 > zero, blended / square_root(size2), normal)
    shading = shading * select(wide_dot(shading, normal) >= zero, one, zero - one)
    agree = wide_dot(direction, shading) * wide_dot(direction, normal) > zero
    seen = wide_select(agree, shading, normal)
    side = select(wide_dot(direction, seen) < zero, one, zero - one)
    return normal * side, seen * side
