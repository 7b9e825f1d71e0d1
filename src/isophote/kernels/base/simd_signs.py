"""Signs of eight doubles in one register as bits, and how many bits are set."""

from __future__ import annotations

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from isophote.kernels.base.simd_double import f64x8

__all__ = ["count_bits", "sign_bits"]

_LANES = 8


@intrinsic
def sign_bits(typingctx, x):
    """The lanes of a vector below 0, as bits."""
    if x != f64x8:
        return None

    def codegen(context, builder, sig, args):
        zeros = ir.Constant(ir.VectorType(ir.DoubleType(), _LANES), [0.0] * _LANES)
        below = builder.bitcast(builder.fcmp_ordered("<", args[0], zeros), ir.IntType(_LANES))
        return builder.zext(below, ir.IntType(64))

    return types.int64(x), codegen


@intrinsic
def count_bits(typingctx, x):
    """How many bits of a whole number are set."""
    if x != types.int64:
        return None

    def codegen(context, builder, sig, args):
        return builder.ctpop(args[0])

    return types.int64(x), codegen
