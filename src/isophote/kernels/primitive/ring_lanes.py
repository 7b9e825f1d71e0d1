"""Sixteen rays against a torus: as ring.py finds crossings, all rays taking Newton's steps together, in registers.

The line is gone through in three pieces, between which the quartic has its inflections. Where a piece has no root, a
ray waits for the next one; what is still open after so many steps, as with rays that graze, is found by itself.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from isophote.kernels.base.doubles import doubles_at
from isophote.kernels.base.entry import entry
from isophote.kernels.base.jit import device, exact_inline
from isophote.kernels.base.simd import bits, lowest_bit
from isophote.kernels.base.simd_double16 import (
    chosen_doubles16 as chosen,
)
from isophote.kernels.base.simd_double16 import (
    load_doubles16,
    outside_mask,
    root_doubles16,
    size_doubles16,
    splat_doubles16,
    store_doubles16,
)
from isophote.kernels.primitive import layout
from isophote.kernels.primitive.lanes import BLOCK_DOUBLES, HIGH, LANES, PART, T, U, V, W, X, Y, Z
from isophote.kernels.primitive.ring import cross_ring

__all__ = ["meet_rings"]

_ONE, _DOUBLE, _FAR = np.int64(1), np.int64(8), math.inf
# So many steps for a piece; five to eight are enough for nearly all rays.
_STEPS = 8
_LAST_STEP = 2.0**-26
# More than the rounding of what is compared.
_SURE = 1.0 - 2.0**-40


class Lines(NamedTuple):
    """Sixteen lines: their points nearest to the middle, t there, how they rise, 1 / |direction|², and what is left of
    the square of the torus's reach at those points."""

    x: float
    y: float
    z: float
    nearest: float
    rise: float
    square: float
    inverse_square: float
    reach2: float


class Quartics(NamedTuple):
    """s⁴ + a s² + b s + c, and where the second inflection is: −∞ without any, so that all is the last piece."""

    a: float
    b: float
    c: float
    bend: float


@exact_inline
def _larger(a, b):
    """`b` where `a` is NaN."""
    return chosen(a > b, a, b)


@exact_inline
def _smaller(a, b):
    return chosen(a < b, a, b)


@exact_inline
def _lines(block, tube):
    x, y, z = load_doubles16(block, X), load_doubles16(block, Y), load_doubles16(block, Z)
    u, v, w = load_doubles16(block, U), load_doubles16(block, V), load_doubles16(block, W)
    a = u * u + v * v + w * w
    inverse_a = splat_doubles16(1.0) / a
    nearest = splat_doubles16(0.0) - (x * u + y * v + z * w) * inverse_a
    x, y, z = x + nearest * u, y + nearest * v, z + nearest * w
    reach2 = splat_doubles16((1.0 + tube) * (1.0 + tube)) - (x * x + y * y + z * z)
    return Lines(x, y, z, nearest, v, a, inverse_a, reach2)


@exact_inline
def _may_meet(lines, tube):
    """Whether each line comes into the part of the ball around the torus that lies between the planes around it, and
    some that barely do not."""
    zero = splat_doubles16(0.0)
    away = size_doubles16(lines.y) - splat_doubles16(tube / _SURE)
    rise2 = lines.rise * lines.rise * lines.inverse_square
    apart = (away > zero) & (splat_doubles16(_SURE) * (away * away) > rise2 * lines.reach2)
    return outside_mask(lines.reach2 >= zero, apart)


@exact_inline
def _stretch(block, lines, speed, tube):
    """(start, end, behind) of each line within the ball and between the planes around the torus, from its ray's origin,
    at `behind`, to its limit; where start > end, it misses."""
    half = root_doubles16(_larger(lines.reach2, splat_doubles16(0.0)))
    inverse = speed / lines.rise
    below = (splat_doubles16(-tube) - lines.y) * inverse
    above = (splat_doubles16(tube) - lines.y) * inverse
    # Of level rays these are infinite: on one side where they run between the planes, else both before or behind.
    upward = inverse > splat_doubles16(0.0)
    start = _larger(chosen(upward, below, above), splat_doubles16(0.0) - half)
    end = _smaller(chosen(upward, above, below), half)
    behind = (splat_doubles16(0.0) - lines.nearest) * speed
    limit = (load_doubles16(block, HIGH) - lines.nearest) * speed
    return _larger(behind, start), _smaller(limit, end), behind


@exact_inline
def _quartics(lines, speed, tube):
    y, rise, one = lines.y, lines.rise * speed * lines.inverse_square, splat_doubles16(1.0)
    rho2 = lines.x * lines.x + lines.z * lines.z
    rho, across = root_doubles16(rho2), y * y - splat_doubles16(tube * tube)
    a = splat_doubles16(2.0) * (rho2 + across + one) - splat_doubles16(4.0) * (one - rise * rise)
    # Each factor is told by the distance from the circle on its side.
    c = ((rho - one) * (rho - one) + across) * ((rho + one) * (rho + one) + across)
    bend2 = splat_doubles16(-1.0 / 6.0) * a
    zero = splat_doubles16(0.0)
    bend = chosen(bend2 > zero, root_doubles16(_larger(bend2, zero)), splat_doubles16(-_FAR))
    return Quartics(a, splat_doubles16(8.0) * y * rise, c, bend)


@exact_inline
def _value(f, s):
    s2 = s * s
    return s2 * (s2 + f.a) + (f.b * s + f.c)


@exact_inline
def _slope(f, s):
    return s * (splat_doubles16(4.0) * (s * s) + splat_doubles16(2.0) * f.a) + f.b


@exact_inline
def _descend(f, sign, running, s, stop, way):
    """Newton's steps of the rays that run, from where sign · f is convex and above zero, to its root before `stop`.
    Returns (s, those that found a root, those that are still running)."""
    zero, last, one = splat_doubles16(0.0), splat_doubles16(_LAST_STEP), splat_doubles16(1.0)
    found = outside_mask(running, running)
    turn = sign * way
    for _ in range(_STEPS):
        value, slope = sign * _value(f, s), turn * _slope(f, s)
        step = (zero - value) / slope
        n = s + way * step
        there = running & (value <= zero)
        beyond = (slope >= zero) | ((stop - n) * way < zero)
        moved = outside_mask(outside_mask(running, there), beyond)
        s = chosen(moved, n, s)
        close = moved & (step <= last * (one + size_doubles16(n)))
        found = found | there | close
        running = outside_mask(moved, close)
        if bits(running) == 0:
            break
    return s, found, running


@exact_inline
def _begin(f, sign, concave, inside, start, end):
    """(runs, s, stop, way) of rays that have a root between `start` and `end`, where sign · f is convex, as
    ring._cross_piece; rays that are outside begin where they come in, if it may come down to zero before the end."""
    zero = splat_doubles16(0.0)
    last, last_slope = sign * _value(f, end), sign * _slope(f, end)
    above = last > zero
    # A ray inside leaves a piece that is concave after a descent of -f, one that is convex by the root before its end.
    forward = inside if concave else outside_mask(start < end, inside)
    down = outside_mask(forward & (sign * _slope(f, start) < zero), above & (last_slope <= zero))
    runs = (start < end) & (down | outside_mask(above, forward))
    one = splat_doubles16(1.0)
    return runs, chosen(forward, start, end), chosen(forward, end, start), chosen(forward, one, zero - one)


@exact_inline
def _write(block, t, met):
    store_doubles16(block, T, chosen(met, t, splat_doubles16(_FAR)))
    store_doubles16(block, PART, splat_doubles16(0.0))


@device
def _find(block, line, i, tube):
    """The first crossing of one ray by itself."""
    for k in range(6):
        line[k] = block[LANES * k + i]
    line[layout.LOW], line[layout.HIGH], line[layout.MOST] = 0.0, block[HIGH + i], 1.0
    block[T + i] = line[layout.FOUND] if cross_ring(line, tube) > 0 else _FAR


@entry
def meet_rings(own, block_address, lanes):
    """The first crossings of sixteen rays."""
    block, tube = doubles_at(block_address, BLOCK_DOUBLES), doubles_at(own, _ONE)[0]
    zero = splat_doubles16(0.0)
    lines = _lines(block, tube)
    waits = _may_meet(lines, tube)
    none = outside_mask(waits, waits)
    if bits(waits) == 0:
        _write(block, zero, none)
        return np.int64(0)
    speed = root_doubles16(lines.square)
    start, end, behind = _stretch(block, lines, speed, tube)
    waits = waits & (start <= end)
    if bits(waits) == 0:
        _write(block, zero, none)
        return np.int64(0)
    asked, f = waits, _quartics(lines, speed, tube)
    inside = (start <= behind) & (_value(f, start) < zero)
    found, left, s = none, none, start
    for piece in range(3):
        concave = piece == 1
        sign = splat_doubles16(-1.0 if concave else 1.0)
        after = splat_doubles16(-_FAR) if piece == 0 else (zero - f.bend if concave else f.bend)
        before = zero - f.bend if piece == 0 else (f.bend if concave else splat_doubles16(_FAR))
        runs, at, stop, way = _begin(f, sign, concave, inside, _larger(start, after), _smaller(end, before))
        runs = runs & waits
        if bits(runs) != 0:
            at, met, open_ = _descend(f, sign, runs, at, stop, way)
            s, found, left = chosen(met, at, s), found | met, left | open_
            waits = outside_mask(outside_mask(waits, met), open_)
            if bits(waits) == 0:
                break
    t = lines.nearest + s / speed
    _write(block, t, found & (t > zero) & (t < load_doubles16(block, HIGH)))
    # Thick tubes have an inner surface that does not count.
    alone = bits(asked if tube > 1.0 else left)
    if alone != 0:
        line = doubles_at(block_address + _DOUBLE * BLOCK_DOUBLES, np.int64(layout.WORDS))
        while alone != 0:
            _find(block, line, np.int64(lowest_bit(alone)), tube)
            alone &= alone - np.int32(1)
    return np.int64(0)
