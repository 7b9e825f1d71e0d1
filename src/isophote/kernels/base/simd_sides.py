"""Vectors over the eight children of a tree of seven planes: what holds of planes, for the children at them."""

from __future__ import annotations

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from isophote.kernels.base.simd import f32x8, mask8

__all__ = ["by_fourths", "by_halves", "by_whole", "fused", "lanes_of"]

_I8, _I32 = ir.IntType(8), ir.IntType(32)


@intrinsic
def lanes_of(typingctx, x):
    """The mask of which lane k is bit k of a whole number; higher bits are left out."""
    if not isinstance(x, types.Integer):
        return None

    def codegen(context, builder, signature, args):
        return builder.bitcast(builder.trunc(args[0], _I8), ir.VectorType(ir.IntType(1), 8))

    return mask8(x), codegen


@intrinsic
def fused(typingctx, a, b, c):
    """`a * b + c` lane by lane, rounded once."""
    if not (a == b == c == f32x8):
        return None

    def codegen(context, builder, signature, args):
        vector = args[0].type
        kind = ir.FunctionType(vector, [vector] * 3)
        return builder.call(cgutils.get_or_insert_function(builder.module, kind, "llvm.fma.v8f32"), args)

    return a(a, b, c), codegen


def _spreader(pattern: list[int]):
    @intrinsic
    def spread(typingctx, planes):
        if planes != f32x8:
            return None

        def codegen(context, builder, signature, args):
            return builder.shuffle_vector(args[0], args[0], ir.Constant(ir.VectorType(_I32, 8), pattern))

        return planes(planes), codegen

    return spread


# Seven planes in lanes 0 to 6, in their order from side to side: plane 3 parts children 0 to 3 from 4 to 7; planes 1
# and 5 those halves; planes 0, 2, 4 and 6 what is left. To each child, what holds of that of these planes it lies at.
by_whole = _spreader([3] * 8)
by_halves = _spreader([1, 1, 1, 1, 5, 5, 5, 5])
by_fourths = _spreader([0, 0, 2, 2, 4, 4, 6, 6])
