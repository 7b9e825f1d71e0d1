"""Delaunay triangulations of the plane by dividing and conquering.

Points come in the order of `spatial_order`, with the rank of the cut before each. Finer cuts are merged first, along
the cut's axis (Guibas and Stolfi, 1985; alternating axes: Dwyer, "A faster divide-and-conquer algorithm for
constructing Delaunay triangulations", 1987). A part is a half of its hull that has the outside to its left, or ~v for a
single point v.

A cut of even rank is vertical: what comes before it lies to the left. After turning by a right angle the same holds for
odd ranks, so one function merges both.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import exact_device, exact_inline, exact_kernel
from isophote.kernels.base.predicates import incircle, orient2d
from isophote.kernels.measure.edges import (
    OUTSIDE,
    append_free,
    connect,
    delete_edge,
    drain,
    face,
    left_next,
    left_previous,
    make_edge,
    open_subdivision,
    origin,
    origin_next,
    origin_previous,
    set_face,
    splice,
)

__all__ = ["link_faces", "list_faces", "mark_outside", "merge_parts", "number_faces", "triangulate_part"]

_COARSEST = np.int32(-1)
_orient2d, _incircle = exact_inline(orient2d.py_func), exact_inline(incircle.py_func)


@exact_device
def _x(points, v):
    return points[np.uint64(2 * v)]


@exact_device
def _y(points, v):
    return points[np.uint64(2 * v + 1)]


@exact_device
def _before(points, a, b, turned):
    """Whether a comes before b across a cut: by x and then y, or, turned, by y and then -x."""
    ax, ay, bx, by = _x(points, a), _y(points, a), _x(points, b), _y(points, b)
    if turned:
        return ay < by or (ay == by and ax > bx)
    return ax < bx or (ax == bx and ay < by)


@exact_device
def _last(points, edges, h, turned):
    """The half of the outside whose origin comes last; the order rises and falls once around a convex hull."""
    v = origin(edges, h)
    while True:
        following = left_next(edges, h)
        w = origin(edges, following)
        if not _before(points, v, w, turned):
            break
        h, v = following, w
    while True:
        preceding = left_previous(edges, h)
        w = origin(edges, preceding)
        if not _before(points, v, w, turned):
            return h
        h, v = preceding, w


@exact_device
def _first(points, edges, h, turned):
    """The half of the outside whose origin comes first."""
    v = origin(edges, h)
    while True:
        following = left_next(edges, h)
        w = origin(edges, following)
        if not _before(points, w, v, turned):
            break
        h, v = following, w
    while True:
        preceding = left_previous(edges, h)
        w = origin(edges, preceding)
        if not _before(points, w, v, turned):
            return h
        h, v = preceding, w


@exact_device
def _turn(points, a, b, c):
    return orient2d(_x(points, a), _y(points, a), _x(points, b), _y(points, b), _x(points, c), _y(points, c))


@exact_device
def _tangent(points, edges, free, left, right, turned):
    """Connect two parts by the edge below both, from right to left; it has the outside to its left."""
    l, r = ~left, ~right
    h, g = left, right
    if left >= 0:
        h = _last(points, edges, left, turned)
        l = origin(edges, h)
    if right >= 0:
        g = origin_next(edges, _first(points, edges, right, turned))
        r = origin(edges, g)
    while True:
        if left >= 0:
            end = origin(edges, h ^ 1)
            if _turn(points, l, end, r) > 0:
                h, l = left_next(edges, h), end
                continue
        if right >= 0:
            end = origin(edges, g ^ 1)
            if _turn(points, r, end, l) < 0:
                g, r = origin_next(edges, g ^ 1), end
                continue
        break
    base = make_edge(edges, free, r, l)
    if right >= 0:
        splice(edges, base, origin_previous(edges, g))
    if left >= 0:
        splice(edges, base ^ 1, h)
    return base


@exact_inline
def _left_candidate(points, edges, free, base, lx, ly, rx, ry):
    """The half from the left end of the base to the next vertex above it, after deleting what cannot stay; -1: none."""
    h = origin_next(edges, base ^ 1)
    if h == base ^ 1:
        return np.int64(-1)
    v = origin(edges, h ^ 1)
    x, y = _x(points, v), _y(points, v)
    if _orient2d(lx, ly, rx, ry, x, y) <= 0:
        return np.int64(-1)
    while True:
        following = origin_next(edges, h)
        if following == base ^ 1:
            return h
        w = origin(edges, following ^ 1)
        wx, wy = _x(points, w), _y(points, w)
        if _incircle(lx, ly, rx, ry, x, y, wx, wy) <= 0:
            return h
        delete_edge(edges, free, h)
        h, x, y = following, wx, wy


@exact_inline
def _right_candidate(points, edges, free, base, lx, ly, rx, ry):
    """As `_left_candidate`, from the right end."""
    h = origin_previous(edges, base)
    if h == base:
        return np.int64(-1)
    v = origin(edges, h ^ 1)
    x, y = _x(points, v), _y(points, v)
    if _orient2d(lx, ly, rx, ry, x, y) <= 0:
        return np.int64(-1)
    while True:
        following = origin_previous(edges, h)
        if following == base:
            return h
        w = origin(edges, following ^ 1)
        wx, wy = _x(points, w), _y(points, w)
        if _incircle(lx, ly, rx, ry, x, y, wx, wy) <= 0:
            return h
        delete_edge(edges, free, h)
        h, x, y = following, wx, wy


@exact_device
def _triangle(points, edges, free, h, v):
    """Join an edge by itself and a point; -1 if they lie on a line."""
    way = _turn(points, origin(edges, h), origin(edges, h ^ 1), v)
    if way == 0:
        return np.int64(-1)
    if way < 0:
        h ^= 1
    side = make_edge(edges, free, origin(edges, h ^ 1), v)
    splice(edges, side, h ^ 1)
    connect(edges, free, side, h)
    return h ^ 1


@exact_device
def _merge(points, edges, free, left, right, turned):
    """Merge two parts that a cut separates; returns a half that has the outside to its left."""
    if left < 0:
        if right < 0:
            return make_edge(edges, free, ~right, ~left)
        if origin_next(edges, right) == right and origin_next(edges, right ^ 1) == right ^ 1:
            done = _triangle(points, edges, free, right, ~left)
            if done >= 0:
                return done
    elif right < 0 and origin_next(edges, left) == left and origin_next(edges, left ^ 1) == left ^ 1:
        done = _triangle(points, edges, free, left, ~right)
        if done >= 0:
            return done
    base = lowest = _tangent(points, edges, free, left, right, turned)
    while True:
        l, r = origin(edges, base ^ 1), origin(edges, base)
        lx, ly, rx, ry = _x(points, l), _y(points, l), _x(points, r), _y(points, r)
        a = _left_candidate(points, edges, free, base, lx, ly, rx, ry)
        b = _right_candidate(points, edges, free, base, lx, ly, rx, ry)
        if a < 0:
            if b < 0:
                return lowest
            base = connect(edges, free, b, base ^ 1)
            continue
        if b >= 0:
            v, w = origin(edges, a ^ 1), origin(edges, b ^ 1)
            if _incircle(lx, ly, rx, ry, _x(points, v), _y(points, v), _x(points, w), _y(points, w)) > 0:
                base = connect(edges, free, b, base ^ 1)
                continue
        base = connect(edges, free, base ^ 1, a ^ 1)


@exact_device
def _longer(rows):
    """Twice the rows, of which the first are these."""
    longer = np.empty((2 * len(rows), 2), np.int64)
    for i in range(len(rows)):
        longer[i, 0], longer[i, 1] = rows[i, 0], rows[i, 1]
    return longer


@exact_kernel
def triangulate_part(words, begin, end):
    """Triangulate points `begin` to `end`; returns the part.

    Parts wait, each with the rank of the cut before it, until a coarser cut comes.

    `points` is flat float64, `cuts` int32 ranks, `edges` has room for three edges a point, `free` says which of them.
    """
    plane = open_subdivision(words)
    points, cuts, edges, free = plane.points, plane.cuts, plane.edges, plane.free
    waiting = np.empty((64, 2), np.int64)
    waiting[0, 0] = ~begin
    count = 1
    for i in range(begin + 1, end + 1):
        rank = cuts[i] if i < end else _COARSEST
        while count > 1 and waiting[count - 1, 1] > rank:
            count -= 1
            turned = waiting[count, 1] % 2 == 1
            waiting[count - 1, 0] = _merge(points, edges, free, waiting[count - 1, 0], waiting[count, 0], turned)
        if i == end:
            break
        if count == len(waiting):
            waiting = _longer(waiting)
        waiting[count, 0], waiting[count, 1] = ~i, rank
        count += 1
    drain(edges, free)
    return waiting[0, 0]


@exact_kernel
def merge_parts(words, left, right, rank):
    """Merge two finished parts along a cut; `free` takes over the unused edges of both."""
    plane = open_subdivision(words)
    points, edges, free = plane.points, plane.edges, plane.free
    append_free(edges, free, plane.other_free)
    return _merge(points, edges, free, left, right, rank % 2 == 1)


@exact_kernel
def mark_outside(edges, part, hull):
    """Mark the halves along the outside, and write their origins, clockwise; returns how many."""
    h = part
    count = 0
    while True:
        set_face(edges, h, OUTSIDE)
        hull[count] = origin(edges, h)
        count += 1
        h = left_next(edges, h)
        if h == part:
            return count


@exact_kernel
def list_faces(edges, begin, end, firsts):
    """Write the lowest halves of the triangles that have it between `begin` and `end`; how many."""
    count = np.int64(0)
    for h in range(begin, end):
        following = left_next(edges, h)
        last = left_next(edges, following)
        # Without a branch, which would be guessed wrong every other time; what is not counted is written over.
        firsts[np.uint64(count)] = h
        is_used = (origin(edges, h) >= 0) & (face(edges, h) != OUTSIDE)
        count += (h < following) & (h < last) & is_used
    return count


@exact_kernel
def number_faces(edges, names, firsts, triangles, first):
    """Number triangles, given by their lowest halves, from `first` on, and write them."""
    for i in range(len(firsts)):
        h = np.int64(firsts[i])
        g = left_next(edges, h)
        f = left_next(edges, g)
        at = first + i
        triangles[at, 0] = names[np.uint64(origin(edges, h))]
        triangles[at, 1] = names[np.uint64(origin(edges, g))]
        triangles[at, 2] = names[np.uint64(origin(edges, f))]
        set_face(edges, h, at)
        set_face(edges, g, at)
        set_face(edges, f, at)


@exact_kernel
def link_faces(edges, firsts, neighbours, first):
    """Write the neighbours, each opposite its corner, of the triangles numbered from `first` on."""
    for i in range(len(firsts)):
        h = np.int64(firsts[i])
        g = left_next(edges, h)
        at = first + i
        neighbours[at, 0] = face(edges, g ^ 1)
        neighbours[at, 1] = face(edges, left_next(edges, g) ^ 1)
        neighbours[at, 2] = face(edges, h ^ 1)
