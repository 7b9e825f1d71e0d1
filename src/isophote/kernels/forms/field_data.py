"""What operators of a tape read besides slots: tables of outlines, grids and meshes, all behind one pointer."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from isophote.kernels.base.table import LONG_ROWS, Packed, Table

__all__ = ["FIELD_DATA", "open_field_data", "pack_field_data"]

# Row k: the packed words of the table that rows of a tape name by the number k, padded to the longest.
FIELD_DATA = Table("FieldData", words=LONG_ROWS)
open_field_data = FIELD_DATA.open


def pack_field_data(tables: Sequence[Packed]) -> Packed:
    """The tables of a tape as one, which keeps them alive."""
    words = np.zeros((len(tables), max((len(table.words) for table in tables), default=1)), np.int64)
    for row, table in zip(words, tables, strict=True):
        row[: len(table.words)] = table.words
    packed = FIELD_DATA.pack(words=words)
    return Packed(packed.words, packed.arrays | {"tables": tuple(tables)})
