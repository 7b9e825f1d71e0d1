"""A field in the plane as a picture of truth values: which pixels are inside."""

from __future__ import annotations

import operator
from concurrent.futures import ThreadPoolExecutor
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.errors import GeometryError
from isophote.kernels.forms.mask import LEAF, fill_square, split_picture
from isophote.kernels.forms.opcodes import INPUTS, INTERVALS, ROW, VALUES
from isophote.kernels.forms.regions import REGIONS
from isophote.kernels.forms.tape import LANES
from isophote.kernels.forms.tape_entries import pack_interpreters
from isophote.kernels.forms.tape_interval import REGION_SLOT
from isophote.machine import processors
from isophote.shapes.field.evaluate import packed_data, scratch, values
from isophote.shapes.field.field2 import Field2
from isophote.shapes.field.form import Form
from isophote.shapes.field.kept import Kept
from isophote.shapes.field.tape import tape_of

__all__ = ["mask", "pixel_centres"]

Box: TypeAlias = npt.NDArray[np.float64]
Singles: TypeAlias = npt.NDArray[np.float32]
Ints: TypeAlias = npt.NDArray[np.int32]

_MOST_PIXELS = 1 << 30
# Part of the field's bounds that is left free around it where no bounds are given.
_MARGIN = 0.05


def mask(
    field: Field2, size: tuple[int, int] = (512, 512), bounds: npt.ArrayLike | None = None
) -> npt.NDArray[np.bool_]:
    """(h, w) picture of a field in the plane: True where its value at a pixel's middle is below 0, row 0 at the top.

    `size` is (w, h) in pixels, which cover `bounds` (2, 2), the least and the greatest x and y. Without bounds they are
    square, and the field's own bounds are in the middle with a margin. Whole regions are decided by intervals, the
    pixels near the boundary by the field's value; the result is the same, and the same for any number of threads.

    Raises `GeometryError` for fields in space, for sizes below 1 or above 2³⁰ pixels, and for endless fields without
    bounds.
    """
    form = _form_of(field)
    width, height = _checked_size(size)
    xs, ys = pixel_centres(_bounds_of(form, (width, height), bounds), (width, height))
    picture = np.zeros((height, width), np.uint8)
    if form.is_opaque:
        for row, y in zip(picture, ys, strict=True):
            row[:] = values(form, np.column_stack([xs, np.full(width, y)])) < 0
    else:
        _draw(_tape(form, xs, ys), xs, ys, picture)
    return picture.view(np.bool_)


def pixel_centres(bounds: Box, size: tuple[int, int]) -> tuple[Singles, Singles]:
    """x of the columns and y of the rows, from the top down, of a picture of `size` (w, h) that covers `bounds`."""
    steps = [(np.arange(count) + 0.5) / count for count in size]
    x, y = (low + (high - low) * step for low, high, step in zip(*bounds, steps, strict=True))
    return x.astype(np.float32), y[::-1].astype(np.float32)


class _Tape(NamedTuple):
    """A tape for the region of a picture, flat, its tables, and addresses."""

    rows: Ints
    data: Any
    interpreters: Any


_tapes: Kept[_Tape] = Kept()


def _tape(form: Form, xs: Singles, ys: Singles) -> _Tape:
    region = np.array([[xs[0], ys[-1]], [xs[-1], ys[0]]], np.float64)

    def make() -> _Tape:
        tape = tape_of(form, region)
        chosen = VALUES, INTERVALS
        return _Tape(tape.rows.reshape(-1), packed_data(tape, chosen), pack_interpreters(chosen=chosen))

    return _tapes.get(form, region.tobytes(), make)


def _form_of(field: Field2) -> Form:
    if not isinstance(field, Field2):
        raise GeometryError(f"mask: the field must be one in the plane, a Field2, but is a {type(field).__name__}")
    return field.form


def _checked_size(size: tuple[int, int]) -> tuple[int, int]:
    try:
        width, height = (operator.index(count) for count in size)
    except (TypeError, ValueError):
        raise GeometryError(f"mask: size must be two whole numbers (w, h), but is {size!r}") from None
    if width < 1 or height < 1 or width * height > _MOST_PIXELS:
        raise GeometryError(f"mask: size must be from 1 × 1 to 2³⁰ pixels in all, but is {width} × {height}")
    return width, height


def _bounds_of(form: Form, size: tuple[int, int], bounds: npt.ArrayLike | None) -> Box:
    if bounds is not None:
        try:
            box = np.asarray(bounds, np.float64)
        except (TypeError, ValueError):
            box = np.empty(0)
        if box.shape != (2, 2) or not np.isfinite(box).all() or not (box[0] < box[1]).all():
            raise GeometryError(f"mask: bounds must be ((x0, y0), (x1, y1)), finite and ascending, but are {bounds!r}")
        return box
    box = np.asarray(form.bounds, np.float64)
    if not np.isfinite(box).all():
        raise GeometryError("mask: the field is endless; say which part of it with bounds=((x0, y0), (x1, y1))")
    middle, extent = box.mean(axis=0), np.ptp(box, axis=0) * (1 + 2 * _MARGIN)
    pixel = max(float((extent / size).max()), np.finfo(np.float32).tiny)
    half = pixel * np.array(size) / 2
    return np.stack([middle - half, middle + half])


def _draw(tape: _Tape, xs: Singles, ys: Singles, picture: npt.NDArray[np.uint8]) -> None:
    """Decide all pixels: sixteen squares first, then those that are not decided on all processors."""
    side = LEAF
    while 4 * side < max(picture.shape):
        side *= 4
    columns = np.concatenate([xs, np.full(LEAF, xs[-1])])
    count = len(tape.rows) // ROW
    children = np.zeros((REGIONS, 4), np.int64)
    tapes = np.empty(REGIONS * len(tape.rows), np.int32)
    slots, choices = scratch((count + INPUTS) * REGION_SLOT), np.empty(count, np.int32)
    marks = np.empty(count + INPUTS, np.int32)
    given = tape.data.words, tape.interpreters.words, columns, ys, picture
    left = split_picture(tape.rows, *given, side, children, tapes, slots, choices, marks)

    def work(square: npt.NDArray[np.int64]) -> None:
        most, levels = int(square[3]), (side // LEAF).bit_length() // 2
        fill_square(
            tapes, *given, square, side,
            np.empty(levels * most * ROW, np.int32), scratch((most + INPUTS) * max(REGION_SLOT, LANES)),
            np.empty(levels * most, np.int32), np.empty(most + INPUTS, np.int32), np.empty((levels + 1, 5), np.int64),
        )  # fmt: skip

    threads = min(processors(), left)
    if threads <= 1:
        for square in children[:left]:
            work(square)
        return
    with ThreadPoolExecutor(threads) as pool:
        for job in [pool.submit(work, square) for square in children[:left]]:
            job.result()
