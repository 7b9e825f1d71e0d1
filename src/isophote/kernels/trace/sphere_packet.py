"""Sixteen points in a field at once, each with the tape of the region that it lies in."""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel import field_layout as layout
from isophote.kernels.accel.field_layout import CHILDREN, FIRST_TAPE, NODE
from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import load16, load_float, load_int, lowest_bit, store16, store_float
from isophote.kernels.forms import opcodes as op
from isophote.kernels.forms.field_data import open_field_data
from isophote.kernels.forms.interpreters import values_on

__all__ = ["LANES", "ROWS", "TAPE", "VALUE", "X", "Y", "Z", "evaluate_lanes", "region_at"]

LANES = np.int64(16)
# Rows of sixteen words: points in the field's space, numbers of tapes, and the values there.
X, Y, Z, TAPE, VALUE = (np.int64(16 * row) for row in range(5))
ROWS = 5

_BIT, _NONE = np.int32(1), np.int32(0)
_RESULT, _ONE_VECTOR = np.int64(op.INPUTS - 1), np.int64(1)


@device
def _axis_cell(fields, k, axis, place, cells, size):
    """Number along an axis of the finest cell that a coordinate lies in."""
    # What lies below the root counts as its first cell, so that cutting off is as good as rounding down.
    return min(max(np.int64((place - fields.cubes[k, layout.CELLS + axis]) * cells), 0), size - 1)


@device
def region_at(fields, k, x, y, z):
    """(code, tape that gives the field, least corner and width) of the region of field `k` that a point lies in; points
    beyond the root count as if they lay at its faces."""
    levels = np.int64(fields.numbers[k, layout.LEVELS])
    side = fields.cubes[k, layout.SIDE]
    size = np.int64(1) << (2 * levels)
    cells, unit = np.float32(size) / side, side / np.float32(size)
    cx, cy, cz = (
        _axis_cell(fields, k, 0, x, cells, size),
        _axis_cell(fields, k, 1, y, cells, size),
        _axis_cell(fields, k, 2, z, cells, size),
    )
    shift = 2 * levels
    code = np.int64(fields.numbers[k, layout.ROOT_CODE])
    tape = np.int64(fields.numbers[k, layout.ROOT_TAPE])
    while code > 0:
        shift -= 2
        at = code * NODE + ((cx >> shift) & 3) + 4 * ((cy >> shift) & 3) + 16 * ((cz >> shift) & 3)
        code, tape = np.int64(fields.nodes[at]), np.int64(fields.nodes[at + CHILDREN])
    return (
        code,
        FIRST_TAPE - code if code <= FIRST_TAPE else tape,
        fields.cubes[k, layout.CELLS] + np.float32((cx >> shift) << shift) * unit,
        fields.cubes[k, layout.CELLS + 1] + np.float32((cy >> shift) << shift) * unit,
        fields.cubes[k, layout.CELLS + 2] + np.float32((cz >> shift) << shift) * unit,
        np.float32(np.int64(1) << shift) * unit,
    )


@device
def evaluate_lanes(fields, k, lanes, wanted, slots):
    """The field's values at the points of the lanes `wanted` (bits), each by its own tape, into the row VALUE."""
    data = open_field_data(fields.data[k])
    while wanted != _NONE:
        tape = load_int(lanes, TAPE + np.int64(lowest_bit(wanted)))
        same = _NONE
        for lane in range(LANES):
            same |= _BIT << np.int32(lane) if load_int(lanes, TAPE + lane) == tape else _NONE
        same &= wanted
        for axis in range(3):
            store16(slots, axis * LANES, load16(lanes, axis * LANES))
        first, length = np.int64(fields.tapes[tape, 0]), np.int64(fields.tapes[tape, 1])
        values_on(fields.interpreters, fields.rows, first, length, data, slots, _ONE_VECTOR)
        result = (_RESULT + length) * LANES
        wanted &= ~same
        while same != _NONE:
            lane = np.int64(lowest_bit(same))
            same &= same - _BIT
            store_float(lanes, VALUE + lane, load_float(slots, result + lane))
