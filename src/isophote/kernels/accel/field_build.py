"""Splitting regions of a field: what is proven empty or inside, and shorter tapes for what is not."""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.field_layout import EMPTY, INSIDE
from isophote.kernels.base.jit import device, kernel
from isophote.kernels.base.simd import bits, load16, splat16, store_float
from isophote.kernels.forms import opcodes as op
from isophote.kernels.forms.field_data import open_field_data
from isophote.kernels.forms.tape_interval import REGION_HIGH, REGION_MIDDLE, REGION_SLOT, run_intervals
from isophote.kernels.forms.tape_prune import shorten

__all__ = ["AMBIGUOUS", "PARENT", "open_cells", "split_regions"]

# States of a child beyond EMPTY and INSIDE, and the number that stands for the tape of the region that was split.
AMBIGUOUS = 1
PARENT = -1

_ROW = np.int64(op.ROW)
_LAYER, _ALL = 16, np.int32(0xFFFF)
_ZERO, _HALF = np.float32(0), np.float32(0.5)
# A tape is only written anew where it loses one row in so many.
_WORTH = 8


@device
def _load_layer(slots, x, y, z, width, margin):
    """Boxes of the sixteen children of one layer, whose first has its least corner at (x, y, z)."""
    half = width * _HALF
    for lane in range(_LAYER):
        for axis, low in ((0, x + np.float32(lane & 3) * width), (1, y + np.float32(lane >> 2) * width), (2, z)):
            slot = axis * REGION_SLOT + lane
            store_float(slots, slot, low - margin)
            store_float(slots, slot + REGION_MIDDLE, low + half)
            store_float(slots, slot + REGION_HIGH, low + width + margin)


@device
def _same(out, first, count, other):
    """Whether the `count` rows from `first` on equal those from `other` on."""
    for word in range(count * _ROW):  # noqa: SIM110 - generators are not compiled
        if out[first * _ROW + word] != out[other * _ROW + word]:
            return False
    return True


@device
def _known(out, out_tapes, since, tapes, first, count):
    """Number of the tape, from `since` on, that equals the rows just written, or −1."""
    for tape in range(since, tapes):
        if out_tapes[tape, 1] == count and _same(out, first, count, np.int64(out_tapes[tape, 0])):
            return tape
    return -1


@kernel
def split_regions(
    rows,
    data,
    tapes,
    places,
    low,
    width,
    margin,
    every,
    first,
    last,
    states,
    child_tapes,
    out,
    out_tapes,
    slots,
    choices,
    marks,
):
    """Split the regions `first` ≤ i < `last` into 64 children each.

    `tapes` (n, 2): first row and number of rows of each region's tape. `places` (n, 3): their numbers along the axes,
    counted in regions of this size from the root's corner `low`; children are `width` wide, and what is told of one
    holds up to `margin` beyond it. `states` (n, 64) gets EMPTY, INSIDE or AMBIGUOUS, `child_tapes` the number of the
    child's tape among `out_tapes` (k, 2), or PARENT; with `every`, empty children get tapes of their own too. Tapes go
    to `out`, which has room for 64 of the longest a region. `slots`, `choices` and `marks` are scratch of the
    interpreter. Returns (rows, tapes) that were written, both from 0 on.
    """
    tables = open_field_data(data)
    written, count_out = np.int64(0), np.int64(0)
    for i in range(first, last):
        start, count = np.int64(tapes[i, 0]), np.int64(tapes[i, 1])
        since = count_out
        x = low[0] + np.float32(4 * places[i, 0]) * width
        y = low[1] + np.float32(4 * places[i, 1]) * width
        for layer in range(4):
            z = low[2] + np.float32(4 * places[i, 2] + layer) * width
            _load_layer(slots, x, y, z, width, margin)
            run_intervals(rows, start, count, tables, slots, choices)
            result = (np.int64(op.INPUTS) - 1 + count) * REGION_SLOT
            empty = bits(load16(slots, result) > splat16(_ZERO))
            inside = bits(load16(slots, result + REGION_HIGH) < splat16(_ZERO))
            for lane in range(_LAYER):
                child = layer * _LAYER + lane
                child_tapes[i, child] = PARENT
                is_empty = (empty >> lane) & 1
                if (inside >> lane) & 1:
                    states[i, child] = INSIDE
                    continue
                states[i, child] = EMPTY if is_empty else AMBIGUOUS
                if is_empty and not every:
                    continue
                left = shorten(rows, start, count, choices, lane, out, written, marks)
                if left * _WORTH > count * (_WORTH - 1):
                    continue
                number = _known(out, out_tapes, since, count_out, written, left)
                if number < 0:
                    number = count_out
                    out_tapes[number, 0], out_tapes[number, 1] = written, left
                    written += left
                    count_out += 1
                child_tapes[i, child] = number
    return written, count_out


@kernel
def open_cells(rows, data, tapes, places, low, width, margin, first, last, cells, slots, choices):
    """Set `cells` (n,) to those of the 4 × 4 × 4 cells of the regions `first` ≤ i < `last`, as bits, in which it is not
    proven that the field is above zero. Arguments are as those of `split_regions`."""
    tables = open_field_data(data)
    for i in range(first, last):
        start, count = np.int64(tapes[i, 0]), np.int64(tapes[i, 1])
        x = low[0] + np.float32(4 * places[i, 0]) * width
        y = low[1] + np.float32(4 * places[i, 1]) * width
        found = np.int64(0)
        for layer in range(4):
            z = low[2] + np.float32(4 * places[i, 2] + layer) * width
            _load_layer(slots, x, y, z, width, margin)
            run_intervals(rows, start, count, tables, slots, choices)
            empty = bits(load16(slots, (np.int64(op.INPUTS) - 1 + count) * REGION_SLOT) > splat16(_ZERO))
            found |= np.int64(empty ^ _ALL) << (layer * _LAYER)
        cells[i] = found
