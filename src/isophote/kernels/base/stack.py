"""Scratch on the stack: memory that costs nothing to get, and goes when the function returns."""

from __future__ import annotations

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from isophote.kernels.base.table import FLOATS

__all__ = ["stack_floats"]

_I64 = ir.IntType(64)
# Vectors that lie across two cache lines take twice as long.
_LINE = 64


@intrinsic
def stack_floats(typingctx, count):
    """`count` floats that begin at a cache line, of any values. For entries, which have a frame of their own: called in
    a loop, or in what is compiled into one, it would take more each time."""

    def codegen(context, builder, signature, args):
        view = cgutils.create_struct_proxy(FLOATS)(context, builder)
        data = builder.alloca(ir.FloatType(), size=args[0])
        data.align = _LINE
        view.data, view.rows, view.columns = data, args[0], _I64(1)
        return view._getvalue()

    return FLOATS(types.int64), codegen
