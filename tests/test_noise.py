"""Noises beside their definitions in NumPy, and what is known of them: lattice, slopes, range, statistics."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import isophote as iso
import noise_oracle as oracle
from isophote.kernels.base.jit import kernel
from isophote.kernels.texture.perlin import perlin_at
from isophote.kernels.texture.simplex import simplex_at
from isophote.kernels.texture.value_noise import value_noise_at
from isophote.lower import procedural
from isophote.scene.noise import Noise

Floats = npt.NDArray[np.float32]

SEED = 0xC0FFEE42
RNG = np.random.default_rng(5)
PLACES = np.concatenate(
    [
        RNG.uniform(-6, 6, (3000, 3)),
        np.add(RNG.uniform(-6, 6, (1000, 3)), (1e4, -3e4, 2e4)),
        RNG.integers(-9, 9, (200, 3)),
    ]
).astype(np.float32)


def numbers(texture: iso.Texture, places: npt.ArrayLike = PLACES, **more: npt.ArrayLike) -> Floats:
    return iso.texture_values(texture, own=places, **more)[:, 0]


@kernel
def slopes_of_perlin(places, seed, out):
    for n in range(len(places)):
        out[n, 0], out[n, 1], out[n, 2], out[n, 3] = perlin_at(places[n, 0], places[n, 1], places[n, 2], seed)


@kernel
def slopes_of_simplex(places, seed, out):
    for n in range(len(places)):
        out[n, 0], out[n, 1], out[n, 2], out[n, 3] = simplex_at(places[n, 0], places[n, 1], places[n, 2], seed)


@kernel
def slopes_of_values(places, seed, out):
    for n in range(len(places)):
        out[n, 0], out[n, 1], out[n, 2], out[n, 3] = value_noise_at(places[n, 0], places[n, 1], places[n, 2], seed)


def test_value_noise_is_its_definition_bit_for_bit() -> None:
    np.testing.assert_array_equal(numbers(iso.ValueNoise(seed=SEED)), oracle.value_noise(PLACES, SEED))


def test_perlin_noise_is_its_definition_bit_for_bit() -> None:
    expected = np.clip(np.float32(0.5) + np.float32(0.5) * oracle.perlin(PLACES, SEED), 0, 1)
    np.testing.assert_array_equal(numbers(iso.PerlinNoise(seed=SEED)), expected)


def test_simplex_noise_is_the_sum_over_all_lattice_points() -> None:
    expected = 0.5 + 0.5 * oracle.simplex(PLACES, SEED)
    np.testing.assert_allclose(numbers(iso.SimplexNoise(seed=SEED)), expected, atol=2e-5)


@pytest.mark.parametrize("metric", ["euclidean", "manhattan", "chebyshev"])
@pytest.mark.parametrize("jitter", [1.0, 0.4])
def test_worley_noise_is_a_search_through_all_points(metric: str, jitter: float) -> None:
    places = RNG.uniform(-2, 2, (600, 3)).astype(np.float32)
    points, chance = oracle.features(-5, 5, SEED, jitter)
    distances = oracle.METRICS[metric](points[None] - places[:, None])
    order = np.argsort(distances, axis=1)[:, :2]
    f1, f2 = np.take_along_axis(distances, order, axis=1).T
    expected = {"f1": f1, "f2": f2, "f2-f1": f2 - f1, "cell": oracle.unit(chance[order[:, 0]])}
    for feature, values in expected.items():
        texture = iso.WorleyNoise(seed=SEED, feature=feature, metric=metric, jitter=jitter)
        np.testing.assert_allclose(numbers(texture, places), np.minimum(values, 1), atol=2e-6, err_msg=feature)


@pytest.mark.parametrize("slopes", [slopes_of_perlin, slopes_of_simplex, slopes_of_values])
def test_slopes_are_those_of_finite_differences(slopes: Any) -> None:
    places = RNG.uniform(-4, 4, (400, 3)).astype(np.float32)
    out, ahead, behind = (np.empty((len(places), 4), np.float32) for _ in range(3))
    slopes(places, np.uint32(SEED), out)
    for axis in range(3):
        step = np.zeros(3, np.float32)
        step[axis] = 2.0**-7
        slopes(places + step, np.uint32(SEED), ahead)
        slopes(places - step, np.uint32(SEED), behind)
        measured = (ahead[:, 0] - behind[:, 0]) / (2 * 2.0**-7)
        np.testing.assert_allclose(out[:, 1 + axis], measured, atol=6e-3)


def test_perlin_noise_is_a_half_at_lattice_points() -> None:
    whole = RNG.integers(-1000, 1000, (500, 3)).astype(np.float32)
    np.testing.assert_array_equal(numbers(iso.PerlinNoise(seed=9), whole), 0.5)


def test_value_noise_is_even_at_lattice_points() -> None:
    whole = RNG.integers(-1000, 1000, (20_000, 3)).astype(np.float32)
    found = np.sort(numbers(iso.ValueNoise(seed=9), whole))
    # Kolmogorov and Smirnov: 1.95 / √n is passed by chance once in a thousand.
    assert np.abs(found - np.arange(len(found)) / len(found)).max() < 1.95 / np.sqrt(len(found))


@pytest.mark.parametrize("noise", [iso.ValueNoise, iso.PerlinNoise, iso.SimplexNoise])
def test_noise_has_no_jumps(noise: type[Noise]) -> None:
    line = np.linspace((-3, -2, -1), (3.1, 2.7, 1.9), 200_001).astype(np.float32)
    assert np.abs(np.diff(numbers(noise(seed=4), line))).max() < 2e-4


@pytest.mark.parametrize("noise", [iso.ValueNoise, iso.PerlinNoise, iso.SimplexNoise, iso.WorleyNoise])
def test_seeds_sizes_and_places_make_patterns_apart(noise: type[Noise]) -> None:
    places = RNG.uniform(-50, 50, (40_000, 3)).astype(np.float32)
    base = numbers(noise(seed=1), places)
    others = [numbers(noise(seed=2), places), numbers(noise(seed=1), places + np.float32(256))]
    others.append(numbers(noise(seed=1), places + np.float32((0, 4096, 0))))
    for other in others:
        assert abs(np.corrcoef(base, other)[0, 1]) < 0.025
    np.testing.assert_array_equal(numbers(noise(seed=1, size=4.0), places * np.float32(4)), base)


def test_statistics_that_fading_relies_on() -> None:
    places = RNG.uniform(-200, 200, (300_000, 3)).astype(np.float32)
    for noise, (turbulent, ridged, _) in procedural._SIGNED.items():
        signed = 2 * numbers(noise(seed=6), places).astype(np.float64) - 1
        assert abs(np.abs(signed).mean() - turbulent) < 2e-3
        assert abs(((1 - np.abs(signed)) ** 2).mean() - ridged) < 2e-3
        if noise is not iso.WorleyNoise:
            assert abs(signed.mean()) < 3e-3
    for metric, means in procedural._MEANS.items():
        for feature, mean in means.items():
            found = numbers(iso.WorleyNoise(seed=6, metric=metric, feature=feature), places)
            assert abs(found.mean(dtype=np.float64) - mean) < 2e-3


FADING = [
    *(noise() for noise in (iso.ValueNoise, iso.PerlinNoise, iso.SimplexNoise)),
    *(iso.WorleyNoise(feature=feature) for feature in ("f1", "f2", "f2-f1", "cell")),
    *(iso.Fbm(noise(), 1, kind="turbulence") for noise in (iso.ValueNoise, iso.PerlinNoise, iso.SimplexNoise)),
]


@pytest.mark.parametrize("texture", FADING, ids=repr)
def test_noise_fades_as_its_mean_over_a_square_does(texture: iso.Texture) -> None:
    """How much of it is left is the slope of the line that tells means over squares best from values."""
    count = 40_000
    places = RNG.uniform(-200, 200, (count, 3))
    a = RNG.normal(size=(count, 3))
    a /= np.linalg.norm(a, axis=1, keepdims=True)
    b = np.cross(a, RNG.normal(size=(count, 3)))
    b /= np.linalg.norm(b, axis=1, keepdims=True)
    sharp = numbers(texture, places).astype(np.float64)
    for width in (0.5, 1.0, 1.5, 2.5):
        offsets = RNG.uniform(-width / 2, width / 2, (2, count, 1))
        within = numbers(texture, places + a * offsets[0] + b * offsets[1]).astype(np.float64)
        left = np.cov(sharp, within)[0, 1] / sharp.var()
        axes = np.stack([a, b], axis=1) * width / 2
        faded = np.cov(sharp, numbers(texture, places, own_axes=axes).astype(np.float64))[0, 1] / sharp.var()
        assert abs(faded - left) < 0.16


@pytest.mark.parametrize("texture", FADING, ids=repr)
def test_noise_seen_from_afar_is_its_mean(texture: iso.Texture) -> None:
    axes = np.array([[0, 8.0, 0], [3.0, 0, 0]])
    far = numbers(texture, own_axes=axes)
    assert np.ptp(far) == 0
    assert abs(far[0] - numbers(texture, RNG.uniform(-90, 90, (100_000, 3))).mean(dtype=np.float64)) < 4e-3


@pytest.mark.parametrize(
    ("noise", "low", "high"),
    [(iso.ValueNoise(), 0.0, 1.4), (iso.PerlinNoise(), 0.25, 1.6), (iso.SimplexNoise(), 0.4, 2.2)],
    ids=["value", "perlin", "simplex"],
)
def test_noise_has_one_band_of_frequencies(noise: Noise, low: float, high: float) -> None:
    """In periods a cell, of its spectrum in space: the octaves of sums are then told apart by their sizes."""
    samples, cells = 72, 14
    axis = np.arange(samples) * (cells / samples) + 0.123
    grid = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1)
    values = numbers(noise, grid.reshape(-1, 3)).reshape(grid.shape[:3]).astype(np.float64)
    window = np.hanning(samples)
    windowed = (values - values.mean()) * window[:, None, None] * window[:, None] * window
    power = np.abs(np.fft.fftn(windowed)) ** 2
    frequency = np.fft.fftfreq(samples, cells / samples)
    radius = np.sqrt((np.stack(np.meshgrid(frequency, frequency, frequency)) ** 2).sum(axis=0))
    assert power[radius > high].sum() < 0.01 * power.sum()
    assert power[radius < low].sum() < 0.08 * power.sum()
