"""Constraints become sides of a Delaunay triangulation: flips take away what crosses them.

Sloan, "A fast algorithm for generating constrained Delaunay triangulations", 1993, with exact predicates. Only
sides that crossed the constraint are replaced, so only the new ones need to be made Delaunay again.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import exact_device, exact_kernel
from isophote.kernels.measure.plane_mesh import across, corner_of, find_side, fix_side, flip, is_in_circle, turn

__all__ = ["FROM", "NEXT", "SIDE_END", "SIDE_START", "add_winding", "flip_all", "insert_constraints", "spread_winding"]

# The state between calls: the next constraint, the point from which it goes on; where it crosses another, that one's
# side.
NEXT, FROM, SIDE_START, SIDE_END = 0, 1, 2, 3
_NONE = np.int64(-1)


@exact_device
def _is_ahead(points, a, b, v):
    """Whether v, on the line through a and b, lies from a towards b."""
    axis = 0 if points[a, 0] != points[b, 0] else 1
    return (points[v, axis] > points[a, axis]) == (points[b, axis] > points[a, axis]) and (
        points[v, axis] != points[a, axis]
    )


@exact_device
def _leads_to(points, a, b, v):
    """Whether the side from a to v is on the segment from a to b."""
    return v == b or (turn(points, a, b, v) == 0 and _is_ahead(points, a, b, v))


@exact_device
def _first_step(points, corners, neighbours, at, a, b):
    """(t, k): where the segment from a to b leaves the triangles at a.

    Across the side of t opposite corner k if that corner is a; else along the side of t opposite corner k.
    """
    t = first = np.int64(at[a])
    backward = False
    while True:
        i = corner_of(corners, t, a)
        p, q = np.int64(corners[t, (i + 1) % 3]), np.int64(corners[t, (i + 2) % 3])
        if _leads_to(points, a, b, p):
            return t, (i + 2) % 3
        if _leads_to(points, a, b, q):
            return t, (i + 1) % 3
        if turn(points, a, b, p) < 0 and turn(points, a, b, q) > 0:
            return t, i
        s = np.int64(neighbours[t, (i + 2) % 3 if backward else (i + 1) % 3])
        if s < 0:
            # Met the outside: the other way round.
            backward = True
            s = np.int64(neighbours[first, (corner_of(corners, first, a) + 2) % 3])
        t = s


@exact_device
def _gather(points, corners, neighbours, fixed, a, b, t, k, crossed, state):
    """Write the sides that a segment crosses, up to a point on it: (that point, -1 for a fixed side, and how many)."""
    count = np.int64(0)
    p, q = np.int64(corners[t, (k + 1) % 3]), np.int64(corners[t, (k + 2) % 3])
    while True:
        if fixed[t, k] != 0:
            state[SIDE_START], state[SIDE_END] = p, q
            return _NONE, count
        crossed[count, 0], crossed[count, 1] = p, q
        count += 1
        s = np.int64(neighbours[t, k])
        far = across(neighbours, s, t)
        v = np.int64(corners[s, far])
        side = np.int64(0) if v == b else turn(points, a, b, v)
        if side == 0:
            return v, count
        # Leave across the side to p if the far point is on the left, where q is.
        t = s
        if side > 0:
            k = corner_of(corners, t, q)
            q = v
        else:
            k = corner_of(corners, t, p)
            p = v


@exact_device
def _is_convex(points, corners, neighbours, t, k):
    s = np.int64(neighbours[t, k])
    a, b, c = corners[t, k], corners[t, (k + 1) % 3], corners[t, (k + 2) % 3]
    d = corners[s, across(neighbours, s, t)]
    return turn(points, a, b, d) > 0 and turn(points, a, d, c) > 0


@exact_device
def _clear(points, corners, neighbours, fixed, at, a, e, crossed, count, made):
    """Flip sides until none crosses the segment from a to e; writes the new sides but the segment: how many."""
    head, size, new_count = np.int64(0), count, np.int64(0)
    room = len(crossed)
    while size > 0:
        p, q = np.int64(crossed[head, 0]), np.int64(crossed[head, 1])
        head = (head + 1) % room
        size -= 1
        t, k = find_side(corners, neighbours, at, p, q)
        if _is_convex(points, corners, neighbours, t, k):
            flip(corners, neighbours, fixed, at, t, k)
            p, q = np.int64(corners[t, 0]), np.int64(corners[t, 2])
            ends = (p == a) + (p == e) + (q == a) + (q == e)
            if ends == 2:
                continue
            if ends == 1 or turn(points, a, e, p) == turn(points, a, e, q):
                made[new_count, 0], made[new_count, 1] = p, q
                new_count += 1
                continue
        tail = (head + size) % room
        crossed[tail, 0], crossed[tail, 1] = p, q
        size += 1
    return new_count


@exact_device
def _restore(points, corners, neighbours, fixed, at, made, count):
    """Flip new sides until each is Delaunay."""
    changed = True
    while changed:
        changed = False
        for i in range(count):
            t, k = find_side(corners, neighbours, at, np.int64(made[i, 0]), np.int64(made[i, 1]))
            s = np.int64(neighbours[t, k])
            far = np.int64(corners[s, across(neighbours, s, t)])
            if is_in_circle(points, corners, t, far):
                flip(corners, neighbours, fixed, at, t, k)
                made[i, 0], made[i, 1] = corners[t, 0], corners[t, 2]
                changed = True


@exact_kernel
def insert_constraints(points, corners, neighbours, fixed, at, constraints, crossed, made, state):
    """Insert constraints (c, 2) from `state[NEXT]` on; returns whether all are in, or else one crosses another.

    `crossed` and `made` have room for all sides, (sides, 2) int32.
    """
    while state[NEXT] < len(constraints):
        number = state[NEXT]
        a, b = state[FROM], np.int64(constraints[number, 1])
        if a < 0:
            a = np.int64(constraints[number, 0])
        while a != b:
            state[FROM] = a
            t, k = _first_step(points, corners, neighbours, at, a, b)
            if corners[t, k] != a:
                i = corner_of(corners, t, a)
                end = np.int64(corners[t, 3 - i - k])
                fix_side(neighbours, fixed, t, k, number + 1)
            else:
                end, count = _gather(points, corners, neighbours, fixed, a, b, t, k, crossed, state)
                if end < 0:
                    return False
                new_count = _clear(points, corners, neighbours, fixed, at, a, end, crossed, count, made)
                t, k = find_side(corners, neighbours, at, a, end)
                fix_side(neighbours, fixed, t, k, number + 1)
                _restore(points, corners, neighbours, fixed, at, made, new_count)
            a = end
        state[NEXT] += 1
        state[FROM] = _NONE
    return True


@exact_kernel
def flip_all(points, corners, neighbours, fixed, at):
    """Flip free sides until all are Delaunay, as where a constraint was taken away (Lawson 1977)."""
    changed = True
    while changed:
        changed = False
        for t in range(len(corners)):
            for k in range(3):
                s = np.int64(neighbours[t, k])
                if s >= 0 and fixed[t, k] == 0:
                    far = np.int64(corners[s, across(neighbours, s, t)])
                    if is_in_circle(points, corners, t, far):
                        flip(corners, neighbours, fixed, at, t, k)
                        changed = True


@exact_kernel
def add_winding(points, corners, neighbours, at, constraints, steps):
    """Count in `steps`, (m, 3) int32, how often constraints pass each side with the triangle to their left, less how
    often with it to their right.
    """
    for number in range(len(constraints)):
        a, b = np.int64(constraints[number, 0]), np.int64(constraints[number, 1])
        while a != b:
            t, k = _first_step(points, corners, neighbours, at, a, b)
            i = corner_of(corners, t, a)
            way = 1 if (i + 2) % 3 == k else -1
            steps[t, k] += way
            s = np.int64(neighbours[t, k])
            if s >= 0:
                steps[s, across(neighbours, s, t)] -= way
            a = np.int64(corners[t, 3 - i - k])


@exact_kernel
def spread_winding(neighbours, steps, winding, seen, queue):
    """Winding numbers of triangles from those of the outside, 0, inwards; returns whether all ways agree.

    `seen`, (m,) bool, is False before; `queue` is (m,) int32 scratch.
    """
    count = np.int64(0)
    for t in range(len(neighbours)):
        for k in range(3):
            if neighbours[t, k] < 0 and not seen[t]:
                seen[t] = True
                winding[t] = steps[t, k]
                queue[count] = t
                count += 1
    at = np.int64(0)
    while at < count:
        t = np.int64(queue[at])
        at += 1
        for k in range(3):
            s = np.int64(neighbours[t, k])
            if s >= 0 and not seen[s]:
                seen[s] = True
                winding[s] = winding[t] - steps[t, k]
                queue[count] = s
                count += 1
    for t in range(len(neighbours)):
        for k in range(3):
            s = np.int64(neighbours[t, k])
            if winding[t] - steps[t, k] != (winding[s] if s >= 0 else 0):
                return False
    return True
