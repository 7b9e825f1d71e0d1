"""Vectors and masks: every operation, lane by lane, against NumPy."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numba import njit
from numba.core.errors import TypingError

from isophote.kernels.base.simd import (
    absolute,
    as_float,
    bits,
    lane,
    largest,
    least,
    load4,
    load8,
    load16,
    load_float,
    load_int,
    lowest_bit,
    maximum,
    minimum,
    select,
    splat4,
    splat8,
    splat16,
    store4,
    store8,
    store16,
    store_float,
    store_int,
    swap_triples,
    triples,
)
from isophote.kernels.base.simd_product import product_difference

FLOATS = st.floats(width=32, allow_nan=True, allow_infinity=True, allow_subnormal=True)
FINITE = st.floats(-(2.0**50), 2.0**50, width=32, allow_subnormal=False)
EIGHT = st.lists(FLOATS, min_size=8, max_size=8).map(lambda values: np.array(values, np.float32))
SIXTEEN = st.lists(FLOATS, min_size=16, max_size=16).map(lambda values: np.array(values, np.float32))
EIGHT_FINITE = st.lists(FINITE, min_size=8, max_size=8).map(lambda values: np.array(values, np.float32))
MANY = settings(max_examples=300, deadline=None)


@njit(error_model="numpy")
def eight(a, b, out, masks):
    """Every binary operation on eight lanes: rows of `out`, and comparisons as bits in `masks`."""
    x, y = load8(a, 0), load8(b, 0)
    store8(out[0], 0, x + y)
    store8(out[1], 0, x - y)
    store8(out[2], 0, x * y)
    store8(out[3], 0, x / y)
    store8(out[4], 0, minimum(x, y))
    store8(out[5], 0, maximum(x, y))
    store8(out[6], 0, absolute(x))
    store8(out[7], 0, select(x < y, x, y))
    masks[0], masks[1], masks[2] = bits(x < y), bits(x <= y), bits(x > y)
    masks[3], masks[4] = bits(x >= y), bits(x == y)
    masks[5], masks[6] = bits((x < y) & (x <= y)), bits((x < y) | (x > y))


@njit(error_model="numpy")
def four(a, b, out, masks):
    """The same on four lanes."""
    x, y = load4(a, 0), load4(b, 0)
    store4(out[0], 0, x + y)
    store4(out[1], 0, x - y)
    store4(out[2], 0, x * y)
    store4(out[3], 0, x / y)
    store4(out[4], 0, minimum(x, y))
    store4(out[5], 0, maximum(x, y))
    store4(out[6], 0, absolute(x))
    store4(out[7], 0, select(x < y, x, y))
    masks[0], masks[1], masks[2] = bits(x < y), bits(x <= y), bits(x > y)
    masks[3], masks[4] = bits(x >= y), bits(x == y)
    masks[5], masks[6] = bits((x < y) & (x <= y)), bits((x < y) | (x > y))


@njit(error_model="numpy")
def sixteen(a, b, out, masks):
    """The same on sixteen lanes."""
    x, y = load16(a, 0), load16(b, 0)
    store16(out[0], 0, x + y)
    store16(out[1], 0, x - y)
    store16(out[2], 0, x * y)
    store16(out[3], 0, x / y)
    store16(out[4], 0, minimum(x, y))
    store16(out[5], 0, maximum(x, y))
    store16(out[6], 0, absolute(x))
    store16(out[7], 0, select(x < y, x, y))
    masks[0], masks[1], masks[2] = bits(x < y), bits(x <= y), bits(x > y)
    masks[3], masks[4] = bits(x >= y), bits(x == y)
    masks[5], masks[6] = bits((x < y) & (x <= y)), bits((x < y) | (x > y))


def expected(a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, list[np.ndarray]]:
    with np.errstate(all="ignore"):
        less = a < b
        lower, upper = np.where(less, a, b), np.where(a > b, a, b)
        out = np.stack([a + b, a - b, a * b, a / b, lower, upper, abs(a), lower])
        return out, [less, a <= b, a > b, a >= b, a == b, less & (a <= b), less | (a > b)]


@pytest.mark.parametrize(("run", "lanes"), [(sixteen, 16), (eight, 8), (four, 4)])
@MANY
@given(a=SIXTEEN, b=SIXTEEN)
def test_operations_agree_with_numpy(run, lanes, a, b):
    out, masks = np.zeros((8, 16), np.float32), np.zeros(7, np.int32)
    run(a, b, out, masks)
    values, truths = expected(a[:lanes], b[:lanes])
    assert np.array_equal(out[:, :lanes], values, equal_nan=True)
    assert not out[:, lanes:].any()
    assert masks.tolist() == [int((truth << np.arange(lanes)).sum()) for truth in truths]


@njit
def extremes(a):
    return least(load16(a, 0)), largest(load16(a, 0)), least(load8(a, 0)), largest(load8(a, 0))


@MANY
@given(a=st.lists(FINITE, min_size=16, max_size=16).map(lambda values: np.array(values, np.float32)))
def test_least_and_largest_lanes(a):
    assert extremes(a) == (a.min(), a.max(), a[:8].min(), a[:8].max())


@njit
def marked(numbers, out):
    store16(out, 0, splat16(as_float(np.int32(numbers[0]))))


@pytest.mark.parametrize("number", [0, -1, 17, 2**31 - 1, 0x7F800001])
def test_whole_numbers_travel_as_floats_with_all_their_bits(number):
    """Among them those that as floats are signalling NaNs and subnormal."""
    out = np.zeros(16, np.float32)
    marked(np.array([number]), out)
    assert (out.view(np.int32) == number).all()


def test_a_nan_on_the_left_gives_the_right_operand_and_one_on_the_right_stays():
    nan = np.full(8, np.nan, np.float32)
    one = np.ones(8, np.float32)
    out, masks = np.zeros((8, 8), np.float32), np.zeros(7, np.int32)
    eight(nan, one, out, masks)
    assert (out[4:6] == 1).all()
    assert not masks.any()
    eight(one, nan, out, masks)
    assert np.isnan(out[4:6]).all()
    assert not masks.any()


@njit(error_model="numpy")
def products(a, b, c, d, out8, out4):
    store8(out8, 0, product_difference(load8(a, 0), load8(b, 0), load8(c, 0), load8(d, 0)))
    store4(out4, 0, product_difference(load4(a, 0), load4(b, 0), load4(c, 0), load4(d, 0)))


def assert_differences(a, b, c, d):
    there, half = np.zeros(8, np.float32), np.zeros(4, np.float32)
    products(a, b, c, d, there, half)
    # Products of 24 bits are exact in doubles, and so is what little is left of two that are nearly alike.
    exact = a.astype(np.float64) * b - c.astype(np.float64) * d
    unit = np.spacing(np.abs(exact).astype(np.float32)).astype(np.float64)
    assert (np.abs(there - exact) <= 1.5 * unit + 1e-37).all()
    assert (np.sign(there) == np.sign(exact))[np.abs(exact) > 1e-37].all()
    assert np.array_equal(half, there[:4])


@MANY
@given(a=EIGHT_FINITE, b=EIGHT_FINITE, c=EIGHT_FINITE, d=EIGHT_FINITE)
def test_differences_of_products_are_hardly_rounded(a, b, c, d):
    assert_differences(a, b, c, d)


def test_differences_of_products_that_are_nearly_alike_keep_their_sign():
    generator = np.random.default_rng(1)
    for _ in range(5000):
        a, b = generator.uniform(1, 2, (2, 8)).astype(np.float32)
        steps = np.float32(2.0**-23) * generator.integers(-3, 4, (2, 8)).astype(np.float32)
        assert_differences(a, b, a + steps[0], b + steps[1])
        assert_differences(a, b, b, a)


@njit
def copy(source, target, i, j):
    store8(target, j, load8(source, i))
    store4(target, j + 8, load4(source, i))


@pytest.mark.parametrize("offset", range(9))
def test_loads_and_stores_at_any_offset(offset):
    source = np.arange(40, dtype=np.float32)
    target = np.full(40, -1, np.float32)
    copy(source, target, offset, 2 * offset + 1)
    wanted = np.full(40, -1, np.float32)
    wanted[2 * offset + 1 : 2 * offset + 9] = source[offset : offset + 8]
    wanted[2 * offset + 9 : 2 * offset + 13] = source[offset : offset + 4]
    assert np.array_equal(target, wanted)


@njit
def words(values, numbers):
    store_int(values, 1, load_int(numbers, 0))
    store_float(numbers, 1, load_float(values, 0))
    return load_int(values, 0), load_float(numbers, 0)


@pytest.mark.parametrize("kind", [np.int32, np.uint32])
def test_words_keep_their_bits_whatever_the_type_of_the_array(kind):
    values, numbers = np.array([-1.5, 0], np.float32), np.array([0x40490FDB, 0], kind)
    whole, real = words(values, numbers)
    assert whole == np.float32(-1.5).view(np.int32)
    assert real == np.int32(0x40490FDB).view(np.float32)
    assert values[1] == real
    assert numbers[1].view(np.float32) == np.float32(-1.5)


@njit
def shuffle(a, out):
    v = load8(a, 0)
    store8(out[0], 0, triples(v))
    store8(out[1], 0, swap_triples(v))
    store8(out[2], 0, splat8(a[1]))
    store4(out[3], 0, splat4(a[2]))
    for k in range(8):
        out[4, k] = lane(v, np.int32(7 - k))


def test_triples_splats_and_lanes():
    a = np.array([1, 2, 3, np.nan, 5, 6, 7, np.inf], np.float32)
    out = np.zeros((5, 8), np.float32)
    shuffle(a, out)
    assert out[0].tolist() == [1, 2, 3, 0, 5, 6, 7, 0]
    assert out[1].tolist() == [5, 6, 7, 0, 1, 2, 3, 0]
    assert (out[2] == 2).all()
    assert out[3].tolist() == [3, 3, 3, 3, 0, 0, 0, 0]
    assert np.array_equal(out[4], a[::-1], equal_nan=True)


@njit
def lowest(x):
    return lowest_bit(np.int32(x))


@given(st.integers(1, 2**31 - 1))
@settings(deadline=None)
def test_lowest_bit(x):
    assert lowest(x) == (x & -x).bit_length() - 1


@njit
def mixed(a):
    return bits(load8(a, 0) < load4(a, 0))


@njit
def wide(a):
    return bits(load8(a, 0) < load8(a, 0))


def test_vectors_of_unequal_width_and_arrays_of_other_words_are_refused():
    for call, array in ((mixed, np.zeros(8, np.float32)), (wide, np.zeros(8)), (wide, np.zeros(16, np.float32)[::2])):
        with pytest.raises(TypingError):
            call(array)
