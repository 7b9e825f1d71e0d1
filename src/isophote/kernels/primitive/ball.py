"""The unit ball: spheres and ellipsoids."""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.base.doubles import doubles_at
from isophote.kernels.base.entry import entry
from isophote.kernels.base.jit import device
from isophote.kernels.primitive import layout
from isophote.kernels.primitive.lanes import BLOCK_DOUBLES, U, V, W, X, Y, Z, keep_first_end
from isophote.kernels.primitive.line import around, stretch_ends

__all__ = ["describe_ball", "meet_ball", "meet_balls"]

_WORDS, _NO = np.int64(layout.WORDS), np.int64(0)


@device
def _within(x, y, z, u, v, w):
    """(enter, leave) of a line in the ball, NaN where it passes by: half a chord before and behind the line's point
    nearest to the middle.

    The chord comes of that point, which does not cancel however far the line began (Haines et al., "Precision
    Improvements for Ray/Sphere Intersection", Ray Tracing Gems 7, 2019).
    """
    inverse = 1.0 / (u * u + v * v + w * w)
    nearest = -(x * u + y * v + z * w) * inverse
    x, y, z = x + nearest * u, y + nearest * v, z + nearest * w
    half = math.sqrt((1.0 - (x * x + y * y + z * z)) * inverse)
    return nearest - half, nearest + half


@entry
def meet_ball(own, line_address):
    """Crossings of |p| = 1."""
    line = doubles_at(line_address, _WORDS)
    enter, leave = _within(line[0], line[1], line[2], line[3], line[4], line[5])
    return stretch_ends(line, enter, leave, _NO, _NO)


@entry
def meet_balls(own, block_address, lanes):
    """The first crossings of sixteen rays."""
    block = doubles_at(block_address, BLOCK_DOUBLES)
    for i in range(lanes):
        enter, leave = _within(block[X + i], block[Y + i], block[Z + i], block[U + i], block[V + i], block[W + i])
        keep_first_end(block, i, enter, leave, 0.0, 0.0)
    return _NO


@entry
def describe_ball(own, line_address):
    """u: longitude from +x, v: latitude from the south pole."""
    line = doubles_at(line_address, _WORDS)
    x, y, z = line[layout.PLACE], line[layout.PLACE + 1], line[layout.PLACE + 2]
    inverse = 1.0 / math.sqrt(x * x + y * y + z * z)
    x, y, z = x * inverse, y * inverse, z * inverse
    for at, value in ((0, x), (1, y), (2, z)):
        line[layout.PLACE + at], line[layout.NORMAL + at] = value, value
    line[layout.UV] = around(x, z)
    line[layout.UV + 1] = 0.5 + math.asin(min(max(y, -1.0), 1.0)) / math.pi
    return _NO
