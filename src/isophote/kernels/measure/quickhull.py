"""Convex hulls of three and four dimensions, and lower hulls of points lifted to a paraboloid, by quickhull.

Barber, Dobkin, Huhdanpaa, "The Quickhull Algorithm for Convex Hulls", 1996, with exact predicates: a facet is seen from
a point strictly beyond it. So no facet is flat and none is lost, whatever the points; rounded distances only choose
which point is next. `_KIND_*` say which determinant decides: of the points, or of the points lifted by the sum of their
squares, which is an in-circle or in-sphere test and is never rounded.

Facets lie in one int32 array, `RECORD` numbers each: `d` vertices at 0, the neighbours opposite to them at 4. The
determinant of a facet's vertices and a point beyond it is positive.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import exact_apart, exact_device, exact_inline, exact_kernel
from isophote.kernels.base.orient4d import orient4d
from isophote.kernels.base.predicates import incircle, insphere, orient3d

__all__ = [
    "COUNT",
    "KIND_LIFTED_PLANE",
    "KIND_LIFTED_SPACE",
    "KIND_SPACE",
    "KIND_SPACE_4",
    "PENDING",
    "RECORD",
    "expand_hull",
    "first_facets",
    "side_of",
]

RECORD = 8
_LINK = 4
KIND_SPACE, KIND_SPACE_4, KIND_LIFTED_PLANE, KIND_LIFTED_SPACE = 0, 1, 2, 3
# The state between calls: facets written, and the first that may still have points beyond it.
COUNT, PENDING = 0, 1
_NONE = np.int64(-1)
_DELETED = np.int64(-2)


@exact_apart
def side_of(points, kind, a, b, c, d, e):
    """The sign of the determinant of a facet (a, b, c) or (a, b, c, d) and the last point, by kind."""
    if kind == KIND_LIFTED_PLANE:
        return incircle(
            points[a, 0],
            points[a, 1],
            points[b, 0],
            points[b, 1],
            points[c, 0],
            points[c, 1],
            points[e, 0],
            points[e, 1],
        )
    ax, ay, az = points[a, 0], points[a, 1], points[a, 2]
    bx, by, bz = points[b, 0], points[b, 1], points[b, 2]
    cx, cy, cz = points[c, 0], points[c, 1], points[c, 2]
    ex, ey, ez = points[e, 0], points[e, 1], points[e, 2]
    if kind == KIND_SPACE:
        return orient3d(ax, ay, az, bx, by, bz, cx, cy, cz, ex, ey, ez)
    dx, dy, dz = points[d, 0], points[d, 1], points[d, 2]
    if kind == KIND_LIFTED_SPACE:
        return insphere(ax, ay, az, bx, by, bz, cx, cy, cz, dx, dy, dz, ex, ey, ez)
    return orient4d(
        (ax, ay, az, points[a, 3]),
        (bx, by, bz, points[b, 3]),
        (cx, cy, cz, points[c, 3]),
        (dx, dy, dz, points[d, 3]),
        (ex, ey, ez, points[e, 3]),
    )


@exact_device
def _minor(places, facets, f, i, j, k):
    """The determinant of columns i, j, k of the differences of a facet's vertices."""
    o, a, b, c = facets[f, 0], facets[f, 1], facets[f, 2], facets[f, 3]
    ax, ay, az = places[a, i] - places[o, i], places[a, j] - places[o, j], places[a, k] - places[o, k]
    bx, by, bz = places[b, i] - places[o, i], places[b, j] - places[o, j], places[b, k] - places[o, k]
    cx, cy, cz = places[c, i] - places[o, i], places[c, j] - places[o, j], places[c, k] - places[o, k]
    return ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)


@exact_device
def _set_plane(places, facets, planes, f, dimension):
    """A facet's normal; its length does not matter among the points beyond one facet."""
    o, a, b = facets[f, 0], facets[f, 1], facets[f, 2]
    if dimension == 3:
        ax, ay, az = places[a, 0] - places[o, 0], places[a, 1] - places[o, 1], places[a, 2] - places[o, 2]
        bx, by, bz = places[b, 0] - places[o, 0], places[b, 1] - places[o, 1], places[b, 2] - places[o, 2]
        planes[f, 0], planes[f, 1], planes[f, 2] = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
        return
    planes[f, 0] = _minor(places, facets, f, 1, 2, 3)
    planes[f, 1] = -_minor(places, facets, f, 0, 2, 3)
    planes[f, 2] = _minor(places, facets, f, 0, 1, 3)
    planes[f, 3] = -_minor(places, facets, f, 0, 1, 2)


@exact_inline
def _height(places, facets, planes, f, p, dimension):
    """How far a point is from a facet, positive inside, in units of the normal's length."""
    value = 0.0
    o = facets[f, 0]
    for k in range(dimension):
        value += planes[f, k] * (places[p, k] - places[o, k])
    return value


@exact_inline
def _beyond(points, places, kind, dimension, tolerance, facets, planes, f, p):
    """Whether a point lies strictly beyond a facet; by the rounded plane if that is sure."""
    height = _height(places, facets, planes, f, p, dimension)
    if height < -tolerance:
        return True
    if height > tolerance:
        return False
    a, b = np.int64(facets[f, 0]), np.int64(facets[f, 1])
    c, d = np.int64(facets[f, 2]), np.int64(facets[f, 3])
    return side_of(points, kind, a, b, c, d, p) > 0


@exact_inline
def _give(places, facets, planes, lists, distances, following, f, p, dimension):
    """Put a point on the list of a facet that it is beyond, the furthest one first."""
    distance = -_height(places, facets, planes, f, p, dimension)
    head = lists[f]
    if head < 0 or distance > distances[f]:
        following[p] = head
        lists[f] = p
        distances[f] = distance
    else:
        following[p] = following[head]
        following[head] = p


@exact_device
def _add_facet(places, facets, planes, lists, state, dimension):
    f = state[COUNT]
    state[COUNT] += 1
    lists[f] = _NONE
    _set_plane(places, facets, planes, f, dimension)
    return f


@exact_kernel
def first_facets(
    points, places, kind, dimension, tolerance, simplex, facets, planes, lists, distances, following, state
):
    """Write the facets of a simplex of `dimension` + 1 points, and give all points to facets that they are beyond."""
    for k in range(dimension + 1):
        for j in range(dimension):
            facets[k, j] = simplex[j + (j >= k)]
            facets[k, _LINK + j] = j + (j >= k)
        if dimension == 3:
            facets[k, 3] = facets[k, 0]
        a, b, c, d = facets[k, 0], facets[k, 1], facets[k, 2], facets[k, 3]
        if side_of(points, kind, a, b, c, d, simplex[k]) > 0:
            facets[k, 0], facets[k, 1] = facets[k, 1], facets[k, 0]
            facets[k, _LINK], facets[k, _LINK + 1] = facets[k, _LINK + 1], facets[k, _LINK]
            if dimension == 3:
                facets[k, 3] = facets[k, 0]
        _add_facet(places, facets, planes, lists, state, dimension)
    for p in range(len(points)):
        for f in range(dimension + 1):
            if _beyond(points, places, kind, dimension, tolerance, facets, planes, f, p):
                _give(places, facets, planes, lists, distances, following, f, p, dimension)
                break


@exact_inline
def _find_seen(points, places, kind, dimension, tolerance, facets, planes, marks, seen, rim, first, p):
    """Gather the facets that a point is beyond, and the ridges around them; (-1, -1) if there is no room."""
    seen[0] = first
    marks[first] = p
    count, ridges, at = 1, 0, 0
    while at < count:
        f = np.int64(seen[at])
        at += 1
        if ridges + 4 > len(rim) or count + 4 > len(seen):
            return np.int64(-1), np.int64(-1)
        for k in range(dimension):
            g = np.int64(facets[f, _LINK + k])
            if marks[g] == p:
                continue
            if _beyond(points, places, kind, dimension, tolerance, facets, planes, g, p):
                marks[g] = p
                seen[count] = g
                count += 1
            else:
                rim[ridges] = 4 * f + k
                ridges += 1
    return np.int64(count), np.int64(ridges)


@exact_inline
def _join(facets, heads, chains, f, k, u, v, entry):
    """Link a new facet across its ridge `k` to the one met there before; the ridge is named by vertices u > v."""
    e = np.int64(heads[u])
    while e >= 0:
        if chains[e, 0] == v:
            g, j = chains[e, 1], chains[e, 2]
            facets[f, _LINK + k] = g
            facets[g, _LINK + j] = f
            return entry
        e = np.int64(chains[e, 3])
    chains[entry, 0], chains[entry, 1], chains[entry, 2], chains[entry, 3] = v, f, k, heads[u]
    heads[u] = entry
    return entry + 1


@exact_inline
def _build(places, dimension, facets, planes, lists, marks, state, heads, chains, rim, ridges, p):
    """New facets from the ridges to a point."""
    entry = np.int64(0)
    for i in range(ridges):
        old, k = np.int64(rim[i]) >> 2, np.int64(rim[i]) & 3
        f = state[COUNT]
        outer = np.int64(facets[old, _LINK + k])
        for j in range(dimension):
            facets[f, j] = facets[old, j]
            if facets[outer, _LINK + j] == old:
                facets[outer, _LINK + j] = f
        facets[f, k] = p
        facets[f, _LINK + k] = outer
        if dimension == 3:
            facets[f, 3] = facets[f, 0]
        marks[f] = _NONE
        _add_facet(places, facets, planes, lists, state, dimension)
        for j in range(dimension):
            if j == k:
                continue
            u, v = _NONE, _NONE
            for l in range(dimension):
                if l != j and l != k:
                    w = np.int64(facets[f, l])
                    u, v = (w, u) if w > u else (u, w)
            entry = _join(facets, heads, chains, f, j, u, v, entry)
    for i in range(ridges):
        old = np.int64(rim[i]) >> 2
        for j in range(dimension):
            heads[facets[old, j]] = _NONE


@exact_inline
def _hand_on(
    points,
    places,
    kind,
    dimension,
    tolerance,
    facets,
    planes,
    lists,
    distances,
    following,
    marks,
    seen,
    count,
    first,
    last,
):
    """Give the points of facets that are gone to new ones; those beyond none are inside."""
    for i in range(count):
        f = np.int64(seen[i])
        q = np.int64(lists[f])
        while q >= 0:
            after = np.int64(following[q])
            for g in range(first, last):
                if _beyond(points, places, kind, dimension, tolerance, facets, planes, g, q):
                    _give(places, facets, planes, lists, distances, following, g, q, dimension)
                    break
            q = after
        lists[f] = _NONE
        marks[f] = _DELETED


@exact_kernel
def expand_hull(
    points,
    places,
    kind,
    dimension,
    tolerance,
    facets,
    planes,
    lists,
    distances,
    following,
    marks,
    heads,
    seen,
    rim,
    chains,
    state,
):
    """Go on until no facet has a point beyond it; returns whether that is so, or else room is short.

    points     (n, d) float64 for the determinants; places (n, dimension), in a box of size 1, rounded, for distances
    tolerance  the least height that is sure to have the right sign; infinity: none
    facets     (capacity, RECORD) int32; planes (capacity, 4) float64; lists (capacity,) int32, first point beyond;
               distances (capacity,) float64 of that; marks (capacity,) int64: -2 for facets that are gone
    following  (n,) int32: next on the list; heads (n,) int32: -1
    seen, rim  int32 scratch; chains (ridges, 4) int32 scratch
    state      int64: see COUNT and PENDING
    """
    while state[PENDING] < state[COUNT]:
        f = state[PENDING]
        if marks[f] == _DELETED or lists[f] < 0:
            state[PENDING] += 1
            continue
        p = np.int64(lists[f])
        count, ridges = _find_seen(points, places, kind, dimension, tolerance, facets, planes, marks, seen, rim, f, p)
        if count < 0 or state[COUNT] + ridges > len(facets) or 3 * ridges > len(chains):
            for i in range(len(marks)):
                if marks[i] == p:
                    marks[i] = _NONE
            return False
        lists[f] = following[p]
        first = state[COUNT]
        _build(places, dimension, facets, planes, lists, marks, state, heads, chains, rim, ridges, p)
        last = state[COUNT]
        _hand_on(
            points,
            places,
            kind,
            dimension,
            tolerance,
            facets,
            planes,
            lists,
            distances,
            following,
            marks,
            seen,
            count,
            first,
            last,
        )
    return True
