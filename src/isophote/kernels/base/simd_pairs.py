"""Two vectors of four floats as one of eight."""

from __future__ import annotations

from llvmlite import ir
from numba.extending import intrinsic

from isophote.kernels.base.simd import f32x4, f32x8

__all__ = ["joined"]


@intrinsic
def joined(typingctx, a, b):
    """The lanes of `a`, then those of `b`."""
    if a != f32x4 or b != f32x4:
        return None

    def codegen(context, builder, signature, args):
        return builder.shuffle_vector(*args, ir.Constant(ir.VectorType(ir.IntType(32), 8), list(range(8))))

    return f32x8(a, b), codegen
