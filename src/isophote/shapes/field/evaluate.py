"""The door from fields to the kernels that run their tapes, which are loaded when a field is first evaluated."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from isophote.errors import GeometryError
from isophote.kernels.forms import opcodes
from isophote.kernels.forms.opcodes import GRADIENTS, INTERVALS, VALUES
from isophote.machine import processors
from isophote.shapes.field.data import GridData, MeshData, OutlineData
from isophote.shapes.field.form import Form
from isophote.shapes.field.kept import Kept
from isophote.shapes.field.tape import Tape, numpy_values, sharing_slots, tape_of

__all__ = ["gradients", "packed_data", "scratch", "values"]

Singles = npt.NDArray[np.float32]

# Rows of a tape times points that one thread does in about a millisecond; less is not worth another thread.
_WORK_A_THREAD = 1 << 24
# Points that are brought to single precision, and evaluated, at a time.
_PIECE = 1 << 13
# Bytes of a cache line: vectors that lie across two take twice as long.
_LINE = 64


class _Prepared(NamedTuple):
    """What the interpreters of points take: rows whose slots are used again, how many there are, tables of data."""

    rows: npt.NDArray[np.int32]
    slots: int
    data: Any
    interpreters: Any


# Prepared tapes, by the interpreter that they are for.
_prepared: Kept[_Prepared] = Kept()


def values(form: Form, points: npt.ArrayLike) -> Singles:
    """(n,) float32 values of a form at points (n, dimension), on all processors.

    Points are taken in single precision; those that are not finite there have the value NaN. Raises `GeometryError`
    for points of another shape and for what is no numbers.
    """
    from isophote.kernels.forms.tape import LANES
    from isophote.kernels.forms.tape_arrays import evaluate_points

    array = _points_of(form, points)
    if form.is_opaque:
        return _opaque_values(form, array)
    out = np.empty(len(array), np.float32)
    _on_all(evaluate_points, _prepare(form, VALUES), array, out, LANES)
    return out


def _opaque_values(form: Form, points: npt.NDArray[Any]) -> Singles:
    """Values by NumPy, which asks the user's functions themselves."""
    out = np.full(len(points), np.nan, np.float32)
    finite = np.isfinite(points).all(axis=1)
    out[finite] = numpy_values(form, points[finite])
    return out


def gradients(form: Form, points: npt.ArrayLike) -> Singles:
    """(n, dimension) float32 gradients of a form at points (n, dimension), by exact differentiation.

    Where arms meet, that of one of them; NaN where a point is not finite in single precision.
    """
    from isophote.kernels.forms.tape_arrays import evaluate_gradients
    from isophote.kernels.forms.tape_gradient import GRADIENT_SLOT

    array = _points_of(form, points)
    out = np.empty((len(array), form.dimension), np.float32)
    _on_all(evaluate_gradients, _prepare(form, GRADIENTS), array, out, GRADIENT_SLOT)
    return out


def packed_data(tape: Tape, interpreters: tuple[int, ...] = (VALUES, INTERVALS, GRADIENTS)) -> Any:
    """The tables of a tape as kernels take them: kernels/forms/field_data.py's FIELD_DATA. Keep it while they run.

    Only for the `interpreters` named, numbers of kernels/forms/opcodes.py, the functions of tables are compiled.
    """
    from isophote.kernels.forms.field_data import pack_field_data

    return pack_field_data([_packed(table) for table in tape.data], interpreters)


def scratch(count: int) -> Singles:
    """`count` floats of scratch that begin at a cache line."""
    raw = np.empty(count + _LINE // 4, np.float32)
    first = -raw.ctypes.data % _LINE // 4
    return raw[first : first + count]


def _packed(table: Any) -> Any:
    """A table of data, with the functions that read it."""
    if isinstance(table, OutlineData):
        from isophote.kernels.forms.outline import outline_table

        return outline_table(table.segments, table.sides, table.slope)
    if isinstance(table, GridData):
        from isophote.kernels.forms.grid import grid_table

        return grid_table(table.values, table.low, table.step, table.slope)
    if isinstance(table, MeshData):
        from isophote.kernels.forms.mesh_data import mesh_table

        return mesh_table(table.prepared.table, table.bounds)
    raise GeometryError(f"a table of {type(table).__name__} cannot be evaluated")


def _points_of(form: Form, points: npt.ArrayLike) -> npt.NDArray[Any]:
    """Points as an array of the right shape."""
    try:
        array = np.asarray(points)
    except ValueError as error:
        raise GeometryError(f"points must have shape (n, {form.dimension}), but are of several lengths") from error
    if array.dtype.kind not in "fiub":
        raise GeometryError(f"points must be real numbers, but are {array.dtype}")
    if array.ndim != 2 or array.shape[1] != form.dimension:
        raise GeometryError(f"points must have shape (n, {form.dimension}), but have {array.shape}")
    return array


def _prepare(form: Form, interpreter: int) -> _Prepared:
    from isophote.kernels.forms.tape_entries import pack_interpreters

    def make() -> _Prepared:
        tape = tape_of(form)
        rows, slots = sharing_slots(tape.rows)
        chosen = pack_interpreters(chosen=(interpreter,))
        return _Prepared(np.ascontiguousarray(rows).reshape(-1), slots, packed_data(tape, (interpreter,)), chosen)

    return _prepared.get(form, interpreter, make)


def _on_all(kernel: Callable[..., Any], tape: _Prepared, points: npt.NDArray[Any], out: Singles, slot: int) -> None:
    """Run a kernel over all points, in pieces on as many threads as there is work for."""
    count = len(points)

    def work(begin: int, end: int) -> None:
        slots = scratch((tape.slots + 1) * slot)
        with np.errstate(over="ignore"):
            for first in range(begin, end, _PIECE):
                some = slice(first, min(first + _PIECE, end))
                singles = np.ascontiguousarray(points[some], np.float32)
                kernel(tape.rows, tape.data.words, tape.interpreters.words, singles, slots, out[some], 0, len(singles))

    threads = min(processors(), 1 + len(tape.rows) // opcodes.ROW * count // _WORK_A_THREAD)
    if threads == 1:
        work(0, count)
        return
    step = -(-count // (4 * threads) // _PIECE) * _PIECE
    with ThreadPoolExecutor(threads) as pool:
        for job in [pool.submit(work, first, min(first + step, count)) for first in range(0, count, step)]:
            job.result()
