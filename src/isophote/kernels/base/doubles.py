"""Doubles at an address, as a view: how entries get and give numbers in double precision."""

from __future__ import annotations

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from isophote.kernels.base.table import ViewType

__all__ = ["DOUBLES", "doubles_at"]

DOUBLES = ViewType(types.float64, 1)

_I64 = ir.IntType(64)


@intrinsic
def doubles_at(typingctx, address, count):
    """`count` doubles at an address."""

    def codegen(context, builder, signature, args):
        view = cgutils.create_struct_proxy(DOUBLES)(context, builder)
        view.data = builder.inttoptr(args[0], ir.DoubleType().as_pointer())
        view.rows, view.columns = args[1], _I64(1)
        return view._getvalue()

    return DOUBLES(types.int64, types.int64), codegen
