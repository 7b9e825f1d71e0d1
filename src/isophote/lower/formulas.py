"""Formulas of users' own and fields as tables that textures are looked up in."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from isophote.errors import SceneError
from isophote.kernels.base.table import Packed
from isophote.kernels.forms.opcodes import VALUES
from isophote.kernels.forms.tape_entries import pack_interpreters
from isophote.kernels.texture.formula import FORMULA
from isophote.shapes.field.evaluate import packed_data
from isophote.shapes.field.form import Form
from isophote.shapes.field.tape import sharing_slots, tape_of

__all__ = ["formula_table"]

# Slots lie on the stack, 64 bytes each.
_MOST_SLOTS = 1024


def formula_table(forms: Sequence[Form], ramp: Sequence[float], period: float) -> Packed:
    """The table of a formula: one form whose value goes through a ramp, or three of red, green and blue.

    Raises `SceneError` where an expression keeps too many values at a time.
    """
    tapes = [tape_of(form) for form in forms]
    shared = [sharing_slots(tape.rows) for tape in tapes]
    slots = max(count for _, count in shared)
    if slots > _MOST_SLOTS:
        raise SceneError(
            f"a texture's formula is too long: it keeps {slots} values at a time, of {_MOST_SLOTS} at most"
        )
    tables = [packed_data(tape, (VALUES,)) for tape in tapes]
    data = np.zeros((len(tables), max(len(table.words) for table in tables)), np.int64)
    for row, table in zip(data, tables, strict=True):
        row[: len(table.words)] = table.words
    counts = [len(rows) for rows, _ in shared]
    packed = FORMULA.pack(
        rows=np.concatenate([rows.reshape(-1) for rows, _ in shared]),
        spans=np.array([[sum(counts[:k]), count] for k, count in enumerate(counts)], np.int32),
        slots=slots,
        data=data,
        interpreters=pack_interpreters(chosen=(VALUES,)),
        ramp=np.array(ramp, np.float32),
        period=period,
    )
    # The words of `data` point at these.
    return packed._replace(arrays=packed.arrays | {"tables": tuple(tables)})
