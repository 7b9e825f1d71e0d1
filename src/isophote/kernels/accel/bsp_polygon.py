"""Convex polygons cut by planes, in double precision; faces of cells and parts of triangles are such."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from isophote.kernels.base.jit import device

__all__ = ["MOST_CORNERS", "Plane", "cut_polygon", "extent_along", "height"]

MOST_CORNERS = 12


class Plane(NamedTuple):
    """The plane n · x = place, |n| = 1; `kind` is its axis, or SLANTED (bsp_layout.py)."""

    x: float
    y: float
    z: float
    place: float
    kind: int


@device
def height(plane, words, at):
    """How far the point at word `at` is above the plane."""
    return plane.x * words[at] + plane.y * words[at + 1] + plane.z * words[at + 2] - plane.place


@device
def extent_along(plane, words, at, corners):
    """The least and the greatest height of a polygon above the plane."""
    low = high = height(plane, words, at)
    for i in range(1, corners):
        h = height(plane, words, at + 3 * i)
        low, high = min(low, h), max(high, h)
    return low, high


@device
def cut_polygon(plane, side, source, at, corners, target, to):
    """Write the part of a polygon that has side · height ≤ 0 to word `to` of `target`, which has room for
    MOST_CORNERS + 2; return its number of corners. Sutherland, Hodgman: "Reentrant Polygon Clipping", CACM 17(1), 1974.
    """
    kept = np.int64(0)
    b = at + 3 * (corners - 1)
    from_b = side * height(plane, source, b)
    for i in range(corners):
        a = b
        from_a = from_b
        b = at + 3 * i
        from_b = side * height(plane, source, b)
        if (from_a < 0 and from_b > 0) or (from_a > 0 and from_b < 0):
            share = from_a / (from_a - from_b)
            for k in range(3):
                target[to + 3 * kept + k] = source[a + k] + share * (source[b + k] - source[a + k])
            kept += 1
        if from_b <= 0:
            for k in range(3):
                target[to + 3 * kept + k] = source[b + k]
            kept += 1
    return kept
