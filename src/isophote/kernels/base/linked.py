"""Kernels that other kernels call by their address: long ones, compiled once and not into every caller.

A linked kernel takes four int64 numbers, the first of which is the address of a table's words, and returns one:

    @kernel
    def run(address, first, count, width): t = WORK_AT(address); ...

    WORK_AT = opener_at(WORK)              # kernel: a table by the address of its words
    address = address_of(run)              # Python: compiled, or loaded from the cache
    call_linked(address, words, a, b, c)   # kernel: a call through the address

It must not raise, and what its table names must live on, as with every table.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from isophote.kernels.base.table import Table

__all__ = ["address_of", "call_linked", "opener_at"]

_ARGUMENTS = (types.int64,) * 4
_SIGNATURE = types.int64(*_ARGUMENTS)


def address_of(linked: Any) -> int:
    """The address of a linked kernel's machine code, which is compiled if it is not in the cache."""
    linked.compile(_SIGNATURE)
    compiled = linked.overloads[_ARGUMENTS]
    address: int = compiled.library.get_pointer_to_function(compiled.fndesc.llvm_func_name)
    return address


def opener_at(table: Table) -> Any:
    """The function by which a kernel opens a table from the address of its words."""
    kind = table.type

    @intrinsic
    def open_at(typingctx, address):
        def codegen(context, builder, signature, args):
            return builder.inttoptr(args[0], ir.IntType(64).as_pointer())

        return kind(types.int64), codegen

    return open_at


@intrinsic
def call_linked(typingctx, address, words, a, b, c):
    """What the linked kernel at an address returns for four numbers."""

    def codegen(context, builder, signature, args):
        convention = context.call_conv
        kind = convention.get_function_type(types.int64, _ARGUMENTS)
        function = builder.inttoptr(args[0], kind.as_pointer())
        _, result = convention.call_function(builder, function, types.int64, _ARGUMENTS, args[1:])
        return result

    return types.int64(*(types.int64,) * 5), codegen
