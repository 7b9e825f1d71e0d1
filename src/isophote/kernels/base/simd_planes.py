"""Planes in one register of eight doubles, and the products of their numbers that sums of squares are made of.

A plane is (u, v, w, d, x, y, z, 1): a normal, its product with a point, and the point. The products are two registers:

    (u u, u v, u w, v v, v w, w w, u d, v d)   and   (w d, d d, x, y, z, 1, 1, 1)
"""

from __future__ import annotations

from llvmlite import ir
from numba.extending import intrinsic

from isophote.kernels.base.simd_double import f64x8

__all__ = ["later_products", "leading_products"]

_U, _V, _W, _D, _X, _Y, _Z, _ONE = range(8)


def _product(first: list[int], second: list[int]):
    """A function that multiplies the lanes of a plane in one order by those in another."""

    @intrinsic
    def products(typingctx, plane):
        if plane != f64x8:
            return None

        def codegen(context, builder, sig, args):
            (v,) = args
            kind = ir.VectorType(ir.IntType(32), 8)
            a, b = (builder.shuffle_vector(v, v, ir.Constant(kind, order)) for order in (first, second))
            return builder.fmul(a, b, flags=("contract", "nsz"))

        return f64x8(plane), codegen

    return products


leading_products = _product([_U, _U, _U, _V, _V, _W, _U, _V], [_U, _V, _W, _V, _W, _W, _D, _D])
later_products = _product([_W, _D, _X, _Y, _Z, _ONE, _ONE, _ONE], [_D, _D, _ONE, _ONE, _ONE, _ONE, _ONE, _ONE])
