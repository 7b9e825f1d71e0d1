"""Vectors of the processor as Numba types: `f32x16`, `f32x8` and `f32x4`, so many floats in one register.

A vector exists only inside kernels: it is loaded from or stored to an array, or made by `splat`, and has
the operators `+ - * /`, the comparisons but `!=` (which give a mask), and the functions below. Masks have
`&` and `|`. Everything maps to one or two machine instructions; nothing allocates.

    a = load8(values, i)                  # eight floats from values[i] on
    near = minimum(a, b) - splat8(x)
    hit = bits(near <= far)               # bit k: lane k
    while hit != 0:
        k = lowest_bit(hit)               # lane by lane
        hit &= hit - 1

`minimum(a, b)` is `a < b ? a : b` lane by lane, so a NaN in `a` yields `b`. Products and sums may be
contracted to one rounding, except where the name says `exact`.
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
    "absolute",
    "as_float",
    "bits",
    "floor",
    "lane",
    "largest",
    "least",
    "load4",
    "load8",
    "load16",
    "load_float",
    "load_int",
    "lowest_bit",
    "maximum",
    "minimum",
    "round_even",
    "select",
    "splat4",
    "splat8",
    "splat16",
    "square_root",
    "store4",
    "store8",
    "store16",
    "store_float",
    "store_int",
    "swap_triples",
    "triples",
]

_F32, _I32, _I1 = ir.FloatType(), ir.IntType(32), ir.IntType(1)
_CONTRACT = ("contract", "nsz")


class VectorType(types.Type):
    """Numba type of `lanes` floats in one register."""

    def __init__(self, lanes: int) -> None:
        self.lanes = lanes
        super().__init__(name=f"f32x{lanes}")


class MaskType(types.Type):
    """Numba type of `lanes` truth values in one register."""

    def __init__(self, lanes: int) -> None:
        self.lanes = lanes
        super().__init__(name=f"mask{lanes}")


@register_model(VectorType)
class _VectorModel(models.PrimitiveModel):
    def __init__(self, dmm, fe_type):
        super().__init__(dmm, fe_type, ir.VectorType(_F32, fe_type.lanes))


@register_model(MaskType)
class _MaskModel(models.PrimitiveModel):
    def __init__(self, dmm, fe_type):
        super().__init__(dmm, fe_type, ir.VectorType(_I1, fe_type.lanes))


f32x16, f32x8, f32x4 = VectorType(16), VectorType(8), VectorType(4)
mask16, mask8, mask4 = MaskType(16), MaskType(8), MaskType(4)
_MASK_OF = {f32x16: mask16, f32x8: mask8, f32x4: mask4}


def _is_vector(*operands) -> bool:
    return all(isinstance(a, VectorType) for a in operands) and len(set(operands)) == 1


def _is_mask(*operands) -> bool:
    return all(isinstance(a, MaskType) for a in operands) and len(set(operands)) == 1


# --- memory ---------------------------------------------------------------------------------------


def _address(context, builder, array_type, array, index, element):
    """Pointer to element `index` of a contiguous array of 32-bit elements, as `element`."""
    data = cgutils.create_struct_proxy(array_type)(context, builder, array).data
    return builder.bitcast(builder.gep(data, [index]), element.as_pointer())


def _is_words(array) -> bool:
    """Whether a type is that of a contiguous array, or of a view, of 32-bit elements."""
    if isinstance(array, types.Array):
        return array.layout == "C" and array.dtype.bitwidth == 32
    return isinstance(array, ViewType) and array.dtype in (types.float32, types.int32, types.uint32)


def _loader(result: types.Type, element: ir.Type):
    @intrinsic
    def load(typingctx, array, index):
        if not _is_words(array):
            return None

        def codegen(context, builder, signature, args):
            loaded = builder.load(_address(context, builder, signature.args[0], *args, element))
            loaded.align = 4
            return loaded

        return result(array, types.intp), codegen

    return load


def _storer(value: types.Type, element: ir.Type):
    @intrinsic
    def store(typingctx, array, index, stored):
        if not _is_words(array):
            return None

        def codegen(context, builder, signature, args):
            pointer = _address(context, builder, signature.args[0], args[0], args[1], element)
            builder.store(args[2], pointer).align = 4
            return context.get_dummy_value()

        return types.void(array, types.intp, value), codegen

    return store


load16, store16 = _loader(f32x16, ir.VectorType(_F32, 16)), _storer(f32x16, ir.VectorType(_F32, 16))
load8, store8 = _loader(f32x8, ir.VectorType(_F32, 8)), _storer(f32x8, ir.VectorType(_F32, 8))
load4, store4 = _loader(f32x4, ir.VectorType(_F32, 4)), _storer(f32x4, ir.VectorType(_F32, 4))
# One word of an array of 32-bit elements, read or written as the type in the name whatever the array's own
# type: tables of nodes hold floats and integers side by side. No wrap-around of negative indices.
load_float, store_float = _loader(types.float32, _F32), _storer(types.float32, _F32)
load_int, store_int = _loader(types.int32, _I32), _storer(types.int32, _I32)


# --- making and taking apart ----------------------------------------------------------------------


def _splatter(result: VectorType):
    @intrinsic
    def splat(typingctx, x):
        def codegen(context, builder, signature, args):
            vector = ir.VectorType(_F32, result.lanes)
            undefined = ir.Constant(vector, ir.Undefined)
            one = builder.insert_element(undefined, args[0], _I32(0))
            zeros = ir.Constant(ir.VectorType(_I32, result.lanes), [0] * result.lanes)
            return builder.shuffle_vector(one, undefined, zeros)

        return result(types.float32), codegen

    return splat


splat16, splat8, splat4 = _splatter(f32x16), _splatter(f32x8), _splatter(f32x4)


@intrinsic
def as_float(typingctx, x):
    """The float that has the bits of an int32; it may only be moved, not computed with."""

    def codegen(context, builder, signature, args):
        return builder.bitcast(args[0], _F32)

    return types.float32(types.int32), codegen


def _reducer(name: str):
    @intrinsic
    def reduce(typingctx, v):
        if not _is_vector(v):
            return None

        def codegen(context, builder, signature, args):
            kind = ir.FunctionType(_F32, [args[0].type])
            function = cgutils.get_or_insert_function(builder.module, kind, f"llvm.vector.reduce.{name}.v{v.lanes}f32")
            return builder.call(function, args, fastmath=("nnan", "nsz"))

        return types.float32(v), codegen

    return reduce


# Least and largest lane of a vector without NaN.
least, largest = _reducer("fmin"), _reducer("fmax")


@intrinsic
def lane(typingctx, v, i):
    """Lane `i` of a vector, as a float."""
    if not _is_vector(v):
        return None

    def codegen(context, builder, signature, args):
        return builder.extract_element(args[0], args[1])

    return types.float32(v, types.int32), codegen


@intrinsic
def bits(typingctx, mask):
    """A mask as an integer: bit k is lane k."""
    if not _is_mask(mask):
        return None

    def codegen(context, builder, signature, args):
        packed = builder.bitcast(args[0], ir.IntType(mask.lanes))
        return builder.zext(packed, _I32)

    return types.int32(mask), codegen


@intrinsic
def lowest_bit(typingctx, x):
    """Number of the lowest set bit of a non-zero int32."""

    def codegen(context, builder, signature, args):
        return builder.cttz(args[0], _I1(1))

    return types.int32(types.int32), codegen


# --- arithmetic -----------------------------------------------------------------------------------


def _operator(function, matches, result, lower, *classes) -> None:
    """Give an operator to pairs of our types: `result` is of the type told by the first, `lower` makes the value."""

    @infer_global(function)
    class Typing(AbstractTemplate):
        def generic(self, args, kws):
            return signature(result(args[0]), *args) if len(args) == 2 and matches(*args) else None

    @lower_builtin(function, *classes)
    def codegen(context, builder, sig, args):
        return lower(builder, *args)


def _arithmetic(instruction: str):
    return lambda builder, a, b: getattr(builder, instruction)(a, b, flags=_CONTRACT)


def _comparison(predicate: str):
    return lambda builder, a, b: builder.fcmp_ordered(predicate, a, b)


def _logic(instruction: str):
    return lambda builder, a, b: getattr(builder, instruction)(a, b)


for _function, _instruction in (
    (operator.add, "fadd"),
    (operator.sub, "fsub"),
    (operator.mul, "fmul"),
    (operator.truediv, "fdiv"),
):
    _operator(_function, _is_vector, lambda a: a, _arithmetic(_instruction), VectorType, VectorType)
for _function, _predicate in (
    (operator.lt, "<"),
    (operator.le, "<="),
    (operator.gt, ">"),
    (operator.ge, ">="),
    (operator.eq, "=="),
):
    _operator(_function, _is_vector, lambda a: _MASK_OF[a], _comparison(_predicate), VectorType, VectorType)
for _function, _instruction in ((operator.and_, "and_"), (operator.or_, "or_")):
    _operator(_function, _is_mask, lambda a: a, _logic(_instruction), MaskType, MaskType)


def _choice(predicate: str):
    @intrinsic
    def choose(typingctx, a, b):
        if not _is_vector(a, b):
            return None

        def codegen(context, builder, signature, args):
            return builder.select(builder.fcmp_ordered(predicate, *args), *args)

        return a(a, b), codegen

    return choose


minimum, maximum = _choice("<"), _choice(">")


@intrinsic
def select(typingctx, mask, a, b):
    """Lane by lane, `a` where the mask is set, else `b`."""
    if not (_is_mask(mask) and _is_vector(a, b)):
        return None

    def codegen(context, builder, signature, args):
        return builder.select(*args)

    return a(mask, a, b), codegen


def _triples(first: int, second: int):
    @intrinsic
    def shuffle(typingctx, v):
        if v != f32x8:
            return None

        def codegen(context, builder, signature, args):
            zeros = ir.Constant(args[0].type, [0.0] * 8)
            pattern = [first, first + 1, first + 2, 8, second, second + 1, second + 2, 8]
            return builder.shuffle_vector(args[0], zeros, ir.Constant(ir.VectorType(_I32, 8), pattern))

        return v(v), codegen

    return shuffle


# Eight floats as two triples, (x, y, z, -, x', y', z', -): lanes 3 and 7 made zero, and the triples exchanged too.
triples, swap_triples = _triples(0, 4), _triples(4, 0)


def _unary(name: str):
    """A function of one vector that LLVM names `name`."""

    @intrinsic
    def function(typingctx, a):
        if not _is_vector(a):
            return None

        def codegen(context, builder, signature, args):
            vector = args[0].type
            kind = ir.FunctionType(vector, [vector])
            called = cgutils.get_or_insert_function(builder.module, kind, f"llvm.{name}.v{a.lanes}f32")
            return builder.call(called, args)

        return a(a), codegen

    return function


# Lane by lane: |a|, √a, largest whole number ≤ a, nearest whole number (the even one of two).
absolute, square_root, floor, round_even = (_unary(name) for name in ("fabs", "sqrt", "floor", "rint"))
