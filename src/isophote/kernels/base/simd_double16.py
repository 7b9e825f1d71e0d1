"""`f64x16`: sixteen doubles, in two registers or four, for what is found for sixteen rays at once; see simd.py.

It is loaded, stored or splatted, has `+ - * /` and the comparisons `< <= > >=`, which give the masks of sixteen floats.
Products and sums may be contracted to one rounding.
"""

from __future__ import annotations

import operator

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import intrinsic, lower_builtin, models, register_model

from isophote.kernels.base.simd import mask16
from isophote.kernels.base.table import ViewType

__all__ = [
    "chosen_doubles16",
    "f64x16",
    "floor_doubles16",
    "load_doubles16",
    "outside_mask",
    "root_doubles16",
    "size_doubles16",
    "splat_doubles16",
    "store_doubles16",
]

_LANES = 16
_VECTOR = ir.VectorType(ir.DoubleType(), _LANES)
_CONTRACT = ("contract", "nsz")


class Doubles16Type(types.Type):
    """Numba type of sixteen doubles in registers."""

    def __init__(self) -> None:
        super().__init__(name="f64x16")


f64x16 = Doubles16Type()


@register_model(Doubles16Type)
class _Doubles16Model(models.PrimitiveModel):
    def __init__(self, dmm, fe_type):
        super().__init__(dmm, fe_type, _VECTOR)


def _is_doubles(view) -> bool:
    return isinstance(view, ViewType) and view.dtype == types.float64


def _address(context, builder, view_type, view, index):
    data = cgutils.create_struct_proxy(view_type)(context, builder, view).data
    return builder.bitcast(builder.gep(data, [index]), _VECTOR.as_pointer())


@intrinsic
def load_doubles16(typingctx, view, index):
    """Sixteen doubles of a view, from element `index` on."""
    if not _is_doubles(view):
        return None

    def codegen(context, builder, sig, args):
        loaded = builder.load(_address(context, builder, sig.args[0], *args))
        loaded.align = 8
        return loaded

    return f64x16(view, types.intp), codegen


@intrinsic
def store_doubles16(typingctx, view, index, value):
    """Write sixteen doubles to a view, from `index` on."""
    if not _is_doubles(view) or value != f64x16:
        return None

    def codegen(context, builder, sig, args):
        builder.store(args[2], _address(context, builder, sig.args[0], args[0], args[1])).align = 8
        return context.get_dummy_value()

    return types.void(view, types.intp, value), codegen


@intrinsic
def splat_doubles16(typingctx, x):
    """A double in all lanes."""

    def codegen(context, builder, sig, args):
        undefined = ir.Constant(_VECTOR, ir.Undefined)
        one = builder.insert_element(undefined, args[0], ir.IntType(32)(0))
        zeros = ir.Constant(ir.VectorType(ir.IntType(32), _LANES), [0] * _LANES)
        return builder.shuffle_vector(one, undefined, zeros)

    return f64x16(types.float64), codegen


@intrinsic
def chosen_doubles16(typingctx, mask, a, b):
    """Lane by lane, `a` where the mask is set, else `b`."""
    if mask != mask16 or not a == b == f64x16:
        return None

    def codegen(context, builder, sig, args):
        return builder.select(*args)

    return f64x16(mask, a, b), codegen


@intrinsic
def outside_mask(typingctx, a, b):
    """Lanes of the mask `a` that are not in `b`."""
    if not a == b == mask16:
        return None

    def codegen(context, builder, sig, args):
        return builder.and_(args[0], builder.not_(args[1]))

    return mask16(a, b), codegen


def _unary(name: str):
    @intrinsic
    def apply(typingctx, a):
        if a != f64x16:
            return None

        def codegen(context, builder, sig, args):
            kind = ir.FunctionType(_VECTOR, [_VECTOR])
            return builder.call(cgutils.get_or_insert_function(builder.module, kind, f"llvm.{name}.v16f64"), args)

        return a(a), codegen

    return apply


# Lane by lane: √a, |a|, the largest whole number ≤ a.
root_doubles16, size_doubles16, floor_doubles16 = _unary("sqrt"), _unary("fabs"), _unary("floor")


def _operator(function, result, lower) -> None:
    @infer_global(function)
    class Typing(AbstractTemplate):
        def generic(self, args, kws):
            return signature(result, *args) if len(args) == 2 and all(a == f64x16 for a in args) else None

    @lower_builtin(function, Doubles16Type, Doubles16Type)
    def codegen(context, builder, sig, args):
        return lower(builder, *args)


def _arithmetic(instruction: str):
    return lambda builder, a, b: getattr(builder, instruction)(a, b, flags=_CONTRACT)


def _comparison(predicate: str):
    return lambda builder, a, b: builder.fcmp_ordered(predicate, a, b)


for _function, _instruction in (
    (operator.add, "fadd"),
    (operator.sub, "fsub"),
    (operator.mul, "fmul"),
    (operator.truediv, "fdiv"),
):
    _operator(_function, f64x16, _arithmetic(_instruction))
for _function, _predicate in (
    (operator.lt, "<"),
    (operator.le, "<="),
    (operator.gt, ">"),
    (operator.ge, ">="),
):
    _operator(_function, mask16, _comparison(_predicate))
