"""Triangles cut to boxes, in double precision: how far of a triangle lies in a box.

A triangle whose second and third corner are one and the same bounds nothing but a line, and no ray meets it. In all
builders it stands for the box of which its ends are opposite corners: so other things than triangles come by
(things.py).

Sutherland, Hodgman: "Reentrant Polygon Clipping", CACM 17(1), 1974. A triangle has at most nine corners after six
planes.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import device

__all__ = ["CLIP_WORDS", "clip_extent", "is_box", "round_down", "round_up"]

_CORNERS = 10
# Float64 words of work.
CLIP_WORDS = 2 * 3 * _CORNERS

_ULP = 2.0**-23
_LEAST = 2.0**-149
_LARGEST = np.float64(np.finfo(np.float32).max)


@device
def is_box(triangles, triangle):
    """Whether a triangle stands for a box."""
    return triangles[3 * triangle + 1] == triangles[3 * triangle + 2]


@device
def _clip_box(positions, triangles, triangle, box, extent):
    """As clip_extent, of a box."""
    a, b = 3 * np.int64(triangles[3 * triangle]), 3 * np.int64(triangles[3 * triangle + 1])
    for k in range(3):
        low, high = min(positions[a + k], positions[b + k]), max(positions[a + k], positions[b + k])
        extent[k], extent[k + 3] = max(low, box[k]), min(high, box[k + 3])
        if extent[k] > extent[k + 3]:
            return False
    return True


@device
def round_down(x):
    """A float32 not above `x`, one or two steps below it at most."""
    return np.float32(max(x - abs(x) * _ULP - _LEAST, -_LARGEST))


@device
def round_up(x):
    """A float32 not below `x`, one or two steps above it at most."""
    return np.float32(min(x + abs(x) * _ULP + _LEAST, _LARGEST))


@device
def _cut(work, source, target, count, axis, plane, side):
    """Cut the polygon at word `source` to side · x ≤ side · plane; return its number of corners at word `target`."""
    kept = 0
    for i in range(count):
        a = source + 3 * i
        b = source + 3 * (i + 1 if i + 1 < count else 0)
        from_a, from_b = side * (work[a + axis] - plane), side * (work[b + axis] - plane)
        if from_a <= 0:
            for k in range(3):
                work[target + 3 * kept + k] = work[a + k]
            kept += 1
        if (from_a < 0 and from_b > 0) or (from_a > 0 and from_b < 0):
            share = from_a / (from_a - from_b)
            for k in range(3):
                work[target + 3 * kept + k] = work[a + k] + share * (work[b + k] - work[a + k])
            work[target + 3 * kept + axis] = plane
            kept += 1
    return kept


@device
def clip_extent(positions, triangles, triangle, box, work, extent):
    """Bounds of the part of a triangle that lies in the box (lower x, y, z, upper x, y, z), closed.

    Writes them to `extent`, six float32 that hold at least that part and do not leave the box; returns whether there is
    such a part. `box` holds float32 numbers; `work` has CLIP_WORDS float64.
    """
    if is_box(triangles, triangle):
        return _clip_box(positions, triangles, triangle, box, extent)
    for corner in range(3):
        vertex = 3 * np.int64(triangles[3 * triangle + corner])
        for k in range(3):
            work[3 * corner + k] = positions[vertex + k]
    source, target, count = 0, 3 * _CORNERS, 3
    for axis in range(3):
        for upper in range(2):
            plane, side = np.float64(box[axis + 3 * upper]), 1.0 if upper == 1 else -1.0
            count = _cut(work, source, target, count, axis, plane, side)
            source, target = target, source
            if count == 0:
                return False
    for axis in range(3):
        low = high = work[source + axis]
        for i in range(1, count):
            low, high = min(low, work[source + 3 * i + axis]), max(high, work[source + 3 * i + axis])
        extent[axis] = max(_outward(low, -1.0), box[axis])
        extent[axis + 3] = min(_outward(high, 1.0), box[axis + 3])
    return True


@device
def _outward(x, side):
    """`x` as it is where it is a float32, else the next float32 on a side of it or the one after."""
    if np.float64(np.float32(x)) == x:
        return np.float32(x)
    return round_up(x) if side > 0 else round_down(x)
