"""Winding numbers of polygons in the plane, exactly, with points on the boundary told apart.

A ray runs from the point along +x. An edge counts that begins at or below it and ends above it, or the other way round
(Hormann, Agathos: "The point in polygon problem for arbitrary polygons", 2001). Edges are listed by the horizontal
strips that they reach into, so that a point looks at those of its strip.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import device, exact_device, kernel
from isophote.kernels.base.predicates import orient2d

__all__ = ["fill_strips", "polygon_windings", "strip_of"]

_NONE, _PLUS, _MINUS = np.int64(0), np.int64(1), np.int64(-1)


@device
def strip_of(y, least, across, strips):
    """Number of the strip of a coordinate: not decreasing in `y`, whatever the rounding."""
    return np.int64(max(0.0, min((y * 0.5 - least) * across, strips - 1.0)))


@kernel
def fill_strips(edges, least, across, strips, firsts, listed):
    """List edges, (k, 4) rows of x, y of start and end, by their strips.

    `firsts` (strips + 1,) int64, zeros before; strip s has the edges `listed[firsts[s]:firsts[s + 1]]`. With empty
    `listed` only `firsts` is made.
    """
    if listed.size == 0:
        for k in range(len(edges)):
            low, high = min(edges[k, 1], edges[k, 3]), max(edges[k, 1], edges[k, 3])
            for s in range(strip_of(low, least, across, strips), strip_of(high, least, across, strips) + 1):
                firsts[s + 1] += 1
        for s in range(strips):
            firsts[s + 1] += firsts[s]
        return
    free = firsts[:-1].copy()
    for k in range(len(edges)):
        low, high = min(edges[k, 1], edges[k, 3]), max(edges[k, 1], edges[k, 3])
        for s in range(strip_of(low, least, across, strips), strip_of(high, least, across, strips) + 1):
            listed[free[s]] = k
            free[s] += 1


@exact_device
def _crossing(x, y, ax, ay, bx, by):
    """(what an edge adds to the winding number, whether the point lies on it)."""
    if (ay > y and by > y) or (ay < y and by < y) or (ax < x and bx < x):
        return _NONE, False
    upward = ay <= y < by
    downward = by <= y < ay
    if ax > x and bx > x:
        return (_PLUS if upward else (_MINUS if downward else _NONE)), False
    side = orient2d(ax, ay, bx, by, x, y)
    if side == 0:
        # On the line of the edge, and neither above, below, left nor right of it.
        return _NONE, True
    if upward:
        return (_PLUS if side > 0 else _NONE), False
    return (_MINUS if downward and side < 0 else _NONE), False


@kernel
def polygon_windings(edges, least, across, strips, firsts, listed, points, begin, end, numbers, on):
    """Fill `numbers` (n,) int64 with winding numbers, `on` (n,) with 1 for points on an edge: a range of rows."""
    for i in range(begin, end):
        x, y = points[i, 0], points[i, 1]
        total, touching = _NONE, False
        s = strip_of(y, least, across, strips)
        for at in range(firsts[s], firsts[s + 1]):
            k = listed[at]
            added, here = _crossing(x, y, edges[k, 0], edges[k, 1], edges[k, 2], edges[k, 3])
            total += added
            touching |= here
        numbers[i] = total
        on[i] = 1 if touching else 0
