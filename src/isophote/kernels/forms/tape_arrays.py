"""Tapes at arrays of points: values, LANES at a time, and gradients, sixteen at a time."""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.columns import load_pairs, load_triples
from isophote.kernels.base.jit import device, kernel
from isophote.kernels.base.simd import load16, load_int, splat16, store16
from isophote.kernels.forms import opcodes as op
from isophote.kernels.forms.field_data import open_field_data
from isophote.kernels.forms.interpreters import gradients_on, open_interpreters, values_on
from isophote.kernels.forms.tape import LANES, WIDTH
from isophote.kernels.forms.tape_gradient import GRADIENT_SLOT

__all__ = ["evaluate_gradients", "evaluate_points"]

_ROW, _FIRST = np.int64(op.ROW), np.int64(0)
_ZERO = np.float32(0)
_LANES = 16


@device
def _load_points(points, start, slots):
    """Points from row `start` on, LANES of them, to slots 0, 1, 2."""
    for j in range(0, LANES, 16):
        if points.shape[1] == 3:
            x, y, z = load_triples(points, start + j)
            store16(slots, j + 2 * LANES, z)
        else:
            x, y = load_pairs(points, start + j)
        store16(slots, j, x)
        store16(slots, j + LANES, y)


@device
def _store_values(slots, result, out, start):
    """The values of LANES points; NaN for points that are not finite, whatever the operators make of them."""
    zero = splat16(_ZERO)
    for j in range(0, LANES, 16):
        x, y, z = load16(slots, j), load16(slots, j + LANES), load16(slots, j + 2 * LANES)
        store16(out, start + j, load16(slots, result + j) + (x * zero + y * zero + z * zero))


@kernel
def evaluate_points(rows, data, interpreters, points, slots, out, first, last):
    """Values at points `first` ≤ i < `last` of (n, 2) or (n, 3) float32 into `out`.

    `data` and `interpreters` are the words of a FIELD_DATA and of INTERPRETERS. `slots` holds LANES floats for each
    slot, and LANES more.
    """
    tables, runners = open_field_data(data), open_interpreters(interpreters)
    count = np.int64(rows.size) // _ROW
    result = np.int64(load_int(rows, (count - 1) * _ROW + op.OUT)) * LANES
    rest = np.int64(slots.size) - LANES
    for j in range(LANES):
        slots[2 * LANES + j] = _ZERO
    start = np.int64(first)
    while start < last:
        size = min(np.int64(LANES), last - start)
        if size == LANES:
            _load_points(points, start, slots)
        else:
            for i in range(LANES):
                for axis in range(points.shape[1]):
                    slots[axis * LANES + i] = points[start + min(i, size - 1), axis]
        values_on(runners, rows, _FIRST, count, tables, slots, np.int64(WIDTH))
        if size == LANES:
            _store_values(slots, result, out, start)
        else:
            _store_values(slots, result, slots, rest)
            for i in range(size):
                out[start + i] = slots[rest + i]
        start += size


@kernel
def evaluate_gradients(rows, data, interpreters, points, slots, out, first, last):
    """Gradients at points `first` ≤ i < `last` of (n, 2) or (n, 3) float32 into `out`, of their shape.

    `data` and `interpreters` are the words of a FIELD_DATA and of INTERPRETERS. `slots` holds GRADIENT_SLOT floats for
    each slot. NaN where points are not finite.
    """
    tables, runners = open_field_data(data), open_interpreters(interpreters)
    count = np.int64(rows.size) // _ROW
    result = np.int64(load_int(rows, (count - 1) * _ROW + op.OUT)) * GRADIENT_SLOT
    for j in range(_LANES):
        slots[2 * GRADIENT_SLOT + j] = _ZERO
    for start in range(first, last, _LANES):
        size = min(np.int64(_LANES), last - start)
        for i in range(_LANES):
            for axis in range(points.shape[1]):
                slots[axis * GRADIENT_SLOT + i] = points[start + min(i, size - 1), axis]
        gradients_on(runners, rows, _FIRST, count, tables, slots)
        for i in range(size):
            blame = _ZERO
            for axis in range(points.shape[1]):
                blame += slots[axis * GRADIENT_SLOT + i] * _ZERO
            for axis in range(points.shape[1]):
                out[start + i, axis] = slots[result + _LANES * (1 + axis) + i] + blame
