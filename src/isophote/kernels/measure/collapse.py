"""Simplification of triangle meshes by collapsing edges, the one that costs least first.

Costs wait in a heap with the ages of both ends; an entry whose ends have changed since is passed over. Triangles
around vertices are told in rings.py.
"""

from __future__ import annotations

import math

from isophote.kernels.base.double3 import cross3, difference, dot3, norm, row3, scaled
from isophote.kernels.base.jit import device, kernel
from isophote.kernels.measure.quadric import add_plane, best_place, quadric_error
from isophote.kernels.measure.rings import (
    MOST_AROUND,
    keeps_its_connection,
    merge,
    triangle_cross,
    triangles_across,
    turns_over,
    vertices_around,
)

__all__ = ["collapse_edges", "prepare_collapse"]

# How much a boundary edge's own plane counts beside those of faces.
_BOUNDARY = 1e3


@kernel
def prepare_collapse(positions, triangles, heads, following, quadrics, on_rim):
    """Fill the quadrics of vertices, and (n,) `on_rim`: 1 for ends of edges with one triangle or three."""
    for f in range(triangles.shape[0]):
        n = triangle_cross(positions, triangles, f)
        size = norm(n)
        if size > 0.0:
            for i in range(3):
                v = triangles[f, i]
                add_plane(quadrics, v, scaled(n, 1.0 / size), row3(positions, v), 0.5 * size)
                quadrics[v, 10] += 0.5 * size
    for c in range(3 * triangles.shape[0]):
        f, i = c // 3, c % 3
        a, b = triangles[f, i], triangles[f, (i + 1) % 3]
        if triangles_across(triangles, heads, following, a, b) != 2:
            on_rim[a] = on_rim[b] = 1
            _guard(positions, triangles, quadrics, f, a, b)


@device
def _guard(positions, triangles, quadrics, f, a, b):
    """Hold a boundary edge in place: a plane through it, upright on its triangle."""
    p = row3(positions, a)
    edge = difference(row3(positions, b), p)
    upright = cross3(edge, triangle_cross(positions, triangles, f))
    size = norm(upright)
    if size > 0.0:
        weight = _BOUNDARY * dot3(edge, edge)
        add_plane(quadrics, a, scaled(upright, 1.0 / size), p, weight)
        add_plane(quadrics, b, scaled(upright, 1.0 / size), p, weight)


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
            if a < b or triangles_across(triangles, heads, following, a, b) == 1:
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
        if not keeps_its_connection(triangles, heads, following, on_rim, a, b, near_a, near_b):
            continue
        if turns_over(positions, triangles, heads, following, a, b, place) or turns_over(
            positions, triangles, heads, following, b, a, place
        ):
            continue
        positions[a, 0], positions[a, 1], positions[a, 2] = place.x, place.y, place.z
        for k in range(11):
            quadrics[a, k] = q[k]
        on_rim[a] |= on_rim[b]
        left -= merge(triangles, heads, following, a, b)
        ages[a] += 1
        ages[b] = -1
        count = vertices_around(triangles, heads, following, a, near_a)
        if size + MOST_AROUND > costs.size:
            size = _forget_stale(ages, costs, ends, size)
        for k in range(count):
            size = _push(positions, quadrics, ages, costs, ends, size, a, near_a[k], q)
    return left
