"""The unit ball: spheres and ellipsoids."""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.base.doubles import doubles_at
from isophote.kernels.base.entry import entry
from isophote.kernels.primitive import layout
from isophote.kernels.primitive.line import around, stretch_ends

__all__ = ["describe_ball", "meet_ball"]

_WORDS, _NO = np.int64(layout.WORDS), np.int64(0)


@entry
def meet_ball(own, line_address):
    """Crossings of |p| = 1, half a chord before and behind the line's point nearest to the middle.

    The chord comes of that point, which does not cancel however far the line began (Haines et al., "Precision
    Improvements for Ray/Sphere Intersection", Ray Tracing Gems 7, 2019).
    """
    line = doubles_at(line_address, _WORDS)
    x, y, z, u, v, w = line[0], line[1], line[2], line[3], line[4], line[5]
    a = u * u + v * v + w * w
    nearest = -(x * u + y * v + z * w) / a
    x, y, z = x + nearest * u, y + nearest * v, z + nearest * w
    height2 = 1.0 - (x * x + y * y + z * z)
    if not height2 >= 0.0:
        return _NO
    half = math.sqrt(height2 / a)
    return stretch_ends(line, nearest - half, nearest + half, _NO, _NO)


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
