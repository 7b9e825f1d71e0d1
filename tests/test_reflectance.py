"""The contract of all materials: reciprocity, energy, samplers and densities, single directions."""

from __future__ import annotations

import numpy as np
import pytest

import isophote as iso
from isophote.checks.check import mean_of
from isophote.checks.materials import WHITE, probe_of
from isophote.checks.scatter import (
    direction,
    disk_points,
    fit_sampler,
    reciprocity_gap,
    reflected_power,
    sampled_power,
    upper_directions,
)
from isophote.lower.probe import Probe, Scattered
from reflectances import ALL, GLASSES, MATTE_OR_GLOSSY, SINGLE

ANGLES = (0.0, 0.7, 1.2, 1.45)


def generator(seed: int) -> np.random.Generator:
    return np.random.default_rng(seed)


@pytest.mark.parametrize("name", MATTE_OR_GLOSSY | GLASSES)
def test_reciprocity(name: str) -> None:
    material = (MATTE_OR_GLOSSY | GLASSES)[name]
    # Single precision is worst where light is only just refracted.
    allowed = 2e-3 if name in GLASSES else 2e-4
    assert reciprocity_gap(material, probe_of(material), 4000, generator(1)) < allowed


def test_what_is_not_reciprocal_or_sampled_otherwise_is_found() -> None:
    material = iso.Glass(1.5, roughness=0.6)
    true = probe_of(material)
    # Light through the boundary without its squeeze.
    assert reciprocity_gap(iso.Glass(1.4, roughness=0.6), true, 1000, generator(1)) > 0.1
    grazing = iso.Plastic("red", 0.5)
    tilted = Tilted(probe_of(grazing))
    assert reciprocity_gap(grazing, tilted, 1000, generator(1)) > 0.05  # type: ignore[arg-type]
    assert fit_sampler(tilted, direction(0.7), 160_000, generator(1)).deviation > 5  # type: ignore[arg-type]


class Tilted:
    """A probe whose values and densities are brighter to one side."""

    def __init__(self, true: Probe) -> None:
        self._true = true

    def evaluate(self, out: np.ndarray, into: np.ndarray) -> Scattered:
        found, tilt = self._true.evaluate(out, into), 1 + 0.1 * np.atleast_2d(into)[:, 0]
        return Scattered(found.into, found.value * tilt[:, None], found.density * tilt)

    def sample(self, out: np.ndarray, points: np.ndarray) -> Scattered:
        return self._true.sample(out, points)


@pytest.mark.parametrize("angle", ANGLES)
@pytest.mark.parametrize("name", [name for name in ALL if name != "mix of glass and mirror"])
def test_no_more_light_leaves_than_comes(name: str, angle: float) -> None:
    for side in (0.0, np.pi) if isinstance(ALL[name], iso.Glass) else (0.0,):
        total = reflected_power(ALL[name], probe_of(ALL[name]), direction(abs(side - angle), 0.4))
        assert (total > 0.03).all()
        # The quadrature's own error.
        assert total.max() < 1.003


@pytest.mark.parametrize("angle", ANGLES)
@pytest.mark.parametrize("name", WHITE)
def test_white_furnace(name: str, angle: float) -> None:
    """What is white and loses nothing, gives back just what comes."""
    power = sampled_power(WHITE[name], probe_of(WHITE[name]), direction(angle, 0.3), 2**18)[:, 0]
    # The tables of what facets reflect are good to 0.3 %.
    assert mean_of(power, 1, 0.003).passed


@pytest.mark.parametrize("angle", ANGLES)
@pytest.mark.parametrize("name", ALL)
def test_samples_have_the_density_that_is_told(name: str, angle: float) -> None:
    """Chi-square over cells of the sphere; those that are lost, or go to single directions, count as one cell more."""
    count = 160_000
    fit = fit_sampler(probe_of(ALL[name]), direction(angle, 0.5), count, generator(4))
    assert fit.untold > -0.004
    assert abs(fit.lost - fit.untold) < 1.5 * np.sqrt(0.25 / count) + 0.004
    assert fit.deviation < 5


@pytest.mark.parametrize("name", ALL)
def test_weights_are_values_over_densities(name: str) -> None:
    found = probe_of(ALL[name])
    out = np.concatenate([upper_directions(3000, generator(5)), upper_directions(3000, generator(6)) * (1, 1, -1)])
    sample = found.sample(out, disk_points(6084)[:6000])
    counted = (sample.density > 0) & sample.value.any(axis=1)
    told = found.evaluate(out[counted], sample.into[counted])
    np.testing.assert_allclose(told.density, sample.density[counted], rtol=5e-3)
    np.testing.assert_allclose(told.value, (sample.value * sample.density[:, None])[counted], rtol=5e-3, atol=1e-6)
    assert np.isfinite(sample.value).all()


@pytest.mark.parametrize("name", SINGLE)
def test_single_directions_are_sampled_by_their_share(name: str) -> None:
    """The mean weight of samples in each single direction is the share of that branch."""
    found, out = probe_of(SINGLE[name]), direction(0.8, 0.5)
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
        assert probe_of(material).branches == 0
        assert probe_of(material).scatters


def test_directions_along_the_surface_are_finite() -> None:
    flat = direction(np.pi / 2 - 1e-7, 0.2)
    for material in ALL.values():
        sample = probe_of(material).sample(flat, disk_points(2500))
        assert np.isfinite(sample.value).all()
        assert np.isfinite(probe_of(material).evaluate(flat, sample.into).value).all()
