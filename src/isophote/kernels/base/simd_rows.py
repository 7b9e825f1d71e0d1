"""Sixteen numbers at once between arrays of triples, rows of floats, of doubles and of whole numbers."""

from __future__ import annotations

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from isophote.kernels.base.simd import f32x16, mask16
from isophote.kernels.base.simd_double16 import f64x16
from isophote.kernels.base.table import ViewType

__all__ = ["load_narrowed", "load_triples", "store_flags", "store_whole", "store_widened"]

_LANES = 16
_FLOATS, _DOUBLES = ir.VectorType(ir.FloatType(), _LANES), ir.VectorType(ir.DoubleType(), _LANES)
_INTS = ir.VectorType(ir.IntType(32), _LANES)


def _is_view(view, dtype: types.Type) -> bool:
    return isinstance(view, ViewType) and view.dtype == dtype


def _address(context, builder, view_type, view, index, element: ir.Type):
    data = cgutils.create_struct_proxy(view_type)(context, builder, view).data
    return builder.bitcast(builder.gep(data, [index]), element.as_pointer())


@intrinsic
def load_triples(typingctx, view, row):
    """Rows `row` to `row` + 15 of a view of three columns, as one vector for each column."""
    if not _is_view(view, types.float32):
        return None
    result = types.UniTuple(f32x16, 3)

    def codegen(context, builder, signature, args):
        many = ir.VectorType(ir.FloatType(), 3 * _LANES)
        first = builder.mul(args[1], args[1].type(3))
        loaded = builder.load(_address(context, builder, signature.args[0], args[0], first, many))
        loaded.align = 4
        nothing = ir.Constant(many, ir.Undefined)
        columns = [list(range(column, 3 * _LANES, 3)) for column in range(3)]
        kind = ir.VectorType(ir.IntType(32), _LANES)
        values = [builder.shuffle_vector(loaded, nothing, ir.Constant(kind, places)) for places in columns]
        return context.make_tuple(builder, result, values)

    return result(view, types.intp), codegen


@intrinsic
def store_widened(typingctx, view, index, value):
    """Write a vector as sixteen doubles, from element `index` on."""
    if not _is_view(view, types.float64) or value != f32x16:
        return None

    def codegen(context, builder, signature, args):
        pointer = _address(context, builder, signature.args[0], args[0], args[1], _DOUBLES)
        builder.store(builder.fpext(args[2], _DOUBLES), pointer).align = 8
        return context.get_dummy_value()

    return types.void(view, types.intp, value), codegen


@intrinsic
def load_narrowed(typingctx, view, index):
    """Sixteen doubles, from element `index` on, each rounded to the nearest float."""
    if not _is_view(view, types.float64):
        return None

    def codegen(context, builder, signature, args):
        loaded = builder.load(_address(context, builder, signature.args[0], args[0], args[1], _DOUBLES))
        loaded.align = 8
        return builder.fptrunc(loaded, _FLOATS)

    return f32x16(view, types.intp), codegen


@intrinsic
def store_whole(typingctx, view, index, value):
    """Write sixteen doubles that are whole numbers as int32, from element `index` on."""
    if not _is_view(view, types.int32) or value != f64x16:
        return None

    def codegen(context, builder, signature, args):
        pointer = _address(context, builder, signature.args[0], args[0], args[1], _INTS)
        builder.store(builder.fptosi(args[2], _INTS), pointer).align = 4
        return context.get_dummy_value()

    return types.void(view, types.intp, value), codegen


@intrinsic
def store_flags(typingctx, view, index, mask):
    """Write a mask as sixteen bytes, 0 or 1, from element `index` on."""
    if not _is_view(view, types.uint8) or mask != mask16:
        return None

    def codegen(context, builder, signature, args):
        kind = ir.VectorType(ir.IntType(8), _LANES)
        pointer = _address(context, builder, signature.args[0], args[0], args[1], kind)
        builder.store(builder.zext(args[2], kind), pointer).align = 1
        return context.get_dummy_value()

    return types.void(view, types.intp, mask), codegen
