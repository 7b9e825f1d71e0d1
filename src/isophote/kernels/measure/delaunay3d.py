"""Delaunay triangulations of space, point by point: the tetrahedra whose spheres hold a new point make way for it.

Tetrahedra lie in one int32 array, eight numbers each: four vertices, and for each the neighbour across the opposite
face. `orient3d` of the vertices is positive. Every face of the hull has a tetrahedron on its other side whose fourth
vertex is -1, at infinity: it conflicts with a point strictly beyond the face, or in the face's plane where the finite
neighbour conflicts. With strict and exact conflicts the hole is star-shaped around the new point, and no new
tetrahedron is flat, whatever the points: where the new point lies in the plane of a face, both spheres at the face meet
the plane in one circle, so both sides conflict or none.

Bowyer, "Computing Dirichlet tessellations", 1981; Watson, 1981.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import exact_device, exact_inline, exact_kernel
from isophote.kernels.base.predicates import INSPHERE_BOUND, insphere, orient3d

__all__ = ["FIRST", "FREE", "FRESH", "RECORD", "STAMP", "WHERE", "insert_points", "start"]

RECORD = 8
_LINK = 4
INFINITE = np.int64(-1)
_NOWHERE = np.int32(-1)

# The state between calls: next point, unused tetrahedra on the list, first one never used, a recent one, last stamp.
FIRST, FREE, FRESH, WHERE, STAMP = 0, 1, 2, 3, 4

# 72 terms of the determinant, each at most the product of the greatest differences along the axes times the square of
# the greatest of all.
_QUICK_BOUND = 73 * INSPHERE_BOUND
_SMALLEST, _GREATEST = 1e-58, 1e58


@exact_device
def _vertex(tets, t, k):
    return np.int64(tets[np.uint64(RECORD * t + k)])


@exact_device
def _link(tets, t, k):
    return np.int64(tets[np.uint64(RECORD * t + _LINK + k)])


@exact_device
def _set_vertex(tets, t, k, v):
    tets[np.uint64(RECORD * t + k)] = v


@exact_device
def _set_link(tets, t, k, s):
    tets[np.uint64(RECORD * t + _LINK + k)] = s


@exact_device
def _place(points, v):
    at = np.uint64(3 * v)
    return points[at], points[at + np.uint64(1)], points[at + np.uint64(2)]


@exact_device
def _side(points, a, b, c, d):
    ax, ay, az = _place(points, a)
    bx, by, bz = _place(points, b)
    cx, cy, cz = _place(points, c)
    dx, dy, dz = _place(points, d)
    return orient3d(ax, ay, az, bx, by, bz, cx, cy, cz, dx, dy, dz)


@exact_inline
def _is_in_sphere(points, tets, t, ex, ey, ez):
    """Whether a point lies strictly inside the sphere of a finite tetrahedron."""
    ax, ay, az = _place(points, _vertex(tets, t, 0))
    bx, by, bz = _place(points, _vertex(tets, t, 1))
    cx, cy, cz = _place(points, _vertex(tets, t, 2))
    dx, dy, dz = _place(points, _vertex(tets, t, 3))
    aex, bex, cex, dex = ax - ex, bx - ex, cx - ex, dx - ex
    aey, bey, cey, dey = ay - ey, by - ey, cy - ey, dy - ey
    aez, bez, cez, dez = az - ez, bz - ez, cz - ez, dz - ez
    ab, bc, cd = aex * bey - bex * aey, bex * cey - cex * bey, cex * dey - dex * cey
    da, ac, bd = dex * aey - aex * dey, aex * cey - cex * aey, bex * dey - dex * bey
    a = aex * aex + aey * aey + aez * aez
    b = bex * bex + bey * bey + bez * bez
    c = cex * cex + cey * cey + cez * cez
    d = dex * dex + dey * dey + dez * dez
    value = (d * (aez * bc - bez * ac + cez * ab) - c * (dez * ab + aez * bd + bez * da)) + (
        b * (cez * da + dez * ac + aez * cd) - a * (bez * cd - cez * bd + dez * bc)
    )
    x = max(max(abs(aex), abs(bex)), max(abs(cex), abs(dex)))
    y = max(max(abs(aey), abs(bey)), max(abs(cey), abs(dey)))
    z = max(max(abs(aez), abs(bez)), max(abs(cez), abs(dez)))
    most = max(x, max(y, z))
    # Within these, nothing that underflows or overflows on the way counts.
    if min(x, min(y, z)) > _SMALLEST and most < _GREATEST:
        bound = _QUICK_BOUND * (x * y * z) * (most * most)
        if value > bound:
            return True
        if -value > bound:
            return False
    return insphere(ax, ay, az, bx, by, bz, cx, cy, cz, dx, dy, dz, ex, ey, ez) > 0


@exact_inline
def _conflicts(points, tets, t, p):
    x, y, z = _place(points, p)
    if _vertex(tets, t, 3) == INFINITE:
        side = _side(points, _vertex(tets, t, 0), _vertex(tets, t, 1), _vertex(tets, t, 2), p)
        if side != 0:
            return side > 0
        return _is_in_sphere(points, tets, _link(tets, t, 3), x, y, z)
    return _is_in_sphere(points, tets, t, x, y, z)


@exact_inline
def _locate(points, tets, t, p):
    """A tetrahedron that holds a point; one at infinity if the point is strictly beyond its face."""
    if _vertex(tets, t, 3) == INFINITE:
        t = _link(tets, t, 3)
    previous = INFINITE
    while True:
        a, b, c, d = _vertex(tets, t, 0), _vertex(tets, t, 1), _vertex(tets, t, 2), _vertex(tets, t, 3)
        following = INFINITE
        s = _link(tets, t, 0)
        if s != previous and _side(points, p, b, c, d) < 0:
            following = s
        if following == INFINITE:
            s = _link(tets, t, 1)
            if s != previous and _side(points, a, p, c, d) < 0:
                following = s
        if following == INFINITE:
            s = _link(tets, t, 2)
            if s != previous and _side(points, a, b, p, d) < 0:
                following = s
        if following == INFINITE:
            s = _link(tets, t, 3)
            if s != previous and _side(points, a, b, c, p) < 0:
                following = s
        if following == INFINITE:
            return t
        if _vertex(tets, following, 3) == INFINITE:
            return following
        previous, t = t, following


@exact_device
def _same_vertex(points, tets, t, p):
    """The vertex of a tetrahedron that a point equals, or -1."""
    x, y, z = _place(points, p)
    for k in range(4):
        v = _vertex(tets, t, k)
        if v != INFINITE:
            vx, vy, vz = _place(points, v)
            if x == vx and y == vy and z == vz:
                return v
    return INFINITE


@exact_inline
def _find_hole(points, tets, marks, hole, rim, first, p, stamp):
    """Gather the tetrahedra that conflict with a point, and the faces around them; (-1, -1) if there is no room.

    Marks conflicting ones with the stamp, and tried ones that do not conflict with the number after it.
    """
    hole[0] = first
    marks[np.uint64(first)] = stamp
    count, faces, at = 1, 0, 0
    while at < count:
        t = np.int64(hole[at])
        at += 1
        if faces + 4 > len(rim) or count + 4 > len(hole):
            return np.int64(-1), np.int64(-1)
        for k in range(4):
            s = _link(tets, t, k)
            mark = marks[np.uint64(s)]
            if mark == stamp:
                continue
            if mark != stamp + 1:
                if _conflicts(points, tets, s, p):
                    marks[np.uint64(s)] = stamp
                    hole[count] = s
                    count += 1
                    continue
                marks[np.uint64(s)] = stamp + 1
            rim[faces] = 4 * t + k
            faces += 1
    return np.int64(count), np.int64(faces)


@exact_device
def _point_back(tets, s, old, new):
    """Make a neighbour's link to one tetrahedron lead to another."""
    for k in range(4):
        if _link(tets, s, k) == old:
            _set_link(tets, s, k, new)


@exact_inline
def _join(tets, heads, chains, t, k, u, v, entry):
    """Link a new tetrahedron across its face `k`, at the new point and the edge u v, to the one met before there.

    Each edge of the rim is met twice; the first time it is put on the chain of its greater vertex.
    """
    if u < v:
        u, v = v, u
    e = np.int64(heads[np.uint64(u)])
    while e >= 0:
        if chains[e, 0] == v:
            s, j = np.int64(chains[e, 1]), np.int64(chains[e, 2])
            _set_link(tets, t, k, s)
            _set_link(tets, s, j, t)
            return entry
        e = np.int64(chains[e, 3])
    chains[entry, 0], chains[entry, 1], chains[entry, 2] = v, t, k
    chains[entry, 3] = heads[np.uint64(u)]
    heads[np.uint64(u)] = entry
    return entry + 1


@exact_inline
def _fill_hole(tets, free, state, heads, chains, rim, faces, p):
    """Connect all faces around the hole to the new point; returns one of the new tetrahedra."""
    entry = np.int64(0)
    t = np.int64(0)
    for i in range(faces):
        old, k = np.int64(rim[i]) >> 2, np.int64(rim[i]) & 3
        if state[FREE] > 0:
            state[FREE] -= 1
            t = np.int64(free[state[FREE]])
        else:
            t = state[FRESH]
            state[FRESH] += 1
        for j in range(4):
            _set_vertex(tets, t, j, _vertex(tets, old, j))
        _set_vertex(tets, t, k, p)
        outer = _link(tets, old, k)
        _set_link(tets, t, k, outer)
        _point_back(tets, outer, old, t)
        for j in range(4):
            if j != k:
                # The face opposite vertex j has the new point and the two other vertices of the rim's face.
                l = 0
                while l in (j, k):
                    l += 1
                entry = _join(tets, heads, chains, t, j, _vertex(tets, t, l), _vertex(tets, t, 6 - j - k - l), entry)
    for i in range(faces):
        old, k = np.int64(rim[i]) >> 2, np.int64(rim[i]) & 3
        for j in range(4):
            v = _vertex(tets, old, j)
            if v != INFINITE and j != k:
                heads[np.uint64(v)] = _NOWHERE
    return t


@exact_kernel
def insert_points(points, tets, marks, free, state, heads, hole, rim, chains, same_as):
    """Insert points from `state[FIRST]` on; returns whether all are in, or else room is short.

    points   flat float64; numbers of points are vertices
    tets     flat int32 of `RECORD` numbers a tetrahedron
    marks    int32 a tetrahedron, 0 before the first call
    free     int32 a tetrahedron: unused ones
    state    int64 (5): see FIRST to STAMP
    heads    int32 a point, -1
    hole     int32: room for conflicting tetrahedra; rim, for faces around them; chains, (faces, 4), for three halves of
             edges a face
    same_as  int32 a point: gets the vertex that each equals, if one does
    """
    capacity = len(tets) // RECORD
    for p in range(state[FIRST], len(points) // 3):
        state[FIRST] = p
        if state[STAMP] > 2000000000:
            marks[:] = 0
            state[STAMP] = 0
        state[STAMP] += 2
        t = _locate(points, tets, state[WHERE], p)
        v = _same_vertex(points, tets, t, p)
        if v != INFINITE:
            same_as[p] = v
            continue
        count, faces = _find_hole(points, tets, marks, hole, rim, t, p, state[STAMP])
        if count < 0 or 3 * faces > 2 * len(chains) or state[FRESH] + faces - state[FREE] > capacity:
            return False
        state[WHERE] = _fill_hole(tets, free, state, heads, chains, rim, faces, p)
        for i in range(count):
            free[state[FREE]] = hole[i]
            state[FREE] += 1
    state[FIRST] = len(points) // 3
    return True


@exact_kernel
def start(points, tets, first):
    """Write the tetrahedron of four points not in a plane, and the four at infinity around it."""
    for k in range(4):
        tets[k] = first[k]
    if _side(points, first[0], first[1], first[2], first[3]) < 0:
        tets[0], tets[1] = first[1], first[0]
    for k in range(4):
        # Seen from the other side of face k, its vertices go round the other way.
        i, j, l = (k + 1) % 4, (k + 2) % 4, (k + 3) % 4
        if _side(points, _vertex(tets, 0, i), _vertex(tets, 0, j), _vertex(tets, 0, l), _vertex(tets, 0, k)) > 0:
            i, j = j, i
        t = k + 1
        _set_vertex(tets, t, 0, _vertex(tets, 0, i))
        _set_vertex(tets, t, 1, _vertex(tets, 0, j))
        _set_vertex(tets, t, 2, _vertex(tets, 0, l))
        _set_vertex(tets, t, 3, INFINITE)
        _set_link(tets, t, 0, i + 1)
        _set_link(tets, t, 1, j + 1)
        _set_link(tets, t, 2, l + 1)
        _set_link(tets, t, 3, 0)
        _set_link(tets, 0, k, t)
