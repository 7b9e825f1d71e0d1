"""`Wide`: sixteen vectors as one value inside kernels, a component in each of three registers of sixteen floats.

    to_light = spread(light) - place
    cosine = wide_dot(normal, to_light) / square_root(wide_dot(to_light, to_light))

Tables of floats hold such vectors as three rows, of which columns i … i + 15 are loaded and stored at once. Lanes that
hold nothing are worked out like the others, and never looked at.
"""

from __future__ import annotations

import operator

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import intrinsic, lower_builtin, make_attribute_wrapper, models, register_model

from isophote.kernels.base.simd import f32x16, mask16
from isophote.kernels.base.table import ViewType
from isophote.kernels.base.vec import vec3_type

__all__ = [
    "counts_up",
    "load_lanes",
    "load_wide",
    "spread",
    "store_lanes",
    "store_wide",
    "wide",
    "wide_cross",
    "wide_dot",
    "wide_select",
    "zero_lanes",
]

_AXES = ("x", "y", "z")
_CONTRACT = ("contract", "nsz")
_LANES = 16
_I32, _I64, _F32 = ir.IntType(32), ir.IntType(64), ir.FloatType()
_VECTOR = ir.VectorType(_F32, _LANES)


class WideType(types.Type):
    """Numba type of sixteen vectors of three floats."""

    def __init__(self) -> None:
        super().__init__(name="Wide")


wide_type = WideType()


@register_model(WideType)
class _WideModel(models.StructModel):
    def __init__(self, dmm, fe_type):
        super().__init__(dmm, fe_type, [(axis, f32x16) for axis in _AXES])


for _axis in _AXES:
    make_attribute_wrapper(WideType, _axis, _axis)


def _parts(context, builder, kind, value):
    proxy = cgutils.create_struct_proxy(kind)(context, builder, value)
    return [getattr(proxy, axis) for axis in _AXES]


def _pack(context, builder, parts):
    proxy = cgutils.create_struct_proxy(wide_type)(context, builder)
    for axis, part in zip(_AXES, parts, strict=True):
        setattr(proxy, axis, part)
    return proxy._getvalue()


def _splat(builder, x):
    undefined = ir.Constant(_VECTOR, ir.Undefined)
    one = builder.insert_element(undefined, x, _I32(0))
    return builder.shuffle_vector(one, undefined, ir.Constant(ir.VectorType(_I32, _LANES), [0] * _LANES))


@intrinsic
def wide(typingctx, x, y, z):
    """Sixteen vectors from their components."""

    def codegen(context, builder, signature, args):
        return _pack(context, builder, args)

    return wide_type(f32x16, f32x16, f32x16), codegen


@intrinsic
def spread(typingctx, v):
    """The same vector in all lanes."""

    def codegen(context, builder, signature, args):
        return _pack(context, builder, [_splat(builder, p) for p in _parts(context, builder, vec3_type, args[0])])

    return wide_type(vec3_type), codegen


def _operator(function, instruction: str) -> None:
    """Vectors with vectors component by component, and with one number a lane on the right."""

    @infer_global(function)
    class Typing(AbstractTemplate):
        def generic(self, args, kws):
            right = len(args) == 2 and args[0] == wide_type and args[1] in (wide_type, f32x16)
            return signature(wide_type, *args) if right else None

    def codegen(context, builder, sig, args):
        left = _parts(context, builder, wide_type, args[0])
        right = _parts(context, builder, wide_type, args[1]) if sig.args[1] == wide_type else [args[1]] * 3
        parts = [getattr(builder, instruction)(p, q, flags=_CONTRACT) for p, q in zip(left, right, strict=True)]
        return _pack(context, builder, parts)

    lower_builtin(function, WideType, WideType)(codegen)
    lower_builtin(function, WideType, type(f32x16))(codegen)


for _function, _instruction in (
    (operator.add, "fadd"),
    (operator.sub, "fsub"),
    (operator.mul, "fmul"),
    (operator.truediv, "fdiv"),
):
    _operator(_function, _instruction)


@intrinsic
def wide_dot(typingctx, a, b):
    """a · b lane by lane, rounded as `vec.dot` is."""

    def codegen(context, builder, signature, args):
        left, right = (_parts(context, builder, wide_type, value) for value in args)
        products = [builder.fmul(p, q, flags=_CONTRACT) for p, q in zip(left, right, strict=True)]
        return builder.fadd(builder.fadd(products[0], products[1], flags=_CONTRACT), products[2], flags=_CONTRACT)

    return f32x16(wide_type, wide_type), codegen


@intrinsic
def wide_cross(typingctx, a, b):
    """a × b lane by lane."""

    def codegen(context, builder, signature, args):
        a, b = (_parts(context, builder, wide_type, value) for value in args)
        parts = []
        for i, j in ((1, 2), (2, 0), (0, 1)):
            left = builder.fmul(a[i], b[j], flags=_CONTRACT)
            parts.append(builder.fsub(left, builder.fmul(a[j], b[i], flags=_CONTRACT), flags=_CONTRACT))
        return _pack(context, builder, parts)

    return wide_type(wide_type, wide_type), codegen


@intrinsic
def wide_select(typingctx, mask, a, b):
    """Lane by lane, `a` where the mask is set, else `b`."""

    def codegen(context, builder, signature, args):
        a, b = (_parts(context, builder, wide_type, value) for value in args[1:])
        return _pack(context, builder, [builder.select(args[0], p, q) for p, q in zip(a, b, strict=True)])

    return wide_type(mask16, wide_type, wide_type), codegen


# --- rows of tables ---------------------------------------------------------------------------------------------------


def _places(context, builder, kind, table, row, column, count):
    """Pointers to sixteen columns of `count` rows."""
    view = cgutils.create_struct_proxy(kind)(context, builder, table)
    first = builder.add(builder.mul(row, view.columns, flags=("nsw",)), column, flags=("nsw",))
    pointers = []
    for _ in range(count):
        pointers.append(builder.bitcast(builder.gep(view.data, [first]), _VECTOR.as_pointer()))
        first = builder.add(first, view.columns, flags=("nsw",))
    return pointers


def _is_rows(table) -> bool:
    """Whether a type is that of rows of 32-bit elements: whole numbers may be moved as floats, not computed with."""
    return isinstance(table, ViewType) and table.ndim == 2 and table.dtype in (types.float32, types.uint32)


def _loader(result, count):
    @intrinsic
    def load(typingctx, table, row, column):
        if not _is_rows(table):
            return None

        def codegen(context, builder, signature, args):
            loaded = [builder.load(at) for at in _places(context, builder, signature.args[0], *args, count)]
            for part in loaded:
                part.align = 4
            return loaded[0] if count == 1 else _pack(context, builder, loaded)

        return result(table, types.intp, types.intp), codegen

    return load


def _storer(stored, count):
    @intrinsic
    def store(typingctx, table, row, column, value):
        if not _is_rows(table):
            return None

        def codegen(context, builder, signature, args):
            parts = [args[3]] if count == 1 else _parts(context, builder, wide_type, args[3])
            pointers = _places(context, builder, signature.args[0], *args[:3], count)
            for at, part in zip(pointers, parts, strict=True):
                builder.store(part, at).align = 4
            return context.get_dummy_value()

        return types.void(table, types.intp, types.intp, stored), codegen

    return store


def _words(context, builder, signature, args):
    """Columns i … i + 15 of a row of 32-bit whole numbers."""
    (at,) = _places(context, builder, signature.args[0], *args, 1)
    loaded = builder.load(builder.bitcast(at, ir.VectorType(_I32, _LANES).as_pointer()))
    loaded.align = 4
    return loaded


@intrinsic
def zero_lanes(typingctx, table, row, column):
    """In which of the columns i … i + 15 of a row the words are 0."""

    def codegen(context, builder, signature, args):
        words = _words(context, builder, signature, args)
        return builder.icmp_signed("==", words, ir.Constant(words.type, [0] * _LANES))

    return mask16(table, types.intp, types.intp), codegen


@intrinsic
def counts_up(typingctx, table, row, column):
    """Whether the words in columns i … i + 15 of a row are a, a + 1 … a + 15."""

    def codegen(context, builder, signature, args):
        words = _words(context, builder, signature, args)
        first = builder.shuffle_vector(words, words, ir.Constant(words.type, [0] * _LANES))
        equal = builder.icmp_signed("==", words, builder.add(first, ir.Constant(words.type, list(range(_LANES)))))
        return builder.icmp_signed("==", builder.bitcast(equal, ir.IntType(_LANES)), ir.IntType(_LANES)(-1))

    return types.boolean(table, types.intp, types.intp), codegen


# Columns i … i + 15 of one row, and of three.
load_lanes, store_lanes = _loader(f32x16, 1), _storer(f32x16, 1)
load_wide, store_wide = _loader(wide_type, 3), _storer(wide_type, 3)
