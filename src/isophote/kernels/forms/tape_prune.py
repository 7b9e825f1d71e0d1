"""Tapes made shorter for one region: what cannot matter there is left out."""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import load_int, store_int
from isophote.kernels.forms import opcodes as op

__all__ = ["shorten"]

_ROW, _INPUTS = np.int64(op.ROW), np.int64(op.INPUTS)
_DEAD, _LIVE = np.int32(-1), np.int32(0)


@device
def _becomes(code, choice, lane):
    """The operator that a row becomes in the region of a lane, and the word that names its argument.

    A row of which one argument alone decides becomes a COPY of it, which no row need be written for.
    """
    first, second = (choice >> lane) & 1, (choice >> (lane + 16)) & 1
    if first == 0 and second == 0:
        return np.int64(code), np.int64(op.A)
    if code == op.SELECT:
        return np.int64(op.COPY), np.int64(op.B) if first != 0 else np.int64(op.C)
    if first != 0:
        return np.int64(op.COPY), np.int64(op.A)
    if code == op.ABSOLUTE:
        return np.int64(op.NEGATE), np.int64(op.A)
    if code == op.MINIMUM_CONSTANT or code == op.MAXIMUM_CONSTANT:
        return np.int64(op.CONSTANT), np.int64(op.A)
    return np.int64(op.COPY), np.int64(op.B)


@device
def _mark(rows, first, count, choices, lane, scratch):
    """Mark the slots that the value in the region depends on."""
    for slot in range(_INPUTS + count - 1):
        store_int(scratch, slot, _DEAD)
    store_int(scratch, _INPUTS + count - 1, _LIVE)
    for number in range(count - 1, -1, -1):
        if load_int(scratch, _INPUTS + number) == _DEAD:
            continue
        row = (first + number) * _ROW
        code, word = _becomes(load_int(rows, row + op.OP), load_int(choices, number), lane)
        if code == op.COPY or code == op.NEGATE:
            store_int(scratch, load_int(rows, row + word), _LIVE)
        elif code != op.CONSTANT:
            # Words of arguments that a row does not have name slot 0, the point, which is there anyway.
            store_int(scratch, load_int(rows, row + op.A), _LIVE)
            store_int(scratch, load_int(rows, row + op.B), _LIVE)
            store_int(scratch, load_int(rows, row + op.C), _LIVE)


@device
def _write(rows, row, out, to, code, slot, a, b, c):
    store_int(out, to + op.OP, np.int32(code))
    store_int(out, to + op.OUT, np.int32(slot))
    store_int(out, to + op.A, a)
    store_int(out, to + op.B, b)
    store_int(out, to + op.C, c)
    for word in range(op.IMM, op.ROW):
        store_int(out, to + word, load_int(rows, row + word))


@device
def shorten(rows, first, count, choices, lane, out, out_first, scratch):
    """Copy the rows `first` ≤ r < `first + count` that matter in the region of `lane` to `out`, from `out_first` on.

    `choices` are those that `run_intervals` left. Row k of the copy writes slot INPUTS + k, and the last row writes the
    value. `out` has room for `count` rows or more; `scratch`, int32, for INPUTS + `count` words. Returns how many rows
    are left.
    """
    _mark(rows, first, count, choices, lane, scratch)
    for slot in range(_INPUTS):
        store_int(scratch, slot, np.int32(slot))
    none = np.int32(0)
    left = np.int64(0)
    for number in range(count):
        if load_int(scratch, _INPUTS + number) == _DEAD:
            continue
        row, to = (first + number) * _ROW, (out_first + left) * _ROW
        code, word = _becomes(load_int(rows, row + op.OP), load_int(choices, number), lane)
        a = load_int(scratch, load_int(rows, row + word))
        slot = np.int32(_INPUTS + left)
        if code == op.COPY and (number < count - 1 or (left > 0 and a == slot - 1)):
            slot = a
        elif code == op.COPY or code == op.NEGATE:
            _write(rows, row, out, to, code, slot, a, none, none)
            left += 1
        elif code == op.CONSTANT:
            _write(rows, row, out, to, code, slot, none, none, none)
            left += 1
        else:
            b = load_int(scratch, load_int(rows, row + op.B))
            c = load_int(scratch, load_int(rows, row + op.C))
            _write(rows, row, out, to, code, slot, a, b, c)
            left += 1
        store_int(scratch, _INPUTS + number, slot)
    return left
