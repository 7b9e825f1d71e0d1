"""`Vec3`: three floats as one value inside kernels, with operators and the usual products.

    p = origin + t * direction
    n = normalise(cross(b - a, c - a))

A `Vec3` lives in registers; it is never stored in an array as such (`load_vec3`, `store_vec3`). Scalars that
meet a vector become float32.
"""

from __future__ import annotations

import operator

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import intrinsic, lower_builtin, make_attribute_wrapper, models, register_model

from isophote.kernels.base.jit import device

__all__ = [
    "cross",
    "dot",
    "length",
    "load_vec3",
    "maximum_component",
    "normalise",
    "orthonormal",
    "reflect",
    "store_vec3",
    "vec3",
]

_AXES = ("x", "y", "z")
_CONTRACT = ("contract", "nsz")
_ONE = np.float32(1)


class Vec3Type(types.Type):
    """Numba type of three floats."""

    def __init__(self) -> None:
        super().__init__(name="Vec3")


vec3_type = Vec3Type()


@register_model(Vec3Type)
class _Vec3Model(models.StructModel):
    def __init__(self, dmm, fe_type):
        super().__init__(dmm, fe_type, [(axis, types.float32) for axis in _AXES])


for _axis in _AXES:
    make_attribute_wrapper(Vec3Type, _axis, _axis)


def _parts(context, builder, value):
    proxy = cgutils.create_struct_proxy(vec3_type)(context, builder, value)
    return [getattr(proxy, axis) for axis in _AXES]


def _pack(context, builder, parts):
    proxy = cgutils.create_struct_proxy(vec3_type)(context, builder)
    for axis, part in zip(_AXES, parts, strict=True):
        setattr(proxy, axis, part)
    return proxy._getvalue()


@intrinsic
def vec3(typingctx, x, y, z):
    """A vector from its three components."""

    def codegen(context, builder, signature, args):
        return _pack(context, builder, args)

    return vec3_type(types.float32, types.float32, types.float32), codegen


def _operator(function, instruction: str) -> None:
    """Vector with vector component by component, and vector with scalar either way round."""

    @infer_global(function)
    class Typing(AbstractTemplate):
        def generic(self, args, kws):
            if vec3_type not in args or not all(a == vec3_type or isinstance(a, types.Number) for a in args):
                return None
            return signature(vec3_type, *(a if a == vec3_type else types.float32 for a in args))

    def codegen(context, builder, sig, args):
        sides = [
            _parts(context, builder, value) if kind == vec3_type else [value] * 3
            for kind, value in zip(sig.args, args, strict=True)
        ]
        parts = [getattr(builder, instruction)(p, q, flags=_CONTRACT) for p, q in zip(*sides, strict=True)]
        return _pack(context, builder, parts)

    for classes in ((Vec3Type, Vec3Type), (Vec3Type, types.Float), (types.Float, Vec3Type)):
        lower_builtin(function, *classes)(codegen)


for _function, _instruction in (
    (operator.add, "fadd"),
    (operator.sub, "fsub"),
    (operator.mul, "fmul"),
    (operator.truediv, "fdiv"),
):
    _operator(_function, _instruction)


@infer_global(operator.neg)
class _Negative(AbstractTemplate):
    def generic(self, args, kws):
        return signature(vec3_type, vec3_type) if args == (vec3_type,) else None


@lower_builtin(operator.neg, Vec3Type)
def _negate(context, builder, sig, args):
    return _pack(context, builder, [builder.fneg(p) for p in _parts(context, builder, args[0])])


@intrinsic
def dot(typingctx, a, b):
    """a · b."""

    def codegen(context, builder, signature, args):
        left, right = (_parts(context, builder, value) for value in args)
        products = [builder.fmul(p, q, flags=_CONTRACT) for p, q in zip(left, right, strict=True)]
        return builder.fadd(builder.fadd(products[0], products[1], flags=_CONTRACT), products[2], flags=_CONTRACT)

    return types.float32(vec3_type, vec3_type), codegen


@intrinsic
def cross(typingctx, a, b):
    """a × b."""

    def codegen(context, builder, signature, args):
        a, b = (_parts(context, builder, value) for value in args)
        parts = []
        for i, j in ((1, 2), (2, 0), (0, 1)):
            left = builder.fmul(a[i], b[j], flags=_CONTRACT)
            parts.append(builder.fsub(left, builder.fmul(a[j], b[i], flags=_CONTRACT), flags=_CONTRACT))
        return _pack(context, builder, parts)

    return vec3_type(vec3_type, vec3_type), codegen


@intrinsic
def _sqrt(typingctx, x):
    def codegen(context, builder, signature, args):
        kind = ir.FunctionType(ir.FloatType(), [ir.FloatType()])
        return builder.call(cgutils.get_or_insert_function(builder.module, kind, "llvm.sqrt.f32"), args)

    return types.float32(types.float32), codegen


@device
def length(a):
    """|a|."""
    return _sqrt(dot(a, a))


@device
def normalise(a):
    """a / |a|."""
    return a / _sqrt(dot(a, a))


@device
def maximum_component(a):
    """The largest of the three components."""
    return max(a.x, max(a.y, a.z))


@device
def reflect(d, n):
    """Mirror direction of `d` at a surface with unit normal `n`: d − 2 (d · n) n."""
    return d - n * (dot(d, n) + dot(d, n))


@device
def orthonormal(n):
    """Two unit vectors that make a right-handed frame with the unit vector `n` (Duff et al., JCGT 6(1), 2017)."""
    sign = _ONE if n.z >= 0 else -_ONE
    a = -_ONE / (sign + n.z)
    b = n.x * n.y * a
    return vec3(_ONE + sign * n.x * n.x * a, sign * b, -sign * n.x), vec3(b, sign + n.y * n.y * a, -n.y)


@intrinsic
def load_vec3(typingctx, array, index):
    """Three consecutive floats of a contiguous float32 array from element `index` on."""

    def codegen(context, builder, signature, args):
        data = cgutils.create_struct_proxy(signature.args[0])(context, builder, args[0]).data
        parts = []
        for k in range(3):
            at = builder.add(args[1], ir.IntType(64)(k))
            parts.append(builder.load(builder.gep(data, [at])))
        return _pack(context, builder, parts)

    return vec3_type(array, types.intp), codegen


@intrinsic
def store_vec3(typingctx, array, index, value):
    """Write a vector to three consecutive floats of a contiguous float32 array."""

    def codegen(context, builder, signature, args):
        data = cgutils.create_struct_proxy(signature.args[0])(context, builder, args[0]).data
        for k, part in enumerate(_parts(context, builder, args[2])):
            at = builder.add(args[1], ir.IntType(64)(k))
            builder.store(part, builder.gep(data, [at]))
        return context.get_dummy_value()

    return types.void(array, types.intp, vec3_type), codegen
