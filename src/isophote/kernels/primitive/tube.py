"""Cylinders about y of radius 1: between y = −1 and y = 1, or endless."""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.base.doubles import doubles_at
from isophote.kernels.base.entry import entry
from isophote.kernels.base.jit import device
from isophote.kernels.primitive import layout
from isophote.kernels.primitive.lanes import BLOCK_DOUBLES, U, V, W, X, Z, keep_first_end, keep_within_lids
from isophote.kernels.primitive.line import around, describe_lid, stretch_ends, within_lids

__all__ = ["describe_pipe", "describe_tube", "meet_pipe", "meet_pipes", "meet_tube", "meet_tubes"]

_WORDS, _NO = np.int64(layout.WORDS), np.int64(0)
_FAR = math.inf
# Lines that lean no more than this, squared, run along the axis.
_ALONG = 1e-32


@device
def _within_side(x, z, u, v, w):
    """(enter, leave) of a line in the endless cylinder, NaN where it passes by. As ball._within, in the plane."""
    a = u * u + w * w
    upright = a <= _ALONG * v * v
    inverse = 1.0 / (1.0 if upright else a)
    nearest = -(x * u + z * w) * inverse
    x, z = x + nearest * u, z + nearest * w
    half = math.sqrt((1.0 - (x * x + z * z)) * inverse)
    half = half * (_FAR if upright else 1.0)
    return nearest - half, nearest + half


@entry
def meet_pipe(own, line_address):
    """Crossings of x² + z² = 1."""
    line = doubles_at(line_address, _WORDS)
    enter, leave = _within_side(line[0], line[2], line[3], line[4], line[5])
    return stretch_ends(line, enter, leave, _NO, _NO)


@entry
def meet_tube(own, line_address):
    """Crossings of the side (part 0) and the lids at y = 1 (part 1) and y = −1 (part 2)."""
    line = doubles_at(line_address, _WORDS)
    enter, leave = _within_side(line[0], line[2], line[3], line[4], line[5])
    if not enter <= leave:
        return _NO
    return within_lids(line, enter, leave)


@entry
def meet_pipes(own, block_address, lanes):
    """The first crossings of sixteen rays with an endless cylinder."""
    block = doubles_at(block_address, BLOCK_DOUBLES)
    for i in range(lanes):
        enter, leave = _within_side(block[X + i], block[Z + i], block[U + i], block[V + i], block[W + i])
        keep_first_end(block, i, enter, leave, 0.0, 0.0)
    return _NO


@entry
def meet_tubes(own, block_address, lanes):
    """The first crossings of sixteen rays with a cylinder and its lids."""
    block = doubles_at(block_address, BLOCK_DOUBLES)
    for i in range(lanes):
        enter, leave = _within_side(block[X + i], block[Z + i], block[U + i], block[V + i], block[W + i])
        keep_within_lids(block, i, enter, leave)
    return _NO


@device
def _describe_side(line, y):
    x, z = line[layout.PLACE], line[layout.PLACE + 2]
    inverse = 1.0 / math.sqrt(x * x + z * z)
    x, z = x * inverse, z * inverse
    line[layout.PLACE], line[layout.PLACE + 1], line[layout.PLACE + 2] = x, y, z
    line[layout.NORMAL], line[layout.NORMAL + 1], line[layout.NORMAL + 2] = x, 0.0, z
    line[layout.UV] = around(x, z)


@entry
def describe_pipe(own, line_address):
    """u: angle from +x, v: height, in circumferences."""
    line = doubles_at(line_address, _WORDS)
    y = line[layout.PLACE + 1]
    _describe_side(line, y)
    line[layout.UV + 1] = y / (2 * math.pi)
    return _NO


@entry
def describe_tube(own, line_address):
    """Of the side, u: angle from +x, v: height, 0 to 1; of a lid as line.describe_lid."""
    line = doubles_at(line_address, _WORDS)
    if line[layout.PART] > 0.0:
        describe_lid(line, 1.0)
        return _NO
    most = max(1.0 - line[layout.SLACK], 0.5)
    y = min(max(line[layout.PLACE + 1], -most), most)
    _describe_side(line, y)
    line[layout.UV + 1] = 0.5 + 0.5 * y
    return _NO
