"""What the entries of all kinds share: lines, stretches of them within solids, and texture coordinates."""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.base.exact import fused
from isophote.kernels.base.jit import device, exact_device
from isophote.kernels.primitive import layout

__all__ = ["around", "describe_lid", "discriminant", "found", "placed", "roots", "stretch_ends", "within_lids"]

_NO, _ONE, _SIDE, _TOP, _BOTTOM = np.int64(0), np.int64(1), np.int64(0), np.int64(1), np.int64(2)
_TURN, _HALF, _WHOLE, _NOTHING = 1 / (2 * math.pi), 0.5, 1.0, 0.0


@device
def placed(m, k, x, y, z, w):
    """A point (w = 1) or vector (w = 0) by affine matrix number `k`."""
    return (
        m[k, 0] * x + m[k, 1] * y + m[k, 2] * z + m[k, 3] * w,
        m[k, 4] * x + m[k, 5] * y + m[k, 6] * z + m[k, 7] * w,
        m[k, 8] * x + m[k, 9] * y + m[k, 10] * z + m[k, 11] * w,
    )


@device
def found(line, count, t, part):
    """Write down crossing number `count` if it counts and is still wanted; returns how many there are now."""
    if t > line[layout.LOW] and t < line[layout.HIGH] and count < np.int64(line[layout.MOST]):
        at = layout.FOUND + 2 * count
        line[at], line[at + 1] = t, np.float64(part)
        return count + _ONE
    return count


@device
def stretch_ends(line, enter, leave, part_in, part_out):
    """Crossings of a convex solid, which a line is in from `enter` to `leave`; none where one is NaN."""
    if not enter <= leave:
        return _NO
    count = found(line, _NO, enter, part_in)
    return found(line, count, leave, part_out)


@exact_device
def discriminant(a, b, c):
    """b² − a c, to within two units in the last place (Kahan, "On the Cost of Floating-Point Computation Without
    Extra-Precise Arithmetic", 2004)."""
    square, product = b * b, a * c
    return (square - product) + (fused(b, b, -square) - fused(a, c, -product))


@device
def around(x, z):
    """How far (x, z) is turned about +y from +x, anticlockwise seen from +y: 0 to 1."""
    turn = math.atan2(-z, x) * _TURN
    return turn if turn >= _NOTHING else turn + _WHOLE


@device
def roots(a, b, c, d):
    """The roots of a t² + 2 b t + c, for d = b² − a c ≥ 0, in order: one does not cancel, the other follows from their
    product (Press et al., "Numerical Recipes", section 5.6). Where a is 0, one is infinite, on the side where the
    polynomial is below zero."""
    root = math.sqrt(d)
    q = root - b if b < _NOTHING else -root - b
    # Adding zero makes −0 zero.
    first, second = q / (a + _NOTHING), c / q
    none = q == _NOTHING
    first, second = (_NOTHING if none else first), (_NOTHING if none else second)
    return (first, second) if first < second else (second, first)


@device
def within_lids(line, enter, leave):
    """Crossings of a convex solid, cut off by lids at y = 1 (part 1) and y = −1 (part 2), which without them the line
    would be in from `enter` to `leave` (part 0)."""
    y, v = line[1], line[4]
    first, last = _SIDE, _SIDE
    if v == _NOTHING:
        return stretch_ends(line, enter, leave, first, last) if abs(y) <= _WHOLE else _NO
    inverse = _WHOLE / v
    low, high = (-_WHOLE - y) * inverse, (_WHOLE - y) * inverse
    upward = v > _NOTHING
    near, far = (low, high) if upward else (high, low)
    if near > enter:
        enter, first = near, _BOTTOM if upward else _TOP
    if far < leave:
        leave, last = far, _TOP if upward else _BOTTOM
    return stretch_ends(line, enter, leave, first, last)


@device
def describe_lid(line, radius):
    """A place on the lid at y = 1 (part 1) or y = −1 (part 2): u along x, v along −z (below: z), 0 to 1 across it."""
    side = _WHOLE if line[layout.PART] == _WHOLE else -_WHOLE
    x, z = line[layout.PLACE], line[layout.PLACE + 2]
    rho, most = math.sqrt(x * x + z * z), max(radius - line[layout.SLACK], _HALF * radius)
    if rho > most:
        x, z = x * most / rho, z * most / rho
    line[layout.PLACE], line[layout.PLACE + 1], line[layout.PLACE + 2] = x, side, z
    line[layout.NORMAL], line[layout.NORMAL + 1], line[layout.NORMAL + 2] = _NOTHING, side, _NOTHING
    across = _HALF / radius if radius > _NOTHING else _NOTHING
    line[layout.UV], line[layout.UV + 1] = _HALF + x * across, _HALF - side * z * across
