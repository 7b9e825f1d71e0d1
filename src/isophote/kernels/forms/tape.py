"""The interpreter of a field's tape: one pass over the rows for many points at once.

Nothing is compiled for a new shape. Reading a row and jumping to its operator costs a few nanoseconds, shared by all
points of a pass: slot s of a pass holds the value at `width` × 16 points, from `slots[s * width * 16]` on.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import (
    absolute,
    floor,
    load16,
    load_float,
    load_int,
    maximum,
    minimum,
    round_even,
    select,
    splat16,
    square_root,
    store16,
)
from isophote.kernels.base.simd_math import arc_cosine, arc_sine, arc_tangent, cosine, exponential, logarithm, sine
from isophote.kernels.forms import opcodes as op
from isophote.kernels.forms.field_data import call_table

__all__ = [
    "LANES",
    "WIDTH",
    "greater",
    "lesser",
    "run_tape",
    "smooth_maximum",
    "smooth_minimum",
]

# Vectors of sixteen points in a pass over many, and the points in it.
WIDTH = 8
LANES = 16 * WIDTH

_ROW = np.int64(op.ROW)
_ZERO, _ONE, _QUARTER = np.float32(0), np.float32(1), np.float32(0.25)


@device
def lesser(a, b):
    """The smaller of two; NaN if one of them is."""
    # `minimum` gives its second argument where one is NaN.
    return select(a == a, minimum(a, b), a)


@device
def greater(a, b):
    """The larger of two; NaN if one of them is."""
    return select(a == a, maximum(a, b), a)


@device
def smooth_minimum(a, b, k):
    h = maximum(splat16(_ZERO), splat16(k) - absolute(a - b))
    return minimum(a, b) - h * h * splat16(_QUARTER / k)


@device
def smooth_maximum(a, b, k):
    h = maximum(splat16(_ZERO), splat16(k) - absolute(a - b))
    return maximum(a, b) + h * h * splat16(_QUARTER / k)


@device
def run_tape(rows, first, count, data, slots, width):
    """Run rows `first` ≤ r < `first + count` of a tape; slots 0, 1, 2 hold the points, `width` vectors each.

    `data` is the opened FIELD_DATA of the tape's tables. The value is what the last row wrote.
    """
    stride = np.int64(16) * width
    for row in range(first * _ROW, (first + count) * _ROW, _ROW):
        code = load_int(rows, row + op.OP)
        out = load_int(rows, row + op.OUT) * stride
        a = load_int(rows, row + op.A) * stride
        b = load_int(rows, row + op.B) * stride
        k = load_float(rows, row + op.IMM)
        end = stride
        if code == op.ADD:
            for j in range(0, end, 16):
                store16(slots, out + j, load16(slots, a + j) + load16(slots, b + j))
        elif code == op.SUBTRACT:
            for j in range(0, end, 16):
                store16(slots, out + j, load16(slots, a + j) - load16(slots, b + j))
        elif code == op.MULTIPLY:
            for j in range(0, end, 16):
                store16(slots, out + j, load16(slots, a + j) * load16(slots, b + j))
        elif code == op.DIVIDE:
            for j in range(0, end, 16):
                store16(slots, out + j, load16(slots, a + j) / load16(slots, b + j))
        elif code == op.MINIMUM:
            for j in range(0, end, 16):
                store16(slots, out + j, lesser(load16(slots, a + j), load16(slots, b + j)))
        elif code == op.MAXIMUM:
            for j in range(0, end, 16):
                store16(slots, out + j, greater(load16(slots, a + j), load16(slots, b + j)))
        elif code == op.NEGATE:
            for j in range(0, end, 16):
                store16(slots, out + j, splat16(_ZERO) - load16(slots, a + j))
        elif code == op.ABSOLUTE:
            for j in range(0, end, 16):
                store16(slots, out + j, absolute(load16(slots, a + j)))
        elif code == op.SQUARE:
            for j in range(0, end, 16):
                x = load16(slots, a + j)
                store16(slots, out + j, x * x)
        elif code == op.SQUARE_ROOT:
            for j in range(0, end, 16):
                store16(slots, out + j, square_root(maximum(splat16(_ZERO), load16(slots, a + j))))
        elif code == op.LENGTH2:
            for j in range(0, end, 16):
                x, y = load16(slots, a + j), load16(slots, b + j)
                store16(slots, out + j, square_root(x * x + y * y))
        elif code == op.LENGTH3:
            c = load_int(rows, row + op.C) * stride
            for j in range(0, end, 16):
                x, y, z = load16(slots, a + j), load16(slots, b + j), load16(slots, c + j)
                store16(slots, out + j, square_root(x * x + y * y + z * z))
        elif code == op.ADD_CONSTANT:
            for j in range(0, end, 16):
                store16(slots, out + j, load16(slots, a + j) + splat16(k))
        elif code == op.MULTIPLY_CONSTANT:
            for j in range(0, end, 16):
                store16(slots, out + j, load16(slots, a + j) * splat16(k))
        elif code == op.CONSTANT_MINUS:
            for j in range(0, end, 16):
                store16(slots, out + j, splat16(k) - load16(slots, a + j))
        elif code == op.CONSTANT_OVER:
            for j in range(0, end, 16):
                store16(slots, out + j, splat16(k) / load16(slots, a + j))
        elif code == op.MINIMUM_CONSTANT:
            for j in range(0, end, 16):
                store16(slots, out + j, minimum(splat16(k), load16(slots, a + j)))
        elif code == op.MAXIMUM_CONSTANT:
            for j in range(0, end, 16):
                store16(slots, out + j, maximum(splat16(k), load16(slots, a + j)))
        elif code == op.SMOOTH_MINIMUM:
            for j in range(0, end, 16):
                store16(slots, out + j, smooth_minimum(load16(slots, a + j), load16(slots, b + j), k))
        elif code == op.SMOOTH_MAXIMUM:
            for j in range(0, end, 16):
                store16(slots, out + j, smooth_maximum(load16(slots, a + j), load16(slots, b + j), k))
        elif code == op.MULTIPLY_ADD:
            c = load_int(rows, row + op.C) * stride
            for j in range(0, end, 16):
                store16(slots, out + j, load16(slots, a + j) * load16(slots, b + j) + load16(slots, c + j))
        elif code == op.SELECT:
            c = load_int(rows, row + op.C) * stride
            for j in range(0, end, 16):
                negative = load16(slots, a + j) < splat16(_ZERO)
                store16(slots, out + j, select(negative, load16(slots, b + j), load16(slots, c + j)))
        elif code == op.FLOOR:
            for j in range(0, end, 16):
                store16(slots, out + j, floor(load16(slots, a + j)))
        elif code == op.ROUND:
            for j in range(0, end, 16):
                store16(slots, out + j, round_even(load16(slots, a + j)))
        elif code == op.SINE:
            for j in range(0, end, 16):
                store16(slots, out + j, sine(load16(slots, a + j)))
        elif code == op.COSINE:
            for j in range(0, end, 16):
                store16(slots, out + j, cosine(load16(slots, a + j)))
        elif code == op.ARC_SINE:
            for j in range(0, end, 16):
                store16(slots, out + j, arc_sine(load16(slots, a + j)))
        elif code == op.ARC_COSINE:
            for j in range(0, end, 16):
                store16(slots, out + j, arc_cosine(load16(slots, a + j)))
        elif code == op.EXPONENTIAL:
            for j in range(0, end, 16):
                store16(slots, out + j, exponential(load16(slots, a + j)))
        elif code == op.LOGARITHM:
            for j in range(0, end, 16):
                store16(slots, out + j, logarithm(load16(slots, a + j)))
        elif code == op.ARC_TANGENT:
            for j in range(0, end, 16):
                store16(slots, out + j, arc_tangent(load16(slots, a + j), load16(slots, b + j)))
        elif code == op.COPY:
            for j in range(0, end, 16):
                store16(slots, out + j, load16(slots, a + j))
        elif code == op.CONSTANT:
            for j in range(0, end, 16):
                store16(slots, out + j, splat16(k))
        else:
            c = load_int(rows, row + op.C) * stride
            call_table(data, op.VALUES, load_int(rows, row + op.IMM), slots, out, a, b, c, width)
