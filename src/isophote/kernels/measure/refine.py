"""Refinement of constrained Delaunay triangulations: new points, until no angle is small and no triangle large.

Ruppert, "A Delaunay Refinement Algorithm for Quality 2-Dimensional Mesh Generation", 1995: fixed sides that have a
point in their diametral circle are split, and triangles that are not as wanted get a point at the centre of their
circle, unless it is in the diametral circle of a side, which is split instead. Sides at acute corners are split on
circles about the corner, and a triangle between two such sides is left as it is (Shewchuk, "Delaunay refinement
algorithms for triangular mesh generation", 2002, section 5), since no refinement can mend an angle that was given.

Only triangles whose `region` is positive are refined.
"""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.base.jit import exact_device, exact_inline, exact_kernel
from isophote.kernels.measure.insert import (
    BLOCKED,
    INSIDE,
    POINTS,
    TRIANGLES,
    fill_hole,
    find_hole,
    locate,
    split_side,
)
from isophote.kernels.measure.plane_mesh import find_side, turn

__all__ = ["SIDES_FIRST", "SIDES_LAST", "TRIANGLES_FIRST", "TRIANGLES_LAST", "queue_all", "refine_queued"]

# The state, after that of `insert`: the ends of the two queues.
SIDES_FIRST, SIDES_LAST, TRIANGLES_FIRST, TRIANGLES_LAST = 3, 4, 5, 6
_NONE = np.int64(-1)
# How often a triangle waits for sides to be split, and how many rows of a queue one step may take.
_TRIES = 64
_ROWS_A_STEP = 4096
# How near distances from a corner are to be on one circle.
_SAME_CIRCLE = 1e-3
# Sides shorter than this part of their coordinates are not split.
_SHORTEST = 1e-13


@exact_inline
def _square(points, a, b):
    x, y = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1]
    return x * x + y * y


@exact_inline
def _sees_blunt(points, a, b, x, y):
    """Whether a place lies strictly inside the diametral circle of a and b."""
    return (points[a, 0] - x) * (points[b, 0] - x) + (points[a, 1] - y) * (points[b, 1] - y) < 0


@exact_inline
def _put(queue, state, last, a, b, c, t, tries):
    at = state[last] % len(queue)
    queue[at, 0], queue[at, 1], queue[at, 2], queue[at, 3], queue[at, 4] = a, b, c, t, tries
    state[last] += 1


@exact_inline
def _common_corner(segments, lines, u, v):
    """The corner where the lines meet that two points were put on, or -1."""
    m, n = np.int64(lines[u]), np.int64(lines[v])
    if m < 0 or n < 0 or m == n:
        return _NONE
    for i in range(2):
        for j in range(2):
            if segments[m, i] == segments[n, j]:
                return np.int64(segments[m, i])
    return _NONE


@exact_inline
def _is_given(points, fixed, segments, lines, t, k, a, b, c):
    """Whether the angle at a, which is corner k, is as it was given: b and c are on two lines that meet."""
    if fixed[t, (k + 1) % 3] != 0 and fixed[t, (k + 2) % 3] != 0:
        return True
    corner = _common_corner(segments, lines, b, c)
    if corner < 0:
        return False
    first, second = _square(points, corner, b), _square(points, corner, c)
    return abs(first - second) <= _SAME_CIRCLE * first


@exact_inline
def _is_wanting(points, corners, fixed, segments, lines, t, least_sine, most_area):
    """Whether a triangle is too large, or has an angle that is too small and was not given."""
    k = _shortest(points, corners, t)
    a, b, c = np.int64(corners[t, k]), np.int64(corners[t, (k + 1) % 3]), np.int64(corners[t, (k + 2) % 3])
    ux, uy = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1]
    vx, vy = points[c, 0] - points[a, 0], points[c, 1] - points[a, 1]
    area = 0.5 * (ux * vy - uy * vx)
    reach = abs(points[a, 0]) + abs(points[a, 1])
    if _square(points, b, c) <= _SHORTEST * _SHORTEST * reach * reach:
        return False
    if area > most_area:
        return True
    # The sine of the angle at a, opposite the shortest side, which is the least.
    length = math.sqrt((ux * ux + uy * uy) * (vx * vx + vy * vy))
    return 2 * area < least_sine * length and not _is_given(points, fixed, segments, lines, t, k, a, b, c)


@exact_inline
def _shortest(points, corners, t):
    """The corner opposite the shortest side."""
    k = 0
    for j in range(1, 3):
        if _opposite(points, corners, t, j) < _opposite(points, corners, t, k):
            k = j
    return k


@exact_inline
def _opposite(points, corners, t, k):
    return _square(points, corners[t, (k + 1) % 3], corners[t, (k + 2) % 3])


@exact_device
def _queue_triangle(points, corners, fixed, region, segments, lines, sides, wanting, state, t, least_sine, most_area):
    """Put what is to be done about a triangle on the queues."""
    if region[t] <= 0:
        return
    for k in range(3):
        if fixed[t, k] != 0:
            a, b, c = corners[t, (k + 1) % 3], corners[t, (k + 2) % 3], corners[t, k]
            if _sees_blunt(points, a, b, points[c, 0], points[c, 1]):
                _put(sides, state, SIDES_LAST, a, b, _NONE, t, 0)
    if _is_wanting(points, corners, fixed, segments, lines, t, least_sine, most_area):
        _put(wanting, state, TRIANGLES_LAST, corners[t, 0], corners[t, 1], corners[t, 2], t, 0)


@exact_kernel
def queue_all(points, corners, fixed, region, segments, lines, sides, wanting, state, least_sine, most_area):
    """Put all that is to be done on the queues, which have room for three rows a triangle."""
    for t in range(state[TRIANGLES]):
        _queue_triangle(
            points, corners, fixed, region, segments, lines, sides, wanting, state, t, least_sine, most_area
        )


@exact_device
def _middle(points, lines, acute, a, b, v):
    """Write the place at which a side is split: in the middle, or on a circle about its one end at an acute corner."""
    part = 0.5
    first, second = acute[a] and lines[a] < 0, acute[b] and lines[b] < 0
    if first != second:
        length = math.sqrt(_square(points, a, b))
        part = 2.0 ** math.floor(math.log2(length / 1.5)) / length
        if second:
            part = 1 - part
    for axis in range(2):
        points[v, axis] = points[a, axis] + part * (points[b, axis] - points[a, axis])


@exact_device
def _centre(points, corners, t, v):
    """Write the centre of a triangle's circle."""
    a, b, c = corners[t, 0], corners[t, 1], corners[t, 2]
    ux, uy = points[b, 0] - points[a, 0], points[b, 1] - points[a, 1]
    vx, vy = points[c, 0] - points[a, 0], points[c, 1] - points[a, 1]
    u, w, twice = ux * ux + uy * uy, vx * vx + vy * vy, 2 * (ux * vy - uy * vx)
    points[v, 0] = points[a, 0] + (vy * u - uy * w) / twice
    points[v, 1] = points[a, 1] + (ux * w - vx * u) / twice


@exact_device
def _blocking_sides(points, corners, fixed, rim, sides, queue, state, v):
    """Put the fixed sides of a rim that have point v in their diametral circle on the queue; how many."""
    found = 0
    for i in range(sides):
        t, k = np.int64(rim[i]) // 3, np.int64(rim[i]) % 3
        if fixed[t, k] != 0:
            a, b = corners[t, (k + 1) % 3], corners[t, (k + 2) % 3]
            if _sees_blunt(points, a, b, points[v, 0], points[v, 1]):
                _put(queue, state, SIDES_LAST, a, b, _NONE, t, 0)
                found += 1
    return found


@exact_device
def _unseen_sides(points, corners, fixed, hole, count, queue, state, v):
    """Put the fixed sides of a hole on the queue that have point v on them or behind them; how many."""
    found = 0
    for i in range(count):
        t = np.int64(hole[i])
        for k in range(3):
            a, b = corners[t, (k + 1) % 3], corners[t, (k + 2) % 3]
            if fixed[t, k] != 0 and turn(points, a, b, v) <= 0:
                _put(queue, state, SIDES_LAST, a, b, _NONE, t, 0)
                found += 1
    return found


@exact_kernel
def refine_queued(
    points,
    corners,
    neighbours,
    fixed,
    at,
    region,
    starts,
    marks,
    hole,
    rim,
    news,
    segments,
    lines,
    acute,
    sides,
    wanting,
    state,
    least_sine,
    most_area,
    most_points,
):
    """Refine until the queues are empty; returns whether they are, or else room is short or there are enough points.

    Besides what `insert` says: `segments`, (s, 2) int32, ends of the fixed sides before refinement, `fixed` holding 1 +
    their numbers; `lines`, (n,) int32: on which of them a new point was put, or -1; `acute`, (n,) bool: points where
    two of them meet at an acute angle; `sides` and `wanting`, (., 5) int32 rings of what is to be done.
    """
    while state[SIDES_FIRST] < state[SIDES_LAST] or state[TRIANGLES_FIRST] < state[TRIANGLES_LAST]:
        v = state[POINTS]
        if v >= min(len(points), most_points) or state[TRIANGLES] + 2 > len(corners):
            return False
        if _is_short(sides, state, SIDES_FIRST) or _is_short(wanting, state, TRIANGLES_FIRST):
            return False
        made = np.int64(0)
        if state[SIDES_FIRST] < state[SIDES_LAST]:
            entry = sides[state[SIDES_FIRST] % len(sides)]
            state[SIDES_FIRST] += 1
            a, b = np.int64(entry[0]), np.int64(entry[1])
            t, k = find_side(corners, neighbours, at, a, b)
            if t < 0 or fixed[t, k] == 0:
                continue
            reach = abs(points[a, 0]) + abs(points[a, 1])
            if _square(points, a, b) <= _SHORTEST * _SHORTEST * reach * reach:
                continue
            lines[v] = fixed[t, k] - 1
            acute[v] = False
            _middle(points, lines, acute, a, b, v)
            made = split_side(
                points, corners, neighbours, fixed, at, region, starts, marks, hole, rim, news, state, t, k, v
            )
        else:
            entry = wanting[state[TRIANGLES_FIRST] % len(wanting)]
            state[TRIANGLES_FIRST] += 1
            t = np.int64(entry[3])
            if corners[t, 0] != entry[0] or corners[t, 1] != entry[1] or corners[t, 2] != entry[2]:
                continue
            if not _is_wanting(points, corners, fixed, segments, lines, t, least_sine, most_area):
                continue
            made = _insert_centre(
                points,
                corners,
                neighbours,
                fixed,
                at,
                region,
                starts,
                marks,
                hole,
                rim,
                news,
                sides,
                wanting,
                lines,
                acute,
                state,
                t,
                v,
                np.int64(entry[4]),
            )
        if made == 0:
            continue
        state[POINTS] += 1
        for i in range(made):
            _queue_triangle(
                points,
                corners,
                fixed,
                region,
                segments,
                lines,
                sides,
                wanting,
                state,
                np.int64(news[i, 0]),
                least_sine,
                most_area,
            )
    return True


@exact_inline
def _is_short(queue, state, first):
    """Whether what one step adds may not fit on a queue."""
    return state[first + 1] - state[first] + _ROWS_A_STEP > len(queue)


@exact_inline
def _try_again(wanting, state, a, b, c, t, tries):
    """Put a triangle back on the queue, behind what is in its way; not for ever, for that may be too short to split."""
    if tries < _TRIES:
        _put(wanting, state, TRIANGLES_LAST, a, b, c, t, tries + 1)


@exact_device
def _insert_centre(
    points,
    corners,
    neighbours,
    fixed,
    at,
    region,
    starts,
    marks,
    hole,
    rim,
    news,
    sides,
    wanting,
    lines,
    acute,
    state,
    t,
    v,
    tries,
):
    """Put point v at the centre of a triangle's circle, or queue the sides that are in its way; how many triangles are
    new.
    """
    _centre(points, corners, t, v)
    if not (math.isfinite(points[v, 0]) and math.isfinite(points[v, 1])):
        return np.int64(0)
    a, b, c = corners[t, 0], corners[t, 1], corners[t, 2]
    what, s, k = locate(points, corners, neighbours, fixed, t, v, False)
    if what == BLOCKED:
        _put(sides, state, SIDES_LAST, corners[s, (k + 1) % 3], corners[s, (k + 2) % 3], _NONE, s, 0)
        _try_again(wanting, state, a, b, c, t, tries)
    if what != INSIDE:
        return np.int64(0)
    count, found = find_hole(points, corners, neighbours, fixed, marks, hole, rim, state, s, _NONE, v)
    if found == 0:
        if _unseen_sides(points, corners, fixed, hole, count, sides, state, v) > 0:
            _try_again(wanting, state, a, b, c, t, tries)
        return found
    if _blocking_sides(points, corners, fixed, rim, found, sides, state, v) > 0:
        _try_again(wanting, state, a, b, c, t, tries)
        return np.int64(0)
    lines[v] = -1
    acute[v] = False
    fill_hole(corners, neighbours, fixed, at, region, starts, marks, hole, rim, news, state, count, found, v)
    return found
