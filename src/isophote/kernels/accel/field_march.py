"""Where a ray first crosses a field's surface within one region, found certainly.

A pass of the tape takes sixteen points of the ray, or sixteen stretches of it. Between two points with values a and b
of one sign, h apart, the field is not zero if |a| + |b| > L h, for L is its Lipschitz constant. Where that proves
nothing, intervals over stretches of the ray do, or a closer look. What is not proven is never stepped over, down to
what positions in single precision can tell apart.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import (
    absolute,
    bits,
    load16,
    load_float,
    lowest_bit,
    maximum,
    minimum,
    splat16,
    store16,
    store_float,
)
from isophote.kernels.forms import opcodes as op
from isophote.kernels.forms.tape_entries import bounds_on, values_on
from isophote.kernels.forms.tape_interval import REGION_HIGH, REGION_MIDDLE, REGION_SLOT

__all__ = ["Line", "Tape", "affine_doubles", "first_crossing", "tape_at"]

# A pass of sixteen points has fifteen gaps.
_LANES, _GAPS = np.int64(16), np.int64(15)
_ZERO, _HALF, _ONE = np.float32(0), np.float32(0.5), np.float32(1)
_STEPS = np.arange(16, dtype=np.float32)
_GAP, _STRETCH = np.float32(1 / 15), np.float32(1 / 16)
# Gaps are proven with this much to spare, for the rounding of positions.
_SPARE = np.float32(1 + 2.0**-10)
# Where a ray starts within a region, it usually leaves a surface: how near its first points lie, in parts of the side.
_NEAR = np.float32(2.0**-16)
# A crossing is looked at closer until its stretch is so short in parts of the root's side; a line finds it there.
_CLOSE = np.float32(2.0**-13)
# Passes after which a ray that still cannot be told from the surface has met it.
_PASSES = np.int64(1024)
_GROWTH = np.float32(16)
_FAR = np.float32(np.inf)
_LOWEST, _ALL, _ALL_GAPS = np.int32(1), np.int32(0xFFFF), np.int32(0x7FFF)
# Closer looks at points before intervals are asked.
_CLOSER = np.int64(1)
# The value stands in slot _RESULT + rows of the tape.
_RESULT = np.int64(op.INPUTS - 1)


class Line(NamedTuple):
    """A ray in a field's space: origin, unit direction, the least step and the side of the root region."""

    x: float
    y: float
    z: float
    dx: float
    dy: float
    dz: float
    least: float
    side: float


class Tape(NamedTuple):
    """Rows of a tape, and the Lipschitz constant of its value."""

    first: int
    length: int
    lipschitz: float


@device
def affine_doubles(m, k, x, y, z, w):
    """A point (w = 1) or vector (w = 0) by matrix `k`, in double precision."""
    return (
        m[k, 0] * x + m[k, 1] * y + m[k, 2] * z + m[k, 3] * w,
        m[k, 4] * x + m[k, 5] * y + m[k, 6] * z + m[k, 7] * w,
        m[k, 8] * x + m[k, 9] * y + m[k, 10] * z + m[k, 11] * w,
    )


@device
def tape_at(fields, number):
    """The `Tape` of this number."""
    first, count = np.int64(fields.tapes[number, 0]), np.int64(fields.tapes[number, 1])
    if count == 0:
        # The field is a coordinate of the point.
        return Tape(first, count, _ONE)
    last = (first + count - 1) * np.int64(op.ROW)
    return Tape(first, count, load_float(fields.rows, last + op.LIPSCHITZ))


@device
def _load_points(slots, line, places):
    """Points of the line at sixteen places."""
    store16(slots, np.int64(0), splat16(line.x) + places * splat16(line.dx))
    store16(slots, np.int64(16), splat16(line.y) + places * splat16(line.dy))
    store16(slots, np.int64(32), splat16(line.z) + places * splat16(line.dz))


@device
def _load_axis(slots, slot, origin, direction, start, end, slack):
    """Boxes around stretches along one axis."""
    a, b = splat16(origin) + start * splat16(direction), splat16(origin) + end * splat16(direction)
    spread = (absolute(a) + absolute(b)) * splat16(slack)
    store16(slots, slot, minimum(a, b) - spread)
    store16(slots, slot + REGION_MIDDLE, (a + b) * splat16(_HALF))
    store16(slots, slot + REGION_HIGH, maximum(a, b) + spread)


@device
def _spread_places(places, start, end, near):
    """Sixteen places from `start` to `end`: evenly, or, where the surface is known to be `near` the start, in steps
    that grow from there."""
    span = end - start
    if not near < span:
        store16(places, np.int64(0), splat16(start) + load16(_STEPS, np.int64(0)) * splat16(span * _GAP))
    else:
        # start + a (rᵏ − 1), so that the first step is about a.
        ratio = np.float32(math.exp(math.log(_ONE + span / near) * _GAP))
        power = _ONE
        for k in range(_LANES):
            store_float(places, k, start + near * (power - _ONE))
            power *= ratio
    store_float(places, _GAPS, end)


@device
def _look_at_points(fields, data, tape, line, start, end, near, sign, slots, places):
    """One pass over sixteen points. Returns bits of the gaps in which the sign changes, and of those not proven
    clear."""
    _spread_places(places, start, end, near)
    at = load16(places, np.int64(0))
    _load_points(slots, line, at)
    values_on(fields.interpreters, fields.rows, tape.first, tape.length, data, slots)
    values = load16(slots, (_RESULT + tape.length) * _LANES) * splat16(sign)
    store16(places, _LANES, values)
    store_float(places, 2 * _LANES, _ZERO)
    following, there = load16(places, _LANES + 1), load16(places, np.int64(1))
    crossed = bits(following <= splat16(_ZERO)) & _ALL_GAPS
    proven = bits(values + following > (there - at) * splat16(_SPARE * tape.lipschitz))
    return crossed, (proven ^ _ALL) & _ALL_GAPS


@device
def _look_at_stretches(fields, data, tape, line, start, end, sign, slots, choices):
    """Sixteen stretches by intervals. Returns bits of those not proven clear, and of those whose middle has the other
    sign."""
    width = (end - start) * _STRETCH
    begin = splat16(start) + load16(_STEPS, np.int64(0)) * splat16(width)
    finish = begin + splat16(width)
    slack = np.float32(2.0**-22)
    _load_axis(slots, np.int64(0), line.x, line.dx, begin, finish, slack)
    _load_axis(slots, np.int64(REGION_SLOT), line.y, line.dy, begin, finish, slack)
    _load_axis(slots, np.int64(2 * REGION_SLOT), line.z, line.dz, begin, finish, slack)
    bounds_on(fields.interpreters, fields.rows, tape.first, tape.length, data, slots, choices)
    result = (_RESULT + tape.length) * np.int64(REGION_SLOT)
    zero = splat16(_ZERO)
    above, below = load16(slots, result) > zero, load16(slots, result + REGION_HIGH) < zero
    clear = bits(above) if sign > _ZERO else bits(below)
    crossed = bits(load16(slots, result + REGION_MIDDLE) * splat16(sign) <= zero)
    return clear ^ _ALL, crossed & (clear ^ _ALL)


@device
def _narrow(fields, data, tape, line, start, end, sign, slots, places):
    """Place of the first change of sign seen between `start` and `end`, where the sign is the other one."""
    close = max(line.side * _CLOSE, _LANES * line.least)
    while True:
        wide = end - start
        crossed, _ = _look_at_points(fields, data, tape, line, start, end, end, sign, slots, places)
        if load_float(places, _LANES) <= _ZERO:
            return start
        k = np.int64(lowest_bit(crossed)) if crossed != 0 else _GAPS - 1
        start, end = load_float(places, k), load_float(places, k + 1)
        if wide <= close * np.float32(_GAPS):
            a, b = load_float(places, _LANES + k), load_float(places, _LANES + k + 1)
            # The line through both values.
            part = a / (a - b) if b <= _ZERO else _ONE
            return start + (end - start) * part


@device
def _sign_at(fields, data, tape, line, place, slots):
    """−1 inside, 1 elsewhere."""
    _load_points(slots, line, splat16(place))
    values_on(fields.interpreters, fields.rows, tape.first, tape.length, data, slots)
    return -_ONE if load_float(slots, (_RESULT + tape.length) * _LANES) < _ZERO else _ONE


@device
def _nearness(places, k, lipschitz, far):
    """How near the surface is known to lie where gap `k` begins, if the ray goes away from it there; else `far`."""
    a, b = load_float(places, _LANES + k), load_float(places, _LANES + k + 1)
    return a / lipschitz if b > a and lipschitz > _ZERO else far


@device
def first_crossing(fields, data, tape, line, start, end, sign, leaves, any_hit, slots, places, choices):
    """The first place from `start` to `end` at which the field's sign is not `sign`; 0 takes the sign at the start.

    `leaves` tells that a ray begins here. Returns (sign, whether there is such a place, place); with `any_hit` the
    place is only near. `slots`, `places` and `choices` are scratch.
    """
    if sign == _ZERO:
        sign = _sign_at(fields, data, tape, line, start, slots)
    # How often the last look has proven nothing: a closer one follows, then intervals. Without a Lipschitz constant
    # only these prove anything.
    calm = np.int64(0) if tape.lipschitz < _FAR else _CLOSER + 1
    doubt = calm
    at, reach = start, end
    near = line.side * _NEAR if leaves else end
    for _ in range(_PASSES):
        if doubt <= _CLOSER:
            crossed, unclear = _look_at_points(fields, data, tape, line, at, reach, near, sign, slots, places)
            if load_float(places, _LANES) <= _ZERO:
                return sign, True, at
            event = crossed | unclear
            if event == 0:
                at, reach, near, doubt = reach, end, end, calm
            else:
                k = np.int64(lowest_bit(event))
                near = _nearness(places, k, tape.lipschitz, end)
                at, reach = load_float(places, k), load_float(places, k + 1)
                if (crossed >> np.int32(k)) & _LOWEST:
                    if not any_hit:
                        at = _narrow(fields, data, tape, line, at, reach, sign, slots, places)
                    return sign, True, at
                doubt += 1
        else:
            crossed, unclear = _look_at_stretches(fields, data, tape, line, at, reach, sign, slots, choices)
            width = (reach - at) * _STRETCH
            if unclear == 0:
                at, reach, near, doubt = reach, min(end, reach + (reach - at) * _GROWTH), end, calm
            else:
                k = lowest_bit(unclear)
                at = at + np.float32(k) * width
                if (crossed >> k) & _LOWEST:
                    reach = at + width * _HALF
                    if not any_hit:
                        at = _narrow(fields, data, tape, line, at, reach, sign, slots, places)
                    return sign, True, at
                reach = at + width
                if width <= line.least:
                    # Nothing can lie between these two; the next look begins with the sign there.
                    at, reach, near, doubt = reach, min(end, reach + width * _GROWTH), end, calm
        if at >= end:
            return sign, False, end
    return sign, True, at
