"""Quadrics, a x² + b y² + c z² + d xy + e xz + f yz + g x + h y + i z + j ≤ 0, within a box.

Numbers of their own: these ten, the least and the greatest corner of the box (infinite where it is open), a middle that
lines are counted from, and 1 where the box's faces close the solid.
"""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.base.doubles import doubles_at
from isophote.kernels.base.entry import entry
from isophote.kernels.base.jit import device
from isophote.kernels.primitive import layout
from isophote.kernels.primitive.line import around, discriminant, found, roots

__all__ = ["describe_quadric", "meet_quadric"]

_WORDS, _NO, _ONE, _OWN = np.int64(layout.WORDS), np.int64(0), np.int64(1), np.int64(20)
_BOX, _MIDDLE, _CLOSED = np.int64(10), np.int64(16), np.int64(19)
_FAR = math.inf


@device
def _box(line, own):
    """(enter, leave, part entered by, part left by) of the box; parts 1 + those of block.meet_block."""
    enter, leave, first, last = -_FAR, _FAR, _NO, _NO
    for axis in range(3):
        o, d = line[axis], line[3 + axis]
        low, high = own[_BOX + axis], own[_BOX + 3 + axis]
        if d == 0.0:
            if not low <= o <= high:
                return _FAR, -_FAR, _NO, _NO
            continue
        a, b = (low - o) / d, (high - o) / d
        forward = np.int64(d > 0.0)
        near, far = (a, b) if forward else (b, a)
        if near > enter:
            enter, first = near, 2 * axis + 2 - forward
        if far < leave:
            leave, last = far, 2 * axis + 1 + forward
    return enter, leave, first, last


@device
def _value(q, x, y, z):
    return x * (q[0] * x + q[3] * y + q[4] * z + q[6]) + y * (q[1] * y + q[5] * z + q[7]) + z * (q[2] * z + q[8]) + q[9]


@device
def _slopes(q, x, y, z):
    return (
        2.0 * q[0] * x + q[3] * y + q[4] * z + q[6],
        2.0 * q[1] * y + q[3] * x + q[5] * z + q[7],
        2.0 * q[2] * z + q[4] * x + q[5] * y + q[8],
    )


@device
def _along(line, q, nearest):
    """(near, far, a, c): the roots along the line, counted from its point `nearest`, infinite or NaN where there are
    none; the polynomial's first and last coefficient."""
    u, v, w = line[3], line[4], line[5]
    x, y, z = line[0] + nearest * u, line[1] + nearest * v, line[2] + nearest * w
    a = u * (q[0] * u + q[3] * v + q[4] * w) + v * (q[1] * v + q[5] * w) + w * w * q[2]
    gx, gy, gz = _slopes(q, x, y, z)
    b, c = 0.5 * (gx * u + gy * v + gz * w), _value(q, x, y, z)
    d = discriminant(a, b, c)
    if d < 0.0 or (a == 0.0 and b == 0.0):
        return math.nan, math.nan, a, c
    near, far = roots(a, b, c, d)
    return near, far, a, c


@entry
def meet_quadric(own_address, line_address):
    """Crossings of the surface (part 0) within the box and, of a closed solid, of the box's faces (parts 1 to 6) within
    the surface."""
    line, own = doubles_at(line_address, _WORDS), doubles_at(own_address, _OWN)
    enter, leave, first, last = _box(line, own)
    if not enter <= leave:
        return _NO
    u, v, w = line[3], line[4], line[5]
    to_middle = (own[_MIDDLE] - line[0]) * u + (own[_MIDDLE + 1] - line[1]) * v + (own[_MIDDLE + 2] - line[2]) * w
    nearest = min(max(to_middle / (u * u + v * v + w * w), enter), leave)
    near, far, a, c = _along(line, own, nearest)
    near, far = near + nearest, far + nearest
    closed = own[_CLOSED] != 0.0
    count = _NO
    if not near <= far:
        # Nowhere on the surface: all of the line in the box is inside, or none.
        if closed and (a < 0.0 or (a == 0.0 and c < 0.0)):
            count = found(line, count, enter, first)
            count = found(line, count, leave, last)
        return count
    # Where the polynomial opens upward the inside lies between the roots, otherwise beyond them. Of a line, with a = 0,
    # one root is infinite, and the inside lies between the two.
    between = a >= 0.0
    if closed and (near < enter < far) == between and enter != near and enter != far:
        count = found(line, count, enter, first)
    if enter <= near <= leave:
        count = found(line, count, near, _NO)
    if enter <= far <= leave and far != near:
        count = found(line, count, far, _NO)
    if closed and (near < leave < far) == between and leave != near and leave != far:
        count = found(line, count, leave, last)
    return count


@entry
def describe_quadric(own_address, line_address):
    """u: angle about the upright line through the middle, from +x; v: height in the box, 0 to 1, or y where it is
    open."""
    line, own = doubles_at(line_address, _WORDS), doubles_at(own_address, _OWN)
    x, y, z, part = line[layout.PLACE], line[layout.PLACE + 1], line[layout.PLACE + 2], np.int64(line[layout.PART])
    gx, gy, gz = _slopes(own, x, y, z)
    if part > 0:
        axis, side = (part - _ONE) >> 1, (part - _ONE) & 1
        at = own[_BOX + axis + 3 * side]
        x, y, z = at if axis == 0 else x, at if axis == 1 else y, at if axis == 2 else z
        out = 2.0 * side - 1.0
        gx, gy, gz = out * (axis == 0), out * (axis == 1), out * (axis == 2)
    else:
        size2 = gx * gx + gy * gy + gz * gz
        if size2 > 0.0:
            step = _value(own, x, y, z) / size2
            x, y, z = x - step * gx, y - step * gy, z - step * gz
        else:
            # The tip of a cone.
            gy = 1.0
    line[layout.PLACE], line[layout.PLACE + 1], line[layout.PLACE + 2] = x, y, z
    line[layout.NORMAL], line[layout.NORMAL + 1], line[layout.NORMAL + 2] = gx, gy, gz
    low, high = own[_BOX + 1], own[_BOX + 4]
    line[layout.UV] = around(x - own[_MIDDLE], z - own[_MIDDLE + 2])
    line[layout.UV + 1] = (y - low) / (high - low) if high - low < _FAR else y
    return _NO
