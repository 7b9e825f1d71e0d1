"""Sets of up to 64 things as the bits of an int64."""

from __future__ import annotations

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from isophote.kernels.base.jit import device

__all__ = ["count_of", "first_of", "leading"]

_ALL, _ONE, _WHOLE = np.int64(-1), np.int64(1), np.int64(64)


@intrinsic
def first_of(typingctx, members):
    """The lowest number in a set that is not empty."""
    if members != types.int64:
        return None

    def codegen(context, builder, signature, args):
        return builder.cttz(args[0], ir.IntType(1)(1))

    return types.int64(members), codegen


@intrinsic
def count_of(typingctx, members):
    """How many a set holds."""
    if members != types.int64:
        return None

    def codegen(context, builder, signature, args):
        return builder.ctpop(args[0])

    return types.int64(members), codegen


@device
def leading(count):
    """The numbers below `count`, which is 0 to 64."""
    return (_ONE << np.int64(count)) - _ONE if count < _WHOLE else _ALL
