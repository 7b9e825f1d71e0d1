"""Boxes of triangles, three coordinates at a time."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from isophote.kernels.base.jit import device
from isophote.kernels.base.prefetch import prefetch
from isophote.kernels.base.simd import load4, maximum, minimum

__all__ = ["AHEAD", "Triangles", "box_of", "expect_triangle"]

# So many triangles take about as long as memory does.
AHEAD = 24
_THREE, _FOUR = np.int64(3), np.int64(4)


class Triangles(NamedTuple):
    """Flat positions and corners of triangles, as views, and the last position by itself, with a fourth number."""

    positions: object
    corners: object
    last_point: object


@device
def _point(mesh, i):
    """Coordinates of point `i`, and any number in the fourth lane. Behind the last one nothing may be read."""
    at = _THREE * np.int64(i)
    return load4(mesh.positions, at) if at + _FOUR <= mesh.positions.rows else load4(mesh.last_point, 0)


@device
def box_of(mesh, triangle):
    """Least and greatest corner of one of the Triangles, and any number in the fourth lane."""
    at = _THREE * triangle
    a, b, c = _point(mesh, mesh.corners[at]), _point(mesh, mesh.corners[at + 1]), _point(mesh, mesh.corners[at + 2])
    return minimum(a, minimum(b, c)), maximum(a, maximum(b, c))


@device
def expect_triangle(mesh, triangle):
    """Have the corners of one of the Triangles brought nearer: vertices of neighbours may lie anywhere."""
    at = _THREE * triangle
    for k in range(3):
        prefetch(mesh.positions, _THREE * np.int64(mesh.corners[at + k]))
