"""What operators of a tape read besides slots: tables of outlines, grids and meshes, all behind one pointer.

A table comes with what runs it: three functions (kernels/base/entry.py), one for each interpreter, which are called by
their addresses, so that interpreters hold no code for tables that a tape does not have. Each gets the address of the
table's words, that of the slots, the place in the slots where its value goes, those of its arguments, and the number of
vectors in a slot.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from isophote.kernels.base.entry import Entry, call_entry, element_address
from isophote.kernels.base.jit import device
from isophote.kernels.base.table import LONG_ROWS, Packed, Table
from isophote.kernels.forms.opcodes import GRADIENTS, INTERVALS, VALUES

__all__ = [
    "FIELD_DATA",
    "DataTable",
    "call_table",
    "open_field_data",
    "pack_field_data",
]

# Row k: the addresses of the three functions and the packed words of the table that rows of a tape name by the number
# k, padded to the longest.
FIELD_DATA = Table("FieldData", words=LONG_ROWS)
open_field_data = FIELD_DATA.open

# The table's own words begin after those of the interpreters.
_HEAD = 3
_FIRST = np.int64(0)


class DataTable(NamedTuple):
    """A packed table, and the functions of values, intervals and gradients that read it."""

    packed: Packed
    functions: tuple[Entry, Entry, Entry]


def pack_field_data(
    tables: Sequence[DataTable], interpreters: Iterable[int] = (VALUES, INTERVALS, GRADIENTS)
) -> Packed:
    """The tables of a tape as one, which keeps them alive, for the interpreters that are to run the tape."""
    columns = _HEAD + max((len(table.packed.words) for table in tables), default=0)
    words = np.zeros((len(tables), columns), np.int64)
    chosen = tuple(interpreters)
    for row, table in zip(words, tables, strict=True):
        for interpreter in chosen:
            row[interpreter] = table.functions[interpreter].address
        row[_HEAD : _HEAD + len(table.packed.words)] = table.packed.words
    packed = FIELD_DATA.pack(words=words)
    return packed.holding({"tables": tuple(tables)})


@device
def call_table(data, interpreter, number, slots, out, a, b, c, width):
    """Have table `number` write its value at the arguments."""
    row = np.int64(number) * data.words.columns
    places = np.int64(out), np.int64(a), np.int64(b), np.int64(c), np.int64(width)
    begin = element_address(data.words, row + _HEAD), element_address(slots, _FIRST)
    call_entry(data.words[row // data.words.columns, interpreter], begin + places)
