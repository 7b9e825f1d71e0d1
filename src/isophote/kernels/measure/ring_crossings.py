"""Edges of polygons that meet where they should not, exactly."""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import exact_device, exact_kernel
from isophote.kernels.base.predicates import orient2d
from isophote.kernels.measure.medial_sites import POLYGON

__all__ = ["first_crossing"]

_open = POLYGON.open


@exact_device
def _apart(p, i, j):
    """Whether the boxes of two nodes of the tree have no point in common."""
    before = p.boxes[4 * i + 2] < p.boxes[4 * j] or p.boxes[4 * j + 2] < p.boxes[4 * i]
    return before or p.boxes[4 * i + 3] < p.boxes[4 * j + 1] or p.boxes[4 * j + 3] < p.boxes[4 * i + 1]


@exact_device
def _meet(p, e, f):
    """Whether two edges have a point in common, their boxes having one."""
    a, c = 2 * e, 2 * f
    b, d = 2 * np.int64(p.after[e]), 2 * np.int64(p.after[f])
    ax, ay, bx, by = p.starts[a], p.starts[a + 1], p.starts[b], p.starts[b + 1]
    cx, cy, dx, dy = p.starts[c], p.starts[c + 1], p.starts[d], p.starts[d + 1]
    if orient2d(ax, ay, bx, by, cx, cy) * orient2d(ax, ay, bx, by, dx, dy) > 0:
        return False
    return orient2d(cx, cy, dx, dy, ax, ay) * orient2d(cx, cy, dx, dy, bx, by) <= 0


@exact_kernel
def first_crossing(polygon):
    """Two edges of a `POLYGON` that meet and do not follow each other; (-1, -1) where there are none."""
    p = _open(polygon)
    n, size = p.lengths.rows, p.boxes.rows >> 3
    stack = np.empty(256, np.int64)
    for e in range(n):
        stack[0] = 1
        count = 1
        while count > 0:
            count -= 1
            i = stack[count]
            if _apart(p, i, size + e):
                continue
            if i < size:
                stack[count], stack[count + 1] = 2 * i, 2 * i + 1
                count += 2
                continue
            f = i - size
            if f > e and p.after[e] != f and p.after[f] != e and _meet(p, e, f):
                return e, f
    return -1, -1
