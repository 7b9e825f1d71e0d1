"""Three doubles as one value inside kernels that measure: `Vec3` is single precision."""

from __future__ import annotations

import math
from typing import NamedTuple

from isophote.kernels.base.jit import device

__all__ = ["Double3", "cross3", "difference", "dot3", "norm", "row3", "scaled", "total"]


class Double3(NamedTuple):
    """A vector of three doubles."""

    x: float
    y: float
    z: float


@device
def row3(array, i):
    """Row `i` of an (n, 3) array."""
    return Double3(array[i, 0], array[i, 1], array[i, 2])


@device
def total(a, b):
    """a + b."""
    return Double3(a.x + b.x, a.y + b.y, a.z + b.z)


@device
def difference(a, b):
    """a − b."""
    return Double3(a.x - b.x, a.y - b.y, a.z - b.z)


@device
def scaled(a, s):
    """a · s."""
    return Double3(a.x * s, a.y * s, a.z * s)


@device
def dot3(a, b):
    """Inner product."""
    return a.x * b.x + a.y * b.y + a.z * b.z


@device
def cross3(a, b):
    """a × b."""
    return Double3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x)


@device
def norm(a):
    """Length."""
    return math.sqrt(dot3(a, a))
