"""Planar subdivisions as directed edges: each half of an edge knows its origin and its neighbours around it.

Edges live in one int32 array, four numbers a half: origin, next half counterclockwise around the origin, next half
clockwise, and the face to its left. The halves of an edge are 2k and 2k + 1, so that `h ^ 1` goes the other way.
Guibas and Stolfi, "Primitives for the Manipulation of General Subdivisions and the Computation of Voronoi Diagrams",
1985, without the dual.

Unused edges are a list: its first and last half, then a range of edges never used, in `free` (int64, 4).
"""

from __future__ import annotations

import numpy as np
from numba import types

from isophote.kernels.base.jit import exact_device
from isophote.kernels.base.table import INTS, LONGS, Table, ViewType

__all__ = [
    "EDGE",
    "FACE",
    "FREE",
    "HALF",
    "OUTSIDE",
    "SUBDIVISION",
    "append_free",
    "connect",
    "delete_edge",
    "drain",
    "face",
    "left_next",
    "left_previous",
    "make_edge",
    "open_subdivision",
    "origin",
    "origin_next",
    "origin_previous",
    "release",
    "set_face",
    "splice",
]

HALF = 4
EDGE = 2 * HALF
DOUBLES = ViewType(types.float64, 1)
# Arrays as views, which are passed on without counting references.
SUBDIVISION = Table("Subdivision", points=DOUBLES, cuts=INTS, edges=INTS, free=LONGS, other_free=LONGS)
open_subdivision = SUBDIVISION.open
ORIGIN, NEXT, PREVIOUS, FACE = 0, 1, 2, 3
FREE = 4
HEAD, TAIL, FRESH, FRESH_END = 0, 1, 2, 3
OUTSIDE = np.int32(-1)
_UNUSED = np.int32(-1)


@exact_device
def origin(edges, h):
    """The vertex that a half starts from; -1 for an unused half."""
    return np.int64(edges[np.uint64(HALF * h + ORIGIN)])


@exact_device
def origin_next(edges, h):
    """The next half counterclockwise around the origin."""
    return np.int64(edges[np.uint64(HALF * h + NEXT)])


@exact_device
def origin_previous(edges, h):
    """The next half clockwise around the origin."""
    return np.int64(edges[np.uint64(HALF * h + PREVIOUS)])


@exact_device
def face(edges, h):
    """The face to the left."""
    return np.int64(edges[np.uint64(HALF * h + FACE)])


@exact_device
def set_face(edges, h, number):
    """Name the face to the left."""
    edges[np.uint64(HALF * h + FACE)] = number


@exact_device
def left_next(edges, h):
    """The next half counterclockwise along the face to the left."""
    return origin_previous(edges, h ^ 1)


@exact_device
def left_previous(edges, h):
    """The half before this one along the face to the left."""
    return origin_next(edges, h) ^ 1


@exact_device
def splice(edges, a, b):
    """Join or part the rings around the origins of two halves."""
    after_a, after_b = origin_next(edges, a), origin_next(edges, b)
    edges[np.uint64(HALF * a + NEXT)] = after_b
    edges[np.uint64(HALF * b + NEXT)] = after_a
    edges[np.uint64(HALF * after_b + PREVIOUS)] = a
    edges[np.uint64(HALF * after_a + PREVIOUS)] = b


@exact_device
def make_edge(edges, free, a, b):
    """A new edge by itself from vertex a to vertex b; returns its first half."""
    h = free[HEAD]
    if h >= 0:
        free[HEAD] = origin_next(edges, h)
    else:
        h = 2 * free[FRESH]
        free[FRESH] += 1
    at = np.uint64(HALF * h)
    edges[at + np.uint64(ORIGIN)] = a
    edges[at + np.uint64(NEXT)] = h
    edges[at + np.uint64(PREVIOUS)] = h
    edges[at + np.uint64(FACE)] = 0
    edges[at + np.uint64(HALF + ORIGIN)] = b
    edges[at + np.uint64(HALF + NEXT)] = h + 1
    edges[at + np.uint64(HALF + PREVIOUS)] = h + 1
    edges[at + np.uint64(HALF + FACE)] = 0
    return h


@exact_device
def connect(edges, free, a, b):
    """A new edge from the end of half a to the origin of half b, in the face to the left of both."""
    h = make_edge(edges, free, origin(edges, a ^ 1), origin(edges, b))
    splice(edges, h, left_next(edges, a))
    splice(edges, h ^ 1, b)
    return h


@exact_device
def release(edges, free, h):
    """Put the edge of a half on the list of unused ones."""
    h &= ~1
    edges[np.uint64(HALF * h + ORIGIN)] = _UNUSED
    edges[np.uint64(HALF * h + HALF + ORIGIN)] = _UNUSED
    # So that a walk from an unused half leads nowhere else.
    edges[np.uint64(HALF * h + PREVIOUS)] = h
    edges[np.uint64(HALF * h + HALF + PREVIOUS)] = h
    edges[np.uint64(HALF * h + NEXT)] = free[HEAD]
    if free[HEAD] < 0:
        free[TAIL] = h
    free[HEAD] = h


@exact_device
def delete_edge(edges, free, h):
    """Take an edge out of both rings."""
    splice(edges, h, origin_previous(edges, h))
    splice(edges, h ^ 1, origin_previous(edges, h ^ 1))
    release(edges, free, h)


@exact_device
def drain(edges, free):
    """Put the edges never used on the list."""
    while free[FRESH] < free[FRESH_END]:
        release(edges, free, 2 * free[FRESH])
        free[FRESH] += 1


@exact_device
def append_free(edges, free, other):
    """Append the list of another part, whose edges are all on it or in use."""
    if other[HEAD] < 0:
        return
    if free[HEAD] < 0:
        free[HEAD] = other[HEAD]
    else:
        edges[np.uint64(HALF * free[TAIL] + NEXT)] = other[HEAD]
    free[TAIL] = other[TAIL]
