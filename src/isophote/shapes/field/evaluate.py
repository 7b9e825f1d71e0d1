"""The door from fields to the kernels that run their tapes, which are loaded when a field is first evaluated."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from isophote.errors import GeometryError
from isophote.shapes.field.form import Form
from isophote.shapes.field.tape import tape_of

__all__ = ["values"]


def values(form: Form, points: npt.ArrayLike) -> npt.NDArray[np.float32]:
    """(n,) float32 values of a form at points (n, dimension)."""
    from isophote.kernels.forms.field_data import pack_field_data
    from isophote.kernels.forms.tape import LANES, evaluate_points

    array = np.asarray(points, np.float32)
    if array.ndim != 2 or array.shape[1] != form.dimension:
        raise GeometryError(f"points must have shape (n, {form.dimension}), but have {np.shape(points)}")
    tape = tape_of(form)
    out = np.empty(len(array), np.float32)
    slots = np.zeros((len(tape.rows) + 3) * LANES, np.float32)
    data = pack_field_data(())
    evaluate_points(tape.rows.reshape(-1), data.words, np.ascontiguousarray(array), slots, out, 0, len(array))
    return out
