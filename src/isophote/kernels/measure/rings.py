"""Triangles around vertices, as rings that change while a mesh is worked on.

The corners of triangles at a vertex are a ring: `following[c]` is the next corner at the vertex of corner c = 3f + i,
`heads[v]` one of them, NONE for a vertex without triangles. Triangles that are gone have NONE as their first vertex;
their corners may still be in rings.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.double3 import cross3, difference, dot3, norm, row3
from isophote.kernels.base.jit import device, kernel

__all__ = [
    "MOST_AROUND",
    "NONE",
    "fill_rings",
    "has_vertex",
    "is_gone",
    "keeps_its_connection",
    "link",
    "merge",
    "triangle_cross",
    "triangles_across",
    "turns_over",
    "unlink",
    "vertices_around",
]

NONE = np.int32(-1)
# Vertices around an edge that is collapsed, at most.
MOST_AROUND = 256
# A triangle may turn by less than acos of this when a vertex of it moves.
_TURN = 0.2


@device
def is_gone(triangles, f):
    """Whether triangle f was taken away."""
    return triangles[f, 0] < 0


@device
def has_vertex(triangles, f, v):
    """Whether v is a vertex of triangle f."""
    return triangles[f, 0] == v or triangles[f, 1] == v or triangles[f, 2] == v


@device
def triangle_cross(positions, triangles, f):
    """Twice the area of a triangle along its normal."""
    p = row3(positions, triangles[f, 0])
    return cross3(difference(row3(positions, triangles[f, 1]), p), difference(row3(positions, triangles[f, 2]), p))


@device
def link(heads, following, v, c):
    """Put corner c into the ring of vertex v."""
    if heads[v] == NONE:
        heads[v] = c
        following[c] = c
    else:
        following[c] = following[heads[v]]
        following[heads[v]] = c


@device
def unlink(heads, following, v, c):
    """Take corner c out of the ring of vertex v."""
    before = c
    while following[before] != c:
        before = following[before]
    if before == c:
        heads[v] = NONE
        return
    following[before] = following[c]
    heads[v] = before


@device
def triangles_across(triangles, heads, following, a, b):
    """How many triangles have both vertices."""
    count, c = 0, heads[a]
    while True:
        f = c // 3
        if not is_gone(triangles, f) and has_vertex(triangles, f, b):
            count += 1
        c = following[c]
        if c == heads[a]:
            return count


@device
def vertices_around(triangles, heads, following, v, found):
    """The vertices that share a triangle with v, to `found`. Returns how many; −1 where they don't fit."""
    count, c = 0, heads[v]
    while True:
        f = c // 3
        if not is_gone(triangles, f):
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
def keeps_its_connection(triangles, heads, following, on_rim, a, b, near_a, near_b):
    """Whether the surface is connected as before when edge ab becomes a point: the link condition.

    Source: Dey, Edelsbrunner, Guha, Nekhayev, "Topology Preserving Edge Contraction", 1999.
    """
    across = triangles_across(triangles, heads, following, a, b)
    if across > 2 or across == 0 or (across == 2 and on_rim[a] != 0 and on_rim[b] != 0):
        return False
    count_a = vertices_around(triangles, heads, following, a, near_a)
    count_b = vertices_around(triangles, heads, following, b, near_b)
    if count_a < 0 or count_b < 0 or count_a + count_b > MOST_AROUND:
        return False
    shared = 0
    for i in range(count_a):
        for j in range(count_b):
            shared += 1 if near_a[i] == near_b[j] else 0
    # The last four triangles of a closed part stay.
    return shared == across and count_a + count_b - shared > 4


@device
def turns_over(positions, triangles, heads, following, v, other, place):
    """Whether a triangle at v, but those that go, would turn too far or lose its area with v at `place`."""
    c = heads[v]
    while True:
        f, i = c // 3, c % 3
        if not is_gone(triangles, f) and not has_vertex(triangles, f, other):
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
def merge(triangles, heads, following, a, b):
    """Give all triangles of b to a, but those that have both, which go. Returns how many go."""
    gone, c = 0, heads[b]
    while True:
        f, i = c // 3, c % 3
        if not is_gone(triangles, f):
            if has_vertex(triangles, f, a):
                triangles[f, 0] = NONE
                gone += 1
            else:
                triangles[f, i] = a
        c = following[c]
        if c == heads[b]:
            break
    following[heads[a]], following[heads[b]] = following[heads[b]], following[heads[a]]
    heads[b] = NONE
    tidy(triangles, heads, following, a)
    return gone


@device
def tidy(triangles, heads, following, v):
    """Take the corners of triangles that are gone out of a ring."""
    start = heads[v]
    while is_gone(triangles, start // 3):
        start = following[start]
        if start == heads[v]:
            return
    heads[v] = start
    last, c = start, following[start]
    while c != start:
        if not is_gone(triangles, c // 3):
            following[last] = c
            last = c
        c = following[c]
    following[last] = start


@kernel
def fill_rings(triangles, heads, following):
    """Make the rings; `heads` comes filled with NONE."""
    for c in range(3 * triangles.shape[0]):
        link(heads, following, triangles[c // 3, c % 3], np.int32(c))
