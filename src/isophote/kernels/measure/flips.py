"""Triangulations of the plane made Delaunay by flips: every side is tried with the exact in-circle test.

Lawson, "Software for C1 surface interpolation", 1977: where no side is wrong the triangulation is a Delaunay one, and
flipping wrong sides ends.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import exact_device, exact_kernel
from isophote.kernels.base.predicates import incircle

__all__ = ["flip_wrong"]

_NEXT = (1, 2, 0)
_BEFORE = (2, 0, 1)


@exact_device
def _far_side(neighbours, t, k):
    """(s, j): the triangle across side k of t, and which of its sides that is."""
    s = neighbours[t, k]
    for j in range(3):
        if neighbours[s, j] == t:
            return s, j
    return s, 0


@exact_device
def _sign(points, triangles, neighbours, t, k):
    """1 where the corner beyond side k of t lies inside t's circle, 0 where it lies on it, else -1."""
    if neighbours[t, k] < 0:
        return np.int64(-1)
    s, j = _far_side(neighbours, t, k)
    a, b, c = 2 * triangles[t, 0], 2 * triangles[t, 1], 2 * triangles[t, 2]
    d = 2 * triangles[s, j]
    return incircle(
        points[a],
        points[a + 1],
        points[b],
        points[b + 1],
        points[c],
        points[c + 1],
        points[d],
        points[d + 1],
    )


@exact_device
def _relink(neighbours, t, before, after):
    """Tell triangle t, if there is one, that its neighbour has another number."""
    if t >= 0:
        for k in range(3):
            if neighbours[t, k] == before:
                neighbours[t, k] = after


@exact_device
def _flip(triangles, neighbours, t, k):
    """Exchange the diagonal of t and the triangle across side k: t = (a, b, d), s = (a, d, c)."""
    s, j = _far_side(neighbours, t, k)
    a, b, c, d = triangles[t, k], triangles[t, _NEXT[k]], triangles[t, _BEFORE[k]], triangles[s, j]
    ab, ca = neighbours[t, _BEFORE[k]], neighbours[t, _NEXT[k]]
    cd, db = neighbours[s, _BEFORE[j]], neighbours[s, _NEXT[j]]
    triangles[t, 0], triangles[t, 1], triangles[t, 2] = a, b, d
    triangles[s, 0], triangles[s, 1], triangles[s, 2] = a, d, c
    neighbours[t, 0], neighbours[t, 1], neighbours[t, 2] = db, s, ab
    neighbours[s, 0], neighbours[s, 1], neighbours[s, 2] = cd, ca, t
    _relink(neighbours, db, s, t)
    _relink(neighbours, ca, t, s)
    return s


@exact_kernel
def flip_wrong(points, triangles, neighbours):
    """Flip sides until none is wrong; returns how many flips that took."""
    waiting = np.empty(1024, np.int64)
    flips = 0
    for first in range(len(triangles)):
        waiting[0] = first
        count = 1
        while count > 0:
            count -= 1
            t = waiting[count]
            for k in range(3):
                if _sign(points, triangles, neighbours, t, k) > 0:
                    s = _flip(triangles, neighbours, t, k)
                    flips += 1
                    if count + 2 > len(waiting):
                        longer = np.empty(2 * len(waiting), np.int64)
                        longer[: len(waiting)] = waiting
                        waiting = longer
                    waiting[count], waiting[count + 1] = s, t
                    count += 2
                    break
    return flips
