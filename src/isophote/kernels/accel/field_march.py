"""Where a ray first crosses a field's surface within one region, found certainly.

A pass of the tape takes 64 points of the ray, or sixteen stretches of it. Between two points with values a and b of one
sign, h apart, the field is not zero if |a| + |b| > L h, for L is its Lipschitz constant. Where that proves nothing,
a closer look does, or intervals over stretches of the ray. What is not proven is never stepped over, down to what
positions in single precision can tell apart.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from isophote.kernels.accel import field_layout as layout
from isophote.kernels.base.entry import floats_at
from isophote.kernels.base.jit import device
from isophote.kernels.base.long_words import load_long, lowest_bit, store_long
from isophote.kernels.base.simd import (
    absolute,
    bits,
    load16,
    load_float,
    load_int,
    maximum,
    minimum,
    splat16,
    store16,
    store_float,
    store_int,
)
from isophote.kernels.base.simd_lanes import following_lanes, lane_numbers
from isophote.kernels.forms import opcodes as op
from isophote.kernels.forms.interpreters import bounds_on, values_on
from isophote.kernels.forms.tape_interval import REGION_HIGH, REGION_MIDDLE, REGION_SLOT

__all__ = ["Line", "Tape", "affine_doubles", "first_crossing", "slots_at", "tape_at"]

_WORD, _LINE, _SLOT, _INPUTS = (np.int64(n) for n in (4, layout.LINE, layout.SLOT, op.INPUTS))
_ZERO, _HALF, _ONE = np.float32(0), np.float32(0.5), np.float32(1)
_FAR = np.float32(np.inf)

# Points of a pass, in four vectors; the last of them begins at _TAIL. Gap k lies between points k and k + 1.
_VECTORS, _LANES, _POINTS, _TAIL, _LAST = (np.int64(n) for n in (4, 16, 64, 48, 63))


def _spacings() -> np.ndarray:
    """Rows of places from 0 to 1: evenly spaced, and in steps that grow, the first being about 2⁻ᵏ for row k."""
    number = np.arange(64)
    rows = [number / 63]
    for power in range(1, 31):
        ratio = (1 + 2.0**power) ** (1 / 63)
        rows.append((ratio**number - 1) / (ratio**63 - 1))
    return np.array(rows, np.float32).reshape(-1)


_SPACINGS = _spacings()
_MOST_POWER = np.int64(30)
_MANTISSA, _BIAS = np.int64(23), np.int64(127)

# Gaps are proven with this much to spare, for the rounding of positions.
_SPARE = np.float32(1 + 2.0**-10)
# Where a ray starts within a region, it usually leaves a surface: how near its first points lie, in steps that
# positions can tell apart.
_NEAR = np.float32(8)
# A crossing is looked at closer until its gap, with what a bend may move it, is so short in parts of the details' size.
_CLOSE = np.float32(2.0**-13)
# A line finds a crossing to this part of the details' size, where three gaps in turn that are not longer than the
# other part say so.
_STRAIGHT, _SHORT = np.float32(2.0**-18), np.float32(2.0**-7)
# Two bends are those of one smooth curve if their difference is not more than so much of their sum. Two of Newton's
# steps bring the crossing from the line onto the curve.
_ALIKE, _NEWTON_STEPS = np.float32(0.5), np.int64(2)
# Looks after which a ray that still cannot be told from the surface has met it.
_PASSES = np.int64(1024)
_STRETCH, _GROWTH = np.float32(1 / 16), np.float32(16)
# Half the precision of positions, by which boxes around stretches are widened.
_SLACK = np.float32(2.0**-22)
_LOWEST, _ALL = np.int32(1), np.int32(0xFFFF)
_NO_GAP, _GAP, _GAPS = np.int64(0), np.int64(1), np.int64((1 << 63) - 1)
# Looks at gaps of the last look stand behind it in the scratch. Each has, as bits, the gaps that are not clear and have
# yet to be gone through, and those at whose end the sign has changed; and how many times gaps could not be proven.
# Beyond the deepest look intervals are asked.
_UNCLEAR, _CROSSED, _FAILED, _LEVEL = (np.int64(layout.LOOK + n) for n in (0, 2, 4, 16))
_DEEPEST = _LEVEL * (layout.LOOKS - 1)
# Neighbouring gaps that are not clear are looked at together, up to so many in the first look and half as many in each
# closer one, so that the deepest tells apart what positions can.
_TOGETHER = np.int64(16)
# Closer looks that a look may need before intervals are asked about the rest.
_PATIENCE = np.int32(4)
# The value stands in slot _RESULT + rows of the tape.
_RESULT = np.int64(op.INPUTS - 1)


class Line(NamedTuple):
    """A ray in a field's space: origin, unit direction, the least step, and the size of details."""

    x: float
    y: float
    z: float
    dx: float
    dy: float
    dz: float
    least: float
    detail: float


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
def slots_at(fields, scratch):
    """The slots within an entry's scratch, from its address."""
    behind = scratch + _WORD * (layout.CHOICES_AT + fields.longest)
    return floats_at((behind + (_LINE - 1)) & -_LINE, _SLOT * (fields.longest + _INPUTS))


@device
def tape_at(fields, root, number):
    """The `Tape` of this number, of the field whose whole tape is `root`."""
    slope = min(_steepness(fields, root), _steepness(fields, number))
    return Tape(np.int64(fields.tapes[number, 0]), np.int64(fields.tapes[number, 1]), slope)


@device
def _steepness(fields, number):
    """The Lipschitz constant that the last row of a tape tells."""
    first, count = np.int64(fields.tapes[number, 0]), np.int64(fields.tapes[number, 1])
    # Without rows the field is a coordinate of the point.
    return load_float(fields.rows, (first + count - 1) * np.int64(op.ROW) + op.LIPSCHITZ) if count > 0 else _ONE


@device
def _load_axis(slots, slot, origin, direction, start, end):
    """Boxes around stretches along one axis."""
    a, b = splat16(origin) + start * splat16(direction), splat16(origin) + end * splat16(direction)
    spread = (absolute(a) + absolute(b)) * splat16(_SLACK)
    store16(slots, slot, minimum(a, b) - spread)
    store16(slots, slot + REGION_MIDDLE, (a + b) * splat16(_HALF))
    store16(slots, slot + REGION_HIGH, maximum(a, b) + spread)


@device
def _row_of_spacings(span, near, places, base):
    """The row of spacings for a span at whose start the surface is known to be `near`."""
    if not near < span:
        return np.int64(0)
    store_float(places, base, span / near)
    power = np.int64(load_int(places, base) >> np.int32(_MANTISSA)) - _BIAS + 1
    return min(power, _MOST_POWER)


@device
def _look(fields, data, tape, line, start, end, near, sign, slots, places, base):
    """Run the tape at 64 points from `start` to `end`, whose places and values are left in `places` from `base` on,
    with the gaps that are not clear. Returns the sign, which is taken from the first value if it is 0."""
    span = end - start
    row = _row_of_spacings(span, near, places, base) * _POINTS
    for v in range(0, _POINTS, _LANES):
        at = splat16(start) + load16(_SPACINGS, row + v) * splat16(span)
        store16(places, base + v, at)
        store16(slots, v, splat16(line.x) + at * splat16(line.dx))
        store16(slots, _POINTS + v, splat16(line.y) + at * splat16(line.dy))
        store16(slots, 2 * _POINTS + v, splat16(line.z) + at * splat16(line.dz))
    values_on(fields.interpreters, fields.rows, tape.first, tape.length, data, slots, _VECTORS)
    result = (_RESULT + tape.length) * _POINTS
    if sign == _ZERO:
        sign = -_ONE if load_float(slots, result) < _ZERO else _ONE
    _keep_gaps(tape, sign, slots, result, places, base)
    return sign


@device
def _keep_gaps(tape, sign, slots, result, places, base):
    """Keep the values of a look, and its gaps: a gap is clear if the sign is the same at both ends and the Lipschitz
    constant leaves no room for another between."""
    slope = _SPARE * tape.lipschitz if tape.lipschitz < _FAR else -_FAR
    crossed, clear = _NO_GAP, _NO_GAP
    for v in range(0, _POINTS, _LANES):
        following = min(v + _LANES, _TAIL)
        at, value = load16(places, base + v), load16(slots, result + v)
        to = following_lanes(at, load16(places, base + following))
        there = following_lanes(value, load16(slots, result + following)) * splat16(sign)
        crossed |= np.int64(bits(there <= splat16(_ZERO))) << v
        clear |= np.int64(bits(value * splat16(sign) + there > (to - at) * splat16(slope))) << v
        store16(places, base + _POINTS + v, value)
    store_long(places, base + _UNCLEAR, (~clear | crossed) & _GAPS)
    store_long(places, base + _CROSSED, crossed)
    store_int(places, base + _FAILED, np.int32(0))


@device
def _look_at_stretches(fields, data, tape, line, start, end, sign, slots, choices):
    """Sixteen stretches by intervals. Returns bits of those not proven clear, and of those whose middle has the other
    sign."""
    width = (end - start) * _STRETCH
    begin = splat16(start) + lane_numbers() * splat16(width)
    finish = begin + splat16(width)
    _load_axis(slots, np.int64(0), line.x, line.dx, begin, finish)
    _load_axis(slots, np.int64(REGION_SLOT), line.y, line.dy, begin, finish)
    _load_axis(slots, np.int64(2 * REGION_SLOT), line.z, line.dz, begin, finish)
    bounds_on(fields.interpreters, fields.rows, tape.first, tape.length, data, slots, choices)
    result = (_RESULT + tape.length) * np.int64(REGION_SLOT)
    zero = splat16(_ZERO)
    above, below = load16(slots, result) > zero, load16(slots, result + REGION_HIGH) < zero
    clear = bits(above) if sign > _ZERO else bits(below)
    crossed = bits(load16(slots, result + REGION_MIDDLE) * splat16(sign) <= zero)
    return clear ^ _ALL, crossed


@device
def _search(fields, data, tape, line, start, end, sign, slots, choices):
    """What intervals find between two places: (whether the sign changes, place up to which there is no change, place
    of the other sign)."""
    at, reach = start, end
    for _ in range(_PASSES):
        unclear, crossed = _look_at_stretches(fields, data, tape, line, at, reach, sign, slots, choices)
        width = (reach - at) * _STRETCH
        if unclear == 0:
            at, reach = reach, min(end, reach + (reach - at) * _GROWTH)
        else:
            k = lowest_bit(np.int64(unclear))
            at = at + np.float32(k) * width
            if (crossed >> k) & _LOWEST:
                return True, at, at + width * _HALF
            reach = at + width
            if width <= line.least:
                # Nothing that positions could tell lies between these two.
                at, reach = reach, min(end, reach + width * _GROWTH)
        if at >= end:
            return False, end, end
    return True, at, at


@device
def _proven_ahead(fields, data, tape, line, k, sign, slots, places, base, choices):
    """The first gap from number `k` on that intervals over the rest of a look do not prove clear."""
    at, end = load_float(places, base + k), load_float(places, base + _LAST)
    unclear, _ = _look_at_stretches(fields, data, tape, line, at, end, sign, slots, choices)
    if unclear == 0:
        return _LAST
    reach = at + np.float32(lowest_bit(np.int64(unclear))) * ((end - at) * _STRETCH)
    while k < _LAST and load_float(places, base + k + 1) <= reach:
        k += 1
    return k


@device
def _nearness(places, base, k, end, lipschitz, far):
    """How near the surface is known to lie at point `k`, if the ray goes away from it up to point `end`; else `far`."""
    a, b = abs(load_float(places, base + _POINTS + k)), abs(load_float(places, base + _POINTS + end))
    return a / lipschitz if b > a else far


@device
def _together(unclear, crossed, k, most):
    """The point at which gaps end that are to be looked at with gap `k`: a crossing is looked at by itself."""
    if (crossed >> k) & _GAP:
        return k + 1
    return k + min(lowest_bit(~((unclear & ~crossed) >> k)), most)


@device
def _slope(places, base, k):
    """The slope of the values between the ends of gap `k`."""
    rise = load_float(places, base + _POINTS + k + 1) - load_float(places, base + _POINTS + k)
    return rise / (load_float(places, base + k + 1) - load_float(places, base + k))


@device
def _root(places, base, k, line):
    """(place in gap `k` at which the values cross zero, whether it is known so well that no closer look is needed).

    It lies on the line through the values at both ends, or on a parabola where the gaps beside it bend alike.
    """
    at, to = load_float(places, base + k), load_float(places, base + k + 1)
    a, b = load_float(places, base + _POINTS + k), load_float(places, base + _POINTS + k + 1)
    width, slope = to - at, (b - a) / (to - at)
    place = at + width * (a / (a - b))
    tiny = width <= _GROWTH * line.least
    if k == 0 or k == _LAST - 1:
        return place, tiny
    to_before = to - load_float(places, base + k - 1)
    to_behind = load_float(places, base + k + 2) - at
    before, behind = slope - _slope(places, base, k - 1), _slope(places, base, k + 1) - slope
    bend = max(abs(before), abs(behind))
    # A line would be off by the bend times the gap, over eight slopes, or by a kink's whole bend.
    off = bend * width / abs(slope)
    known = width <= _SHORT * line.detail and (off <= _STRAIGHT * line.detail or off + width <= _CLOSE * line.detail)
    before, behind = before / to_before, behind / to_behind
    if abs(behind - before) < _ALIKE * abs(behind + before):
        curve = (before + behind) * _HALF
        for _ in range(_NEWTON_STEPS):
            value = (place - at) * slope + a + curve * (place - at) * (place - to)
            place -= value / (slope + curve * ((place - at) + (place - to)))
        # Where positions cannot tell points apart, slopes are no numbers.
        place = place if at <= place <= to else at + width * (a / (a - b))
    return place, known or tiny


@device
def first_crossing(fields, data, tape, line, start, end, sign, leaves, any_hit, slots, places, choices):
    """The first place from `start` to `end` at which the field's sign is not `sign`; 0 takes the sign at the start.

    `leaves` tells that a ray begins here. Returns (sign, whether there is such a place, place); with `any_hit` the
    place is only near. `slots`, `places` and `choices` are scratch.
    """
    base = np.int64(0)
    sign = _look(fields, data, tape, line, start, end, _NEAR * line.least if leaves else end, sign, slots, places, base)
    if not tape.lipschitz < _FAR:
        # Only intervals prove anything.
        found, at, to = _search(fields, data, tape, line, start, end, sign, slots, choices)
        if not found or any_hit:
            return sign, found, at
        _look(fields, data, tape, line, at, to, to, sign, slots, places, base)
    for _ in range(_PASSES):
        # A change of sign just where a look begins lies behind what was proven before it.
        if load_float(places, base + _POINTS) * sign <= _ZERO:
            return sign, True, load_float(places, base)
        unclear, crossed = load_long(places, base + _UNCLEAR), load_long(places, base + _CROSSED)
        if unclear == _NO_GAP:
            if base == 0:
                return sign, False, end
            base -= _LEVEL
            continue
        k = lowest_bit(unclear)
        at, to = load_float(places, base + k), load_float(places, base + k + 1)
        if (crossed >> k) & _GAP:
            place, known = _root(places, base, k, line)
            if known or any_hit or base == _DEEPEST:
                return sign, True, place
        most = max(_TOGETHER >> (base // _LEVEL), _GAP)
        last = _together(unclear, crossed, k, most)
        failed = load_int(places, base + _FAILED) + np.int32(1)
        store_int(places, base + _FAILED, failed)
        if failed > _PATIENCE or last - k == _TOGETHER:
            # Along a flat face distances prove little, and intervals much.
            ahead = _proven_ahead(fields, data, tape, line, k, sign, slots, places, base, choices)
            if ahead > k:
                store_long(places, base + _UNCLEAR, unclear & (_GAPS << ahead))
                continue
        to = load_float(places, base + last)
        store_long(places, base + _UNCLEAR, unclear & (_GAPS << last))
        if base < _DEEPEST:
            near = _nearness(places, base, k, last, tape.lipschitz, to)
            base += _LEVEL
            _look(fields, data, tape, line, at, to, near, sign, slots, places, base)
        else:
            found, at, to = _search(fields, data, tape, line, at, to, sign, slots, choices)
            if found:
                return sign, True, at
    return sign, True, load_float(places, base)
