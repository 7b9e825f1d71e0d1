"""Convex polygons cut by planes, in double precision; faces of cells and parts of triangles are such.

Three corners of which the second and the third are the same stand for a box (clip.py): all between the first and the
second.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from isophote.kernels.base.jit import device

__all__ = ["MOST_CORNERS", "Plane", "cut_box", "cut_polygon", "extent_along", "height", "is_boxed"]

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
def is_boxed(words, at, corners):
    """Whether the corners at word `at` stand for a box."""
    if corners != 3 or words[at + 3] != words[at + 6]:
        return False
    return words[at + 4] == words[at + 7] and words[at + 5] == words[at + 8]


@device
def _box_extent(plane, words, at):
    """As extent_along, of a box: what is n · x at its middle, and how much that changes towards its corners."""
    middle = 0.5 * (height(plane, words, at) + height(plane, words, at + 3))
    half = abs(plane.x * (words[at + 3] - words[at])) + abs(plane.y * (words[at + 4] - words[at + 1]))
    half = 0.5 * (half + abs(plane.z * (words[at + 5] - words[at + 2])))
    return middle - half, middle + half


@device
def cut_box(plane, side, source, at, target, to):
    """As cut_polygon, of a box and a plane along an axis that parts it."""
    for k in range(9):
        target[to + k] = source[at + k]
    first, second = to + plane.kind, to + 3 + plane.kind
    # The corner beyond the plane comes to lie in it.
    if side * target[first] > side * target[second]:
        target[first] = plane.place
    else:
        target[second] = target[second + 3] = plane.place
    return np.int64(3)


@device
def extent_along(plane, words, at, corners):
    """The least and the greatest height of a polygon above the plane."""
    if is_boxed(words, at, corners):
        return _box_extent(plane, words, at)
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
