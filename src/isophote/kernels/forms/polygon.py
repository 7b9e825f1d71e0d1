"""Polygons cut into triangles by clipping ears.

An ear is a corner that turns as the polygon does and whose triangle holds no other corner; a simple polygon of more
than three corners always has two (Meisters: "Polygons have ears", American Mathematical Monthly 82(6), 1975). Only
reflex corners, those that do not turn as the polygon does, can lie in an ear, so only they are looked at. They are
kept in lists, one for each cell of a grid over the polygon, and an ear asks the cells that it reaches into.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from isophote.kernels.base.jit import device, kernel

__all__ = ["clip_ears"]

# A polygon that had so many corners cut off without being ears crosses itself all over, and no cut is better than
# another: the rest is cut in turn, so that no input takes long.
_MOST_FORCED = 64

_LEAST_EXPONENT = -1000

# Corners for each cell of the grid, if all were reflex.
_CORNERS_A_CELL = 4


class Grid(NamedTuple):
    """A square grid over a polygon: its lower corner, cells for a unit of length, and cells along a side."""

    x: float
    y: float
    cells_x: float
    cells_y: float
    side: int


@njit(nogil=True, error_model="numpy")
def _turn(x, y, a, b, c):
    """Twice the signed area of the triangle a, b, c; compiled without contraction, so that zero stays zero."""
    return (x[b] - x[a]) * (y[c] - y[a]) - (y[b] - y[a]) * (x[c] - x[a])


@kernel
def clip_ears(vertices, indices, offsets, faces, first, corners):
    """Cut each of `faces` (f,) into triangles and write them to `corners` from row `first[face]` on.

    `vertices` (n, 3) float64, `indices` (c,) int32 and `offsets` (m + 1,) int64 are a mesh's; `corners` (t, 3) int64
    receives places in `indices`, as many rows as a face has corners, less two.
    """
    most = 0
    for face in faces:
        most = max(most, offsets[face + 1] - offsets[face])
    flat = np.empty((2, most))
    ring = np.empty((2, most), np.int64)
    # After the corners one entry for each cell of the grid, where its list of reflex corners begins and ends.
    reflex = np.empty((2, most + max(most // _CORNERS_A_CELL, 1)), np.int64)
    for face in faces:
        start, count = offsets[face], offsets[face + 1] - offsets[face]
        _flatten(vertices, indices, start, count, flat)
        _clip(flat[0], flat[1], count, ring, reflex, start, corners[first[face] :])


@device
def _flatten(vertices, indices, start, count, flat):
    """Project a polygon along Newell's normal onto a coordinate plane, so that it turns to the left."""
    origin, scale = _frame(vertices, indices, start, count)
    nx, ny, nz = _newell(vertices, indices, start, count, origin, scale)
    k = _largest(nx, ny, nz)
    if nx == 0 and ny == 0 and nz == 0:
        k = _thinnest(vertices, indices, start, count)
    i, j = (k + 1) % 3, (k + 2) % 3
    normal = (nx, ny, nz)
    if normal[k] < 0:
        i, j = j, i
    along = normal[k] if normal[k] != 0 else 1.0
    lean_i, lean_j = normal[i] / along, normal[j] / along
    for c in range(count):
        p = vertices[indices[start + c]]
        height = (p[k] * 0.5 - origin[k]) * scale
        flat[0, c] = (p[i] * 0.5 - origin[i]) * scale - lean_i * height
        flat[1, c] = (p[j] * 0.5 - origin[j]) * scale - lean_j * height


@device
def _frame(vertices, indices, start, count):
    """Half the first point, and a factor that brings the differences from it to about 1.

    Halves cannot overflow, and a power of two rounds nothing, so that straight stays straight.
    """
    p = vertices[indices[start]]
    origin = (p[0] * 0.5, p[1] * 0.5, p[2] * 0.5)
    extent = 0.0
    for c in range(count):
        p = vertices[indices[start + c]]
        for axis in range(3):
            extent = max(extent, abs(p[axis] * 0.5 - origin[axis]))
    return origin, math.ldexp(1.0, -max(math.frexp(extent)[1], _LEAST_EXPONENT))


@device
def _newell(vertices, indices, start, count, origin, scale):
    """Newell's normal: the sum of cross products of neighbours, twice the polygon's area in length."""
    nx, ny, nz = 0.0, 0.0, 0.0
    p = vertices[indices[start + count - 1]]
    px, py, pz = _local(p, origin, scale)
    for c in range(count):
        qx, qy, qz = _local(vertices[indices[start + c]], origin, scale)
        nx += (py - qy) * (pz + qz)
        ny += (pz - qz) * (px + qx)
        nz += (px - qx) * (py + qy)
        px, py, pz = qx, qy, qz
    return nx, ny, nz


@device
def _local(p, origin, scale):
    return (p[0] * 0.5 - origin[0]) * scale, (p[1] * 0.5 - origin[1]) * scale, (p[2] * 0.5 - origin[2]) * scale


@device
def _largest(x, y, z):
    ax, ay, az = abs(x), abs(y), abs(z)
    if az >= ax and az >= ay:
        return 2
    return 0 if ax >= ay else 1


@device
def _thinnest(vertices, indices, start, count):
    """The axis along which a polygon without a normal reaches least."""
    best, least = 2, np.inf
    for axis in (2, 1, 0):
        low, high = np.inf, -np.inf
        for c in range(count):
            value = vertices[indices[start + c], axis] * 0.5
            low, high = min(low, value), max(high, value)
        if high - low < least:
            best, least = axis, high - low
    return best


@device
def _clip(x, y, count, ring, reflex, start, triangles):
    """Cut the polygon (x, y), which turns to the left, into `count` - 2 rows of `triangles`.

    Corners where it folds back on itself go first, always: next to one, two corners at one place do not have their
    insides apart, and an ear could not be told from a corner across the fold.
    """
    before, after = ring[0], ring[1]
    grid = _grid(x, y, count)
    _link(x, y, count, before, after, reflex, grid)
    i, left, idle, forced, unfolded = 0, count, 0, 0, False
    while left > 3:
        if not (
            _folds(x, y, before[i], i, after[i])
            or (unfolded and (forced > _MOST_FORCED or _is_ear(x, y, i, before, after, reflex, count, grid)))
        ):
            i = after[i]
            idle += 1
            if idle < left:
                continue
            idle = 0
            if not unfolded:
                unfolded = True
                continue
            i = _smallest(x, y, i, left, before, after)
            forced += 1
        a, c = before[i], after[i]
        _write(triangles[count - left], start, a, i, c)
        _cut(x, y, i, before, after, reflex, count, grid)
        left -= 1
        idle = 0
        if _folds(x, y, before[a], a, c):
            i = a
        elif _folds(x, y, a, c, after[c]):
            i = c
        else:
            # Skipping one corner makes fewer slivers than cutting at neighbours.
            i = after[c]
    _write(triangles[count - 3], start, before[i], i, after[i])


@device
def _write(triangle, start, a, b, c):
    triangle[0], triangle[1], triangle[2] = start + a, start + b, start + c


@device
def _grid(x, y, count):
    low_x, high_x, low_y, high_y = np.inf, -np.inf, np.inf, -np.inf
    for c in range(count):
        low_x, high_x = min(low_x, x[c]), max(high_x, x[c])
        low_y, high_y = min(low_y, y[c]), max(high_y, y[c])
    side = max(int(math.sqrt(count / _CORNERS_A_CELL)), 1)
    wide, tall = max(high_x - low_x, 1e-30), max(high_y - low_y, 1e-30)
    return Grid(low_x, low_y, side / wide, side / tall, side)


@device
def _column(grid, x):
    return min(int((x - grid.x) * grid.cells_x), grid.side - 1)


@device
def _row(grid, y):
    return min(int((y - grid.y) * grid.cells_y), grid.side - 1)


@device
def _link(x, y, count, before, after, reflex, grid):
    for head in range(count, count + grid.side * grid.side):
        reflex[:, head] = head
    for c in range(count):
        before[c] = c - 1 if c > 0 else count - 1
        after[c] = c + 1 if c < count - 1 else 0
        reflex[:, c] = -1
    for c in range(count):
        _sort(x, y, c, before, after, reflex, count, grid)


@device
def _sort(x, y, i, before, after, reflex, count, grid):
    """Put a corner into its cell's list of reflex corners or take it out, as it turns now."""
    listed = reflex[1, i] >= 0
    convex = _turn(x, y, before[i], i, after[i]) > 0
    if convex and listed:
        _unlist(i, reflex)
    elif not convex and not listed:
        head = count + _row(grid, y[i]) * grid.side + _column(grid, x[i])
        first = reflex[1, head]
        reflex[0, i], reflex[1, i] = head, first
        reflex[1, head], reflex[0, first] = i, i


@device
def _unlist(i, reflex):
    a, b = reflex[0, i], reflex[1, i]
    reflex[1, a], reflex[0, b] = b, a
    reflex[:, i] = -1


@device
def _cut(x, y, i, before, after, reflex, count, grid):
    """Take a corner out of the ring."""
    a, c = before[i], after[i]
    after[a], before[c] = c, a
    if reflex[1, i] >= 0:
        _unlist(i, reflex)
    _sort(x, y, a, before, after, reflex, count, grid)
    _sort(x, y, c, before, after, reflex, count, grid)


@device
def _is_ear(x, y, b, before, after, reflex, count, grid):
    """Whether corner b can be cut off: it turns to the left, and its triangle holds no reflex corner.

    Corners at the same places as the triangle's own do not count: where a polygon touches itself, they pass by.
    """
    a, c = before[b], after[b]
    if _turn(x, y, a, b, c) <= 0:
        return False
    low_x, high_x = min(x[a], x[b], x[c]), max(x[a], x[b], x[c])
    low_y, high_y = min(y[a], y[b], y[c]), max(y[a], y[b], y[c])
    for row in range(_row(grid, low_y), _row(grid, high_y) + 1):
        for column in range(_column(grid, low_x), _column(grid, high_x) + 1):
            head = count + row * grid.side + column
            q = reflex[1, head]
            while q != head:
                if low_x <= x[q] <= high_x and low_y <= y[q] <= high_y and _holds(x, y, a, b, c, q):
                    return False
                q = reflex[1, q]
    return True


@device
def _holds(x, y, a, b, c, q):
    """Whether q is in the triangle a, b, c or on its outline, but at none of its corners."""
    return (
        _turn(x, y, a, b, q) >= 0
        and _turn(x, y, b, c, q) >= 0
        and _turn(x, y, c, a, q) >= 0
        and not (_same(x, y, q, a) or _same(x, y, q, b) or _same(x, y, q, c))
    )


@device
def _folds(x, y, a, b, c):
    """Whether the path a, b, c turns straight back at b or stays there."""
    return _turn(x, y, a, b, c) == 0 and (x[a] - x[b]) * (x[c] - x[b]) + (y[a] - y[b]) * (y[c] - y[b]) >= 0


@device
def _same(x, y, a, b):
    return x[a] == x[b] and y[a] == y[b]


@device
def _smallest(x, y, i, left, before, after):
    """The corner whose triangle has the least area: what is left to cut where there is no ear, degenerate or not."""
    best, least = i, np.inf
    for _ in range(left):
        area = abs(_turn(x, y, before[i], i, after[i]))
        if area < least:
            best, least = i, area
        i = after[i]
    return best
