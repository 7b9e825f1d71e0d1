"""Compiled functions that other kernels call by their address.

A device function is compiled into every kernel that calls it, and again into all that call that. What is large, or what
only some scenes need, is made an `Entry` instead: it is compiled once, when its address is first asked for, takes
whole numbers, most of them addresses, and gives back one. Kernels find its address in a table.

    @entry
    def measure(things, scratch): ...

    SCENE.pack(..., measure=measure.address)                                                     # Python
    call_entry(scene.measure, (table_address(scene.things), element_address(scratch, first)))    # kernel
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.ccallback import CFunc
from numba.extending import intrinsic

from isophote.kernels.base import cache
from isophote.kernels.base.table import FLOATS, INTS, Table, TableType, ViewType

__all__ = [
    "Entry",
    "call_entry",
    "element_address",
    "entry",
    "floats_at",
    "ints_at",
    "opener_at",
    "table_address",
]

_I64 = ir.IntType(64)
# Arithmetic as that of kernels (jit.py).
_OPTIONS = {"nopython": True, "error_model": "numpy", "fastmath": {"contract", "nsz"}}

cache.install()


class Entry:
    """A function of whole numbers that is compiled, or loaded from the cache, when `address` is first asked for."""

    def __init__(self, function: Callable[..., int]) -> None:
        self._function = function
        self._lock = threading.Lock()
        self._compiled: Any = None

    @property
    def address(self) -> int:
        """Where the machine code lies; valid as long as the process runs."""
        return int(self.compile().address)

    def compile(self) -> Any:
        """The compiled function."""
        with self._lock:
            if self._compiled is None:
                arguments = (types.int64,) * self._function.__code__.co_argcount
                compiled = CFunc(self._function, (arguments, types.int64), {}, _OPTIONS)
                compiled.enable_caching()
                compiled.compile()
                self._compiled = compiled
            return self._compiled


def entry(function: Callable[..., int]) -> Entry:
    """Make an `Entry` of a module-level function of whole numbers."""
    return Entry(function)


@intrinsic
def call_entry(typingctx, address, arguments):
    """Call the entry at `address` with a tuple of int64."""
    if not isinstance(arguments, types.UniTuple):
        return None

    def codegen(context, builder, signature, args):
        function = ir.FunctionType(_I64, [_I64] * arguments.count)
        values = cgutils.unpack_tuple(builder, args[1], arguments.count)
        return builder.call(builder.inttoptr(args[0], function.as_pointer()), values)

    return types.int64(types.int64, types.UniTuple(types.int64, arguments.count)), codegen


@intrinsic
def table_address(typingctx, table):
    """Address of an opened table's words."""
    if not isinstance(table, TableType):
        return None

    def codegen(context, builder, signature, args):
        return builder.ptrtoint(args[0], _I64)

    return types.int64(table), codegen


@intrinsic
def element_address(typingctx, array, index):
    """Address of element `index` of a contiguous array or view."""
    if not isinstance(array, ViewType | types.Array):
        return None

    def codegen(context, builder, signature, args):
        data = cgutils.create_struct_proxy(signature.args[0])(context, builder, args[0]).data
        return builder.ptrtoint(builder.gep(data, [args[1]]), _I64)

    return types.int64(array, types.intp), codegen


def _viewer(kind: ViewType):
    @intrinsic
    def view_at(typingctx, address, count):
        def codegen(context, builder, signature, args):
            view = cgutils.create_struct_proxy(kind)(context, builder)
            view.data = builder.inttoptr(args[0], context.get_data_type(kind.dtype).as_pointer())
            view.rows, view.columns = args[1], _I64(1)
            return view._getvalue()

        return kind(types.int64, types.int64), codegen

    return view_at


# `count` floats or int32 at an address, as a view.
floats_at, ints_at = _viewer(FLOATS), _viewer(INTS)


def opener_at(table: Table):
    """The function by which an entry opens a table of this type from its address."""

    @intrinsic
    def open_at(typingctx, address):
        def codegen(context, builder, signature, args):
            return builder.inttoptr(args[0], _I64.as_pointer())

        return table.type(types.int64), codegen

    return open_at
