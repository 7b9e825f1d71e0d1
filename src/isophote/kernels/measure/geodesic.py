"""Exact geodesic distances on triangle meshes: windows are carried across faces, the nearest first.

A window is a stretch of an edge whose points see a common source straight across the faces unfolded so far. It lies on
the edge that it enters a face by. Carried across the face it falls on one or both of the other edges. A source is a
given vertex or, later, a vertex where shortest paths may turn: one with more than 2π round it, or on the boundary.

Chen, Han: "Shortest paths on a polyhedron", 1990: of the windows that see the vertex opposite an edge only the one
that is nearest to it goes on to both sides. Xin, Wang: "Improving Chen and Han's algorithm on the discrete geodesic
problem", 2009: the queue, and windows dropped where a vertex is a nearer source for all of their points (theorem 3.2).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from isophote.kernels.base.jit import device, kernel

__all__ = ["exact_distances"]

# Windows: face, edge, and these numbers: the stretch, the source (x along the edge, y behind it), how far the source
# itself is, and the key in the queue.
_START, _END, _X, _Y, _BEFORE, _KEY, _NUMBERS = (np.int64(k) for k in range(7))
_NONE = np.int64(-1)
# Rounding of lengths, in parts of them: what is nearer by less is as near, what is seen by less is seen.
_ROUNDING = 1e-12
_FIRST_ROOM = 4096


class Surface(NamedTuple):
    """Points (n, 3), triangles (m, 3), the half-edges across the edges (m, 3), their lengths (m, 3), whether paths may
    turn at a vertex (n,), and the corners at each vertex: `corners[firsts[v]:firsts[v + 1]]`, 3 face + number."""

    points: object
    triangles: object
    across: object
    lengths: object
    turning: object
    firsts: object
    corners: object


class Queue(NamedTuple):
    """A heap of numbers of windows or, from -1 down, of vertices; free windows; sizes of the heap and of the free."""

    heap: object
    keys: object
    free: object
    sizes: object


# --- the queue ------------------------------------------------------------------------------------


@device
def _push(queue, key, item):
    at = queue.sizes[0]
    queue.sizes[0] += 1
    while at > 0:
        above = (at - 1) >> 1
        if queue.keys[above] <= key:
            break
        queue.keys[at], queue.heap[at] = queue.keys[above], queue.heap[above]
        at = above
    queue.keys[at], queue.heap[at] = key, item


@device
def _pop(queue):
    """(key, item) of the least key."""
    key, item = queue.keys[0], queue.heap[0]
    queue.sizes[0] -= 1
    size = queue.sizes[0]
    moved_key, moved = queue.keys[size], queue.heap[size]
    at = np.int64(0)
    while True:
        below = 2 * at + 1
        if below >= size:
            break
        if below + 1 < size and queue.keys[below + 1] < queue.keys[below]:
            below += 1
        if queue.keys[below] >= moved_key:
            break
        queue.keys[at], queue.heap[at] = queue.keys[below], queue.heap[below]
        at = below
    queue.keys[at], queue.heap[at] = moved_key, moved
    return key, item


@device
def _longer(array):
    longer = np.empty((2 * len(array), *array.shape[1:]), array.dtype)
    longer[: len(array)] = array
    return longer


# --- geometry of a face ---------------------------------------------------------------------------


@device
def _apex(surface, face, edge):
    """The vertex opposite an edge of a face, along the edge from its first vertex, and away from it."""
    a = surface.triangles[face, edge]
    b = surface.triangles[face, (edge + 1) % 3]
    c = surface.triangles[face, (edge + 2) % 3]
    p = surface.points
    length = surface.lengths[face, edge]
    ux, uy, uz = (p[b, 0] - p[a, 0]) / length, (p[b, 1] - p[a, 1]) / length, (p[b, 2] - p[a, 2]) / length
    wx, wy, wz = p[c, 0] - p[a, 0], p[c, 1] - p[a, 1], p[c, 2] - p[a, 2]
    along = wx * ux + wy * uy + wz * uz
    wx, wy, wz = wx - along * ux, wy - along * uy, wz - along * uz
    return along, math.sqrt(wx * wx + wy * wy + wz * wz)


@device
def _where(bx, by, sx, sy, px, py, ex, ey):
    """Where the ray from (sx, sy) through (bx, by) meets the line from p along e, in parts of e, between 0 and 1."""
    dx, dy = bx - sx, by - sy
    across = dx * ey - dy * ex
    if across == 0.0:
        return 0.0
    return max(0.0, min(1.0, -(dx * (py - sy) - dy * (px - sx)) / across))


# --- windows --------------------------------------------------------------------------------------


@device
def _far(w, at):
    """The distance of a point of the window's edge by way of the window's source."""
    return w[_BEFORE] + math.hypot(at - w[_X], w[_Y])


@device
def _enter(surface, distance, half_edge, w, reverse, other, near_start, windows, places, queue):
    """Queue a window `w` on a half-edge, unless it is of no use.

    `reverse`: whether `w` runs against the half-edge. `other`: the vertex opposite the edge on the side it comes from;
    `near_start`: whether it entered that face by an edge at the start of `w`'s edge, rather than at its end.
    """
    face, edge = half_edge // 3, half_edge % 3
    length = surface.lengths[face, edge]
    a, b = surface.triangles[face, edge], surface.triangles[face, (edge + 1) % 3]
    if reverse:
        w[_START], w[_END] = length - w[_END], length - w[_START]
        w[_X] = length - w[_X]
        near_start = not near_start
    slack = _ROUNDING * (length + w[_BEFORE] + abs(w[_X]) + w[_Y])
    start, end = w[_START], w[_END]
    if _far(w, end) > distance[a] + end + slack or _far(w, start) > distance[b] + (length - start) + slack:
        return
    along, away = _apex(surface, surface.across[face, edge] // 3, surface.across[face, edge] % 3)
    if surface.triangles[surface.across[face, edge] // 3, surface.across[face, edge] % 3] != a:
        along = length - along
    inner = start if near_start else end
    if _far(w, inner) > distance[other] + math.hypot(inner - along, away) + slack:
        return
    w[_KEY] = _far(w, min(max(w[_X], start), end))
    queue.sizes[1] -= 1
    number = queue.free[queue.sizes[1]]
    windows[number] = w
    places[number] = half_edge
    _push(queue, w[_KEY], number)


@device
def _lower(surface, distance, vertex, far, queue):
    """A path of length `far` was found to a vertex. Where paths may turn, the vertex becomes a source."""
    if far >= distance[vertex]:
        return
    distance[vertex] = far
    if surface.turning[vertex] != 0:
        _push(queue, far, -1 - vertex)


@device
def _radiate(surface, distance, vertex, windows, places, queue, w):
    """Windows from a vertex on all edges opposite to it."""
    for k in range(surface.firsts[vertex], surface.firsts[vertex + 1]):
        corner = surface.corners[k]
        face, edge = corner // 3, (corner % 3 + 1) % 3
        a, b = surface.triangles[face, edge], surface.triangles[face, (edge + 1) % 3]
        far = distance[vertex]
        _lower(surface, distance, a, far + surface.lengths[face, corner % 3], queue)
        _lower(surface, distance, b, far + surface.lengths[face, (edge + 1) % 3], queue)
        across = surface.across[face, edge]
        if across < 0:
            continue
        w[_START], w[_END] = 0.0, surface.lengths[face, edge]
        w[_X], w[_Y] = _apex(surface, face, edge)
        w[_BEFORE] = far
        reverse = surface.triangles[across // 3, across % 3] != a
        _enter(surface, distance, across, w, reverse, vertex, True, windows, places, queue)


@device
def _pass_on(surface, distance, half_edge, w, left, cx, cy, low, high, windows, places, queue, child):
    """Queue what a window lights of the left edge of its face (or the right one): parts `low` to `high` from its edge.

    (cx, cy) is the face's apex.
    """
    face, edge = half_edge // 3, half_edge % 3
    exit_edge = (edge + 2) % 3 if left else (edge + 1) % 3
    across = surface.across[face, exit_edge]
    length = surface.lengths[face, exit_edge]
    if across < 0 or not high > low:
        return
    px = 0.0 if left else surface.lengths[face, edge]
    ex, ey = (cx - px) / length, cy / length
    x, y = w[_X] - px, -w[_Y]
    child[_START], child[_END] = low * length, high * length
    child[_X], child[_Y] = x * ex + y * ey, abs(x * ey - y * ex)
    child[_BEFORE] = w[_BEFORE]
    near = surface.triangles[face, edge] if left else surface.triangles[face, (edge + 1) % 3]
    other = surface.triangles[face, (edge + 1) % 3] if left else surface.triangles[face, edge]
    reverse = surface.triangles[across // 3, across % 3] != near
    _enter(surface, distance, across, child, reverse, other, True, windows, places, queue)


@device
def _carry(surface, distance, best, entry, half_edge, w, windows, places, queue, child):
    """Carry a window across the face that it enters."""
    face, edge = half_edge // 3, half_edge % 3
    cx, cy = _apex(surface, face, edge)
    length = surface.lengths[face, edge]
    sx, sy = w[_X], -w[_Y]
    reach = _ROUNDING * (length + abs(cx) + cy + abs(sx) + w[_Y])
    # Where the straight line from the source to the apex crosses the edge.
    crossing = sx + (cx - sx) * w[_Y] / (cy + w[_Y]) if cy + w[_Y] > 0.0 else cx
    go_left, go_right = crossing > w[_START], crossing < w[_END]
    if w[_START] - reach <= crossing <= w[_END] + reach:
        apex = surface.triangles[face, (edge + 2) % 3]
        far = w[_BEFORE] + math.hypot(cx - sx, cy + w[_Y])
        _lower(surface, distance, apex, far, queue)
        if far < best[half_edge]:
            best[half_edge], entry[half_edge] = far, crossing
        if far > best[half_edge] + reach:
            go_left &= crossing < entry[half_edge]
            go_right &= crossing > entry[half_edge]
    if go_left:
        low = _where(w[_START], 0.0, sx, sy, 0.0, 0.0, cx, cy)
        high = 1.0 if crossing <= w[_END] else _where(w[_END], 0.0, sx, sy, 0.0, 0.0, cx, cy)
        _pass_on(surface, distance, half_edge, w, True, cx, cy, low, high, windows, places, queue, child)
    if go_right:
        low = _where(w[_END], 0.0, sx, sy, length, 0.0, cx - length, cy)
        high = 1.0 if crossing >= w[_START] else _where(w[_START], 0.0, sx, sy, length, 0.0, cx - length, cy)
        _pass_on(surface, distance, half_edge, w, False, cx, cy, low, high, windows, places, queue, child)


@kernel
def exact_distances(points, triangles, across, lengths, turning, firsts, corners, sources, most, distance):
    """Fill `distance` (n,), infinite before, with lengths of shortest paths from `sources` over the surface.

    Arrays as in `Surface`. Returns the number of windows carried, or -1 if more than `most` waited at one time.
    """
    surface = Surface(points, triangles, across, lengths, turning, firsts, corners)
    best, entry = np.full(3 * len(triangles), np.inf), np.zeros(3 * len(triangles))
    room = max(_FIRST_ROOM, 2 * len(triangles)) + 3 * len(sources)
    windows, places = np.empty((room, _NUMBERS), np.float64), np.empty(room, np.int64)
    queue = Queue(
        np.empty(2 * room, np.int64), np.empty(2 * room), np.arange(room), np.array([0, room], np.int64)
    )  # fmt: skip
    w, child = np.empty(_NUMBERS), np.empty(_NUMBERS)
    # What one step may need: two windows and a vertex, or two vertices and a window for each corner at a vertex.
    need = np.int64(8)
    for vertex in range(len(points)):
        need = max(need, 3 * (firsts[vertex + 1] - firsts[vertex]) + 8)
    for source in sources:
        distance[source] = 0.0
        _push(queue, 0.0, -1 - source)
    carried = 0
    while queue.sizes[0] > 0:
        if queue.sizes[1] < need or queue.sizes[0] + need > len(queue.heap):
            if room > most:
                return _NONE
            windows, places = _longer(windows), _longer(places)
            free = np.empty(2 * room, np.int64)
            free[: queue.sizes[1]] = queue.free[: queue.sizes[1]]
            free[queue.sizes[1] : queue.sizes[1] + room] = np.arange(room, 2 * room)
            sizes = np.array([queue.sizes[0], queue.sizes[1] + room], np.int64)
            queue = Queue(_longer(queue.heap), _longer(queue.keys), free, sizes)
            room *= 2
        key, item = _pop(queue)
        if item < 0:
            vertex = -1 - item
            if key <= distance[vertex]:
                _radiate(surface, distance, vertex, windows, places, queue, child)
            continue
        w[:] = windows[item]
        queue.free[queue.sizes[1]] = item
        queue.sizes[1] += 1
        carried += 1
        _carry(surface, distance, best, entry, places[item], w, windows, places, queue, child)
    return carried
