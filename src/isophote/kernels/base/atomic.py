"""Words that threads share: read, written and exchanged so that what one thread publishes, others see whole.

A thread that reads a word by `load_acquire` sees all that another one wrote before it left the word there by
`store_release`.
"""

from __future__ import annotations

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from isophote.kernels.base.table import ViewType

__all__ = ["claim", "load_acquire", "store_release"]

_I32 = ir.IntType(32)
_ALIGN = 4


def _is_words(view) -> bool:
    return isinstance(view, ViewType) and view.dtype in (types.float32, types.int32, types.uint32)


def _place(context, builder, view_type, view, index):
    data = cgutils.create_struct_proxy(view_type)(context, builder, view).data
    return builder.bitcast(builder.gep(data, [index]), _I32.as_pointer())


@intrinsic
def load_acquire(typingctx, view, index):
    """The int32 in word `index` of a view of 32-bit words."""
    if not _is_words(view):
        return None

    def codegen(context, builder, signature, args):
        return builder.load_atomic(_place(context, builder, signature.args[0], *args), "acquire", _ALIGN)

    return types.int32(view, types.intp), codegen


@intrinsic
def store_release(typingctx, view, index, value):
    """Leave an int32 in word `index`, after all that was written before."""
    if not _is_words(view):
        return None

    def codegen(context, builder, signature, args):
        place = _place(context, builder, signature.args[0], args[0], args[1])
        builder.store_atomic(args[2], place, "release", _ALIGN)
        return context.get_dummy_value()

    return types.void(view, types.intp, types.int32), codegen


@intrinsic
def claim(typingctx, view, index, expected, value):
    """Put the int32 `value` in the place of `expected` in word `index`; True for the one thread that did."""
    if not _is_words(view):
        return None

    def codegen(context, builder, signature, args):
        place = _place(context, builder, signature.args[0], args[0], args[1])
        exchanged = builder.cmpxchg(place, args[2], args[3], "acq_rel", "acquire")
        return builder.extract_value(exchanged, 1)

    return types.boolean(view, types.intp, types.int32, types.int32), codegen
