"""The Voronoi diagram as the dual of a Delaunay triangulation: vertices, edges, partners of sites, nearest sites."""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import exact_device, exact_inline, exact_kernel, kernel
from isophote.kernels.base.predicates import INCIRCLE_BOUND, incircle
from isophote.kernels.measure.fortune_circles import centre

__all__ = [
    "centres",
    "count_edges",
    "edge_signs",
    "follow",
    "hull_after",
    "link_sites",
    "name_rows",
    "nearest_sites",
    "write_edges",
]

_NEXT = (1, 2, 0)
_BEFORE = (2, 0, 1)
_FIRST = np.int32(0)
_ONE, _TWO, _THREE = np.uint64(1), np.uint64(2), np.uint64(3)
# Twice what is needed, since it is rounded as well.
_OUTSIDE_BOUND = 2 * INCIRCLE_BOUND
_UNDERFLOW = 2.0**-1022


@exact_inline
def _place(points, v):
    """A point of flat coordinates."""
    at = _TWO * np.uint64(v)
    return points[at], points[at + _ONE]


@exact_kernel
def centres(points, triangles, begin, end, middles):
    """Write the middles of the circles through the corners of triangles `begin` to `end`; all arrays are flat."""
    for t in range(begin, end):
        first = _THREE * np.uint64(t)
        ax, ay = _place(points, triangles[first])
        bx, by = _place(points, triangles[first + _ONE])
        cx, cy = _place(points, triangles[first + _TWO])
        row = _TWO * np.uint64(t)
        middles[row], middles[row + _ONE] = centre(ax, ay, bx, by, cx, cy)


@exact_device
def _tells(neighbour, t):
    """Whether triangle t tells its side to a neighbour: the lesser of two does, or the only one."""
    return (neighbour > t) | (neighbour < 0)


@exact_kernel
def count_edges(neighbours, begin, end):
    """How many edges triangles `begin` to `end` tell."""
    count = 0
    for t in range(begin, end):
        for k in range(3):
            count += _tells(neighbours[t, k], t)
    return count


@exact_kernel
def write_edges(triangles, neighbours, begin, end, row, stop, edges, sites):
    """Write the edges that triangles `begin` to `end` tell into rows `row` to `stop`; all arrays are flat.

    `edges` get the triangles on both sides, -1 for none, and `sites` those to the left and to the right.
    """
    for t in range(begin, end):
        first = _THREE * np.uint64(t)
        for k in range(3):
            if row == stop:
                return
            # Without a branch, which would be guessed wrong every other time; what is not told is written over.
            s = neighbours[first + np.uint64(k)]
            at = _TWO * np.uint64(row)
            edges[at], edges[at + _ONE] = t, s
            sites[at] = triangles[first + np.uint64(_BEFORE[k])]
            sites[at + _ONE] = triangles[first + np.uint64(_NEXT[k])]
            row += _tells(s, t)


@exact_inline
def _third(triangles, t, others):
    """The corner of a triangle besides two others, which are given as one number: the bits in which they differ."""
    first = _THREE * np.uint64(t)
    return triangles[first] ^ triangles[first + _ONE] ^ triangles[first + _TWO] ^ others


@exact_inline
def _is_outside(points, a, b, c, d):
    """Whether d surely lies outside the circle through a, b, c, counterclockwise.

    By the filter of `incircle`, with a bound that is greater and takes less: |u × v| and so on are |u| |v| at most, and
    that is half of u² + v² at most.
    """
    dx, dy = _place(points, d)
    ax, ay = _place(points, a)
    bx, by = _place(points, b)
    cx, cy = _place(points, c)
    ax, ay, bx, by, cx, cy = ax - dx, ay - dy, bx - dx, by - dy, cx - dx, cy - dy
    u, v, w = ax * ax + ay * ay, bx * bx + by * by, cx * cx + cy * cy
    value = u * (bx * cy - cx * by) + v * (cx * ay - ax * cy) + w * (ax * by - bx * ay)
    return -value > _OUTSIDE_BOUND * (u * v + v * w + w * u) + _UNDERFLOW * (u + v + w + 1)


@exact_inline
def _far_corners(triangles, edges, sites, e):
    """(a, b, c, d): the triangles at an edge are a, b, c, counterclockwise, and d, c, b."""
    at = _TWO * np.uint64(e)
    b, c = sites[at + _ONE], sites[at]
    # At the end of a ray, any triangle.
    return _third(triangles, edges[at], b ^ c), b, c, _third(triangles, max(edges[at + _ONE], _FIRST), b ^ c)


@exact_kernel
def edge_signs(points, triangles, edges, sites, row, stop, signs):
    """Write which edges in rows `row` to `stop` are right, as `write_edges` left them; counts the wrong, and the ties.

    1: wrong, the far corner of one triangle lies in the circle of the other; 0: all four corners lie on one; -1: right.
    All arrays are flat.
    """
    doubts = 0
    for e in range(row, stop):
        a, b, c, d = _far_corners(triangles, edges, sites, e)
        is_right = (edges[_TWO * np.uint64(e) + _ONE] < 0) | _is_outside(points, a, b, c, d)
        signs[np.uint64(e)] = -np.int8(is_right)
        doubts += not is_right
    wrong = ties = 0
    if doubts:
        for e in range(row, stop):
            if signs[np.uint64(e)] == 0:
                a, b, c, d = _far_corners(triangles, edges, sites, e)
                sign = incircle(*_place(points, a), *_place(points, b), *_place(points, c), *_place(points, d))
                signs[np.uint64(e)] = sign
                wrong += sign > 0
                ties += sign == 0
    return wrong, ties


@exact_kernel
def name_rows(names, row, stop, numbers):
    """Exchange pairs of numbers, in rows `row` to `stop`, for their names; all flat."""
    for i in range(2 * row, 2 * stop):
        numbers[np.uint64(i)] = names[np.uint64(numbers[np.uint64(i)])]


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
