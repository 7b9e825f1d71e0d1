"""Rays that begin so far from a grid that their rounding is more than the slack of its lists.

Such a ray goes from slice to slice of cells along its longest axis, and looks into every cell of a slice that it may
come within its rounding of; of grids within grids, into all cells.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.contract import STACK, closest_in_blocks
from isophote.kernels.accel.grid_layout import NEAR_ORIGINS
from isophote.kernels.accel.spread import spread_of
from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import load_int, store_int

__all__ = ["closest_from_afar", "is_far"]

_ROOT, _ONE = np.int64(0), np.int64(1)
_BOTTOM = np.int64(STACK)


@device
def is_far(origin, reach):
    """Whether a ray from here is one of these."""
    return max(abs(origin.x), max(abs(origin.y), abs(origin.z))) > np.float32(NEAR_ORIGINS) * reach


@device
def _component(v, axis):
    return np.float64(v.x if axis == 0 else (v.y if axis == 1 else v.z))


@device
def _cells_between(frames, shapes, axis, origin, direction, begin, end, wide):
    """First and last cell of the outermost grid on an axis that the ray may be in at `begin` ≤ t ≤ `end`; the last
    before the first where there is none."""
    a, b = origin + begin * direction, origin + end * direction
    lower, size, count = frames[_ROOT, axis], frames[_ROOT, 3 + axis], shapes[_ROOT, axis]
    first, last = (min(a, b) - wide - lower) / size, (max(a, b) + wide - lower) / size
    if not (last >= 0.0 and first < count):
        return _ONE, _ONE - _ONE
    return np.int64(max(first, 0.0)), np.int64(min(last, np.float64(count - 1)))


@device
def _all_in(grid, cell, triangles, sheared, nearest, words):
    """(nearest, triangles tested, cells): all that a cell and the grids within it hold."""
    tested, visited, top = np.int64(0), np.int64(0), _BOTTOM
    first, last = cell, cell + 1
    while True:
        for at in range(first, last):
            visited += 1
            code = np.int64(grid.cells[at])
            if code > 0:
                count = np.int64(grid.lists[2 * code + 1])
                tested += count
                block = np.int64(grid.lists[2 * code])
                nearest = closest_in_blocks(triangles, block, count, sheared, nearest, words)
            elif code < 0:
                store_int(words, top, np.int32(-code))
                top += 1
        if top == _BOTTOM:
            return nearest, tested, visited
        top -= 1
        inner = np.int64(load_int(words, top))
        first = grid.shapes[inner, 3]
        last = first + grid.shapes[inner, 0] * grid.shapes[inner, 1] * grid.shapes[inner, 2]


@device
def closest_from_afar(grid, triangles, origin, direction, sheared, nearest, words):
    """(nearest, triangles tested, cells): the nearest triangle on such a ray."""
    frames, shapes = grid.frames, grid.shapes
    spread = spread_of(origin, direction, grid.reach)
    main = sheared.kz
    one, two = (main + 1) % 3, (main + 2) % 3
    start, along, inverse = _component(origin, main), _component(direction, main), _component(spread.inverse, main)
    slack = _component(spread.slack, main)
    wide = slack * abs(along)
    tested, visited = np.int64(0), np.int64(0)
    stride = _ONE, shapes[_ROOT, 0], shapes[_ROOT, 0] * shapes[_ROOT, 1]
    count, lower, size = shapes[_ROOT, main], frames[_ROOT, main], frames[_ROOT, 3 + main]
    for k in range(count):
        slice_ = k if along > 0.0 else count - 1 - k
        a, b = (lower + slice_ * size - start) * inverse, (lower + (slice_ + 1) * size - start) * inverse
        begin, end = max(min(a, b) - slack, 0.0), max(a, b) + slack
        if begin > np.float64(nearest.t):
            break
        if end < 0.0:
            continue
        low1, high1 = _cells_between(
            frames, shapes, one, _component(origin, one), _component(direction, one), begin, end, wide
        )
        low2, high2 = _cells_between(
            frames, shapes, two, _component(origin, two), _component(direction, two), begin, end, wide
        )
        for j in range(low2, high2 + 1):
            for i in range(low1, high1 + 1):
                cell = slice_ * stride[main] + i * stride[one] + j * stride[two]
                nearest, more, cells = _all_in(grid, cell, triangles, sheared, nearest, words)
                tested += more
                visited += cells
    return nearest, tested, visited
