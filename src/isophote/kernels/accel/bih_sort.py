"""Triangles sorted into the cells of a grid, for the parts of a bounding interval hierarchy (bih_layout.py)."""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.build import RECORD
from isophote.kernels.accel.triangle_box import AHEAD, Triangles, box_of, expect_triangle
from isophote.kernels.base.jit import kernel
from isophote.kernels.base.simd import lane, load4, load_float, maximum, minimum, splat4, splat8, store4, store8
from isophote.kernels.base.table import FLOATS, INTS, LONG_ROWS, Table

__all__ = ["SORT", "cells_of", "extent_of", "order_by_cell"]

_INFINITY, _ZERO = np.float32(np.inf), np.float32(0)
_AHEAD = np.int64(AHEAD)
_X, _Y, _Z = np.int32(0), np.int32(1), np.int32(2)

# `positions`, `corners`, `last_point`: Triangles (triangle_box.py). `numbers`: of those that are sorted; empty for all.
# `frame` (12,): the grid, in twice the centres: its first corner, cells to a unit of length, the last cell's number,
# each for three axes and once more for nothing. `cells`: of each triangle. Each job sorts a range of the triangles, and
# has a row of `counts`, how many are in each cell, of `boxes`, records (build.py) of what they bound, in whose words 3
# and 7 anything is left, and of `places`, where in `order` the next one of a cell goes.
SORT = Table(
    "Sort",
    positions=FLOATS,
    corners=INTS,
    last_point=FLOATS,
    numbers=INTS,
    frame=FLOATS,
    cells=INTS,
    counts=LONG_ROWS,
    boxes=FLOATS,
    places=LONG_ROWS,
    order=INTS,
)
open_sort = SORT.open


@kernel
def extent_of(positions, begin, end, found):
    """Least corner and negated greatest corner of points `begin` to `end`, into `found` (6,)."""
    x0 = y0 = z0 = x1 = y1 = z1 = _INFINITY
    for i in range(begin, end):
        x, y, z = positions[3 * i], positions[3 * i + 1], positions[3 * i + 2]
        x0, y0, z0 = min(x, x0), min(y, y0), min(z, z0)
        x1, y1, z1 = min(-x, x1), min(-y, y1), min(-z, z1)
    found[0], found[1], found[2], found[3], found[4], found[5] = x0, y0, z0, x1, y1, z1


@kernel
def cells_of(words, job, begin, end):
    """Find the cells of triangles `begin` to `end`, by the centres of their boxes."""
    sort = open_sort(words)
    counts, boxes = sort.counts[job], sort.boxes
    first = job * counts.rows
    for k in range(counts.rows):
        counts[k] = 0
        store8(boxes, (first + k) * RECORD, splat8(_INFINITY))
    origin, scale, last = load4(sort.frame, 0), load4(sort.frame, 4), load4(sort.frame, 8)
    along_y, along_z = np.int64(load_float(sort.frame, 9)) + 1, np.int64(load_float(sort.frame, 10)) + 1
    # Views are taken out of the table once: what is written might, for all the compiler knows, change it.
    triangles, numbers, cells = Triangles(sort.positions, sort.corners, sort.last_point), sort.numbers, sort.cells
    some = numbers.rows > 0
    for i in range(begin, end):
        ahead = min(i + _AHEAD, end - 1)
        expect_triangle(triangles, np.int64(numbers[ahead]) if some else np.int64(ahead))
        low, high = box_of(triangles, np.int64(numbers[i]) if some else np.int64(i))
        # The order of the operands turns a NaN, from an infinite extent, into the last cell.
        place = maximum(minimum((low + high - origin) * scale, last), splat4(_ZERO))
        x, y, z = np.int64(lane(place, _X)), np.int64(lane(place, _Y)), np.int64(lane(place, _Z))
        cell = (x * along_y + y) * along_z + z
        cells[i] = np.int32(cell)
        counts[cell] += 1
        row = (first + cell) * RECORD
        store4(boxes, row, minimum(low, load4(boxes, row)))
        store4(boxes, row + 4, minimum(splat4(_ZERO) - high, load4(boxes, row + 4)))


@kernel
def order_by_cell(words, job, begin, end):
    """Put triangles `begin` to `end` where those of their cells go."""
    sort = open_sort(words)
    places, numbers, cells, order = sort.places[job], sort.numbers, sort.cells, sort.order
    some = numbers.rows > 0
    for i in range(begin, end):
        cell = np.int64(cells[i])
        order[places[cell]] = numbers[i] if some else np.int32(i)
        places[cell] += 1
