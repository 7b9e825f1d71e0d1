"""Tables as kernels see them: a record of arrays and numbers behind one pointer.

An array argument costs a compiled function seven words and a reference count at every call; a scene has forty. So
tables cross the border as one int64 array of words, three for each field: an array's address, rows and columns, or a
number. Python packs them (`Table.pack`), and a kernel opens them again:

    SCENE = Table("Scene", nodes=FLOATS, roots=INTS, to_world=FLOAT_ROWS, lights=LIGHTS, reach=FLOAT)

    words = SCENE.pack(nodes=..., roots=..., ...)     # Python: checked once
    scene = SCENE.open(words)                         # kernel: one pointer
    scene.nodes[i], scene.to_world[i, j], scene.lights.cdf[k], scene.nodes.rows

Fields are loaded where they are used. Views into arrays have no bounds, no negative indices, and own nothing: the words
that Python holds keep the arrays alive.
"""

from __future__ import annotations

import operator
import struct
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.typing.templates import AbstractTemplate, AttributeTemplate, infer_getattr, infer_global, signature
from numba.extending import intrinsic, lower_builtin, lower_getattr_generic, models, register_model

__all__ = [
    "BYTES",
    "BYTE_ROWS",
    "DOUBLE_BOXES",
    "FLOAT",
    "FLOATS",
    "FLOAT_ROWS",
    "INT",
    "INTS",
    "INT_ROWS",
    "LONGS",
    "LONG_ROWS",
    "WORDS",
    "WORD_ROWS",
    "Packed",
    "Table",
    "ViewType",
]

_I64 = ir.IntType(64)
_WORDS_A_FIELD = 3


class ViewType(types.Type):
    """Numba type of an array without an owner: its address, `rows` and `columns` (the product of all further axes)."""

    def __init__(self, dtype: types.Type, ndim: int) -> None:
        self.dtype = dtype
        self.ndim = ndim
        super().__init__(name=f"View({dtype}, {ndim})")


class TableType(types.Type):
    """Numba type of an opened `Table`: a pointer to its words."""

    def __init__(self, name: str, fields: dict[str, tuple[int, types.Type]]) -> None:
        self.fields = fields
        super().__init__(name=f"Table({name})")


@register_model(ViewType)
class _ViewModel(models.StructModel):
    def __init__(self, dmm, fe_type):
        members = [("data", types.CPointer(fe_type.dtype)), ("rows", types.intp), ("columns", types.intp)]
        super().__init__(dmm, fe_type, members)


@register_model(TableType)
class _TableModel(models.PrimitiveModel):
    def __init__(self, dmm, fe_type):
        super().__init__(dmm, fe_type, _I64.as_pointer())


FLOATS, FLOAT_ROWS = ViewType(types.float32, 1), ViewType(types.float32, 2)
INTS, INT_ROWS = ViewType(types.int32, 1), ViewType(types.int32, 2)
LONGS, LONG_ROWS = ViewType(types.int64, 1), ViewType(types.int64, 2)
WORDS, WORD_ROWS = ViewType(types.uint32, 1), ViewType(types.uint32, 2)
BYTES, BYTE_ROWS = ViewType(types.uint8, 1), ViewType(types.uint8, 2)
DOUBLE_BOXES = ViewType(types.float64, 2)
INT, FLOAT = types.int64, types.float32


# --- fields of a table, sizes of a view -----------------------------------------------------------


@infer_getattr
class _TableFields(AttributeTemplate):
    key = TableType

    def generic_resolve(self, table, name):
        return table.fields[name][1] if name in table.fields else None


@infer_getattr
class _ViewSizes(AttributeTemplate):
    key = ViewType

    def generic_resolve(self, view, name):
        return types.intp if name in ("rows", "columns") else None


@lower_getattr_generic(TableType)
def _load_field(context, builder, table, value, name):
    first, kind = table.fields[name]
    at = builder.gep(value, [_I64(_WORDS_A_FIELD * first)])
    if isinstance(kind, TableType):
        return at
    if isinstance(kind, ViewType):
        view = cgutils.create_struct_proxy(kind)(context, builder)
        element = context.get_data_type(kind.dtype)
        view.data = builder.inttoptr(builder.load(at), element.as_pointer())
        view.rows = builder.load(builder.gep(at, [_I64(1)]))
        view.columns = builder.load(builder.gep(at, [_I64(2)]))
        return view._getvalue()
    word = builder.load(at)
    if kind == types.float32:
        return builder.fptrunc(builder.bitcast(word, ir.DoubleType()), ir.FloatType())
    return word


@lower_getattr_generic(ViewType)
def _load_size(context, builder, view, value, name):
    return getattr(cgutils.create_struct_proxy(view)(context, builder, value), name)


# --- elements of a view ---------------------------------------------------------------------------


def _is_place(view, index) -> bool:
    if view.ndim == 1:
        return isinstance(index, types.Integer)
    if not isinstance(index, types.UniTuple | types.Tuple) or len(index) != 2:
        return False
    return all(isinstance(part, types.Integer) for part in index.types)


@infer_global(operator.getitem)
class _GetItem(AbstractTemplate):
    def generic(self, args, kws):
        view, index = args
        if not isinstance(view, ViewType):
            return None
        if _is_place(view, index):
            return signature(view.dtype, view, index)
        if view.ndim == 2 and isinstance(index, types.Integer):
            return signature(ViewType(view.dtype, 1), view, index)
        return None


@infer_global(operator.setitem)
class _SetItem(AbstractTemplate):
    def generic(self, args, kws):
        view, index, _ = args
        if isinstance(view, ViewType) and _is_place(view, index):
            return signature(types.none, view, index, view.dtype)
        return None


def _element(context, builder, view_type, view, index_type, index):
    proxy = cgutils.create_struct_proxy(view_type)(context, builder, view)
    if view_type.ndim == 1:
        place = context.cast(builder, index, index_type, types.intp)
    else:
        row, column = (
            context.cast(builder, part, kind, types.intp)
            for part, kind in zip(cgutils.unpack_tuple(builder, index, 2), index_type, strict=True)
        )
        place = builder.add(builder.mul(row, proxy.columns, flags=("nsw",)), column, flags=("nsw",))
    return builder.gep(proxy.data, [place])


@lower_builtin(operator.getitem, ViewType, types.Integer)
@lower_builtin(operator.getitem, ViewType, types.BaseTuple)
def _get(context, builder, sig, args):
    view_type, index_type = sig.args
    if view_type.ndim == 2 and isinstance(index_type, types.Integer):
        return _get_row(context, builder, sig, args)
    return builder.load(_element(context, builder, view_type, args[0], index_type, args[1]))


def _get_row(context, builder, sig, args):
    """Row `i` of a two-dimensional view, as a view."""
    proxy = cgutils.create_struct_proxy(sig.args[0])(context, builder, args[0])
    place = builder.mul(context.cast(builder, args[1], sig.args[1], types.intp), proxy.columns)
    row = cgutils.create_struct_proxy(sig.return_type)(context, builder)
    row.data, row.rows, row.columns = builder.gep(proxy.data, [place]), proxy.columns, _I64(1)
    return row._getvalue()


@lower_builtin(operator.setitem, ViewType, types.Integer, types.Any)
@lower_builtin(operator.setitem, ViewType, types.BaseTuple, types.Any)
def _set(context, builder, sig, args):
    view_type, index_type, value_type = sig.args
    value = context.cast(builder, args[2], value_type, view_type.dtype)
    builder.store(value, _element(context, builder, view_type, args[0], index_type, args[1]))
    return context.get_dummy_value()


# --- packing and opening --------------------------------------------------------------------------


class _Owner(bytearray):
    """The memory of a table's words, which keeps what they point to."""

    kept: dict[str, Any]


class Packed(NamedTuple):
    """A table's `words`, for kernels, and the arrays behind them, by name. The words alone keep the arrays alive."""

    words: np.ndarray
    arrays: dict[str, Any]

    def holding(self, more: Mapping[str, Any]) -> Packed:
        """The same table, which keeps further objects alive."""
        self.arrays.update(more)
        return self


class Table:
    """A record's fields: names with views (FLOATS, INT_ROWS …), numbers (INT, FLOAT), or other tables."""

    def __init__(self, name: str, /, **fields: types.Type | Table) -> None:
        self.name = name
        self.fields = fields
        self.size: int = 0
        self.type: TableType
        placed: dict[str, tuple[int, types.Type]] = {}
        for field, kind in fields.items():
            placed[field] = self.size, kind.type if isinstance(kind, Table) else kind
            self.size += kind.size if isinstance(kind, Table) else 1
        self.type = TableType(name, placed)
        self.open = _opener(self.type)

    def pack(self, **values: Any) -> Packed:
        """The words of a table. Arrays must be C-contiguous and of the field's type, since they are not copied."""
        if values.keys() != self.fields.keys():
            raise TypeError(f"{self.name} has fields {sorted(self.fields)}, not {sorted(values)}")
        owner = _Owner(8 * _WORDS_A_FIELD * self.size)
        owner.kept = values
        words = np.frombuffer(owner, np.int64)
        for field, value in values.items():
            first = _WORDS_A_FIELD * self.type.fields[field][0]
            kind = self.fields[field]
            if isinstance(kind, Table):
                words[first : first + _WORDS_A_FIELD * kind.size] = value.words
            else:
                words[first : first + _WORDS_A_FIELD] = self._words_of(field, kind, value)
        return Packed(words, values)

    def _words_of(self, field: str, kind: types.Type, value: Any) -> tuple[int, int, int]:
        if isinstance(kind, ViewType):
            right = value.dtype == np.dtype(kind.dtype.name) and value.flags.c_contiguous
            if not right or (value.ndim > 1) != (kind.ndim > 1):
                raise TypeError(f"{self.name}.{field} must be a contiguous {kind}, not {value.dtype} {value.shape}")
            rows = value.shape[0]
            return value.ctypes.data, rows, value.size // rows if rows else 0
        if kind == FLOAT:
            return struct.unpack("q", struct.pack("d", value))[0], 0, 0
        return int(value), 0, 0


def _opener(kind: TableType):
    """The function by which a kernel opens a table of this type from its int64 words."""

    @intrinsic
    def open_table(typingctx, words):
        def codegen(context, builder, sig, args):
            return cgutils.create_struct_proxy(sig.args[0])(context, builder, args[0]).data

        return kind(words), codegen

    return open_table
