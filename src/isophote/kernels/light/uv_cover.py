"""Which texels of an atlas triangles touch, and the place on the triangle that is nearest to each texel's centre.

A texel counts as touched where its centre lies within half a diagonal, √½ texels, of the triangle: then no texel that a
triangle touches, if only by a corner, is left out.
"""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.base.jit import device, kernel

__all__ = ["cover_texels"]

_REACH = np.float64(math.sqrt(0.5))
# Coordinates in single precision put neighbours' shared edges this far apart, in texels of the largest atlas.
_DEEP = np.float64(-0.01)


@device
def _clipped(low, high, px, py, qx, qy, left, right):
    """[left, right] widened to the part of the edge pq with low ≤ y ≤ high."""
    first, last = 0.0, 1.0
    if qy != py:
        t, s = (low - py) / (qy - py), (high - py) / (qy - py)
        first, last = max(first, min(t, s)), min(last, max(t, s))
    elif py < low or py > high:
        last = -1.0
    if first <= last:
        x, z = px + first * (qx - px), px + last * (qx - px)
        left, right = min(left, x, z), max(right, x, z)
    return left, right


@device
def _along(x, y, px, py, qx, qy):
    """(squared distance of a point from the edge pq, how far along the edge the nearest place is)."""
    dx, dy = qx - px, qy - py
    length = dx * dx + dy * dy
    t = ((x - px) * dx + (y - py) * dy) / length if length > 0 else 0.0
    t = min(1.0, max(0.0, t))
    ex, ey = px + t * dx - x, py + t * dy - y
    return ex * ex + ey * ey, t


@device
def _inside(x, y, t):
    """(depth within triangle `t`, weights of its second and third corner); a negative depth outside."""
    ax, ay, bx, by, cx, cy = t[0, 0], t[0, 1], t[1, 0], t[1, 1], t[2, 0], t[2, 1]
    twice = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
    if twice == 0:
        return -1.0, 0.0, 0.0
    u = ((cx - bx) * (y - by) - (cy - by) * (x - bx)) / twice
    v = ((ax - cx) * (y - cy) - (ay - cy) * (x - cx)) / twice
    w = 1.0 - u - v
    size = abs(twice)
    far_a = u * size / math.hypot(cx - bx, cy - by)
    far_b = v * size / math.hypot(ax - cx, ay - cy)
    far_c = w * size / math.hypot(bx - ax, by - ay)
    return min(far_a, far_b, far_c), v, w


@device
def _nearest(x, y, t):
    """(distance from triangle `t`, weights of its second and third corner at the nearest place).

    Within the triangle the distance is negative: how deep the point is in it.
    """
    depth, v, w = _inside(x, y, t)
    if depth >= 0:
        return -depth, v, w
    square, s = _along(x, y, t[0, 0], t[0, 1], t[1, 0], t[1, 1])
    v, w = s, 0.0
    other, s = _along(x, y, t[1, 0], t[1, 1], t[2, 0], t[2, 1])
    if other < square:
        square, v, w = other, 1.0 - s, s
    other, s = _along(x, y, t[2, 0], t[2, 1], t[0, 0], t[0, 1])
    if other < square:
        square, v, w = other, 0.0, 1.0 - s
    return math.sqrt(square), v, w


@kernel
def cover_texels(corners, owner, distance, weights, crowded):
    """Find for each texel the triangle that it lies deepest in, or is nearest to.

    `corners` (t, 3, 2) float64: in texels, x to the right, y down; the centre of texel (row, column) is at
    (column + ½, row + ½). `owner` (h, w) int32, −1 to begin with; `distance` (h, w) float32, infinite to begin with,
    negative where the centre lies within the triangle; `weights` (h, w, 2) float32 of the second and third corner;
    `crowded` (h, w) uint8: 1 where the centre lies well within several triangles.
    """
    height, width = owner.shape
    for k in range(len(corners)):
        t = corners[k]
        lowest, highest = min(t[0, 1], t[1, 1], t[2, 1]), max(t[0, 1], t[1, 1], t[2, 1])
        for row in range(max(0, math.ceil(lowest - _REACH - 0.5)), min(height, math.floor(highest + _REACH + 0.5))):
            y = row + 0.5
            left, right = np.inf, -np.inf
            for i in range(3):
                j = (i + 1) % 3
                left, right = _clipped(y - _REACH, y + _REACH, t[i, 0], t[i, 1], t[j, 0], t[j, 1], left, right)
            if left > right:
                continue
            for column in range(max(0, math.ceil(left - _REACH - 0.5)), min(width, math.floor(right + _REACH + 0.5))):
                far, v, w = _nearest(column + 0.5, y, t)
                if far > _REACH:
                    continue
                if far < _DEEP and distance[row, column] < _DEEP:
                    crowded[row, column] = 1
                if far < distance[row, column]:
                    owner[row, column] = k
                    distance[row, column] = far
                    weights[row, column, 0] = v
                    weights[row, column, 1] = w
