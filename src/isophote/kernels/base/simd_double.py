"""`f64x8`: eight doubles in one register, for kernels that measure; see simd.py for single precision.

It is loaded, stored or splatted, and has `+ - * /`; products and sums may be contracted to one rounding.
"""

from __future__ import annotations

import operator

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import intrinsic, lower_builtin, models, register_model

from isophote.kernels.base.table import ViewType

__all__ = [
    "absolute_doubles",
    "any_negative",
    "double_lane",
    "load_doubles",
    "root_doubles",
    "splat_doubles",
    "store_doubles",
    "where_negative",
]

_LANES = 8
_VECTOR = ir.VectorType(ir.DoubleType(), _LANES)
_CONTRACT = ("contract", "nsz")


class DoublesType(types.Type):
    """Numba type of eight doubles in one register."""

    def __init__(self) -> None:
        super().__init__(name="f64x8")


f64x8 = DoublesType()


@register_model(DoublesType)
class _DoublesModel(models.PrimitiveModel):
    def __init__(self, dmm, fe_type):
        super().__init__(dmm, fe_type, _VECTOR)


def _is_doubles(array) -> bool:
    if isinstance(array, types.Array):
        return array.layout == "C" and array.dtype == types.float64
    return isinstance(array, ViewType) and array.dtype == types.float64


def _address(context, builder, array_type, array, index):
    data = cgutils.create_struct_proxy(array_type)(context, builder, array).data
    return builder.bitcast(builder.gep(data, [index]), _VECTOR.as_pointer())


@intrinsic
def load_doubles(typingctx, array, index):
    """Eight doubles of a contiguous array or a view, from element `index` on, counted through all rows."""
    if not _is_doubles(array):
        return None

    def codegen(context, builder, sig, args):
        loaded = builder.load(_address(context, builder, sig.args[0], *args))
        loaded.align = 8
        return loaded

    return f64x8(array, types.intp), codegen


@intrinsic
def store_doubles(typingctx, array, index, value):
    """Write eight doubles to a contiguous array, from `index` on."""
    if not _is_doubles(array) or value != f64x8:
        return None

    def codegen(context, builder, sig, args):
        builder.store(args[2], _address(context, builder, sig.args[0], args[0], args[1])).align = 8
        return context.get_dummy_value()

    return types.void(array, types.intp, value), codegen


@intrinsic
def splat_doubles(typingctx, x):
    """A double in all lanes."""

    def codegen(context, builder, sig, args):
        undefined = ir.Constant(_VECTOR, ir.Undefined)
        one = builder.insert_element(undefined, args[0], ir.IntType(32)(0))
        zeros = ir.Constant(ir.VectorType(ir.IntType(32), _LANES), [0] * _LANES)
        return builder.shuffle_vector(one, undefined, zeros)

    return f64x8(types.float64), codegen


def _unary(name: str):
    @intrinsic
    def apply(typingctx, a):
        if a != f64x8:
            return None

        def codegen(context, builder, sig, args):
            kind = ir.FunctionType(_VECTOR, [_VECTOR])
            return builder.call(cgutils.get_or_insert_function(builder.module, kind, f"llvm.{name}.v8f64"), args)

        return a(a), codegen

    return apply


root_doubles, absolute_doubles = _unary("sqrt"), _unary("fabs")


def _negative(builder, x):
    return builder.fcmp_ordered("<", x, ir.Constant(_VECTOR, [0.0] * _LANES))


@intrinsic
def where_negative(typingctx, x, a, b):
    """Lane by lane, `a` where x < 0, else `b`."""
    if not x == a == b == f64x8:
        return None

    def codegen(context, builder, sig, args):
        return builder.select(_negative(builder, args[0]), args[1], args[2])

    return f64x8(x, a, b), codegen


@intrinsic
def any_negative(typingctx, x):
    """Whether any lane is below 0."""
    if x != f64x8:
        return None

    def codegen(context, builder, sig, args):
        byte = ir.IntType(_LANES)
        return builder.icmp_unsigned("!=", builder.bitcast(_negative(builder, args[0]), byte), byte(0))

    return types.boolean(x), codegen


@intrinsic
def double_lane(typingctx, v, i):
    """Lane `i` of a vector, as a double."""
    if v != f64x8:
        return None

    def codegen(context, builder, sig, args):
        return builder.extract_element(args[0], builder.trunc(args[1], ir.IntType(32)))

    return types.float64(v, types.int64), codegen


def _operator(function, instruction: str) -> None:
    @infer_global(function)
    class Typing(AbstractTemplate):
        def generic(self, args, kws):
            return signature(f64x8, *args) if len(args) == 2 and all(a == f64x8 for a in args) else None

    @lower_builtin(function, DoublesType, DoublesType)
    def codegen(context, builder, sig, args):
        return getattr(builder, instruction)(*args, flags=_CONTRACT)


for _function, _instruction in (
    (operator.add, "fadd"),
    (operator.sub, "fsub"),
    (operator.mul, "fmul"),
    (operator.truediv, "fdiv"),
):
    _operator(_function, _instruction)
