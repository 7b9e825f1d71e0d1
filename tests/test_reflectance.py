"""The contract of all materials: reciprocity, energy, samplers and densities, single directions."""

from __future__ import annotations

import numpy as np
import pytest

import isophote as iso
from reflectances import ALL, GLASSES, MATTE_OR_GLOSSY, SINGLE, WHITE, direction, disk_points, probe, sphere_grid
from statistics_of_samples import deviation

ANGLES = (0.0, 0.7, 1.2, 1.45)


def random_directions(count: int, seed: int) -> np.ndarray:
    """Unit vectors above the surface, not quite along it."""
    v = np.random.default_rng(seed).normal(size=(count, 3))
    v[:, 2] = np.abs(v[:, 2]) + 0.05
    return v / np.linalg.norm(v, axis=1, keepdims=True)


@pytest.mark.parametrize("name", MATTE_OR_GLOSSY)
def test_reciprocity(name: str) -> None:
    out, into = random_directions(2000, 1), random_directions(2000, 2)
    there = probe(MATTE_OR_GLOSSY[name]).evaluate(out, into).value / into[:, 2:]
    back = probe(MATTE_OR_GLOSSY[name]).evaluate(into, out).value / out[:, 2:]
    assert there.min() >= 0
    np.testing.assert_allclose(there, back, rtol=2e-3, atol=1e-6)


@pytest.mark.parametrize("name", GLASSES)
def test_reciprocity_of_glass(name: str) -> None:
    """f(out, into) / n_into² is the same both ways, where n is the index on the side of a direction (Veach, 1997)."""
    material = GLASSES[name]
    out, into = random_directions(4000, 1), random_directions(4000, 2)
    below = into * (1, 1, -1)
    there = probe(material).evaluate(out, below).value / into[:, 2:]
    back = probe(material).evaluate(below, out).value / out[:, 2:]
    np.testing.assert_allclose(there * material.ior**2, back, rtol=2e-3, atol=1e-6)
    assert there.any()
    for side in (1, -1):
        a, b = out * (1, 1, side), into * (1, 1, side)
        there = probe(material).evaluate(a, b).value / into[:, 2:]
        np.testing.assert_allclose(there, probe(material).evaluate(b, a).value / out[:, 2:], rtol=2e-3, atol=1e-6)


def reflected(material: iso.Material, out: np.ndarray) -> np.ndarray:
    """What of light from `out` leaves, by quadrature and by single directions; radiance squeezed by glass counts by its
    power."""
    grid, cell = sphere_grid(512, 512)
    found = probe(material)
    value = found.evaluate(out, grid).value.astype(np.float64)
    total = (_power(material, out, grid, value) * cell[:, None]).sum(axis=0)
    for k in range(found.branches):
        one = found.branch(out, k)
        total += _power(material, out, one.into, one.value)[0]
    return total


def _power(material: iso.Material, out: np.ndarray, into: np.ndarray, value: np.ndarray) -> np.ndarray:
    ior = getattr(material, "ior", 1.0) if isinstance(material, iso.Glass) else 1.0
    through = (into[:, 2] * out[2] < 0)[:, None]
    return np.where(through, value * (ior**2 if out[2] > 0 else ior**-2), value)


@pytest.mark.parametrize("angle", ANGLES)
@pytest.mark.parametrize("name", [name for name in ALL if name != "mix of glass and mirror"])
def test_no_more_light_leaves_than_comes(name: str, angle: float) -> None:
    for side in (0.0, np.pi) if isinstance(ALL[name], iso.Glass) else (0.0,):
        total = reflected(ALL[name], direction(abs(side - angle), 0.4))
        assert (total > 0.03).all()
        # The quadrature's own error.
        assert total.max() < 1.003


@pytest.mark.parametrize("angle", ANGLES)
@pytest.mark.parametrize("name", WHITE)
def test_white_furnace(name: str, angle: float) -> None:
    """What is white and loses nothing, gives back just what comes."""
    sample = probe(WHITE[name]).sample(direction(angle, 0.3), disk_points(250_000))
    weight = sample.value[:, 0].astype(np.float64)
    error = weight.std() / np.sqrt(len(weight))
    # The tables of what facets reflect are good to 0.3 %.
    assert abs(weight.mean() - 1) < 0.003 + 4 * error


@pytest.mark.parametrize("angle", ANGLES)
@pytest.mark.parametrize("name", ALL)
def test_samples_have_the_density_that_is_told(name: str, angle: float) -> None:
    """Chi-square over cells of the sphere; those that are lost, or go to single directions, count as one cell more."""
    count, rows, columns, fine = 160_000, 24, 32, 12
    out, found = direction(angle, 0.5), probe(ALL[name])
    points = np.random.default_rng(4).random((count, 3))
    radius, phi = np.sqrt(points[:, 0]), 2 * np.pi * points[:, 1]
    points[:, 0], points[:, 1] = radius * np.cos(phi), radius * np.sin(phi)
    points[:, 2] = np.minimum(points[:, 2], 1 - 2.0**-24)
    sample = found.sample(out, points)
    counted = (sample.density > 0) & sample.value.any(axis=1)
    into = sample.into[counted].astype(np.float64)
    row = np.clip(((1 - np.arccos(np.clip(into[:, 2], -1, 1)) / np.pi) * rows).astype(int), 0, rows - 1)
    column = (np.arctan2(into[:, 1], into[:, 0]) % (2 * np.pi) / (2 * np.pi) * columns).astype(int) % columns
    observed = np.bincount(row * columns + column, minlength=rows * columns)
    grid, cell = sphere_grid(rows * fine, columns * fine)
    density = found.evaluate(out, grid).density.astype(np.float64) * cell * count
    expected = density.reshape(rows, fine, columns, fine).sum(axis=(1, 3)).reshape(-1)
    # A cell of the grid is known to what the quadrature makes of its density.
    lost = count - expected.sum()
    assert lost > -0.004 * count
    assert abs((count - counted.sum()) - lost) < 6 * np.sqrt(count * 0.25) / 4 + 0.004 * count
    if expected.sum() > 0.01 * count:
        scaled = expected * observed.sum() / expected.sum()
        assert deviation(observed, scaled) < 5


@pytest.mark.parametrize("name", ALL)
def test_weights_are_values_over_densities(name: str) -> None:
    found = probe(ALL[name])
    out = np.concatenate([random_directions(3000, 5), random_directions(3000, 6) * (1, 1, -1)])
    sample = found.sample(out, disk_points(6084)[:6000])
    counted = (sample.density > 0) & sample.value.any(axis=1)
    told = found.evaluate(out[counted], sample.into[counted])
    np.testing.assert_allclose(told.density, sample.density[counted], rtol=5e-3)
    np.testing.assert_allclose(told.value, (sample.value * sample.density[:, None])[counted], rtol=5e-3, atol=1e-6)
    assert np.isfinite(sample.value).all()


@pytest.mark.parametrize("name", SINGLE)
def test_single_directions_are_sampled_by_their_share(name: str) -> None:
    """The mean weight of samples in each single direction is the share of that branch."""
    found, out = probe(SINGLE[name]), direction(0.8, 0.5)
    sample = found.sample(out, disk_points(160_000))
    single = (sample.density == 0) & sample.value.any(axis=1)
    met = np.zeros(len(single), bool)
    for k in range(found.branches):
        branch = found.branch(out, k)
        here = single & (np.abs(sample.into - branch.into[0]).max(axis=1) < 1e-4)
        same = [found.branch(out, j) for j in range(found.branches)]
        share = sum(one.value[0] for one in same if np.abs(one.into - branch.into).max() < 1e-4)
        np.testing.assert_allclose((sample.value * here[:, None]).mean(axis=0), share, rtol=0.02)
        met |= here
    assert (met == single).all()
    assert found.branches > 0


def test_glossy_kinds_have_no_single_directions() -> None:
    for material in (MATTE_OR_GLOSSY | GLASSES).values():
        assert probe(material).branches == 0
        assert probe(material).scatters


def test_directions_along_the_surface_are_finite() -> None:
    flat = direction(np.pi / 2 - 1e-7, 0.2)
    for material in ALL.values():
        sample = probe(material).sample(flat, disk_points(2500))
        assert np.isfinite(sample.value).all()
        assert np.isfinite(probe(material).evaluate(flat, sample.into).value).all()
