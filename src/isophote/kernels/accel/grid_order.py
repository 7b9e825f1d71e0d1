"""The order of triangles within the lists of a grid, and the boxes of their blocks: grid_layout.py.

A list is halved at the middle of its triangles' parts in the cell, along the longest axis, until a block is left. What
a ray passes by within a cell is then told by eight boxes at a time.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.clip import CLIP_WORDS, clip_extent
from isophote.kernels.accel.grid_layout import ROW
from isophote.kernels.accel.layout import LANES, UPPER, WIDTH
from isophote.kernels.base.jit import device, kernel

__all__ = ["order_lists"]

_EXTENT = 6
# Halves of lists that wait, two numbers each.
_STACK = 2 * 64
_INFINITE = np.float32(np.inf)


@device
def _exchange(references, first, extents, a, b):
    references[first + a], references[first + b] = references[first + b], references[first + a]
    for word in range(_EXTENT):
        extents[_EXTENT * a + word], extents[_EXTENT * b + word] = (
            extents[_EXTENT * b + word],
            extents[_EXTENT * a + word],
        )


@device
def _middle(extents, k, axis):
    """Twice the middle of a part."""
    return np.float64(extents[_EXTENT * k + axis]) + np.float64(extents[_EXTENT * k + axis + 3])


@device
def _split(references, first, extents, low, high, place, axis):
    """Put parts low ≤ k < high in such an order that none before `place` lies behind any from there on (Hoare)."""
    last = high - 1
    while low < last:
        pivot = _middle(extents, (low + last) >> 1, axis)
        i, j = low, last
        while i <= j:
            while _middle(extents, i, axis) < pivot:
                i += 1
            while _middle(extents, j, axis) > pivot:
                j -= 1
            if i <= j:
                _exchange(references, first, extents, i, j)
                i += 1
                j -= 1
        if place <= j:
            last = j
        elif place >= i:
            low = i
        else:
            return


@device
def _longest_axis(extents, low, high):
    """The axis along which the middles of parts low ≤ k < high spread most."""
    widest, found = -1.0, 0
    for axis in range(3):
        least = greatest = _middle(extents, low, axis)
        for k in range(low + 1, high):
            middle = _middle(extents, k, axis)
            least, greatest = min(least, middle), max(greatest, middle)
        if greatest - least > widest:
            widest, found = greatest - least, axis
    return found


@device
def _order(references, first, count, extents, stack):
    """Put a list's references, and the extents of their parts, in the order of blocks that lie together."""
    stack[0], stack[1] = 0, count
    top = 2
    while top > 0:
        top -= 2
        low, high = stack[top], stack[top + 1]
        blocks = (high - low + LANES - 1) // LANES
        if blocks < 2:
            continue
        place = low + (blocks + 1) // 2 * LANES
        _split(references, first, extents, low, high, place, _longest_axis(extents, low, high))
        stack[top], stack[top + 1] = place, high
        stack[top + 2], stack[top + 3] = low, place
        top += 4


@device
def _fill_row(extents, low, high, rows, at):
    """The boxes of a row's blocks, of parts low ≤ k < high; blocks that are not there have none that a ray enters."""
    for lane in range(WIDTH):
        for axis in range(3):
            least, greatest = _INFINITE, -_INFINITE
            for k in range(low + lane * LANES, min(low + (lane + 1) * LANES, high)):
                least = min(least, extents[_EXTENT * k + axis])
                greatest = max(greatest, extents[_EXTENT * k + axis + 3])
            rows[at + WIDTH * axis + lane] = least
            rows[at + UPPER + WIDTH * axis + lane] = greatest


@device
def _lies_in(positions, triangles, triangle, cell, extent):
    """Whether a triangle lies in a cell's box; its own box goes to `extent`."""
    a, b, c = (
        3 * np.int64(triangles[3 * triangle]),
        3 * np.int64(triangles[3 * triangle + 1]),
        3 * np.int64(triangles[3 * triangle + 2]),
    )
    inside = True
    for axis in range(3):
        x, y, z = positions[a + axis], positions[b + axis], positions[c + axis]
        low, high = min(x, min(y, z)), max(x, max(y, z))
        extent[axis], extent[axis + 3] = low, high
        inside = inside and low >= cell[axis] and high <= cell[axis + 3]
    return inside


@kernel
def order_lists(positions, triangles, references, starts, first_rows, cells, begin, end, rows):
    """For each list begin ≤ l < end that has rows, the first number `first_rows`[l] ≥ 0: put its references, which are
    starts[l] ≤ r < starts[l + 1], in order, and write its rows. `cells` (lists, 6) float32: what each list is about."""
    work, extent = np.empty(CLIP_WORDS, np.float64), np.empty(_EXTENT, np.float32)
    stack, most = np.empty(_STACK, np.int64), np.int64(0)
    for number in range(begin, end):
        most = max(most, starts[number + 1] - starts[number])
    extents = np.empty(_EXTENT * most, np.float32)
    for number in range(begin, end):
        if first_rows[number] < 0:
            continue
        first, count = starts[number], starts[number + 1] - starts[number]
        for k in range(count):
            triangle = np.int64(references[first + k])
            if not _lies_in(positions, triangles, triangle, cells[number], extent) and not clip_extent(
                positions, triangles, triangle, cells[number], work, extent
            ):
                # Rounding alone brought it here.
                extent[:] = cells[number]
            extents[_EXTENT * k : _EXTENT * (k + 1)] = extent
        _order(references, first, count, extents, stack)
        for low in range(0, count, WIDTH * LANES):
            at = ROW * (np.int64(first_rows[number]) + low // (WIDTH * LANES))
            _fill_row(extents, low, min(low + WIDTH * LANES, count), rows, at)
