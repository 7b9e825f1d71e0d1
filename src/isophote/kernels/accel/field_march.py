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
from isophote.kernels.base.simd import (
    absolute,
    bits,
    load16,
    load_float,
    load_int,
    lowest_bit,
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

# Points of a pass, in four vectors. Point i is lane i // 4 of vector i % 4, so that its neighbour lies beside it in the
# next vector.
_VECTORS, _LANES, _POINTS = np.int64(4), np.int64(16), np.int64(64)
_LAST = np.int64(63)


def _spacings() -> np.ndarray:
    """Rows of places from 0 to 1: evenly spaced, and in steps that grow, the first being about 2⁻ᵏ for row k."""
    number = np.arange(64)
    rows = [number / 63]
    for power in range(1, 31):
        ratio = (1 + 2.0**power) ** (1 / 63)
        rows.append((ratio**number - 1) / (ratio**63 - 1))
    by_lane = np.array(rows).reshape(-1, 16, 4).transpose(0, 2, 1)
    return np.ascontiguousarray(by_lane, np.float32).reshape(-1)


_SPACINGS = _spacings()
_MOST_POWER = np.int64(30)
_MANTISSA, _BIAS = np.int64(23), np.int64(127)

# Gaps are proven with this much to spare, for the rounding of positions.
_SPARE = np.float32(1 + 2.0**-10)
# Where a ray starts within a region, it usually leaves a surface: how near its first points lie, in parts of the
# details' size.
_NEAR = np.float32(2.0**-16)
# A crossing is looked at closer until its gap is so short in parts of the details' size; a line finds it there.
_CLOSE = np.float32(2.0**-13)
# A line finds a crossing to this part of the details' size, where two gaps in turn that are not longer than the other
# part say so.
_STRAIGHT, _SHORT = np.float32(2.0**-18), np.float32(2.0**-10)
# Looks after which a ray that still cannot be told from the surface has met it.
_PASSES = np.int64(1024)
_STRETCH, _GROWTH = np.float32(1 / 16), np.float32(16)
# Half the precision of positions, by which boxes around stretches are widened.
_SLACK = np.float32(2.0**-22)
_LOWEST, _ALL, _ALL_BUT_LAST = np.int32(1), np.int32(0xFFFF), np.int32(0x7FFF)
# Looks at a gap of the last look stand behind it in the scratch, with the number of the next gap to go through and how
# many could not be proven; beyond the deepest intervals are asked.
_NEXT, _FAILED, _LEVEL = np.int64(layout.LOOK), np.int64(layout.LOOK + 1), np.int64(layout.LOOK + 16)
_DEEPEST = _LEVEL * (layout.LOOKS - 1)
# Gaps of a look that may fail before intervals are asked about the rest.
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
    slope = min(_slope(fields, root), _slope(fields, number))
    return Tape(np.int64(fields.tapes[number, 0]), np.int64(fields.tapes[number, 1]), slope)


@device
def _slope(fields, number):
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
def _look(fields, data, tape, line, start, end, near, slots, places, base):
    """Run the tape at 64 points from `start` to `end`, whose places and values are left in `places` from `base` on."""
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
    for v in range(0, _POINTS, _LANES):
        store16(places, base + _POINTS + v, load16(slots, result + v))
    store_int(places, base + _NEXT, np.int32(0))
    store_int(places, base + _FAILED, np.int32(0))


@device
def _gaps(places, base, v, sign, slope, begin):
    """Gaps from number `begin` on that begin at the points of vector `v`: bits of those at whose end the sign has
    changed, and of those that are not proven clear."""
    at, value = load16(places, base + v * _LANES), load16(places, base + _POINTS + v * _LANES)
    if v < _VECTORS - 1:
        following = base + (v + 1) * _LANES
        to, there = load16(places, following), load16(places, _POINTS + following)
    else:
        to, there = following_lanes(load16(places, base)), following_lanes(load16(places, base + _POINTS))
    there = there * splat16(sign)
    crossed = bits(there <= splat16(_ZERO))
    proven = bits(value * splat16(sign) + there > (to - at) * splat16(slope))
    # Behind the last point there is no gap.
    wanted = (_ALL << np.int32((begin - v + _VECTORS - 1) // _VECTORS)) & (_ALL if v < _VECTORS - 1 else _ALL_BUT_LAST)
    return crossed & wanted, (proven ^ _ALL) & wanted


@device
def _point(k):
    """Where point `k` stands in a row of 64."""
    return (k & (_VECTORS - 1)) * _LANES + k // _VECTORS


@device
def _first_event(places, base, sign, slope):
    """(number of the first gap that is not clear, of those not yet gone through, whether the sign changes there);
    number _LAST where all are."""
    begin = np.int64(load_int(places, base + _NEXT))
    crossed0, unclear0 = _gaps(places, base, np.int64(0), sign, slope, begin)
    crossed1, unclear1 = _gaps(places, base, np.int64(1), sign, slope, begin)
    crossed2, unclear2 = _gaps(places, base, np.int64(2), sign, slope, begin)
    crossed3, unclear3 = _gaps(places, base, np.int64(3), sign, slope, begin)
    event0, event1, event2, event3 = crossed0 | unclear0, crossed1 | unclear1, crossed2 | unclear2, crossed3 | unclear3
    event = event0 | event1 | event2 | event3
    if event == 0:
        return _LAST, False
    lane = lowest_bit(event)
    first = _VECTORS * np.int64(lane)
    if (event0 >> lane) & _LOWEST:
        return first, ((crossed0 >> lane) & _LOWEST) != 0
    if (event1 >> lane) & _LOWEST:
        return first + 1, ((crossed1 >> lane) & _LOWEST) != 0
    if (event2 >> lane) & _LOWEST:
        return first + 2, ((crossed2 >> lane) & _LOWEST) != 0
    return first + 3, ((crossed3 >> lane) & _LOWEST) != 0


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
            k = lowest_bit(unclear)
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
    at, end = load_float(places, base + _point(k)), load_float(places, base + _point(_LAST))
    unclear, _ = _look_at_stretches(fields, data, tape, line, at, end, sign, slots, choices)
    if unclear == 0:
        return _LAST
    reach = at + np.float32(lowest_bit(unclear)) * ((end - at) * _STRETCH)
    while k < _LAST and load_float(places, base + _point(k + 1)) <= reach:
        k += 1
    return k


@device
def _nearness(places, base, k, lipschitz, far):
    """How near the surface is known to lie where gap `k` begins, if the ray goes away from it there; else `far`."""
    a, b = abs(load_float(places, base + _POINTS + _point(k))), abs(load_float(places, base + _POINTS + _point(k + 1)))
    return a / lipschitz if b > a else far


@device
def _straight(places, base, k, detail):
    """Whether gap `k` and the one before it have so nearly one slope that a line finds the crossing between them."""
    if k == 0 or load_float(places, base + _point(k + 1)) - load_float(places, base + _point(k)) > _SHORT * detail:
        return False
    x0, x1, x2 = (
        load_float(places, base + _point(k - 1)),
        load_float(places, base + _point(k)),
        load_float(places, base + _point(k + 1)),
    )
    a, b, c = (
        load_float(places, base + _POINTS + _point(k - 1)),
        load_float(places, base + _POINTS + _point(k)),
        load_float(places, base + _POINTS + _point(k + 1)),
    )
    before, slope = (b - a) / (x1 - x0), (c - b) / (x2 - x1)
    # The line is off by the bend times the gap, over eight slopes, or by a kink's whole bend.
    return abs(slope - before) * (x2 - x1) <= _STRAIGHT * detail * abs(slope)


@device
def first_crossing(fields, data, tape, line, start, end, sign, leaves, any_hit, slots, places, choices):
    """The first place from `start` to `end` at which the field's sign is not `sign`; 0 takes the sign at the start.

    `leaves` tells that a ray begins here. Returns (sign, whether there is such a place, place); with `any_hit` the
    place is only near. `slots`, `places` and `choices` are scratch.
    """
    slope = _SPARE * tape.lipschitz
    close = max(line.detail * _CLOSE, _GROWTH * line.least)
    base = np.int64(0)
    _look(fields, data, tape, line, start, end, line.detail * _NEAR if leaves else end, slots, places, base)
    if sign == _ZERO:
        sign = -_ONE if load_float(places, _POINTS) < _ZERO else _ONE
    if not tape.lipschitz < _FAR:
        # Only intervals prove anything.
        found, at, to = _search(fields, data, tape, line, start, end, sign, slots, choices)
        if not found or any_hit:
            return sign, found, at
        _look(fields, data, tape, line, at, to, to, slots, places, base)
        slope = -_FAR
    for _ in range(_PASSES):
        # A change of sign just where a look begins lies behind what was proven before it.
        if load_float(places, base + _POINTS) * sign <= _ZERO:
            return sign, True, load_float(places, base)
        k, crosses = _first_event(places, base, sign, slope)
        if k == _LAST:
            if base == 0:
                return sign, False, end
            base -= _LEVEL
            continue
        at, to = load_float(places, base + _point(k)), load_float(places, base + _point(k + 1))
        if crosses and (any_hit or to - at <= close or base == _DEEPEST or _straight(places, base, k, line.detail)):
            a, b = load_float(places, base + _POINTS + _point(k)), load_float(places, base + _POINTS + _point(k + 1))
            # The line through both values.
            return sign, True, at + (to - at) * (a / (a - b))
        failed = load_int(places, base + _FAILED) + np.int32(1)
        store_int(places, base + _FAILED, failed)
        if failed > _PATIENCE:
            # Along a flat face distances prove little, and intervals much.
            ahead = _proven_ahead(fields, data, tape, line, k, sign, slots, places, base, choices)
            if ahead > k:
                store_int(places, base + _NEXT, np.int32(ahead))
                continue
        store_int(places, base + _NEXT, np.int32(k + 1))
        if base < _DEEPEST:
            near = _nearness(places, base, k, tape.lipschitz, to)
            base += _LEVEL
            _look(fields, data, tape, line, at, to, near, slots, places, base)
        else:
            found, at, to = _search(fields, data, tape, line, at, to, sign, slots, choices)
            if found:
                return sign, True, at
    return sign, True, load_float(places, base)
