"""What scenes know of fields before any is lowered: light to load, for scenes without them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.kernels.accel.field_layout import FIELDS, field_scratch_words
from isophote.kernels.accel.geometry import SCRATCH_WORDS
from isophote.kernels.base.table import Packed
from isophote.kernels.forms.interpreters import INTERPRETERS
from isophote.lower.boxes import no_boxes

if TYPE_CHECKING:
    from isophote.shapes.field.field import Field

__all__ = ["FieldPart", "endless", "no_fields", "scratch_words"]

Matrix: TypeAlias = npt.NDArray[np.float64]


class FieldPart(NamedTuple):
    """An item that is a field: where it stands, its material's number, and its number for the user."""

    field: Field
    matrix: Matrix
    material: int
    public: int


def endless(parts: Sequence[FieldPart]) -> bool:
    """Whether any field has no finite bounds."""
    return any(not np.isfinite(part.field.bounds).all() for part in parts)


def scratch_words(fields: Packed) -> int:
    """Words of scratch that rays through a scene with these fields need."""
    longest = int(fields.arrays["longest"])
    return SCRATCH_WORDS + (field_scratch_words(longest) if len(fields.arrays["numbers"]) else 0)


def no_fields() -> Packed:
    """The table of a scene without fields: nothing is loaded or compiled for it."""
    return FIELDS.pack(
        rows=np.zeros(0, np.int32),
        tapes=np.zeros((0, 2), np.int32),
        nodes=np.zeros(0, np.int32),
        finer=np.zeros(0, np.int64),
        numbers=np.zeros((0, 5), np.int32),
        cubes=np.zeros((0, 17), np.float32),
        to_object=np.zeros((0, 12)),
        to_world=np.zeros((0, 12)),
        data=np.zeros((0, 1), np.int64),
        top_nodes=np.zeros(0, np.float32),
        top_items=np.zeros(0, np.int32),
        boxes=no_boxes(),
        trace=0,
        surface=0,
        longest=0,
        interpreters=INTERPRETERS.pack(values=0, bounds=0, gradients=0),
    )
