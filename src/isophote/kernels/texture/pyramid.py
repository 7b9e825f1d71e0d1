"""Pyramids of means: each level has half the width and half the height of the one before, rounded down, but at least 1.

A texel of a level is the mean of the part of the picture that it covers: of two texels along an even width, and of two
and parts of a third along an odd one (Guthe, Heckbert: "Non-Power-of-Two Mipmapping", 2005). So every level has the
picture's mean.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import device, kernel

__all__ = ["encode", "halve_bytes", "halve_floats"]

_ZERO, _ONE, _HALF = np.float32(0), np.float32(1), np.float32(0.5)


@device
def _taps(size, i):
    """(first, weights of it and of the two after it) of what number `i` of the half of `size` texels covers."""
    if size == 1:
        return 0, (_ONE, _ZERO, _ZERO)
    n = size // 2
    if size % 2 == 0:
        return 2 * i, (_HALF, _HALF, _ZERO)
    inverse = _ONE / np.float32(size)
    return 2 * i, (np.float32(n - i) * inverse, np.float32(n) * inverse, np.float32(i + 1) * inverse)


@device
def _tap_count(size):
    return 1 if size == 1 else 2 + size % 2


@kernel
def halve_floats(texels, width, height, half):
    """The next level of (width · height, 4) texels into `half`."""
    across, down = max(width // 2, 1), max(height // 2, 1)
    for y in range(down):
        row, rows = _taps(height, y)
        for x in range(across):
            column, columns = _taps(width, x)
            for k in range(4):
                total = 0.0
                for j in range(_tap_count(height)):
                    for i in range(_tap_count(width)):
                        total += rows[j] * columns[i] * texels[(row + j) * width + column + i, k]
                half[y * across + x, k] = total


@kernel
def halve_bytes(texels, width, height, decode, encoding, half):
    """As halve_floats, of bytes: linear means of what they stand for by row `encoding` of `decode`; alpha by row 1."""
    across, down = max(width // 2, 1), max(height // 2, 1)
    for y in range(down):
        row, rows = _taps(height, y)
        for x in range(across):
            column, columns = _taps(width, x)
            for k in range(4):
                total = 0.0
                kind = encoding if k < 3 else 1
                for j in range(_tap_count(height)):
                    for i in range(_tap_count(width)):
                        total += rows[j] * columns[i] * decode[kind, texels[(row + j) * width + column + i, k]]
                half[y * across + x, k] = total


@kernel
def encode(texels, limits, starts, encoding, found):
    """The bytes that stand for what comes next to the texels' values. `limits` (2, 255): where the next byte is as
    near, by rows of `decode`; `starts` (2, n + 1): the least byte for values from i / n on."""
    steps = np.float32(starts.shape[1] - 1)
    for at in range(len(texels)):
        for k in range(4):
            kind, value = encoding if k < 3 else 1, texels[at, k]
            byte = starts[kind, np.int64(min(max(value, _ZERO), _ONE) * steps)]
            while byte < 255 and value > limits[kind, byte]:
                byte += 1
            found[at, k] = byte
