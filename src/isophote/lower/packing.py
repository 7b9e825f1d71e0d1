"""Packed tables with some of their fields exchanged."""

from __future__ import annotations

from typing import Any

from isophote.kernels.base.table import Packed, Table

__all__ = ["repacked"]


def repacked(table: Table, packed: Packed, **changes: Any) -> Packed:
    """A packed table with other values in some of its fields; what it holds beside its fields is held on."""
    fields = {name: packed.arrays[name] for name in table.fields} | changes
    return table.pack(**fields).holding(packed.arrays | changes)
