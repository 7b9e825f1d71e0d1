"""New points in a constrained triangulation of the plane: what conflicts makes way, as far as fixed sides.

Besides the arrays of `plane_mesh`: `region`, (m,) int32, a number that new triangles take from those they replace;
`marks`, (m,) int64, and `starts`, (n,) int32, scratch; `hole` and `rim`, int32, room for triangles and 3 * t + k of
sides; `news`, (., 7) int32, of which the first numbers are those of the new triangles.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import exact_device, exact_inline, exact_kernel
from isophote.kernels.measure.plane_mesh import find_side, fix_side, is_in_circle, turn

__all__ = [
    "BLOCKED",
    "INSIDE",
    "MARK",
    "OCCUPIED",
    "POINTS",
    "TRIANGLES",
    "fill_hole",
    "find_hole",
    "insert_point",
    "locate",
    "split_side",
    "unfix",
]

# The state: how many points and triangles there are, and the last mark.
POINTS, TRIANGLES, MARK = 0, 1, 2
# What `locate` finds: a triangle; a point of the same place; a fixed side or the outside on the way.
INSIDE, OCCUPIED, BLOCKED = 0, 1, 2
_NONE = np.int64(-1)


@exact_device
def locate(points, corners, neighbours, fixed, t, v, through):
    """Walk from triangle t to the one that holds point v: (what, t, k), of which k names a corner or a side.

    Goes through fixed sides if `through`. Turns are drawn: where fixed sides keep triangles from being Delaunay, a
    fixed rule could go in circles (Devillers, Pion, Teillaud, "Walking in a triangulation", 2002).
    """
    draw = np.int64(v)
    while True:
        step = _NONE
        draw = (draw * 1103515245 + 12345) & 0x7FFFFFFF
        for i in range(3):
            k = (i + (draw >> 16)) % 3
            side = turn(points, corners[t, (k + 1) % 3], corners[t, (k + 2) % 3], v)
            if side < 0:
                step = np.int64(k)
                if neighbours[t, k] >= 0 and (through or fixed[t, k] == 0):
                    break
        if step < 0:
            for k in range(3):
                c = corners[t, k]
                if points[c, 0] == points[v, 0] and points[c, 1] == points[v, 1]:
                    return OCCUPIED, t, np.int64(k)
            return INSIDE, t, np.int64(0)
        if neighbours[t, step] < 0 or (fixed[t, step] != 0 and not through):
            return BLOCKED, t, step
        t = np.int64(neighbours[t, step])


@exact_device
def find_hole(points, corners, neighbours, fixed, marks, hole, rim, state, t, split, v):
    """Gather the triangles that make way for point v, from t on, and the sides around them: (triangles, sides).

    With `split` >= 0 the triangle across that side of t makes way too, and the side is not one of the rim. There are 0
    sides if one of them cannot be seen from v.
    """
    state[MARK] += 1
    mark = state[MARK]
    hole[0] = t
    marks[t] = mark
    count = np.int64(1)
    if split >= 0 and neighbours[t, split] >= 0:
        hole[1] = neighbours[t, split]
        marks[hole[1]] = mark
        count += 1
    at = np.int64(0)
    while at < count:
        u = np.int64(hole[at])
        at += 1
        for k in range(3):
            s = np.int64(neighbours[u, k])
            if s < 0 or fixed[u, k] != 0 or marks[s] == mark:
                continue
            if is_in_circle(points, corners, s, v):
                marks[s] = mark
                hole[count] = s
                count += 1
    return count, _find_rim(points, corners, neighbours, fixed, marks, hole, rim, count, t, split, v)


@exact_inline
def _find_rim(points, corners, neighbours, fixed, marks, hole, rim, count, t, split, v):
    """How many sides there are around a hole; 0 if one of them cannot be seen from v."""
    mark = marks[t]
    across = np.int64(neighbours[t, split]) if split >= 0 else _NONE
    sides = np.int64(0)
    for at in range(count):
        u = np.int64(hole[at])
        for k in range(3):
            s = np.int64(neighbours[u, k])
            if split >= 0 and ((u == t and k == split) or (u == across and s == t)):
                continue
            if s >= 0 and marks[s] == mark:
                if fixed[u, k] != 0:
                    return np.int64(0)
                continue
            if turn(points, corners[u, (k + 1) % 3], corners[u, (k + 2) % 3], v) <= 0:
                return np.int64(0)
            rim[sides] = 3 * u + k
            sides += 1
    return sides


@exact_device
def fill_hole(corners, neighbours, fixed, at, region, starts, marks, hole, rim, news, state, count, sides, v):
    """Triangles from the rim to point v, in place of those of the hole; writes their numbers to `news`."""
    for i in range(sides):
        t, k = np.int64(rim[i]) // 3, np.int64(rim[i]) % 3
        a, b = corners[t, (k + 1) % 3], corners[t, (k + 2) % 3]
        starts[b] = -1
        # The old triangles go as the new ones come, so what is kept of them is kept first.
        news[i, 1], news[i, 2], news[i, 3] = a, b, neighbours[t, k]
        news[i, 4], news[i, 5], news[i, 6] = fixed[t, k], region[t], t
    for i in range(sides):
        t = np.int64(hole[i]) if i < count else state[TRIANGLES] + i - count
        news[i, 0] = t
        starts[news[i, 1]] = t
    for i in range(sides):
        s, old = np.int64(news[i, 3]), news[i, 6]
        if s >= 0:
            for k in range(3):
                a = corners[s, (k + 1) % 3]
                if neighbours[s, k] == old and a == news[i, 2]:
                    neighbours[s, k] = news[i, 0]
                    break
    state[TRIANGLES] += max(sides - count, 0)
    for i in range(sides):
        t = np.int64(news[i, 0])
        corners[t, 0], corners[t, 1], corners[t, 2] = v, news[i, 1], news[i, 2]
        neighbours[t, 0], neighbours[t, 1], neighbours[t, 2] = news[i, 3], -1, -1
        fixed[t, 0], fixed[t, 1], fixed[t, 2] = news[i, 4], 0, 0
        region[t] = news[i, 5]
        at[news[i, 1]] = at[v] = t
        marks[t] = 0
    for i in range(sides):
        t, s = np.int64(news[i, 0]), np.int64(starts[news[i, 2]])
        if s >= 0:
            neighbours[t, 1] = s
            neighbours[s, 2] = t
        else:
            at[news[i, 2]] = t


@exact_device
def split_side(points, corners, neighbours, fixed, at, region, starts, marks, hole, rim, news, state, t, k, v):
    """Put point v, next to or on a side, between its ends; returns how many triangles are new, 0 if that cannot be."""
    a, b, mark = np.int64(corners[t, (k + 1) % 3]), np.int64(corners[t, (k + 2) % 3]), fixed[t, k]
    count, sides = find_hole(points, corners, neighbours, fixed, marks, hole, rim, state, t, k, v)
    if sides == 0:
        return sides
    fill_hole(corners, neighbours, fixed, at, region, starts, marks, hole, rim, news, state, count, sides, v)
    for end in (a, b):
        s, j = find_side(corners, neighbours, at, end, v)
        fix_side(neighbours, fixed, s, j, mark)
    return sides


@exact_kernel
def insert_point(points, corners, neighbours, fixed, at, region, starts, marks, hole, rim, news, state, t, v):
    """Insert point v, which lies within the hull; returns the point that is at its place: v, or one that was."""
    what, t, k = locate(points, corners, neighbours, fixed, t, v, True)
    if what == OCCUPIED:
        return np.int64(corners[t, k])
    count, sides = find_hole(points, corners, neighbours, fixed, marks, hole, rim, state, t, _NONE, v)
    if what != INSIDE or sides == 0:
        return _NONE
    fill_hole(corners, neighbours, fixed, at, region, starts, marks, hole, rim, news, state, count, sides, v)
    return v


@exact_kernel
def unfix(corners, neighbours, fixed, at, a, b):
    """Free the side between two points."""
    t, k = find_side(corners, neighbours, at, a, b)
    fix_side(neighbours, fixed, t, k, 0)
    return t
