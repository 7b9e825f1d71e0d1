"""Simplification of triangle meshes by collapsing edges, the one that costs least first.

The corners of triangles at a vertex are a ring: `following[c]` is the next corner at the vertex of corner c = 3f + i,
so that two vertices become one by swapping two links. Triangles that are gone have −1 as their first vertex. Costs
wait in a heap with the ages of both ends; an entry whose ends have changed since is passed over.
"""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.base.double3 import cross3, difference, dot3, norm, row3, scaled
from isophote.kernels.base.jit import device, kernel
from isophote.kernels.measure.quadric import add_plane, best_place, quadric_error

__all__ = ["MOST_AROUND", "collapse_edges", "prepare_collapse"]

# Triangles around a vertex that is collapsed, at most.
MOST_AROUND = 256
# A triangle may turn by less than acos of this when an end of it moves.
_TURN = 0.2
# How much a boundary edge's own plane counts beside those of faces.
_BOUNDARY = 1e3
_NONE = np.int32(-1)


@device
def _is_gone(triangles, f):
    return triangles[f, 0] < 0


@device
def _has(triangles, f, v):
    return triangles[f, 0] == v or triangles[f, 1] == v or triangles[f, 2] == v


@device
def _cross(positions, triangles, f):
    """Twice the area of a triangle along its normal."""
    p = row3(positions, triangles[f, 0])
    return cross3(difference(row3(positions, triangles[f, 1]), p), difference(row3(positions, triangles[f, 2]), p))


@kernel
def prepare_collapse(positions, triangles, heads, following, quadrics, on_rim):
    """Fill the rings of corners, the quadrics, and (n,) `on_rim`: 1 for ends of edges with one triangle or three."""
    for c in range(3 * triangles.shape[0]):
        v = triangles[c // 3, c % 3]
        if heads[v] == _NONE:
            heads[v] = c
            following[c] = c
        else:
            following[c] = following[heads[v]]
            following[heads[v]] = c
    for f in range(triangles.shape[0]):
        n = _cross(positions, triangles, f)
        size = norm(n)
        if size > 0.0:
            for i in range(3):
                v = triangles[f, i]
                add_plane(quadrics, v, scaled(n, 1.0 / size), row3(positions, v), 0.5 * size)
                quadrics[v, 10] += 0.5 * size
    for c in range(3 * triangles.shape[0]):
        f, i = c // 3, c % 3
        a, b = triangles[f, i], triangles[f, (i + 1) % 3]
        if _across(triangles, heads, following, a, b) != 2:
            on_rim[a] = on_rim[b] = 1
            _guard(positions, triangles, quadrics, f, a, b)


@device
def _guard(positions, triangles, quadrics, f, a, b):
    """Hold a boundary edge in place: a plane through it, upright on its triangle."""
    p = row3(positions, a)
    edge = difference(row3(positions, b), p)
    upright = cross3(edge, _cross(positions, triangles, f))
    size = norm(upright)
    if size > 0.0:
        weight = _BOUNDARY * dot3(edge, edge)
        add_plane(quadrics, a, scaled(upright, 1.0 / size), p, weight)
        add_plane(quadrics, b, scaled(upright, 1.0 / size), p, weight)


@device
def _across(triangles, heads, following, a, b):
    """How many triangles have both vertices."""
    count, c = 0, heads[a]
    while True:
        f = c // 3
        if not _is_gone(triangles, f) and _has(triangles, f, b):
            count += 1
        c = following[c]
        if c == heads[a]:
            return count


@device
def _around(triangles, heads, following, v, found):
    """The vertices that share a triangle with v, to `found`. Returns how many; −1 where they don't fit."""
    count, c = 0, heads[v]
    while True:
        f = c // 3
        if not _is_gone(triangles, f):
            for i in range(3):
                w = triangles[f, i]
                known = w == v
                for k in range(count):
                    known = known or found[k] == w
                if not known:
                    if count == MOST_AROUND:
                        return np.int64(-1)
                    found[count] = w
                    count += 1
        c = following[c]
        if c == heads[v]:
            return np.int64(count)


@device
def _keeps_its_connection(triangles, heads, following, on_rim, a, b, near_a, near_b):
    """Whether the surface is connected as before when edge ab becomes a point: the link condition.

    Source: Dey, Edelsbrunner, Guha, Nekhayev, "Topology Preserving Edge Contraction", 1999.
    """
    across = _across(triangles, heads, following, a, b)
    if across > 2 or across == 0 or (across == 2 and on_rim[a] != 0 and on_rim[b] != 0):
        return False
    count_a = _around(triangles, heads, following, a, near_a)
    count_b = _around(triangles, heads, following, b, near_b)
    if count_a < 0 or count_b < 0 or count_a + count_b > MOST_AROUND:
        return False
    shared = 0
    for i in range(count_a):
        for j in range(count_b):
            shared += 1 if near_a[i] == near_b[j] else 0
    # The last four triangles of a closed part stay.
    return shared == across and count_a + count_b - shared > 4


@device
def _turns_over(positions, triangles, heads, following, v, other, place):
    """Whether a triangle at v, but those that go, would turn too far or lose its area with v at `place`."""
    c = heads[v]
    while True:
        f, i = c // 3, c % 3
        if not _is_gone(triangles, f) and not _has(triangles, f, other):
            p = row3(positions, v)
            q, r = row3(positions, triangles[f, (i + 1) % 3]), row3(positions, triangles[f, (i + 2) % 3])
            before = cross3(difference(q, p), difference(r, p))
            after = cross3(difference(q, place), difference(r, place))
            sizes = norm(before) * norm(after)
            if norm(before) > 0.0 and not dot3(before, after) > _TURN * sizes:
                return True
        c = following[c]
        if c == heads[v]:
            return False


@device
def _merge(triangles, heads, following, a, b):
    """Give all triangles of b to a, but those that have both, which go. Returns how many go."""
    gone, c = 0, heads[b]
    while True:
        f, i = c // 3, c % 3
        if not _is_gone(triangles, f):
            if _has(triangles, f, a):
                triangles[f, 0] = _NONE
                gone += 1
            else:
                triangles[f, i] = a
        c = following[c]
        if c == heads[b]:
            break
    following[heads[a]], following[heads[b]] = following[heads[b]], following[heads[a]]
    _tidy(triangles, heads, following, a)
    return gone


@device
def _tidy(triangles, heads, following, v):
    """Take the corners of triangles that are gone out of a ring."""
    start = heads[v]
    while _is_gone(triangles, start // 3):
        start = following[start]
        if start == heads[v]:
            return
    heads[v] = start
    last, c = start, following[start]
    while c != start:
        if not _is_gone(triangles, c // 3):
            following[last] = c
            last = c
        c = following[c]
    following[last] = start


@device
def _combined(quadrics, a, b, q):
    for k in range(11):
        q[k] = quadrics[a, k] + quadrics[b, k]


@device
def _swap(costs, ends, i, j):
    costs[i], costs[j] = costs[j], costs[i]
    for k in range(4):
        ends[i, k], ends[j, k] = ends[j, k], ends[i, k]


@device
def _before(costs, ends, i, j):
    """The order of the heap: by cost, then by vertices."""
    if costs[i] != costs[j]:
        return costs[i] < costs[j]
    return ends[i, 0] < ends[j, 0] or (ends[i, 0] == ends[j, 0] and ends[i, 1] < ends[j, 1])


@device
def _rise(costs, ends, at):
    while at > 0 and _before(costs, ends, at, (at - 1) // 2):
        _swap(costs, ends, at, (at - 1) // 2)
        at = (at - 1) // 2


@device
def _sink(costs, ends, size, at):
    while 2 * at + 1 < size:
        child = 2 * at + 1
        if child + 1 < size and _before(costs, ends, child + 1, child):
            child += 1
        if not _before(costs, ends, child, at):
            return
        _swap(costs, ends, at, child)
        at = child


@device
def _push(positions, quadrics, ages, costs, ends, size, a, b, q):
    """Put edge ab into the heap. Returns its new size."""
    a, b = min(a, b), max(a, b)
    _combined(quadrics, a, b, q)
    place = best_place(q, row3(positions, a), row3(positions, b))
    costs[size] = quadric_error(q, place)
    ends[size, 0], ends[size, 1], ends[size, 2], ends[size, 3] = a, b, ages[a], ages[b]
    _rise(costs, ends, size)
    return size + 1


@device
def _forget_stale(ages, costs, ends, size):
    """Drop entries whose ends have changed since, and order the rest anew. Returns the new size."""
    kept = 0
    for k in range(size):
        if ages[ends[k, 0]] == ends[k, 2] and ages[ends[k, 1]] == ends[k, 3]:
            _swap(costs, ends, kept, k)
            kept += 1
    for at in range(kept // 2 - 1, -1, -1):
        _sink(costs, ends, kept, at)
    return kept


@kernel
def collapse_edges(
    positions, triangles, heads, following, quadrics, on_rim, ages, costs, ends, near_a, near_b, q, left, wanted, most
):
    """Collapse edges until `wanted` of `left` triangles are left, or none is left whose error is at most `most`.

    `ages` (n,) int32 zeroed; `costs` (k,) and `ends` (k, 4) int32 the heap, with room for all edges and some; `near_a`,
    `near_b` (MOST_AROUND,) int32 and `q` (11,) scratch. Returns how many triangles are left.
    """
    size = 0
    for f in range(triangles.shape[0]):
        for i in range(3):
            a, b = triangles[f, i], triangles[f, (i + 1) % 3]
            # Once an edge: by the triangle along which it rises, or by the only one.
            if a < b or _across(triangles, heads, following, a, b) == 1:
                size = _push(positions, quadrics, ages, costs, ends, size, a, b, q)
    while left > wanted and size > 0:
        a, b = ends[0, 0], ends[0, 1]
        stale = ages[a] != ends[0, 2] or ages[b] != ends[0, 3]
        size -= 1
        _swap(costs, ends, 0, size)
        _sink(costs, ends, size, 0)
        if stale:
            continue
        _combined(quadrics, a, b, q)
        place = best_place(q, row3(positions, a), row3(positions, b))
        if math.sqrt(quadric_error(q, place) / max(q[10], 1e-300)) > most:
            continue
        if not _keeps_its_connection(triangles, heads, following, on_rim, a, b, near_a, near_b):
            continue
        if _turns_over(positions, triangles, heads, following, a, b, place) or _turns_over(
            positions, triangles, heads, following, b, a, place
        ):
            continue
        positions[a, 0], positions[a, 1], positions[a, 2] = place.x, place.y, place.z
        for k in range(11):
            quadrics[a, k] = q[k]
        on_rim[a] |= on_rim[b]
        left -= _merge(triangles, heads, following, a, b)
        ages[a] += 1
        ages[b] = -1
        count = _around(triangles, heads, following, a, near_a)
        if size + MOST_AROUND > costs.size:
            size = _forget_stale(ages, costs, ends, size)
        for k in range(count):
            size = _push(positions, quadrics, ages, costs, ends, size, a, near_a[k], q)
    return left
