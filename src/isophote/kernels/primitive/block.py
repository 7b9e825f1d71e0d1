"""Boxes and slabs: |p| ≤ h axis by axis, where h may be infinite."""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.base.doubles import doubles_at
from isophote.kernels.base.entry import entry
from isophote.kernels.base.jit import device
from isophote.kernels.primitive import layout
from isophote.kernels.primitive.lanes import BLOCK_DOUBLES, U, V, W, X, Y, Z, keep_first_end
from isophote.kernels.primitive.line import stretch_ends

__all__ = ["describe_block", "meet_block", "meet_blocks"]

_WORDS, _NO, _OWN = np.int64(layout.WORDS), np.int64(0), np.int64(3)
_FAR = math.inf


@device
def _within(o, d, half):
    """(enter, leave) of a line between the planes ±half; (inf, −inf) where it runs beside them."""
    if d == 0.0:
        return (-_FAR, _FAR) if abs(o) <= half else (_FAR, -_FAR)
    inverse = 1.0 / d
    a, b = (-half - o) * inverse, (half - o) * inverse
    return (a, b) if d > 0.0 else (b, a)


@device
def _planes(o, d, half):
    """As `_within`, without a branch: where the line runs beside the planes, 1 / 0 makes the ends infinite; on a plane,
    it is taken as outside."""
    inverse = 1.0 / d
    a, b = (-half - o) * inverse, (half - o) * inverse
    return (a, b) if inverse > 0.0 else (b, a)


@entry
def meet_block(own, line_address):
    """Where the line enters the last and leaves the first of three slabs. Parts: −x, +x, −y, +y, −z, +z."""
    line, halves = doubles_at(line_address, _WORDS), doubles_at(own, _OWN)
    enter, leave, first, last = -_FAR, _FAR, _NO, _NO
    for axis in range(3):
        d = line[3 + axis]
        near, far = _within(line[axis], d, halves[axis])
        forward = np.int64(d > 0.0)
        if near > enter:
            enter, first = near, 2 * axis + 1 - forward
        if far < leave:
            leave, last = far, 2 * axis + forward
    return stretch_ends(line, enter, leave, first, last)


@entry
def meet_blocks(own, block_address, lanes):
    """The first crossings of sixteen rays."""
    block, halves = doubles_at(block_address, BLOCK_DOUBLES), doubles_at(own, _OWN)
    hx, hy, hz = halves[0], halves[1], halves[2]
    for i in range(lanes):
        u, v, w = block[U + i], block[V + i], block[W + i]
        ax, bx = _planes(block[X + i], u, hx)
        ay, by = _planes(block[Y + i], v, hy)
        az, bz = _planes(block[Z + i], w, hz)
        px, py, pz = 0.5 + math.copysign(0.5, u), 2.5 + math.copysign(0.5, v), 4.5 + math.copysign(0.5, w)
        enter, first = (ax, 1.0 - px) if ax > ay else (ay, 5.0 - py)
        enter, first = (az, 9.0 - pz) if az > enter else (enter, first)
        leave, last = (bx, px) if bx < by else (by, py)
        leave, last = (bz, pz) if bz < leave else (leave, last)
        keep_first_end(block, i, enter, leave, first, last)
    return _NO


@device
def _share(c, half):
    """A coordinate as 0 to 1 between the faces, or as it is where there are none."""
    return c if half == _FAR else 0.5 + 0.5 * c / half


@entry
def describe_block(own, line_address):
    """Each face has u to the right and v upward for who looks at it from outside, +y (of the top: −z) being up."""
    line, halves = doubles_at(line_address, _WORDS), doubles_at(own, _OWN)
    part = np.int64(line[layout.PART])
    axis, side = part >> 1, 1.0 if part & 1 else -1.0
    for other in range(3):
        most = max(halves[other] - line[layout.SLACK], 0.5 * halves[other])
        at = layout.PLACE + other
        line[at] = side * halves[other] if other == axis else min(max(line[at], -most), most)
        line[layout.NORMAL + other] = side if other == axis else 0.0
    x, y, z = line[layout.PLACE], line[layout.PLACE + 1], line[layout.PLACE + 2]
    if axis == 0:
        u, v = _share(-side * z, halves[2]), _share(y, halves[1])
    elif axis == 1:
        u, v = _share(x, halves[0]), _share(-side * z, halves[2])
    else:
        u, v = _share(side * x, halves[0]), _share(y, halves[1])
    line[layout.UV], line[layout.UV + 1] = u, v
    return _NO
