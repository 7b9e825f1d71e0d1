"""Morton's code of cells: bits of x, y and z in turns, x the lowest; cells of a cube of 2ⁿ cells lie side by side."""

from __future__ import annotations

import numpy as np
from numba import types
from numba.extending import intrinsic

from isophote.kernels.base.jit import device

__all__ = ["bit_count", "morton", "unpacked"]

_SPREAD = (np.int64(0x030000FF), np.int64(0x0300F00F), np.int64(0x030C30C3), np.int64(0x09249249))


@device
def _spread(a):
    """The low ten bits of a, two places apart."""
    a = (a | a << 16) & _SPREAD[0]
    a = (a | a << 8) & _SPREAD[1]
    a = (a | a << 4) & _SPREAD[2]
    return (a | a << 2) & _SPREAD[3]


@device
def unpacked(code):
    """Every third bit of a code, from the lowest on: x; of code >> 1: y; of code >> 2: z."""
    a = np.int64(code) & _SPREAD[3]
    a = (a | a >> 2) & _SPREAD[2]
    a = (a | a >> 4) & _SPREAD[1]
    a = (a | a >> 8) & _SPREAD[0]
    return (a | a >> 16) & np.int64(1023)


@device
def morton(x, y, z):
    """The code of a cell; coordinates below 1024."""
    return _spread(np.int64(x)) | _spread(np.int64(y)) << 1 | _spread(np.int64(z)) << 2


@intrinsic
def bit_count(typingctx, x):
    """How many bits of an int64 are set."""

    def codegen(context, builder, signature, args):
        return builder.ctpop(args[0])

    return types.int64(types.int64), codegen
