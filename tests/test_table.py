"""Tables: what Python packs is what kernels open."""

from __future__ import annotations

import gc
import re
import weakref
from pathlib import Path

import numpy as np
import pytest
from numba import njit, types

from isophote import kernels
from isophote.kernels.base import table
from isophote.kernels.base.table import Table

VIEWS = {
    "FLOATS": np.float32,
    "FLOAT_ROWS": np.float32,
    "INTS": np.int32,
    "INT_ROWS": np.int32,
    "LONGS": np.int64,
    "LONG_ROWS": np.int64,
    "WORDS": np.uint32,
    "WORD_ROWS": np.uint32,
    "BYTES": np.uint8,
    "BYTE_ROWS": np.uint8,
    "DOUBLE_BOXES": np.float64,
}
EVERY = Table("Every", **{name: getattr(table, name) for name in VIEWS}, INT=table.INT, FLOAT=table.FLOAT)
INNER = Table("Inner", values=table.FLOATS, count=table.INT)
OUTER = Table("Outer", first=table.INT, inner=INNER, last=table.FLOAT)
open_every, open_outer = EVERY.open, OUTER.open


def test_every_view_type_is_tested():
    kinds = {name for name in table.__all__ if isinstance(getattr(table, name), types.Type)}
    assert kinds == {*VIEWS, "INT", "FLOAT"}


def arrays() -> dict[str, np.ndarray]:
    """Arrays of odd shapes with extreme values."""
    made = {}
    for name, dtype in VIEWS.items():
        flat = not name.endswith(("ROWS", "BOXES"))
        shape = (7,) if flat else (5, 3)
        if np.issubdtype(dtype, np.floating):
            values = np.random.default_rng(3).normal(size=shape).astype(dtype)
            values.flat[0] = np.inf
        else:
            limits = np.iinfo(dtype)
            values = np.random.default_rng(3).integers(limits.min, limits.max, shape, dtype, endpoint=True)
            values.flat[:2] = limits.min, limits.max
        made[name] = values
    return made


@njit
def copy_flat(view, out):
    for i in range(view.rows):
        out[i] = view[i]
    return view.rows, view.columns


@njit
def copy_rows(view, out):
    for i in range(view.rows):
        row = view[i]
        for j in range(view.columns):
            out[i, j] = view[i, j]
            if row[j] != view[i, j] or row.rows != view.columns:
                return -1, -1
    return view.rows, view.columns


@njit
def flat_fields(words, floats, ints, longs, unsigned, octets):
    every = open_every(words)
    copy_flat(every.FLOATS, floats)
    copy_flat(every.INTS, ints)
    copy_flat(every.LONGS, longs)
    copy_flat(every.WORDS, unsigned)
    copy_flat(every.BYTES, octets)
    return every.INT, every.FLOAT, every.FLOATS.rows, every.FLOATS.columns


@njit
def row_fields(words, floats, ints, longs, unsigned, octets, boxes):
    every = open_every(words)
    copy_rows(every.FLOAT_ROWS, floats)
    copy_rows(every.INT_ROWS, ints)
    copy_rows(every.LONG_ROWS, longs)
    copy_rows(every.WORD_ROWS, unsigned)
    copy_rows(every.BYTE_ROWS, octets)
    return copy_rows(every.DOUBLE_BOXES, boxes)


def test_every_kind_of_field_comes_back_as_it_went_in():
    given = arrays()
    packed = EVERY.pack(**given, INT=-(2**63), FLOAT=np.float32(0.1))
    flat = [np.zeros_like(a) for name, a in given.items() if a.ndim == 1]
    rows = [np.zeros_like(a) for name, a in given.items() if a.ndim == 2]
    assert flat_fields(packed.words, *flat) == (-(2**63), np.float32(0.1), 7, 1)
    assert row_fields(packed.words, *rows) == (5, 3)
    for a, b in zip([a for a in given.values() if a.ndim == 1], flat, strict=True):
        assert np.array_equal(a, b)
    for a, b in zip([a for a in given.values() if a.ndim == 2], rows, strict=True):
        assert np.array_equal(a, b)


@njit
def write(words):
    every = open_every(words)
    every.FLOATS[6] = 2.5
    every.INT_ROWS[4, 2] = 17
    every.BYTES[3] = 255


def test_kernels_write_into_the_arrays_that_were_packed():
    given = arrays()
    packed = EVERY.pack(**given, INT=0, FLOAT=0.0)
    write(packed.words)
    assert given["FLOATS"][6] == 2.5
    assert given["INT_ROWS"][4, 2] == 17
    assert given["BYTES"][3] == 255


@njit
def nested(words):
    outer = open_outer(words)
    inner = outer.inner
    return outer.first, inner.values[2], inner.values.rows, inner.count, outer.last


def test_tables_hold_tables():
    inner = INNER.pack(values=np.array([1, 2, 3], np.float32), count=9)
    assert nested(OUTER.pack(first=4, inner=inner, last=-0.5).words) == (4, 3, 3, 9, -0.5)


def test_words_alone_keep_the_arrays_alive():
    values, beside, directly = (np.array([1, 2, 3], np.float32) for _ in range(3))
    alive = [weakref.ref(array) for array in (values, beside, directly)]
    words = (
        OUTER.pack(first=4, inner=INNER.pack(values=values, count=9).holding({"beside": beside}), last=0.0)
        .holding({"directly": directly})
        .words
    )
    del values, beside, directly
    gc.collect()
    assert all(array() is not None for array in alive)
    assert nested(words)[1:3] == (3, 3)
    del words
    gc.collect()
    assert all(array() is None for array in alive)


@pytest.mark.parametrize("value", [np.inf, -np.inf, 0.0, 1e-40, 3.4e38])
def test_numbers_keep_their_value(value):
    inner = INNER.pack(values=np.zeros(3, np.float32), count=2**40)
    result = nested(OUTER.pack(first=-1, inner=inner, last=value).words)
    assert result[0] == -1
    assert result[3] == 2**40
    assert result[4] == np.float32(value)


def test_arrays_without_rows_and_of_more_axes():
    given = arrays()
    given["FLOATS"] = np.zeros(0, np.float32)
    given["DOUBLE_BOXES"] = np.arange(24.0).reshape(2, 3, 4)
    packed = EVERY.pack(**given, INT=0, FLOAT=0.0)
    flat = [np.zeros_like(a) for a in given.values() if a.ndim == 1]
    assert flat_fields(packed.words, *flat)[2:] == (0, 0)
    rows = [np.zeros((len(a), a.size // len(a)), a.dtype) for a in given.values() if a.ndim > 1]
    assert row_fields(packed.words, *rows) == (2, 12)
    assert np.array_equal(rows[-1].reshape(-1), np.arange(24.0))


@pytest.mark.parametrize("name", VIEWS)
@pytest.mark.parametrize("spoil", ["type", "order", "stride", "axes", "bytes"])
def test_arrays_that_kernels_would_misread_are_refused(name, spoil):
    given = arrays()
    a = given[name]
    if spoil == "type":
        a = np.zeros(a.shape, np.int16)
    elif spoil == "order":
        a = np.asfortranarray(a) if a.ndim > 1 else np.repeat(a, 2)[::2]
    elif spoil == "stride":
        a = np.repeat(a, 2, axis=0)[::2]
    elif spoil == "axes":
        a = a.reshape(1, -1) if a.ndim == 1 else a.reshape(-1)
    elif a.dtype.itemsize > 1:
        a = a.astype(a.dtype.newbyteorder())
    else:
        a = a.astype(np.int8)
    with pytest.raises(TypeError, match=name):
        EVERY.pack(**{**given, name: a}, INT=0, FLOAT=0.0)


def test_missing_and_unknown_fields_are_refused():
    with pytest.raises(TypeError, match="fields"):
        INNER.pack(values=np.zeros(1, np.float32))
    with pytest.raises(TypeError, match="fields"):
        INNER.pack(values=np.zeros(1, np.float32), count=1, more=2)


def test_no_two_tables_have_one_name() -> None:
    # Numba tells types by their names: two tables of one name would share the fields of the first.
    folder = Path(kernels.__file__ or "").parent
    files = [path for path in sorted(folder.rglob("*.py")) if path.name != "table.py"]
    text = "".join(path.read_text() for path in files)
    names = re.findall(r"\bTable\(\s*\"(\w+)\"", text)
    assert len(names) > 20
    assert sorted(names) == sorted(set(names))
