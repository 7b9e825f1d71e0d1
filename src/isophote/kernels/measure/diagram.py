"""The Voronoi diagram as the dual of a Delaunay triangulation: vertices, edges, partners of sites, nearest sites."""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import exact_device, exact_kernel, kernel
from isophote.kernels.measure.fortune_circles import centre

__all__ = ["centres", "count_edges", "follow", "hull_after", "link_sites", "nearest_sites", "write_edges"]

_NEXT = (1, 2, 0)
_BEFORE = (2, 0, 1)
_NONE = np.int32(-1)


@exact_kernel
def centres(points, triangles, begin, end, middles):
    """Write the middles of the circles through the corners of triangles `begin` to `end`."""
    for t in range(begin, end):
        a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        middles[t, 0], middles[t, 1] = centre(
            points[a, 0], points[a, 1], points[b, 0], points[b, 1], points[c, 0], points[c, 1]
        )


@exact_device
def _has_edge(neighbours, signs, t, k):
    """Whether side k of t is dual to an edge that is told with t; those between equal vertices are none."""
    s = neighbours[t, k]
    return s < 0 or (s > t and signs[t, k] != 0)


@exact_kernel
def count_edges(neighbours, signs, begin, end):
    """How many edges triangles `begin` to `end` tell; `signs` are those of `side_signs`."""
    count = 0
    for t in range(begin, end):
        for k in range(3):
            count += _has_edge(neighbours, signs, t, k)
    return count


@exact_kernel
def write_edges(triangles, neighbours, signs, vertex, begin, end, at, edges, sites):
    """Write edges from row `at` on: vertices, -1 for none, and the sites to the left and to the right.

    `vertex` is the number of the vertex of each triangle.
    """
    for t in range(begin, end):
        for k in range(3):
            if _has_edge(neighbours, signs, t, k):
                s = neighbours[t, k]
                edges[at, 0] = vertex[t]
                edges[at, 1] = vertex[s] if s >= 0 else _NONE
                sites[at, 0], sites[at, 1] = triangles[t, _BEFORE[k]], triangles[t, _NEXT[k]]
                at += 1


@exact_kernel
def hull_after(triangles, neighbours, after):
    """Write for each point on the hull the next one counterclockwise; returns one of them, and how many there are."""
    first, count = np.int64(-1), 0
    for t in range(len(triangles)):
        for k in range(3):
            if neighbours[t, k] < 0:
                first = np.int64(triangles[t, _NEXT[k]])
                after[first] = triangles[t, _BEFORE[k]]
                count += 1
    return first, count


@exact_kernel
def follow(after, first, chain):
    """Write a point and those that come after it."""
    for i in range(len(chain)):
        chain[i] = first
        first = after[first]


@exact_kernel
def link_sites(sites, starts, partners):
    """The partners of each site, from pairs (e, 2): `starts` (n + 1,) zeros, `partners` (2 e,)."""
    for e in range(len(sites)):
        starts[sites[e, 0] + 1] += 1
        starts[sites[e, 1] + 1] += 1
    for i in range(1, len(starts)):
        starts[i] += starts[i - 1]
    for e in range(len(sites)):
        for k in range(2):
            i = sites[e, k]
            partners[starts[i]] = sites[e, 1 - k]
            starts[i] += 1
    for i in range(len(starts) - 1, 0, -1):
        starts[i] = starts[i - 1]
    starts[0] = 0


@kernel
def nearest_sites(points, starts, partners, start, queries, begin, end, found):
    """Write the sites nearest to queries `begin` to `end`: from partner to partner, as long as one is nearer.

    A site that is not nearest has a nearer one across one of its edges. `start` (n,) are sites to begin at.
    """
    for q in range(begin, end):
        x, y = queries[q, 0], queries[q, 1]
        i = np.int64(start[q])
        least = (points[i, 0] - x) ** 2 + (points[i, 1] - y) ** 2
        while True:
            best = i
            for k in range(starts[i], starts[i + 1]):
                j = np.int64(partners[k])
                distance = (points[j, 0] - x) ** 2 + (points[j, 1] - y) ** 2
                if distance < least:
                    least, best = distance, j
            if best == i:
                break
            i = best
        found[q] = i
