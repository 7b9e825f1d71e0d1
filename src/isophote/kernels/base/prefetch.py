"""Asking memory early for what is needed soon."""

from __future__ import annotations

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from isophote.kernels.base.table import ViewType

__all__ = ["prefetch"]

_I8, _I32 = ir.IntType(8), ir.IntType(32)
# To be read, soon and again, as data.
_READ, _KEEP, _DATA = (_I32(k) for k in (0, 3, 1))


@intrinsic
def prefetch(typingctx, view, index):
    """Bring the cache line of element `index` of a view nearer; nothing happens where there is no such element."""
    if not isinstance(view, ViewType):
        return None

    def codegen(context, builder, signature, args):
        data = cgutils.create_struct_proxy(signature.args[0])(context, builder, args[0]).data
        place = builder.bitcast(builder.gep(data, [args[1]]), _I8.as_pointer())
        kind = ir.FunctionType(ir.VoidType(), [place.type, _I32, _I32, _I32])
        function = cgutils.get_or_insert_function(builder.module, kind, "llvm.prefetch.p0i8")
        builder.call(function, [place, _READ, _KEEP, _DATA])
        return context.get_dummy_value()

    return types.void(view, types.intp), codegen
