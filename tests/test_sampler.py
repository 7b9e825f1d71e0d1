"""Patterns of sample points: where they lie, and what they do not depend on."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit

import isophote as iso
from isophote.errors import RenderError
from isophote.kernels.base.sampler import (
    ANTITHETIC,
    BLUE_NOISE,
    INDEPENDENT,
    JITTERED,
    REGULAR,
    SOBOL,
    draw_pairs,
    pair,
    pixel_number,
)

PATTERNS = [INDEPENDENT, JITTERED, SOBOL, BLUE_NOISE, ANTITHETIC]
EVERY = [*PATTERNS, REGULAR]


@njit
def points(pattern, seed, pixel, dimension, count, first, out):
    for i in range(len(out)):
        out[i] = pair(pattern, seed, pixel, first + i, count, dimension)


@njit
def drawn(pattern, seed, pixels, samples, dimension, count, n, u, v):
    draw_pairs(pattern, seed, pixels, samples, count, dimension, n, u, v)


@njit
def numbers(x, y, out):
    for i in range(len(x)):
        out[i] = pixel_number(x[i], y[i])


def pixel_numbers(x, y) -> list[int]:
    out = np.zeros(len(x), np.uint32)
    numbers(np.asarray(x, np.int64), np.asarray(y, np.int64), out)
    return out.tolist()


def sample(pattern: int, count: int, *, pixel=5, seed=1, dimension=2, first=0, planned=None) -> np.ndarray:
    out = np.zeros((count, 2), np.float32)
    points(pattern, seed, pixel, dimension, count if planned is None else planned, first, out)
    return out


@pytest.mark.parametrize("pattern", EVERY)
@pytest.mark.parametrize("count", [1, 2, 3, 7, 64, 100, 1023, 2**20])
def test_points_lie_in_the_half_open_square(pattern, count):
    for seed in (0, 2**32 - 1):
        found = sample(pattern, min(count, 5000), seed=seed, planned=count)
        assert (found >= 0).all()
        assert (found < 1).all()


def assert_net(points: np.ndarray, power: int) -> None:
    """A (0, k, 2)-net: 2^k points, one in each rectangle of 2^-a by 2^-(k-a)."""
    x, y = points.astype(np.float64).T
    for a in range(power + 1):
        cells = (x * 2**a).astype(int) * 2 ** (power - a) + (y * 2 ** (power - a)).astype(int)
        assert len(np.unique(cells)) == 2**power


@pytest.mark.parametrize("pattern", [SOBOL, BLUE_NOISE])
@pytest.mark.parametrize("power", range(11))
@pytest.mark.parametrize("block", [0, 1, 5])
def test_sobol_points_fill_every_elementary_interval_once(pattern, power, block):
    """And so for each aligned block, whatever number is planned."""
    count = 2**power
    for pixel in (0, 1, 2, 2**31 + 5):
        for planned in {count, 1024, 700, 2**20}:
            assert_net(sample(pattern, count, pixel=pixel, first=block * count, planned=planned), power)


@pytest.mark.parametrize("planned", [1, 2, 3, 4, 16, 61])
@pytest.mark.parametrize("scale", [1, 2, 3])
def test_squares_of_pixels_share_out_a_net(planned, scale):
    """All samples of any aligned square of 2^k by 2^k pixels, as many as a power of two, are one net as well."""
    count = 1 << (planned - 1).bit_length()
    for x, y, dimension in ((0, 0, 0), (1, 0, 3), (37, 121, 2)):
        pixels = [
            pixel_numbers([(x << scale) + i], [(y << scale) + j])[0] for j in range(2**scale) for i in range(2**scale)
        ]
        points = [sample(BLUE_NOISE, count, pixel=p, dimension=dimension, planned=planned) for p in pixels]
        assert_net(np.concatenate(points), 2 * scale + count.bit_length() - 1)


def test_pixels_are_numbered_along_mortons_curve():
    rng = np.random.default_rng(2)
    x, y = rng.integers(0, 2**16, (2, 500))
    bits = [zip(f"{i:016b}", f"{j:016b}", strict=True) for i, j in zip(x, y, strict=True)]
    expected = [int("".join(b + a for a, b in pairs), 2) for pairs in bits]
    assert pixel_numbers(x, y) == expected


def test_beyond_the_sequence_pixels_have_samples_of_their_own():
    """Pixels 64 apart, with 2^20 samples planned, would need more than 32 bits: their points are unrelated."""
    far, near = (sample(BLUE_NOISE, 64, pixel=pixel_numbers([x], [0])[0], planned=2**20) for x in (64, 0))
    assert len(np.unique(np.concatenate([far, near]), axis=0)) == 128
    assert abs(np.corrcoef(np.concatenate([far, near], axis=1).T)[0, 2]) < 0.5


@pytest.mark.parametrize("count", [1, 4, 16, 64, 100, 1024])
def test_regular_points_are_the_middles_of_cells(count):
    side = int(np.sqrt(count))
    found = np.sort(np.round(sample(REGULAR, count).astype(np.float64) * side - 0.5, 4) @ (side, 1))
    assert np.allclose(found, np.arange(count), atol=1e-3)


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


@pytest.mark.parametrize("dimension", [0, 7])
@pytest.mark.parametrize("pattern", EVERY)
def test_many_at_once_are_the_same_as_one_by_one_in_any_grouping(pattern, dimension):
    rng = np.random.default_rng(5)
    n = 333
    pixels = rng.integers(0, 2**20, n).astype(np.uint32)
    samples = rng.integers(0, 100, n).astype(np.uint32)
    u, v = np.full((2, n + 1), -1, np.float32)
    drawn(pattern, 3, pixels, samples, dimension, 100, n, u, v)
    assert u[n] == v[n] == -1
    alone = zip(pixels, samples, strict=True)
    single = np.concatenate(
        [sample(pattern, 1, pixel=p, seed=3, dimension=dimension, first=s, planned=100) for p, s in alone]
    )
    assert np.array_equal(np.stack([u[:n], v[:n]], 1), single)
    for start, size in ((0, 1), (5, 8), (100, 233)):
        a, b = np.zeros((2, size), np.float32)
        part = slice(start, start + size)
        drawn(pattern, 3, pixels[part].copy(), samples[part].copy(), dimension, 100, size, a, b)
        assert np.array_equal(a, u[part])
        assert np.array_equal(b, v[part])


def test_patterns_as_arrays_are_what_pixels_take():
    found = iso.sample_pattern("blue-noise", 5, size=(4, 3), dimension=2, seed=1)
    assert found.shape == (3, 4, 5, 2)
    assert np.array_equal(found[1, 3], sample(BLUE_NOISE, 5, pixel=pixel_numbers([3], [1])[0]))
    for settings in (("halton", 4), ("sobol", 0), ("sobol", 2.5), ("sobol", 2**21)):
        with pytest.raises(RenderError):
            iso.sample_pattern(*settings)
    with pytest.raises(RenderError, match="points"):
        iso.sample_pattern("sobol", 2**20, size=(100, 100))
    with pytest.raises(RenderError, match="dimension"):
        iso.sample_pattern("sobol", 1, dimension=-1)


def test_errors_of_neighbours_cancel():
    """The error of a picture of an integral has little power at low frequencies, where white noise has its share."""
    radius = np.hypot(np.fft.fftfreq(64)[:, None], np.fft.fftfreq(64)[None, :])
    low = radius < 1 / 8
    shares = {}
    for name in ("sobol", "blue-noise"):
        power = np.zeros((64, 64))
        for dimension in range(4):
            points = iso.sample_pattern(name, 4, size=(64, 64), dimension=dimension).astype(np.float64)
            value = (np.sin(3 * points[..., 0]) * np.exp(points[..., 1])).mean(axis=2)
            power += np.abs(np.fft.fft2(value - value.mean())) ** 2
        shares[name] = power[low].sum() / power.sum() / low.mean()
    assert 0.8 < shares["sobol"] < 1.2
    assert shares["blue-noise"] < 0.3


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
    assert max(errors[2:]) < errors[0] / 10
