"""The interpreter of tapes over intervals: bounds of a field in sixteen regions of space at once.

A slot takes REGION_SLOT floats: the low ends of sixteen intervals, from REGION_MIDDLE on the values at the regions'
middles, from REGION_HIGH on the high ends. Slots 0, 1, 2 are the regions' boxes and middles.

Two bounds meet in each row, for each is tight where the other is loose. Interval arithmetic is one. The other is the
row's Lipschitz constant: no value in a region differs from that at its middle by more than constant · radius, the
radius being that from the middle to the farthest corner of the box. Both hold for the values that the interpreter
of points computes as well as for the exact ones: ends are rounded outward, and a row knows what rounding may do to it.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import (
    absolute,
    bits,
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
    store_int,
)
from isophote.kernels.base.simd_math import arc_cosine, arc_sine, arc_tangent, cosine, exponential, logarithm, sine
from isophote.kernels.forms import opcodes as op
from isophote.kernels.forms.field_data import call_table
from isophote.kernels.forms.interval import (
    absolute_interval,
    arc_cosine_interval,
    arc_sine_interval,
    arc_tangent_interval,
    downward,
    exponential_interval,
    length_interval,
    logarithm_interval,
    multiply_interval,
    reciprocal_interval,
    upward,
    wave_interval,
)
from isophote.kernels.forms.tape import smooth_maximum, smooth_minimum

__all__ = ["REGION_HIGH", "REGION_MIDDLE", "REGION_SLOT", "run_intervals"]

REGION_MIDDLE, REGION_HIGH, REGION_SLOT = 16, 32, 48

_ROW, _ONE_VECTOR = np.int64(op.ROW), np.int64(1)
# Turns to add, so that the peaks of the sine are at whole ones.
_PEAK_OF_SINE = np.float32(-0.25)
_ZERO, _STEP, _INFINITY = np.float32(0), np.float32(2.0**-21), np.float32(np.inf)


@device
def _radii(slots):
    """Distances from the regions' middles to the farthest corners of their boxes, rounded up."""
    total = splat16(_ZERO)
    for slot in range(0, op.INPUTS * REGION_SLOT, REGION_SLOT):
        middle = load16(slots, slot + REGION_MIDDLE)
        reach = maximum(middle - load16(slots, slot), load16(slots, slot + REGION_HIGH) - middle)
        total = total + reach * reach
    return upward(square_root(total))


@device
def _decided(first, second):
    """A row's choice: lanes where the first argument alone decides, and lanes where the second does."""
    return bits(first) | (bits(second) << np.int32(16))


@device
def run_intervals(rows, first, count, data, slots, choices):
    """Run rows `first` ≤ r < `first + count` of a tape; `choices` gets a word for each row.

    The low sixteen bits of choices[r - first] are the lanes where the value is the first argument's all over the
    region, the high ones those where it is the second's (or the row's constant, or −a for |a|). For SELECT they are
    the lanes where the condition is negative, and those where it is not.
    """
    radii = _radii(slots)
    zero = splat16(_ZERO)
    for number in range(count):
        row = (first + number) * _ROW
        code = load_int(rows, row + op.OP)
        a = load_int(rows, row + op.A) * np.int64(REGION_SLOT)
        b = load_int(rows, row + op.B) * np.int64(REGION_SLOT)
        k = splat16(load_float(rows, row + op.IMM))
        p, x, q = load16(slots, a), load16(slots, a + REGION_MIDDLE), load16(slots, a + REGION_HIGH)
        r, y, s = load16(slots, b), load16(slots, b + REGION_MIDDLE), load16(slots, b + REGION_HIGH)
        choice = np.int32(0)
        if code == op.ADD:
            low, middle, high = downward(p + r), x + y, upward(q + s)
        elif code == op.SUBTRACT:
            low, middle, high = downward(p - s), x - y, upward(q - r)
        elif code == op.MULTIPLY:
            low, high = multiply_interval(p, q, r, s)
            middle = x * y
        elif code == op.DIVIDE:
            r, s = reciprocal_interval(r, s)
            low, high = multiply_interval(p, q, r, s)
            middle = x / y
        elif code == op.MINIMUM:
            low, middle, high = minimum(p, r), minimum(x, y), minimum(q, s)
            choice = _decided(q <= r, s < p)
        elif code == op.MAXIMUM:
            low, middle, high = maximum(p, r), maximum(x, y), maximum(q, s)
            choice = _decided(p >= s, r > q)
        elif code == op.NEGATE:
            low, middle, high = zero - q, zero - x, zero - p
        elif code == op.ABSOLUTE:
            low, high = absolute_interval(p, q)
            middle = absolute(x)
            choice = _decided(p >= zero, q < zero)
        elif code == op.SQUARE:
            low, high = absolute_interval(p, q)
            low, middle, high = downward(low * low), x * x, upward(high * high)
        elif code == op.SQUARE_ROOT:
            low, high = downward(square_root(maximum(p, zero))), upward(square_root(maximum(q, zero)))
            middle = square_root(maximum(x, zero))
        elif code == op.LENGTH2:
            low, high = length_interval(p, q, r, s, zero, zero)
            middle = square_root(x * x + y * y)
        elif code == op.LENGTH3:
            c = load_int(rows, row + op.C) * np.int64(REGION_SLOT)
            z = load16(slots, c + REGION_MIDDLE)
            low, high = length_interval(p, q, r, s, load16(slots, c), load16(slots, c + REGION_HIGH))
            middle = square_root(x * x + y * y + z * z)
        elif code == op.ADD_CONSTANT:
            low, middle, high = downward(p + k), x + k, upward(q + k)
        elif code == op.MULTIPLY_CONSTANT:
            low, high = multiply_interval(p, q, k, k)
            middle = x * k
        elif code == op.CONSTANT_MINUS:
            low, middle, high = downward(k - q), k - x, upward(k - p)
        elif code == op.CONSTANT_OVER:
            r, s = reciprocal_interval(p, q)
            low, high = multiply_interval(k, k, r, s)
            middle = k / x
        elif code == op.MINIMUM_CONSTANT:
            low, middle, high = minimum(p, k), minimum(x, k), minimum(q, k)
            choice = _decided(q <= k, k < p)
        elif code == op.MAXIMUM_CONSTANT:
            low, middle, high = maximum(p, k), maximum(x, k), maximum(q, k)
            choice = _decided(p >= k, k > q)
        elif code == op.SMOOTH_MINIMUM:
            imm = load_float(rows, row + op.IMM)
            step = splat16(_STEP) * k
            low, high = downward(smooth_minimum(p, r, imm)) - step, upward(smooth_minimum(q, s, imm)) + step
            middle = smooth_minimum(x, y, imm)
            choice = _decided(upward(q + k) <= r, upward(s + k) < p)
        elif code == op.SMOOTH_MAXIMUM:
            imm = load_float(rows, row + op.IMM)
            step = splat16(_STEP) * k
            low, high = downward(smooth_maximum(p, r, imm)) - step, upward(smooth_maximum(q, s, imm)) + step
            middle = smooth_maximum(x, y, imm)
            choice = _decided(p >= upward(s + k), r > upward(q + k))
        elif code == op.MULTIPLY_ADD:
            c = load_int(rows, row + op.C) * np.int64(REGION_SLOT)
            low, high = multiply_interval(p, q, r, s)
            low, high = downward(low + load16(slots, c)), upward(high + load16(slots, c + REGION_HIGH))
            middle = x * y + load16(slots, c + REGION_MIDDLE)
        elif code == op.SELECT:
            c = load_int(rows, row + op.C) * np.int64(REGION_SLOT)
            t, z, u = load16(slots, c), load16(slots, c + REGION_MIDDLE), load16(slots, c + REGION_HIGH)
            negative, positive = q < zero, p >= zero
            low = select(negative, r, select(positive, t, minimum(r, t)))
            high = select(negative, s, select(positive, u, maximum(s, u)))
            middle = select(x < zero, y, z)
            choice = _decided(negative, positive)
        elif code == op.FLOOR:
            low, middle, high = floor(p), floor(x), floor(q)
        elif code == op.ROUND:
            low, middle, high = round_even(p), round_even(x), round_even(q)
        elif code == op.SINE:
            low, high = wave_interval(p, q, sine(p), sine(q), _PEAK_OF_SINE)
            middle = sine(x)
        elif code == op.COSINE:
            low, high = wave_interval(p, q, cosine(p), cosine(q), _ZERO)
            middle = cosine(x)
        elif code == op.ARC_SINE:
            low, high = arc_sine_interval(p, q)
            middle = arc_sine(x)
        elif code == op.ARC_COSINE:
            low, high = arc_cosine_interval(p, q)
            middle = arc_cosine(x)
        elif code == op.EXPONENTIAL:
            low, high = exponential_interval(p, q)
            middle = exponential(x)
        elif code == op.LOGARITHM:
            low, high = logarithm_interval(p, q)
            middle = logarithm(x)
        elif code == op.ARC_TANGENT:
            low, high = arc_tangent_interval(p, q, r, s)
            middle = arc_tangent(x, y)
        elif code == op.COPY:
            low, middle, high = p, x, q
        elif code == op.CONSTANT:
            low, middle, high = k, k, k
        else:
            out = load_int(rows, row + op.OUT) * np.int64(REGION_SLOT)
            c = load_int(rows, row + op.C) * np.int64(REGION_SLOT)
            call_table(data, op.INTERVALS, load_int(rows, row + op.IMM), slots, out, a, b, c, _ONE_VECTOR)
            low, middle, high = load16(slots, out), load16(slots, out + REGION_MIDDLE), load16(slots, out + REGION_HIGH)
        reach = radii * splat16(load_float(rows, row + op.LIPSCHITZ)) + splat16(load_float(rows, row + op.ROUNDING))
        # A NaN in the first argument of `maximum` yields the second: what is not known does not narrow.
        low = maximum(maximum(middle - reach, low), splat16(-_INFINITY))
        high = minimum(minimum(middle + reach, high), splat16(_INFINITY))
        out = load_int(rows, row + op.OUT) * np.int64(REGION_SLOT)
        store16(slots, out, low)
        store16(slots, out + REGION_MIDDLE, middle)
        store16(slots, out + REGION_HIGH, high)
        store_int(choices, number, choice)
