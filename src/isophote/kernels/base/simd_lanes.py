"""Vectors of sixteen floats, lane by lane: numbers of the lanes, and each lane's neighbour."""

from __future__ import annotations

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from isophote.kernels.base.simd import f32x16

__all__ = ["count_bits", "following_lanes", "lane_numbers"]

_LANES = 16


@intrinsic
def count_bits(typingctx, x):
    """How many bits of an int32 are set, as those of a mask (simd.bits)."""

    def codegen(context, builder, signature, args):
        return builder.zext(builder.ctpop(args[0]), ir.IntType(64))

    return types.int64(types.int32), codegen


@intrinsic
def lane_numbers(typingctx):
    """(0, 1, …, 15)."""

    def codegen(context, builder, signature, args):
        return ir.Constant(ir.VectorType(ir.FloatType(), _LANES), [float(k) for k in range(_LANES)])

    return f32x16(), codegen


@intrinsic
def following_lanes(typingctx, v, following):
    """Lane k + 1 of `v` in lane k, and the first lane of `following` in the last."""
    if v != f32x16 or following != f32x16:
        return None

    def codegen(context, builder, signature, args):
        pattern = ir.Constant(ir.VectorType(ir.IntType(32), _LANES), list(range(1, _LANES + 1)))
        return builder.shuffle_vector(*args, pattern)

    return v(v, following), codegen
