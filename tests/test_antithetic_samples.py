"""The antithetic pattern on the film: a point in every cell, mirrored from cell to cell, and better at edges."""

from __future__ import annotations

import numpy as np
import pytest

import isophote as iso
from isophote.errors import RenderError

COUNTS = (1, 2, 4, 8, 16, 32, 64, 256)


def film(samples: int, pattern: str = "antithetic", **settings: int) -> np.ndarray:
    """(1024, samples, 2): places in 32 × 32 pixels."""
    found = iso.sample_pattern(pattern, samples, size=(32, 32), **settings)
    return found.reshape(1024, samples, 2).astype(np.float64)


def grid(samples: int) -> tuple[int, int]:
    """Columns and rows: as many, or twice as many columns."""
    columns = 2 ** -(-(samples.bit_length() - 1) // 2)
    return columns, samples // columns


@pytest.mark.parametrize("samples", COUNTS)
def test_every_cell_has_a_point(samples: int) -> None:
    columns, rows = grid(samples)
    cells = np.floor(film(samples) * (columns, rows)).astype(int)
    numbers = np.sort(cells[..., 0] + columns * cells[..., 1], axis=1)
    # A point within rounding of a line between cells may count for the next one.
    assert (numbers == np.arange(samples)).all(axis=1).sum() >= len(numbers) - 2


@pytest.mark.parametrize("samples", [s for s in COUNTS if s > 2])
def test_neighbouring_rows_and_columns_are_mirror_images(samples: int) -> None:
    columns, rows = grid(samples)
    for places in film(samples)[:50]:
        cells, within = np.divmod(places * (columns, rows), 1)
        order = np.lexsort(cells.T)
        across = within[order, 0].reshape(rows, columns)
        along = within[order, 1].reshape(rows, columns)
        assert np.ptp(across, axis=1).max() < 1e-5
        assert np.ptp(along, axis=0).max() < 1e-5
        assert np.allclose(across[::2] + across[1::2], 1, atol=1e-5)
        assert np.allclose(along[:, ::2] + along[:, 1::2], 1, atol=1e-5)


def test_the_first_samples_of_many_are_spread() -> None:
    """Any first 4 or 16 of 64 planned lie in as many quarters and sixteenths."""
    for first in (4, 16):
        side = int(first**0.5)
        cells = np.floor(film(64)[:, :first] * side).astype(int)
        numbers = np.sort(cells[..., 0] + side * cells[..., 1], axis=1)
        assert (numbers == np.arange(first)).all(axis=1).sum() >= len(numbers) - 2


@pytest.mark.parametrize(("samples", "which"), [(1, 0), (4, 0), (16, 0), (16, 7), (64, 3), (12, 11)])
def test_each_sample_is_uniform_over_the_pixel(samples: int, which: int) -> None:
    """Chi-square over 8 by 8 cells for one sample of many pixels and seeds: the mean of any integrand is right."""
    places = np.concatenate([film(samples, seed=seed)[:, which] for seed in range(12)])
    cells = np.histogram2d(*places.T, bins=8, range=[[0, 1], [0, 1]])[0]
    expected = len(places) / 64
    # 63 degrees of freedom: above 117 with a chance of 10⁻⁴ (points that are shared out lie below).
    assert ((cells - expected) ** 2 / expected).sum() < 117


def test_samples_beyond_those_planned_are_new() -> None:
    scene = iso.Scene([iso.Item(iso.sphere(1))], [iso.Sky()], iso.Camera((0, 0, 4), (0, 0, 0)))
    picture = iso.render(scene, iso.PathTrace(seconds=0.1, pattern="antithetic"), size=(8, 8), progress=False)
    assert np.isfinite(picture.channels["colour"]).all()


def test_other_dimensions_and_great_numbers_are_blue_noise() -> None:
    for dimension in (1, 2, 7):
        assert np.array_equal(film(16, dimension=dimension), film(16, "blue-noise", dimension=dimension))
    many = [iso.sample_pattern(name, 8192, size=(2, 2)) for name in ("antithetic", "blue-noise")]
    assert np.array_equal(*many)
    with pytest.raises(RenderError, match="pattern must be"):
        iso.sample_pattern("mirrored", 4)


def errors_at_edges(samples: int, pattern: str, edges: np.ndarray, areas: np.ndarray) -> float:
    """RMS over half-planes and pixels of the share of samples beside what lies within the pixel."""
    places = film(samples, pattern)[::8]
    inside = places @ edges[:, :2].T < edges[:, 2]
    return float(np.sqrt(np.mean((inside.mean(axis=1) - areas) ** 2)))


def half_planes(count: int) -> tuple[np.ndarray, np.ndarray]:
    """(n, 3) normals and distances of half-planes whose edges cross the unit square, and areas within it, by the fine
    grid's middles."""
    rng = np.random.default_rng(3)
    turn = rng.uniform(0, 2 * np.pi, count)
    normals = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    distances = normals @ (0.5, 0.5) + rng.uniform(-0.7, 0.7, count)
    middles = (np.arange(400) + 0.5) / 400
    points = np.stack(np.meshgrid(middles, middles), axis=-1).reshape(-1, 2)
    areas = np.array([(points @ n < d).mean() for n, d in zip(normals, distances, strict=True)])
    return np.column_stack([normals, distances]), areas


def test_edges_have_smaller_errors_than_with_sobol_points() -> None:
    edges, areas = half_planes(300)
    for samples, least in ((4, 0.96), (16, 0.94), (64, 0.93)):
        antithetic, sobol = (errors_at_edges(samples, name, edges, areas) for name in ("antithetic", "sobol"))
        assert antithetic < least * sobol


def test_slopes_have_no_error_at_all() -> None:
    """What is linear over the pixel cancels between mirror images, whatever the places are."""
    for samples in (4, 16, 64):
        places = film(samples)
        assert np.abs((0.3 * places[..., 0] + 0.6 * places[..., 1]).mean(axis=1) - 0.45).max() < 1e-5
