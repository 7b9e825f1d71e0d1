"""The plane y = 0 as a half space below it, and the unit disk in it."""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.base.doubles import doubles_at
from isophote.kernels.base.entry import entry
from isophote.kernels.base.jit import device
from isophote.kernels.primitive import layout
from isophote.kernels.primitive.lanes import BLOCK_DOUBLES, U, V, W, X, Y, Z, keep_crossing
from isophote.kernels.primitive.line import found

__all__ = ["describe_disk", "describe_plane", "meet_disk", "meet_disks", "meet_plane", "meet_planes"]

_WORDS, _NO = np.int64(layout.WORDS), np.int64(0)


@device
def _crossing(line):
    """t in the plane; NaN or infinite for lines along it."""
    return -line[1] / line[4]


@entry
def meet_plane(own, line_address):
    """The crossing of y = 0."""
    line = doubles_at(line_address, _WORDS)
    return found(line, _NO, _crossing(line), _NO)


@entry
def meet_disk(own, line_address):
    """The crossing of y = 0 where x² + z² ≤ 1."""
    line = doubles_at(line_address, _WORDS)
    t = _crossing(line)
    x, z = line[0] + t * line[3], line[2] + t * line[5]
    return found(line, _NO, t, _NO) if x * x + z * z <= 1.0 else _NO


@entry
def meet_planes(own, block_address, lanes):
    """The first crossings of sixteen rays with the plane."""
    block = doubles_at(block_address, BLOCK_DOUBLES)
    for i in range(lanes):
        keep_crossing(block, i, -block[Y + i] / block[V + i], True)
    return _NO


@entry
def meet_disks(own, block_address, lanes):
    """The first crossings of sixteen rays with the disk."""
    block = doubles_at(block_address, BLOCK_DOUBLES)
    for i in range(lanes):
        t = -block[Y + i] / block[V + i]
        x, z = block[X + i] + t * block[U + i], block[Z + i] + t * block[W + i]
        keep_crossing(block, i, t, x * x + z * z <= 1.0)
    return _NO


@device
def _upward(line):
    line[layout.PLACE + 1] = 0.0
    line[layout.NORMAL], line[layout.NORMAL + 1], line[layout.NORMAL + 2] = 0.0, 1.0, 0.0


@entry
def describe_plane(own, line_address):
    """u: x, v: −z, in the plane's own units."""
    line = doubles_at(line_address, _WORDS)
    _upward(line)
    line[layout.UV], line[layout.UV + 1] = line[layout.PLACE], -line[layout.PLACE + 2]
    return _NO


@entry
def describe_disk(own, line_address):
    """u along x, v along −z, 0 to 1 across the disk."""
    line = doubles_at(line_address, _WORDS)
    _upward(line)
    x, z = line[layout.PLACE], line[layout.PLACE + 2]
    from_middle = math.sqrt(x * x + z * z)
    most = max(1.0 - line[layout.SLACK], 0.5)
    if from_middle > most:
        x, z = x * most / from_middle, z * most / from_middle
        line[layout.PLACE], line[layout.PLACE + 2] = x, z
    line[layout.UV], line[layout.UV + 1] = 0.5 + 0.5 * x, 0.5 - 0.5 * z
    return _NO
