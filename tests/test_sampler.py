"""Patterns of sample points: where they lie, and what they do not depend on."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit

from isophote.kernels.base.sampler import INDEPENDENT, JITTERED, SOBOL, draw_pairs, pair

PATTERNS = [INDEPENDENT, JITTERED, SOBOL]


@njit
def points(pattern, seed, pixel, dimension, count, first, out):
    for i in range(len(out)):
        out[i] = pair(pattern, seed, pixel, first + i, count, dimension)


@njit
def drawn(pattern, seed, pixels, samples, dimension, count, n, u, v):
    draw_pairs(pattern, seed, pixels, samples, count, dimension, n, u, v)


def sample(pattern: int, count: int, *, pixel=5, seed=1, dimension=2, first=0, planned=None) -> np.ndarray:
    out = np.zeros((count, 2), np.float32)
    points(pattern, seed, pixel, dimension, count if planned is None else planned, first, out)
    return out


@pytest.mark.parametrize("pattern", PATTERNS)
@pytest.mark.parametrize("count", [1, 2, 3, 7, 64, 100, 1023, 2**20])
def test_points_lie_in_the_half_open_square(pattern, count):
    for seed in (0, 2**32 - 1):
        found = sample(pattern, min(count, 5000), seed=seed, planned=count)
        assert (found >= 0).all()
        assert (found < 1).all()


@pytest.mark.parametrize("power", range(11))
@pytest.mark.parametrize("block", [0, 1, 5])
def test_sobol_points_fill_every_elementary_interval_once(power, block):
    """A (0, k, 2)-net: 2^k points, one in each rectangle of 2^-a by 2^-(k-a), and so for each aligned block."""
    count = 2**power
    for pixel in range(3):
        x, y = sample(SOBOL, count, pixel=pixel, first=block * count).astype(np.float64).T
        for a in range(power + 1):
            cells = (x * 2**a).astype(int) * 2 ** (power - a) + (y * 2 ** (power - a)).astype(int)
            assert len(np.unique(cells)) == count


@pytest.mark.parametrize("count", [*range(1, 50), 64, 97, 100, 128, 1000])
def test_jittered_points_have_cells_of_their_own(count):
    columns = int(np.ceil(np.sqrt(count)))
    rows = -(-count // columns)
    assert 0 <= columns * rows - count < columns
    block = columns * rows
    for turn in range(2):
        x, y = sample(JITTERED, block, planned=count, first=turn * block).T.astype(np.float64)
        cells = np.minimum(x * columns + 1e-6, columns - 1e-3).astype(int)
        cells = cells + columns * np.minimum(y * rows + 1e-6, rows - 1e-3).astype(int)
        # A point within rounding of a line between cells may count for the next one.
        assert len(np.unique(cells)) >= block - (block > 500)


@pytest.mark.parametrize("pattern", PATTERNS)
def test_points_are_uniform_over_pixels_seeds_and_dimensions(pattern):
    """First samples of many pixels, seeds and dimensions: chi-square over 8 by 8 cells."""
    found = np.concatenate(
        [sample(pattern, 4, pixel=p, seed=s, dimension=d) for p in range(64) for s in range(10) for d in range(10)]
    )
    cells = np.histogram2d(*found.T, bins=8, range=[[0, 1], [0, 1]])[0]
    expected = len(found) / 64
    # 63 degrees of freedom: above 117 with a chance of 10⁻⁴ (stratified points lie below).
    assert ((cells - expected) ** 2 / expected).sum() < 117


@pytest.mark.parametrize("pattern", PATTERNS)
def test_dimensions_pixels_and_seeds_are_not_correlated(pattern):
    count = 4096
    base = sample(pattern, count)
    others = [sample(pattern, count, pixel=6), sample(pattern, count, seed=2), sample(pattern, count, dimension=3)]
    for other in others:
        table = np.corrcoef(np.concatenate([base, other], axis=1).T)[:2, 2:]
        assert np.abs(table).max() < 5 / np.sqrt(count)
    assert abs(np.corrcoef(base.T)[0, 1]) < 5 / np.sqrt(count)


@pytest.mark.parametrize("pattern", PATTERNS)
def test_many_at_once_are_the_same_as_one_by_one_in_any_grouping(pattern):
    rng = np.random.default_rng(5)
    n = 333
    pixels = rng.integers(0, 2**20, n).astype(np.uint32)
    samples = rng.integers(0, 100, n).astype(np.uint32)
    u, v = np.full((2, n + 1), -1, np.float32)
    drawn(pattern, 3, pixels, samples, 7, 100, n, u, v)
    assert u[n] == v[n] == -1
    alone = zip(pixels, samples, strict=True)
    single = np.concatenate([sample(pattern, 1, pixel=p, seed=3, dimension=7, first=s, planned=100) for p, s in alone])
    assert np.array_equal(np.stack([u[:n], v[:n]], 1), single)
    for start, size in ((0, 1), (5, 8), (100, 233)):
        a, b = np.zeros((2, size), np.float32)
        part = slice(start, start + size)
        drawn(pattern, 3, pixels[part].copy(), samples[part].copy(), 7, 100, size, a, b)
        assert np.array_equal(a, u[part])
        assert np.array_equal(b, v[part])


def test_stratified_patterns_integrate_better_than_independent_points():
    """A smooth integrand, 64 points: the error of jittered points is several times less, of Sobol's far less."""
    errors = []
    for pattern in PATTERNS:
        runs = [sample(pattern, 64, pixel=p).astype(np.float64) for p in range(200)]
        means = [np.mean(np.sin(3 * x) * np.exp(y)) for x, y in (r.T for r in runs)]
        errors.append(np.std(means))
        truth = (1 - np.cos(3)) / 3 * (np.e - 1)
        assert abs(np.mean(means) - truth) < 4 * np.std(means) / np.sqrt(200)
    assert errors[1] < errors[0] / 3
    assert errors[2] < errors[0] / 10
