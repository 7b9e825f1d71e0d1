"""Triangulations of the plane as triangles and their neighbours: turning around points, flips, sides that are fixed.

corners     (m, 3) int32, counterclockwise
neighbours  (m, 3) int32, each opposite its corner; -1: outside
fixed       (m, 3) int32, for the side opposite each corner: 0, or 1 + the number of a constraint
at          (n,) int32: a triangle at each point; -1: none
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import exact_device
from isophote.kernels.base.predicates import incircle, orient2d

__all__ = ["across", "corner_of", "find_side", "fix_side", "flip", "is_in_circle", "turn"]

_NONE = np.int64(-1)


@exact_device
def turn(points, a, b, c):
    """`orient2d` of three points by number."""
    return orient2d(points[a, 0], points[a, 1], points[b, 0], points[b, 1], points[c, 0], points[c, 1])


@exact_device
def is_in_circle(points, corners, t, v):
    """Whether a point lies strictly inside the circle of a triangle."""
    a, b, c = corners[t, 0], corners[t, 1], corners[t, 2]
    ax, ay, bx, by, cx, cy = points[a, 0], points[a, 1], points[b, 0], points[b, 1], points[c, 0], points[c, 1]
    return incircle(ax, ay, bx, by, cx, cy, points[v, 0], points[v, 1]) > 0


@exact_device
def corner_of(corners, t, v):
    """Which corner of a triangle a point is."""
    if corners[t, 0] == v:
        return np.int64(0)
    return np.int64(1) if corners[t, 1] == v else np.int64(2)


@exact_device
def across(neighbours, s, t):
    """Which side of triangle s triangle t is across."""
    if neighbours[s, 0] == t:
        return np.int64(0)
    return np.int64(1) if neighbours[s, 1] == t else np.int64(2)


@exact_device
def find_side(corners, neighbours, at, u, v):
    """A triangle and its side that joins two points: (t, k), or (-1, -1) if no side does."""
    first = np.int64(at[u])
    t = first
    while t >= 0:
        i = corner_of(corners, t, u)
        if corners[t, (i + 1) % 3] == v:
            return t, (i + 2) % 3
        if corners[t, (i + 2) % 3] == v:
            return t, (i + 1) % 3
        t = np.int64(neighbours[t, (i + 1) % 3])
        if t == first:
            return _NONE, _NONE
    # Met the outside: the other way round.
    t = np.int64(neighbours[first, (corner_of(corners, first, u) + 2) % 3])
    while t >= 0:
        i = corner_of(corners, t, u)
        if corners[t, (i + 1) % 3] == v:
            return t, (i + 2) % 3
        t = np.int64(neighbours[t, (i + 2) % 3])
    return _NONE, _NONE


@exact_device
def fix_side(neighbours, fixed, t, k, value):
    """Mark a side as seen from both its triangles."""
    fixed[t, k] = value
    s = np.int64(neighbours[t, k])
    if s >= 0:
        fixed[s, across(neighbours, s, t)] = value


@exact_device
def _set(corners, neighbours, fixed, t, k, v, s, mark):
    corners[t, k], neighbours[t, k], fixed[t, k] = v, s, mark


@exact_device
def flip(corners, neighbours, fixed, at, t, k):
    """Exchange the diagonal of the two triangles at a side, which form a convex quadrilateral.

    Of a, b, c from corner k of triangle t on, and d across: they become (a, b, d) in t and (a, d, c) across.
    """
    i, j = (k + 1) % 3, (k + 2) % 3
    s = np.int64(neighbours[t, k])
    l = across(neighbours, s, t)
    a, b, c, d = corners[t, k], corners[t, i], corners[t, j], corners[s, l]
    # Of s: its corners are d, c, b from l on; so c d lies opposite b.
    bd, bd_mark = np.int64(neighbours[s, (l + 1) % 3]), fixed[s, (l + 1) % 3]
    dc, dc_mark = np.int64(neighbours[s, (l + 2) % 3]), fixed[s, (l + 2) % 3]
    ca, ca_mark = np.int64(neighbours[t, i]), fixed[t, i]
    ab, ab_mark = np.int64(neighbours[t, j]), fixed[t, j]
    _set(corners, neighbours, fixed, t, 0, a, bd, bd_mark)
    _set(corners, neighbours, fixed, t, 1, b, s, 0)
    _set(corners, neighbours, fixed, t, 2, d, ab, ab_mark)
    _set(corners, neighbours, fixed, s, 0, a, dc, dc_mark)
    _set(corners, neighbours, fixed, s, 1, d, ca, ca_mark)
    _set(corners, neighbours, fixed, s, 2, c, t, 0)
    if bd >= 0:
        neighbours[bd, across(neighbours, bd, s)] = t
    if ca >= 0:
        neighbours[ca, across(neighbours, ca, t)] = s
    at[a] = at[b] = at[d] = t
    at[c] = s
