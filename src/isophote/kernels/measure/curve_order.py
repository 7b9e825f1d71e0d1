"""An order in which to insert points of space: by rounds that grow, each along a Hilbert curve.

Rounds are drawn at random, so that no order of the input is slow, and neighbours along the curve are near each other,
so that each point is found from the one before (Amenta, Choi, Rote, "Incremental Constructions con BRIO", 2003).
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import exact_device, exact_kernel

__all__ = ["insertion_keys"]

_BITS = 19
_CELLS = 2.0**_BITS - 1
_ROUNDS = np.uint64(31)
_ROUND_SHIFT = np.uint64(3 * _BITS)
_ONE = np.uint64(1)


@exact_device
def _hilbert(cells):
    """The place of a cell, three uint64, along the curve (Skilling, "Programming the Hilbert curve", 2004)."""
    bit = _ONE << np.uint64(_BITS - 1)
    while bit > _ONE:
        low = bit - _ONE
        for i in range(3):
            if cells[i] & bit:
                cells[0] ^= low
            else:
                change = (cells[0] ^ cells[i]) & low
                cells[0] ^= change
                cells[i] ^= change
        bit >>= _ONE
    cells[1] ^= cells[0]
    cells[2] ^= cells[1]
    change = np.uint64(0)
    bit = _ONE << np.uint64(_BITS - 1)
    while bit > _ONE:
        if cells[2] & bit:
            change ^= bit - _ONE
        bit >>= _ONE
    place = np.uint64(0)
    for k in range(_BITS - 1, -1, -1):
        for i in range(3):
            place = (place << _ONE) | (((cells[i] ^ change) >> np.uint64(k)) & _ONE)
    return place


@exact_device
def _mixed(i):
    """Bits that look random, of a number (the finaliser of SplitMix64)."""
    x = np.uint64(i) + np.uint64(0x9E3779B97F4A7C15)
    x = (x ^ (x >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    x = (x ^ (x >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return x ^ (x >> np.uint64(31))


@exact_kernel
def insertion_keys(points, least, extent, keys):
    """Keys, (n,) uint64, by which points (n, 3) are to be sorted; `extent` is that of the longest axis.

    Each round holds seven times the points of all before it. Coordinates, least and extent are halved first, so that
    no difference overflows.
    """
    cells = np.empty(3, np.uint64)
    for i in range(len(points)):
        for k in range(3):
            part = (0.5 * points[i, k] - least[k]) / extent if extent > 0 else 0.0
            cells[k] = np.uint64(part * _CELLS)
        bits = _mixed(i)
        late = _ROUNDS
        while late > 0 and bits & np.uint64(7) == 0:
            bits >>= np.uint64(3)
            late -= _ONE
        keys[i] = (late << _ROUND_SHIFT) | _hilbert(cells)
