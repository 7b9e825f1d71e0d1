"""Rows of coordinates as vectors: sixteen points (x, y) or (x, y, z) of an array, one vector for each axis."""

from __future__ import annotations

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from isophote.kernels.base.simd import f32x16

__all__ = ["load_pairs", "load_triples"]

_LANES = 16


def _loader(columns: int):
    @intrinsic
    def load(typingctx, points, first):
        if not (isinstance(points, types.Array) and points.layout == "C" and points.ndim == 2):
            return None
        if points.dtype != types.float32:
            return None
        result = types.UniTuple(f32x16, columns)

        def codegen(context, builder, signature, args):
            data = cgutils.create_struct_proxy(signature.args[0])(context, builder, args[0]).data
            start = builder.gep(data, [builder.mul(args[1], ir.IntType(64)(columns))])
            rows = builder.load(builder.bitcast(start, ir.VectorType(ir.FloatType(), columns * _LANES).as_pointer()))
            rows.align = 4
            parts = []
            for column in range(columns):
                places = [column + columns * lane for lane in range(_LANES)]
                pattern = ir.Constant(ir.VectorType(ir.IntType(32), _LANES), places)
                parts.append(builder.shuffle_vector(rows, ir.Constant(rows.type, ir.Undefined), pattern))
            return context.make_tuple(builder, result, parts)

        return result(points, types.intp), codegen

    return load


# The axes of sixteen rows of a contiguous float32 array with two, or three, columns, from row `first` on.
load_pairs, load_triples = _loader(2), _loader(3)
