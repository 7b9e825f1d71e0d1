"""The interpreter of tapes with derivatives: values and gradients at sixteen points at once.

A slot takes GRADIENT_SLOT floats: the values at sixteen points, then their derivatives by x, by y and by z.
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
from isophote.kernels.forms.tape import greater, lesser, smooth_maximum, smooth_minimum

__all__ = ["GRADIENT_SLOT", "run_gradients"]

GRADIENT_SLOT = 64
_ONE_VECTOR = np.int64(1)

_ROW = np.int64(op.ROW)
_ZERO, _HALF, _ONE = np.float32(0), np.float32(0.5), np.float32(1)


@device
def _quotient(a, b):
    """a / b, and 0 where b is 0: the derivative of a length at the point where it has none."""
    zero = splat16(_ZERO)
    return select(b == zero, zero, a / b)


@device
def _share(a, b, k):
    """Derivative of the smooth minimum by its first argument."""
    return minimum(maximum(splat16(_HALF) - (a - b) * splat16(_HALF / k), splat16(_ZERO)), splat16(_ONE))


@device
def _arc_slope(x):
    """Derivative of the arc sine, 0 where it is clamped."""
    one = splat16(_ONE)
    return _quotient(one, square_root(maximum(one - x * x, splat16(_ZERO))))


@device
def run_gradients(rows, first, count, data, slots):
    """Run rows `first` ≤ r < `first + count` of a tape; the values of slots 0, 1, 2 are the points."""
    zero, one = splat16(_ZERO), splat16(_ONE)
    for slot in range(op.INPUTS):
        for axis in range(op.INPUTS):
            store16(slots, slot * GRADIENT_SLOT + 16 * (1 + axis), one if axis == slot else zero)
    for row in range(first * _ROW, (first + count) * _ROW, _ROW):
        code = load_int(rows, row + op.OP)
        out = load_int(rows, row + op.OUT) * np.int64(GRADIENT_SLOT)
        a = load_int(rows, row + op.A) * np.int64(GRADIENT_SLOT)
        b = load_int(rows, row + op.B) * np.int64(GRADIENT_SLOT)
        c = load_int(rows, row + op.C) * np.int64(GRADIENT_SLOT)
        imm = load_float(rows, row + op.IMM)
        x, y, z, k = load16(slots, a), load16(slots, b), load16(slots, c), splat16(imm)
        # The value, and its derivatives by the arguments.
        value, p, q, r = x, zero, zero, zero
        if code == op.ADD:
            value, p, q = x + y, one, one
        elif code == op.SUBTRACT:
            value, p, q = x - y, one, zero - one
        elif code == op.MULTIPLY:
            value, p, q = x * y, y, x
        elif code == op.DIVIDE:
            value = x / y
            p, q = one / y, zero - value / y
        elif code == op.MINIMUM:
            p = select(x < y, one, zero)
            value, q = lesser(x, y), one - p
        elif code == op.MAXIMUM:
            p = select(x > y, one, zero)
            value, q = greater(x, y), one - p
        elif code == op.NEGATE:
            value, p = zero - x, zero - one
        elif code == op.ABSOLUTE:
            value, p = absolute(x), select(x < zero, zero - one, one)
        elif code == op.SQUARE:
            value, p = x * x, x + x
        elif code == op.SQUARE_ROOT:
            value = square_root(maximum(zero, x))
            p = _quotient(splat16(_HALF), value)
        elif code == op.LENGTH2:
            value = square_root(x * x + y * y)
            p, q = _quotient(x, value), _quotient(y, value)
        elif code == op.LENGTH3:
            value = square_root(x * x + y * y + z * z)
            p, q, r = _quotient(x, value), _quotient(y, value), _quotient(z, value)
        elif code == op.ADD_CONSTANT:
            value, p = x + k, one
        elif code == op.MULTIPLY_CONSTANT:
            value, p = x * k, k
        elif code == op.CONSTANT_MINUS:
            value, p = k - x, zero - one
        elif code == op.CONSTANT_OVER:
            value = k / x
            p = zero - value / x
        elif code == op.MINIMUM_CONSTANT:
            value, p = minimum(k, x), select(x < k, one, zero)
        elif code == op.MAXIMUM_CONSTANT:
            value, p = maximum(k, x), select(x > k, one, zero)
        elif code == op.SMOOTH_MINIMUM:
            value, p = smooth_minimum(x, y, imm), _share(x, y, imm)
            q = one - p
        elif code == op.SMOOTH_MAXIMUM:
            value, q = smooth_maximum(x, y, imm), _share(x, y, imm)
            p = one - q
        elif code == op.MULTIPLY_ADD:
            value, p, q, r = x * y + z, y, x, one
        elif code == op.SELECT:
            negative = x < zero
            value = select(negative, y, z)
            q, r = select(negative, one, zero), select(negative, zero, one)
        elif code == op.FLOOR:
            value = floor(x)
        elif code == op.ROUND:
            value = round_even(x)
        elif code == op.SINE:
            value, p = sine(x), cosine(x)
        elif code == op.COSINE:
            value, p = cosine(x), zero - sine(x)
        elif code == op.ARC_SINE:
            value, p = arc_sine(x), _arc_slope(x)
        elif code == op.ARC_COSINE:
            value, p = arc_cosine(x), zero - _arc_slope(x)
        elif code == op.EXPONENTIAL:
            value = exponential(x)
            p = value
        elif code == op.LOGARITHM:
            value, p = logarithm(x), one / x
        elif code == op.ARC_TANGENT:
            square = x * x + y * y
            value, p, q = arc_tangent(x, y), _quotient(y, square), zero - _quotient(x, square)
        elif code == op.COPY:
            p = one
        elif code == op.CONSTANT:
            value = k
        else:
            call_table(data, op.GRADIENTS, load_int(rows, row + op.IMM), slots, out, a, b, c, _ONE_VECTOR)
            continue
        store16(slots, out, value)
        for part in range(16, GRADIENT_SLOT, 16):
            derivative = p * load16(slots, a + part) + q * load16(slots, b + part) + r * load16(slots, c + part)
            store16(slots, out + part, derivative)
