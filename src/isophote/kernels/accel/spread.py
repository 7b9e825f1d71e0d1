"""How far from a ray things count as on it, so that nothing is left out that the test of a triangle would meet.

The test in forms/triangle.py decides exactly about a triangle whose corners have moved by a few units in the last place
of the largest coordinate about. docs/design/accelerators.md tells what follows.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from isophote.kernels.base.jit import device
from isophote.kernels.base.vec import vec3

__all__ = ["LARGEST", "LEAST_SHARE", "PLACE_SLACK", "TINY", "Spread", "box_interval", "spread_of"]

_ZERO, _ONE = np.float32(0), np.float32(1)
# Sixteen roundings of the largest coordinate: the test's, and those of distances to planes.
PLACE_SLACK = np.float32(2.0**-20)
# Least component of a direction, in parts of the largest: a ray that is turned by less stays within its slack as far as
# things are about. And the least of all, for its reciprocal.
LEAST_SHARE, TINY = np.float32(2.0**-24), np.float32(1e-18)
# Distances and slacks are not infinite: infinity less infinity would be NaN.
LARGEST = np.float32(1e37)


class Spread(NamedTuple):
    """A ray made ready for planes: its origin, 1/d, and by how much distances to planes are uncertain, on each axis."""

    origin: object
    inverse: object
    slack: object


@device
def _inverse(d, smallest):
    return _ONE / (d if abs(d) > smallest else (smallest if d >= _ZERO else -smallest))


@device
def spread_of(origin, direction, reach):
    """The ray's `Spread` among things whose coordinates do not exceed `reach`."""
    most = max(reach, max(abs(origin.x), max(abs(origin.y), abs(origin.z))))
    place = min(most * PLACE_SLACK, LARGEST)
    smallest = max(max(abs(direction.x), max(abs(direction.y), abs(direction.z))) * LEAST_SHARE, TINY)
    x, y, z = _inverse(direction.x, smallest), _inverse(direction.y, smallest), _inverse(direction.z, smallest)
    slack = vec3(min(place * abs(x), LARGEST), min(place * abs(y), LARGEST), min(place * abs(z), LARGEST))
    return Spread(origin, vec3(x, y, z), slack)


@device
def _axis_interval(low, high, origin, inverse, slack):
    a, b = (low - origin) * inverse, (high - origin) * inverse
    return min(a, b) - slack, max(a, b) + slack


@device
def box_interval(spread, bounds, limit):
    """The interval (enter, leave) of 0 ≤ t ≤ `limit` in which the ray may be in a box, empty where enter > leave;
    `bounds` are its lower x, y, z and upper x, y, z."""
    o, i, s = spread.origin, spread.inverse, spread.slack
    x0, x1 = _axis_interval(bounds[0], bounds[3], o.x, i.x, s.x)
    y0, y1 = _axis_interval(bounds[1], bounds[4], o.y, i.y, s.y)
    z0, z1 = _axis_interval(bounds[2], bounds[5], o.z, i.z, s.z)
    return max(max(x0, y0), max(z0, _ZERO)), min(min(x1, y1), min(z1, limit))
