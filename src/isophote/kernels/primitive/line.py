"""What the entries of all kinds share: lines, stretches of them within solids, and texture coordinates."""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.base.exact import fused
from isophote.kernels.base.jit import device, exact_device
from isophote.kernels.primitive import layout

__all__ = ["around", "discriminant", "found", "placed", "stretch_ends"]

_NO, _ONE = np.int64(0), np.int64(1)
_TURN, _WHOLE, _NOTHING = 1 / (2 * math.pi), 1.0, 0.0


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
