"""Polygons in the plane y = 0, in coordinates (x, −z): convex ones as half-planes, others by edges.

Numbers of their own: how many half-planes a x + b y ≤ c follow, each with (a, b) a unit vector; or how many edges, each
from one corner to the next around any ring.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.doubles import doubles_at
from isophote.kernels.base.entry import entry
from isophote.kernels.base.jit import device
from isophote.kernels.primitive import layout
from isophote.kernels.primitive.line import found

__all__ = ["describe_polygon", "meet_convex", "meet_polygon"]

_WORDS, _NO, _ONE = np.int64(layout.WORDS), np.int64(0), np.int64(1)
_HALF_PLANE, _EDGE = np.int64(3), np.int64(4)


@device
def _crossing(line):
    """(t, x, y) of the crossing with the plane; NaN or infinite for lines along it."""
    t = -line[1] / line[4]
    return t, line[0] + t * line[3], -(line[2] + t * line[5])


@entry
def meet_convex(own_address, line_address):
    """The crossing of the plane, where it is in every half-plane."""
    line = doubles_at(line_address, _WORDS)
    t, x, y = _crossing(line)
    if not (t > line[layout.LOW] and t < line[layout.HIGH]):
        return _NO
    count = np.int64(doubles_at(own_address, _ONE)[0])
    own = doubles_at(own_address, _ONE + _HALF_PLANE * count)
    for k in range(count):
        at = _ONE + _HALF_PLANE * k
        if not own[at] * x + own[at + 1] * y <= own[at + 2]:
            return _NO
    return found(line, _NO, t, _NO)


@device
def _is_crossed(ax, ay, bx, by, x, y):
    """Whether a ray from (x, y) along +x crosses an edge, the lower end of which counts."""
    if (ay > y) == (by > y):
        return False
    return (x < ax + (y - ay) / (by - ay) * (bx - ax)) if by > ay else (x < bx + (y - by) / (ay - by) * (ax - bx))


@entry
def meet_polygon(own_address, line_address):
    """The crossing of the plane, where a ray in the plane crosses an odd number of edges."""
    line = doubles_at(line_address, _WORDS)
    t, x, y = _crossing(line)
    if not (t > line[layout.LOW] and t < line[layout.HIGH]):
        return _NO
    count = np.int64(doubles_at(own_address, _ONE)[0])
    own = doubles_at(own_address, _ONE + _EDGE * count)
    inside = False
    for k in range(count):
        at = _ONE + _EDGE * k
        if _is_crossed(own[at], own[at + 1], own[at + 2], own[at + 3], x, y):
            inside = not inside
    return found(line, _NO, t, _NO) if inside else _NO


@entry
def describe_polygon(own_address, line_address):
    """u along x, v along −z, in the polygon's own units."""
    line = doubles_at(line_address, _WORDS)
    line[layout.PLACE + 1] = 0.0
    line[layout.NORMAL], line[layout.NORMAL + 1], line[layout.NORMAL + 2] = 0.0, 1.0, 0.0
    line[layout.UV], line[layout.UV + 1] = line[layout.PLACE], -line[layout.PLACE + 2]
    return _NO
