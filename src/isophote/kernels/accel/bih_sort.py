"""Triangles sorted into the cells of a grid, for the parts of a bounding interval hierarchy (bih_layout.py)."""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.build import RECORD
from isophote.kernels.base.jit import device, kernel
from isophote.kernels.base.simd import load8, minimum, splat8, store8, store_float

__all__ = ["cells_of", "extent_of", "order_by_cell"]

_INFINITY = np.float32(np.inf)


@kernel
def extent_of(positions, begin, end, found):
    """Least corner and negated greatest corner of points `begin` to `end`, into `found` (6,)."""
    x0 = y0 = z0 = x1 = y1 = z1 = _INFINITY
    for i in range(begin, end):
        x, y, z = positions[3 * i], positions[3 * i + 1], positions[3 * i + 2]
        x0, y0, z0 = min(x, x0), min(y, y0), min(z, z0)
        x1, y1, z1 = min(-x, x1), min(-y, y1), min(-z, z1)
    found[0], found[1], found[2], found[3], found[4], found[5] = x0, y0, z0, x1, y1, z1


@device
def _cell(low, high, origin, scale, cells):
    """The cell between `low` and `high` on an axis; `origin` is twice that of the grid."""
    return min(max(np.int64((np.float64(low) + np.float64(high) - origin) * scale), np.int64(0)), cells - 1)


@kernel
def cells_of(positions, corners, numbers, frame, shape, begin, end, cells, counts, boxes):
    """Cells, into `cells`, of the triangles in places `begin` to `end` of `numbers`, or of those of these numbers where
    it is empty, by the centres of their boxes.

    The grid has `shape` (3,) int64 cells from frame[:3] on, frame[3] to a unit of length, in twice the centres.
    `counts` takes how many triangles are in each cell, `boxes` records (build.py) of their boxes.
    """
    counts[:] = 0
    for k in range(len(counts)):
        store8(boxes, k * RECORD, splat8(_INFINITY))
    found = np.empty(RECORD, np.float32)
    found[3] = found[7] = 0
    scale = frame[3]
    for i in range(begin, end):
        triangle = np.int64(numbers[i]) if len(numbers) > 0 else np.int64(i)
        a, b, c = 3 * corners[3 * triangle], 3 * corners[3 * triangle + 1], 3 * corners[3 * triangle + 2]
        cell = np.int64(0)
        for k in range(3):
            x, y, z = positions[a + k], positions[b + k], positions[c + k]
            low, high = min(x, min(y, z)), max(x, max(y, z))
            store_float(found, k, low)
            store_float(found, 4 + k, -high)
            cell = cell * shape[k] + _cell(low, high, frame[k], scale, shape[k])
        cells[i] = cell
        counts[cell] += 1
        store8(boxes, cell * RECORD, minimum(load8(found, 0), load8(boxes, cell * RECORD)))


@kernel
def order_by_cell(cells, numbers, begin, end, places, order):
    """Put the triangles in places `begin` to `end` where those of their cells go: `places` has the next one's place for
    each cell, and moves on."""
    for i in range(begin, end):
        cell = cells[i]
        order[places[cell]] = numbers[i] if len(numbers) > 0 else np.int32(i)
        places[cell] += 1
