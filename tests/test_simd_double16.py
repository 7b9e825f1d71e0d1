"""Sixteen doubles at once: every operation as NumPy's, lane by lane, and the ways to rows of other numbers."""

from __future__ import annotations

import numpy as np
from numba import njit

from isophote.kernels.base.doubles import doubles_at
from isophote.kernels.base.entry import element_address, floats_at, ints_at
from isophote.kernels.base.simd import bits, store16
from isophote.kernels.base.simd_double16 import (
    chosen_doubles16,
    floor_doubles16,
    load_doubles16,
    outside_mask,
    root_doubles16,
    size_doubles16,
    splat_doubles16,
    store_doubles16,
)
from isophote.kernels.base.simd_rows import load_narrowed, load_triples, store_whole, store_widened

RNG = np.random.default_rng(4)


@njit
def calculate(a, b, out, masks):
    given, other = doubles_at(element_address(a, 1), 16), doubles_at(element_address(b, 0), 16)
    x, y = load_doubles16(given, 0), load_doubles16(other, 0)
    found = doubles_at(element_address(out, 0), 144)
    store_doubles16(found, 0, x + y)
    store_doubles16(found, 16, x - y)
    store_doubles16(found, 32, x * y)
    store_doubles16(found, 48, x / y)
    store_doubles16(found, 64, root_doubles16(size_doubles16(x)))
    store_doubles16(found, 80, floor_doubles16(x))
    store_doubles16(found, 96, chosen_doubles16(x < y, x, y))
    store_doubles16(found, 112, splat_doubles16(2.5))
    masks[0], masks[1], masks[2], masks[3] = bits(x < y), bits(x <= y), bits(x > y), bits(x >= y)
    masks[4] = bits(outside_mask(x <= y, x < y))


def test_operations_agree_with_numpy() -> None:
    a, b = RNG.normal(size=17) * 10, RNG.normal(size=16) * 10
    b[3], b[5] = a[4], np.nan
    out, masks = np.zeros(144), np.zeros(5, np.int32)
    calculate(a, b, out, masks)
    x = a[1:]
    expected = [x + b, x - b, x * b, x / b, np.sqrt(np.abs(x)), np.floor(x), np.where(x < b, x, b), np.full(16, 2.5)]
    assert np.array_equal(out[:128].reshape(8, 16), expected, equal_nan=True)
    told = [int(np.sum(m << np.arange(16))) for m in (x < b, x <= b, x > b, x >= b, x == b)]
    assert masks.tolist() == told


@njit
def travel(triples, wide, columns, narrow, whole):
    rows, doubles = floats_at(element_address(triples, 0), 96), doubles_at(element_address(wide, 0), 48)
    x, y, z = load_triples(rows, 2)
    store_widened(doubles, 0, x)
    store_widened(doubles, 16, y)
    store_widened(doubles, 32, z)
    store16(floats_at(element_address(narrow, 0), 16), 0, load_narrowed(doubles_at(element_address(columns, 0), 16), 0))
    floors = floor_doubles16(load_doubles16(doubles_at(element_address(columns, 0), 16), 0))
    store_whole(ints_at(element_address(whole, 0), 16), 0, floors)


def test_columns_of_triples_and_numbers_of_other_kinds() -> None:
    triples, columns = RNG.normal(size=(32, 3)).astype(np.float32), RNG.normal(size=16) * 1e4
    wide, narrow, whole = np.zeros((3, 16)), np.zeros(16, np.float32), np.zeros(16, np.int32)
    travel(triples.reshape(-1), wide.reshape(-1), columns, narrow, whole)
    assert np.array_equal(wide, triples[2:18].T)
    assert np.array_equal(narrow, columns.astype(np.float32))
    assert np.array_equal(whole, np.floor(columns))
