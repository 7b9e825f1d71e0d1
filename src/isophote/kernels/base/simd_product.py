"""Differences of products of vectors, with hardly any rounding."""

from __future__ import annotations

from llvmlite import ir
from numba.core import cgutils
from numba.extending import intrinsic

from isophote.kernels.base.simd import VectorType

__all__ = ["product_difference"]


@intrinsic
def product_difference(typingctx, a, b, c, d):
    """`a * b - c * d` lane by lane, off by 1.5 units in the last place at most, so never of the wrong sign, and zero
    only where it is exactly zero (products that underflow apart).

    Kahan's algorithm: the rounding of c · d is found by a fused multiplication and taken away again. Jeannerod, Louvet,
    Muller: "Further analysis of Kahan's algorithm for the accurate computation of 2 × 2 determinants", Mathematics of
    Computation 82, 2013.
    """
    if not all(isinstance(v, VectorType) for v in (a, b, c, d)):
        return None

    def codegen(context, builder, signature, args):
        p, q, r, s = args
        vector = p.type
        kind = ir.FunctionType(vector, [vector] * 3)
        fused = cgutils.get_or_insert_function(builder.module, kind, f"llvm.fma.v{vector.count}f32")
        # Numba gives its own flags, contraction among them, to operations that have none.
        flags = ("nsz",)
        zero = ir.Constant(vector, [0.0] * vector.count)
        product = builder.fmul(r, s, flags=flags)
        negative = builder.fsub(zero, product, flags=flags)
        rounding = builder.call(fused, [r, s, negative])
        difference = builder.call(fused, [p, q, negative])
        return builder.fsub(difference, rounding, flags=flags)

    return a(a, b, c, d), codegen
