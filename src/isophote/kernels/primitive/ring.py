"""Tori about y: all within r of the circle of radius 1. The one number of their own is r.

Counted from the line's point nearest to the middle, in lengths, the quartic has no cubic term:

    f(s) = (|p|² + 1 − r²)² − 4 (x² + z²) = s⁴ + A s² + B s + C,  f'' = 12 s² + 2 A

Between its inflections f is convex or concave, and there Newton's steps from the right end never overshoot a root. So
every crossing is found in order, however the line grazes, and without a case of degenerate coefficients; what is
uncertain is f's own rounding, some 10⁻¹⁶ of the ring's size.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from isophote.kernels.base.doubles import doubles_at
from isophote.kernels.base.entry import entry
from isophote.kernels.base.jit import device
from isophote.kernels.primitive import layout
from isophote.kernels.primitive.line import around, found

__all__ = ["cross_ring", "describe_ring", "meet_ring"]

_WORDS, _NO, _OWN = np.int64(layout.WORDS), np.int64(0), np.int64(1)
_FAR = math.inf
# Steps of Newton's; toward a double root each one halves what is left.
_STEPS = 64
# Steps shorter than this, in parts of the ring's size, change nothing.
_LAST_STEP = 2.0**-52


class Quartic(NamedTuple):
    """s⁴ + A s² + B s + C; |p|² + 1 − r² = s² + `g`; s is 0 at t = `nearest` and moves by `speed`."""

    a: float
    b: float
    c: float
    g: float
    nearest: float
    speed: float


@device
def _value(f, s):
    s2 = s * s
    return s2 * (s2 + f.a) + (f.b * s + f.c)


@device
def _descend(f, sign, s, end):
    """The root of `sign` f, convex and above zero at `s`, that Newton's steps lead to before `end`, or infinity."""
    way = 1.0 if end > s else -1.0
    for _ in range(_STEPS):
        s2 = s * s
        value = sign * (s2 * (s2 + f.a) + (f.b * s + f.c))
        slope = sign * way * (s * (4.0 * s2 + 2.0 * f.a) + f.b)
        if value <= 0.0:
            return s
        if slope >= 0.0:
            return _FAR
        step = -value / slope
        s += way * step
        if (end - s) * way < 0.0:
            return _FAR
        if step <= _LAST_STEP * (1.0 + abs(s)):
            return s
    return s


@device
def _cross(line, count, f, s):
    """Write a crossing down, unless it lies on the inner surface where a thick tube crosses itself: there
    |p|² + 1 − r² = −2 ρ."""
    return found(line, count, f.nearest + s / f.speed, _NO) if s * s + f.g >= 0.0 else count


@device
def _cross_piece(line, count, f, start, end, inside):
    """Crossings between `start` and `end`, where f has no inflection. Returns (how many there are now, whether f is
    below zero at `end`)."""
    if not start < end or count >= np.int64(line[layout.MOST]):
        return count, inside
    middle = 0.5 * (start + end)
    concave = 6.0 * middle * middle + f.a < 0.0
    sign = -1.0 if concave else 1.0
    # Above zero it may come down to a root, and up from there to another.
    if inside == concave:
        s = _descend(f, sign, start, end)
        if s == _FAR:
            return count, inside
        count, inside, start = _cross(line, count, f, s), not inside, s
    if sign * _value(f, end) > 0.0:
        s = _descend(f, sign, end, start)
        count, inside = _cross(line, count, f, start if s == _FAR else s), not inside
    return count, inside


@device
def _quartic(x, y, z, nearest, v, speed, tube):
    """The quartic of a line whose point nearest to the middle is (x, y, z), and which rises by `v` a length."""
    rho2 = x * x + z * z
    rho = math.sqrt(rho2)
    g = rho2 + y * y + 1.0 - tube * tube
    # C = (g − 2 ρ) (g + 2 ρ), each told by the distance from the circle on its side.
    c = ((rho - 1.0) * (rho - 1.0) + y * y - tube * tube) * ((rho + 1.0) * (rho + 1.0) + y * y - tube * tube)
    return Quartic(2.0 * g - 4.0 * (1.0 - v * v), 8.0 * y * v, c, g, nearest, speed)


@device
def cross_ring(line, tube):
    """Crossings of (|p|² + 1 − r²)² = 4 (x² + z²), written down; returns how many."""
    x, y, z, u, v, w = line[0], line[1], line[2], line[3], line[4], line[5]
    a = u * u + v * v + w * w
    nearest = -(x * u + y * v + z * w) / a
    x, y, z = x + nearest * u, y + nearest * v, z + nearest * w
    half2 = (1.0 + tube) * (1.0 + tube) - (x * x + y * y + z * z)
    if not half2 >= 0.0:
        return _NO
    speed, half = math.sqrt(a), math.sqrt(half2)
    v /= speed
    start, end = -half, half
    if v != 0.0:
        low, high = (-tube - y) / v, (tube - y) / v
        start, end = max(start, min(low, high)), min(end, max(low, high))
    elif abs(y) > tube:
        return _NO
    f, inside = _quartic(x, y, z, nearest, v, speed, tube), False
    low = (line[layout.LOW] - nearest) * speed
    if low > start:
        start, inside = low, _value(f, low) < 0.0
    if f.a >= 0.0:
        return _cross_piece(line, _NO, f, start, end, inside)[0]
    bend = math.sqrt(-f.a / 6.0)
    count, inside = _cross_piece(line, _NO, f, start, min(end, -bend), inside)
    count, inside = _cross_piece(line, count, f, max(start, -bend), min(end, bend), inside)
    return _cross_piece(line, count, f, max(start, bend), end, inside)[0]


@entry
def meet_ring(own, line_address):
    """Crossings of the torus."""
    return cross_ring(doubles_at(line_address, _WORDS), doubles_at(own, _OWN)[0])


@entry
def describe_ring(own, line_address):
    """u: angle about y from +x, v: angle about the tube from its outer side upward; both 0 to 1."""
    line, tube = doubles_at(line_address, _WORDS), doubles_at(own, _OWN)[0]
    x, y, z = line[layout.PLACE], line[layout.PLACE + 1], line[layout.PLACE + 2]
    rho = math.sqrt(x * x + z * z)
    x, z = (x / rho, z / rho) if rho > 0.0 else (1.0, 0.0)
    out, away = rho - 1.0, math.sqrt((rho - 1.0) * (rho - 1.0) + y * y)
    out, y = (out / away, y / away) if away > 0.0 else (1.0, 0.0)
    ring = 1.0 + tube * out
    line[layout.PLACE], line[layout.PLACE + 1], line[layout.PLACE + 2] = x * ring, tube * y, z * ring
    line[layout.NORMAL], line[layout.NORMAL + 1], line[layout.NORMAL + 2] = x * out, y, z * out
    line[layout.UV], line[layout.UV + 1] = around(x, z), around(out, -y)
    return _NO
