"""Whole numbers of 64 bits: their bits, and places for them among words of 32 bits."""

from __future__ import annotations

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from isophote.kernels.base.table import ViewType

__all__ = ["highest_bit", "load_long", "lowest_bit", "store_long"]

_I1, _I64 = ir.IntType(1), ir.IntType(64)


@intrinsic
def lowest_bit(typingctx, x):
    """Number of the lowest set bit of a non-zero int64."""

    def codegen(context, builder, signature, args):
        return builder.cttz(args[0], _I1(1))

    return types.int64(types.int64), codegen


@intrinsic
def highest_bit(typingctx, x):
    """Number of the highest set bit of a non-zero int64."""

    def codegen(context, builder, signature, args):
        return builder.sub(_I64(63), builder.ctlz(args[0], _I1(1)))

    return types.int64(types.int64), codegen


def _place(context, builder, view_type, view, index):
    data = cgutils.create_struct_proxy(view_type)(context, builder, view).data
    return builder.bitcast(builder.gep(data, [index]), _I64.as_pointer())


def _is_words(view) -> bool:
    return isinstance(view, ViewType) and view.dtype in (types.float32, types.int32, types.uint32)


@intrinsic
def load_long(typingctx, view, index):
    """The int64 in words `index` and `index` + 1 of a view of 32-bit words."""
    if not _is_words(view):
        return None

    def codegen(context, builder, signature, args):
        loaded = builder.load(_place(context, builder, signature.args[0], *args))
        loaded.align = 4
        return loaded

    return types.int64(view, types.intp), codegen


@intrinsic
def store_long(typingctx, view, index, stored):
    """Keep an int64 in words `index` and `index` + 1 of a view of 32-bit words."""
    if not _is_words(view):
        return None

    def codegen(context, builder, signature, args):
        builder.store(args[2], _place(context, builder, signature.args[0], args[0], args[1])).align = 4
        return context.get_dummy_value()

    return types.void(view, types.intp, types.int64), codegen
