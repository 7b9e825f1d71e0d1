"""Steps of remeshing: short edges become points, edges are flipped where that evens the valences, vertices move along
the surface.

Source: Botsch, Kobbelt, "A Remeshing Approach to Multiresolution Modeling", 2004. Triangles around vertices are told
in rings.py. Vertices are FREE, on a LINE of creases or boundary, along which they may move, or a CORNER that stays.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.double3 import Double3, cross3, difference, dot3, norm, row3, scaled, total
from isophote.kernels.base.jit import device, kernel
from isophote.kernels.measure.rings import (
    has_vertex,
    is_gone,
    keeps_its_connection,
    link,
    merge,
    triangle_cross,
    triangles_across,
    turns_over,
    unlink,
    vertices_around,
)

__all__ = ["CORNER", "FREE", "LINE", "collapse_short", "flip_edges", "relax", "tell_kinds"]

FREE, LINE, CORNER = np.uint8(0), np.uint8(1), np.uint8(2)
# A line that turns by more than acos of −this at a vertex has a corner there.
_STRAIGHT = -0.7
_INSIDE, _RIM = 6, 4


@device
def _faces_across(triangles, heads, following, a, b):
    """The first two triangles that have both vertices, −1 for none, and how many there are."""
    first, second, count, c = np.int64(-1), np.int64(-1), 0, heads[a]
    while True:
        f = np.int64(c // 3)
        if not is_gone(triangles, f) and has_vertex(triangles, f, b):
            if count == 0:
                first = f
            elif count == 1:
                second = f
            count += 1
        c = following[c]
        if c == heads[a]:
            return first, second, count


@device
def _is_crease(positions, triangles, heads, following, a, b, cosine):
    """Whether edge ab is on a boundary, or its triangles meet at an angle whose cosine is below `cosine`."""
    f, g, count = _faces_across(triangles, heads, following, a, b)
    if count != 2:
        return True
    n, m = triangle_cross(positions, triangles, f), triangle_cross(positions, triangles, g)
    return dot3(n, m) < cosine * norm(n) * norm(m)


@kernel
def tell_kinds(positions, triangles, heads, following, cosine, kinds, on_rim, near):
    """Fill (n,) `kinds`, and `on_rim`: 1 for ends of edges with one triangle, or three and more."""
    for v in range(positions.shape[0]):
        kinds[v], on_rim[v] = FREE, 0
        if heads[v] < 0:
            continue
        count = vertices_around(triangles, heads, following, v, near)
        lines, p = 0, row3(positions, v)
        first = Double3(0.0, 0.0, 0.0)
        straight = 1.0
        for k in range(count):
            w = near[k]
            if triangles_across(triangles, heads, following, v, w) != 2:
                on_rim[v] = 1
            if _is_crease(positions, triangles, heads, following, v, w, cosine):
                along = difference(row3(positions, w), p)
                along = scaled(along, 1.0 / max(norm(along), 1e-300))
                if lines == 0:
                    first = along
                elif lines == 1:
                    straight = dot3(first, along)
                lines += 1
        if lines == 2 and straight < _STRAIGHT:
            kinds[v] = LINE
        elif lines > 0 or count < 0:
            kinds[v] = CORNER


@device
def _meeting_place(positions, kinds, a, b, crease):
    """Where an edge may go when it becomes a point: (whether it may, place)."""
    p, q = row3(positions, a), row3(positions, b)
    if kinds[a] == FREE and kinds[b] == FREE:
        return True, scaled(total(p, q), 0.5)
    if kinds[a] == FREE:
        return True, q
    if kinds[b] == FREE:
        return True, p
    # Two on lines: along a common line only, and a corner stays where it is.
    return crease and (kinds[a] == LINE or kinds[b] == LINE), p if kinds[a] == CORNER else q


@device
def _is_roomy(positions, near, count, place, longest):
    """Whether all vertices are within `longest` of a place."""
    far = 0.0
    for k in range(count):
        far = max(far, norm(difference(row3(positions, near[k]), place)))
    return far <= longest


@kernel
def collapse_short(positions, triangles, heads, following, kinds, on_rim, cosine, shortest, longest, near_a, near_b):
    """Make points of edges below `shortest`, where no edge gets longer than `longest` by it. Returns how many."""
    done = 0
    for f in range(triangles.shape[0]):
        for i in range(3):
            if is_gone(triangles, f):
                break
            a, b = triangles[f, i], triangles[f, (i + 1) % 3]
            if norm(difference(row3(positions, a), row3(positions, b))) >= shortest:
                continue
            crease = _is_crease(positions, triangles, heads, following, a, b, cosine)
            allowed, place = _meeting_place(positions, kinds, a, b, crease)
            if not allowed or not keeps_its_connection(triangles, heads, following, on_rim, a, b, near_a, near_b):
                continue
            count_a = vertices_around(triangles, heads, following, a, near_a)
            count_b = vertices_around(triangles, heads, following, b, near_b)
            if not (
                _is_roomy(positions, near_a, count_a, place, longest)
                and _is_roomy(positions, near_b, count_b, place, longest)
            ):
                continue
            if turns_over(positions, triangles, heads, following, a, b, place) or turns_over(
                positions, triangles, heads, following, b, a, place
            ):
                continue
            positions[a, 0], positions[a, 1], positions[a, 2] = place.x, place.y, place.z
            kinds[a] = max(kinds[a], kinds[b])
            on_rim[a] |= on_rim[b]
            merge(triangles, heads, following, a, b)
            done += 1
    return done


@device
def _valence_error(triangles, heads, following, on_rim, v, change, near):
    count = vertices_around(triangles, heads, following, v, near) + change
    return (count - (_RIM if on_rim[v] != 0 else _INSIDE)) ** 2


@device
def _third(triangles, f, a, b):
    """The vertex of triangle f that is neither a nor b."""
    for i in range(3):
        if triangles[f, i] != a and triangles[f, i] != b:
            return triangles[f, i]
    return a


@device
def _replace(triangles, heads, following, f, a, b, c):
    """Give triangle f other vertices, in the rings too."""
    for i in range(3):
        unlink(heads, following, triangles[f, i], np.int32(3 * f + i))
    triangles[f, 0], triangles[f, 1], triangles[f, 2] = a, b, c
    for i in range(3):
        link(heads, following, triangles[f, i], np.int32(3 * f + i))


@device
def _faces_the_same_way(positions, a, b, c, n):
    """Whether triangle abc has area and faces to the side of n."""
    p = row3(positions, a)
    m = cross3(difference(row3(positions, b), p), difference(row3(positions, c), p))
    return dot3(m, n) > 0.5 * norm(m) * norm(n) and norm(m) > 1e-6 * norm(n)


@kernel
def flip_edges(positions, triangles, heads, following, on_rim, cosine, near):
    """Flip edges where that brings valences nearer to 6, or 4 on the boundary. Returns how many."""
    done = 0
    for f in range(triangles.shape[0]):
        for i in range(3):
            if is_gone(triangles, f):
                break
            a, b = triangles[f, i], triangles[f, (i + 1) % 3]
            first, second, count = _faces_across(triangles, heads, following, a, b)
            if a > b or count != 2 or _is_crease(positions, triangles, heads, following, a, b, cosine):
                continue
            g = second if first == f else first
            c, d = triangles[f, (i + 2) % 3], _third(triangles, g, a, b)
            if c == d or triangles_across(triangles, heads, following, c, d) > 0:
                continue
            before, after = 0, 0
            for v, change in ((a, -1), (b, -1), (c, 1), (d, 1)):
                before += _valence_error(triangles, heads, following, on_rim, v, 0, near)
                after += _valence_error(triangles, heads, following, on_rim, v, change, near)
            if after >= before:
                continue
            n = total(triangle_cross(positions, triangles, f), triangle_cross(positions, triangles, g))
            if _faces_the_same_way(positions, a, d, c, n) and _faces_the_same_way(positions, d, b, c, n):
                _replace(triangles, heads, following, f, a, d, c)
                _replace(triangles, heads, following, g, d, b, c)
                done += 1
    return done


@device
def _centre(positions, triangles, heads, following, v):
    """The centre of the triangles around v, by area, and their common normal."""
    middle, whole, area, c = Double3(0.0, 0.0, 0.0), Double3(0.0, 0.0, 0.0), 0.0, heads[v]
    while True:
        f = c // 3
        if not is_gone(triangles, f):
            n = triangle_cross(positions, triangles, f)
            size = norm(n)
            corners = total(row3(positions, triangles[f, 0]), row3(positions, triangles[f, 1]))
            corners = total(corners, row3(positions, triangles[f, 2]))
            middle, whole, area = total(middle, scaled(corners, size / 3.0)), total(whole, n), area + size
        c = following[c]
        if c == heads[v]:
            return middle, whole, area


@kernel
def relax(positions, triangles, heads, following, kinds, first, last, moved):
    """New places of vertices first ≤ v < last, (n, 3): toward the middle of what is around, along the surface."""
    for v in range(first, last):
        p = row3(positions, v)
        moved[v, 0], moved[v, 1], moved[v, 2] = p.x, p.y, p.z
        if heads[v] < 0 or kinds[v] != FREE:
            continue
        middle, normal, area = _centre(positions, triangles, heads, following, v)
        size = norm(normal)
        if area > 0.0 and size > 0.0:
            step = difference(scaled(middle, 1.0 / area), p)
            n = scaled(normal, 1.0 / size)
            step = difference(step, scaled(n, dot3(step, n)))
            moved[v, 0], moved[v, 1], moved[v, 2] = p.x + step.x, p.y + step.y, p.z + step.z
