"""Elementary functions of vectors, against NumPy in double precision."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from numba import njit

from isophote.kernels.base.simd import load16, store16
from isophote.kernels.base.simd_math import arc_cosine, arc_sine, arc_tangent, cosine, exponential, logarithm, sine

Singles = npt.NDArray[np.float32]


@njit(error_model="numpy")
def apply(which: int, a: Singles, b: Singles, out: Singles) -> None:
    """One of the functions, sixteen numbers at a time."""
    for i in range(0, a.size, 16):
        x, y = load16(a, i), load16(b, i)
        if which == 0:
            x = sine(x)
        elif which == 1:
            x = cosine(x)
        elif which == 2:
            x = exponential(x)
        elif which == 3:
            x = logarithm(x)
        elif which == 4:
            x = arc_tangent(x, y)
        elif which == 5:
            x = arc_sine(x)
        else:
            x = arc_cosine(x)
        store16(out, i, x)


FUNCTIONS: dict[str, Callable[..., Any]] = {
    "sine": lambda a, b: np.sin(a),
    "cosine": lambda a, b: np.cos(a),
    "exponential": lambda a, b: np.exp(a),
    "logarithm": lambda a, b: np.log(a),
    "arc_tangent": np.arctan2,
    "arc_sine": lambda a, b: np.arcsin(np.clip(a, -1, 1)),
    "arc_cosine": lambda a, b: np.arccos(np.clip(a, -1, 1)),
}
COUNT = 1 << 15
SPECIAL = np.array([0, -0.0, 1, -1, 0.5, -0.5, np.inf, -np.inf, np.nan, 1e-45, -1e-40, 3e38, -3e38, 2, 88.8, -104])


def arguments(seed: int) -> tuple[Singles, Singles]:
    """Any bits, numbers of common sizes, quarter turns, and special numbers with each other."""
    rng = np.random.default_rng(seed)
    bits = rng.integers(0, 2**32, (2, COUNT), dtype=np.uint64).astype(np.uint32).view(np.float32)
    common = rng.normal(size=(2, COUNT)) * 10.0 ** rng.integers(-3, 7, (2, COUNT))
    inside = rng.uniform(-1.1, 1.1, (2, COUNT))
    quarters = np.arange(2 * COUNT).reshape(2, -1) * (np.pi / 2)
    pairs = np.stack(np.meshgrid(SPECIAL, SPECIAL)).reshape(2, -1)
    with np.errstate(invalid="ignore"):  # signalling NaNs among the bits
        a, b = np.concatenate([bits, common, inside, quarters, pairs], axis=1).astype(np.float32)
    return a, b


@pytest.mark.parametrize("name", FUNCTIONS)
def test_results_are_within_three_units_in_the_last_place(name: str) -> None:
    a, b = arguments(1)
    found = np.empty_like(a)
    apply(list(FUNCTIONS).index(name), a, b, found)
    with np.errstate(all="ignore"):
        wanted = FUNCTIONS[name](a.astype(np.float64), b.astype(np.float64))
        single = wanted.astype(np.float32)
        unit = np.spacing(np.maximum(np.abs(single), np.float32(2.0**-126))).astype(np.float64)
        close = np.abs(found - wanted) <= 3 * unit
    same = close | (found == single) | (np.isnan(found) & np.isnan(wanted))
    assert same.all(), (a[~same][:4], b[~same][:4], found[~same][:4], wanted[~same][:4])


def test_angles_have_the_signs_of_zeros() -> None:
    y, x = np.stack(np.meshgrid(SPECIAL, SPECIAL)).reshape(2, -1).astype(np.float32)
    found = np.empty_like(x)
    apply(4, y, x, found)
    wanted = np.arctan2(y, x)
    there = ~np.isnan(wanted)
    assert (np.signbit(found) == np.signbit(wanted))[there].all()


@pytest.mark.parametrize(("which", "low", "high"), [(0, -1.0, 1.0), (1, -1.0, 1.0), (2, 0.0, np.inf)])
def test_results_stay_in_their_range(which: int, low: float, high: float) -> None:
    a, b = arguments(2)
    found = np.empty_like(a)
    apply(which, a, b, found)
    found = found[~np.isnan(found)]
    assert found.min() >= low
    assert found.max() <= high
