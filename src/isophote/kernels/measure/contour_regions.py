"""Where a surface may be: regions of a grid by intervals, sixteen at once."""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import device, kernel
from isophote.kernels.base.simd import bits, load16, lowest_bit, splat16
from isophote.kernels.forms.interpreters import bounds_on
from isophote.kernels.forms.opcodes import INPUTS, ROW
from isophote.kernels.forms.tape_interval import REGION_HIGH, REGION_MIDDLE, REGION_SLOT
from isophote.kernels.forms.tape_prune import shorten
from isophote.kernels.measure.contour_tables import BRICK, CONTOUR, WORK
from isophote.kernels.measure.morton import unpacked

__all__ = ["GROUP", "child_place", "children_undecided", "find_bricks", "shorten_for_region"]

# Cells along a group of 4 × 4 × 4 bricks.
GROUP = 4 * BRICK
_ZERO, _HALF = np.float32(0), np.float32(0.5)
_NOWHERE = _FIRST = np.int64(0)

_open_contour, _open_work = CONTOUR.open, WORK.open


@device
def _load_span(slots, at, low, high):
    slots[at] = low
    slots[at + REGION_MIDDLE] = (low + high) * _HALF
    slots[at + REGION_HIGH] = high


@device
def _load_region(grid, slots, lane, i, j, k, size):
    """Put a cube of cells into a lane, as far as it lies in the grid; whether any of it does."""
    if i >= grid.nx or j >= grid.ny or k >= grid.nz:
        i, j, k = _NOWHERE, _NOWHERE, _NOWHERE
        present = False
    else:
        present = True
    _load_span(slots, lane, grid.xs[i], grid.xs[min(i + size, grid.nx)])
    _load_span(slots, REGION_SLOT + lane, grid.ys[j], grid.ys[min(j + size, grid.ny)])
    _load_span(slots, 2 * REGION_SLOT + lane, grid.zs[k], grid.zs[min(k + size, grid.nz)])
    return present


@device
def _undecided(slots, count):
    """Lanes in which the value may be zero."""
    at = (INPUTS - 1 + count) * REGION_SLOT
    zero = splat16(_ZERO)
    return bits((load16(slots, at) <= zero) & (load16(slots, at + REGION_HIGH) >= zero))


@device
def child_place(number):
    """(x, y, z), each below 4, of a child of 64."""
    return unpacked(number), unpacked(number >> 1), unpacked(number >> 2)


@device
def children_undecided(grid, work, count, sixteen, i, j, k, size):
    """Of the children 16 · sixteen and on of a cube at cell (i, j, k), of `size` cells each: those that may hold the
    surface, as bits. The tape is that in `work.near`; `work.choices` then tells what matters in each."""
    here = np.int32(0)
    for lane in range(16):
        x, y, z = child_place(16 * sixteen + lane)
        if _load_region(grid, work.slots, lane, i + size * x, j + size * y, k + size * z, size):
            here |= np.int32(1 << lane)
    bounds_on(grid.interpreters, work.near, _FIRST, count, work.data, work.slots, work.choices)
    return _undecided(work.slots, count) & here


@device
def shorten_for_region(grid, work, i, j, k, size):
    """Put the tape that matters in a cube of cells into `work.near`; its rows, or 0 where the surface cannot be."""
    count = np.int64(grid.rows.rows) // ROW
    for lane in range(16):
        _load_region(grid, work.slots, lane, i, j, k, size)
    bounds_on(grid.interpreters, grid.rows, _FIRST, count, work.data, work.slots, work.far_choices)
    if _undecided(work.slots, count) & 1 == 0:
        return np.int64(0)
    return shorten(grid.rows, np.int64(0), count, work.far_choices, np.int64(0), work.near, np.int64(0), work.marks)


@kernel
def find_bricks(contour, scratch, first, last, found):
    """Numbers of the bricks that the surface may cross, of groups `first` ≤ g < `last`, into `found`; their count."""
    grid, work = _open_contour(contour), _open_work(scratch)
    across, along = (grid.nx + BRICK - 1) // BRICK, (grid.ny + BRICK - 1) // BRICK
    groups_across, groups_along = (grid.nx + GROUP - 1) // GROUP, (grid.ny + GROUP - 1) // GROUP
    count = 0
    for group in range(first, last):
        i = group % groups_across * GROUP
        j = group // groups_across % groups_along * GROUP
        k = group // (groups_across * groups_along) * GROUP
        rows = shorten_for_region(grid, work, i, j, k, np.int64(GROUP))
        if rows == 0:
            continue
        for sixteen in range(4):
            held = children_undecided(grid, work, rows, sixteen, i, j, k, np.int64(BRICK))
            while held != 0:
                x, y, z = child_place(16 * sixteen + lowest_bit(held))
                held &= held - np.int32(1)
                found[count] = ((k // BRICK + z) * along + j // BRICK + y) * across + i // BRICK + x
                count += 1
    return count
