"""What a material's reflectance must obey: reciprocity, energy, and samplers that do what they tell."""

from __future__ import annotations

import math
from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.checks.statistics import chi_square_deviation
from isophote.lower.probe import Probe
from isophote.scene.material import Glass
from isophote.scene.material_base import Material

__all__ = [
    "SamplerFit",
    "direction",
    "disk_points",
    "fit_sampler",
    "reciprocity_gap",
    "reflected_power",
    "sampled_power",
    "sphere_grid",
    "upper_directions",
]

Floats: TypeAlias = npt.NDArray[np.float64]

# Of reflectances below this part of 1 / sr, differences are not relative.
_FAINT = 5e-3
# Cells of the sphere for chi-square, and parts of each along both sides over which densities are summed.
_ROWS, _COLUMNS, _FINE = 24, 32, 12
_BATCHES = 64


class SamplerFit(NamedTuple):
    """How a sampler's directions lie: `deviation` of their chi-square from its mean, in standard deviations, `lost` the
    part of the samples that went nowhere or to single directions, and `untold` what densities leave for those."""

    deviation: float
    lost: float
    untold: float


def direction(theta: float, phi: float = 0.0) -> Floats:
    """The unit vector at these angles from z and from x."""
    return np.array([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])


def upper_directions(count: int, generator: np.random.Generator) -> Floats:
    """(count, 3) unit vectors above the surface, not quite along it."""
    v = generator.normal(size=(count, 3))
    v[:, 2] = np.abs(v[:, 2]) + 0.05
    unit: Floats = v / np.linalg.norm(v, axis=1, keepdims=True)
    return unit


def sphere_grid(rows: int, columns: int) -> tuple[Floats, Floats]:
    """(rows · columns, 3) directions over the whole sphere, and the solid angle (rows · columns,) that each stands for.

    Rows go from z = −1 up in even steps of the angle to the z axis.
    """
    edges = np.linspace(np.pi, 0, rows + 1)
    theta = (edges[1:] + edges[:-1]) / 2
    phi = 2 * np.pi * (np.arange(columns) + 0.5) / columns
    theta, phi = (a.reshape(-1) for a in np.meshgrid(theta, phi, indexing="ij"))
    angles = np.repeat(np.diff(np.cos(edges)), columns) * 2 * np.pi / columns
    return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], 1), angles


def disk_points(count: int, seed: int = 1) -> Floats:
    """(side², 3), side² ≤ count: points of the unit disk, and a number from 0 to 1 each; jittered, so that means are
    tight."""
    side = math.isqrt(count)
    rng = np.random.default_rng(seed)
    cells = np.stack(np.meshgrid(np.arange(side), np.arange(side)), 2).reshape(-1, 2)
    u, v = ((cells + rng.random(cells.shape)) / side).T
    pick = (rng.permutation(side * side) + rng.random(side * side)) / (side * side)
    return _on_disk(u, v, pick)


def _on_disk(u: Floats, v: Floats, pick: Floats) -> Floats:
    r = np.sqrt(u)
    return np.stack([r * np.cos(2 * np.pi * v), r * np.sin(2 * np.pi * v), np.minimum(pick, 1 - 2.0**-24)], 1)


# --- reciprocity and energy -----------------------------------------------------------------------


def reciprocity_gap(material: Material, probe: Probe, pairs: int, generator: np.random.Generator) -> float:
    """The largest difference between f(a, b) and f(b, a) over random pairs, in parts of them.

    Through a boundary f / n² is the same both ways, n the index on the side that light goes to (Veach, 1997, section
    5.2). Where f is below 5e-3 / sr, the difference is in parts of that.
    """
    a, b = upper_directions(pairs, generator), upper_directions(pairs, generator)
    sides = [(1, 1), (1, -1), (-1, -1)] if isinstance(material, Glass) else [(1, 1)]
    gaps = []
    for first, second in sides:
        out, into = a * (1, 1, first), b * (1, 1, second)
        there = probe.evaluate(out, into).value / np.abs(into[:, 2:])
        back = probe.evaluate(into, out).value / np.abs(out[:, 2:])
        there = there * (_squeeze(material) if first != second else 1.0)
        gaps.append(float((np.abs(there - back) / (np.maximum(there, back) + _FAINT)).max()))
    return max(gaps)


def _squeeze(material: Material) -> float:
    """By how much radiance is squeezed together inside the surface, n²."""
    return material.ior**2 if isinstance(material, Glass) else 1.0


def _power(material: Material, out: Floats, into: npt.NDArray[np.float32], value: Floats) -> Floats:
    """Radiance that was squeezed by glass, by its power."""
    squeeze = _squeeze(material)
    through = (into[:, 2] * out[2] < 0)[:, None]
    return np.where(through, value * (squeeze if out[2] > 0 else 1 / squeeze), value)


def reflected_power(material: Material, probe: Probe, out: Floats, cells: int = 512) -> Floats:
    """(3,): the part of light from `out` that leaves the surface, ∫ f |cosθ| dω by quadrature over cells² directions,
    and single directions; transmitted light included."""
    grid, angles = sphere_grid(cells, cells)
    value = probe.evaluate(out, grid).value.astype(np.float64)
    total: Floats = (_power(material, out, grid.astype(np.float32), value) * angles[:, None]).sum(axis=0)
    for k in range(probe.branches):
        one = probe.branch(out, k)
        total += _power(material, out, one.into, one.value.astype(np.float64))[0]
    return total


def sampled_power(material: Material, probe: Probe, out: Floats, samples: int, seed: int = 1) -> Floats:
    """(64, 3): mean weights of 64 batches of jittered samples, about `samples` in all; the mean is `reflected_power`.

    Batches are independent, so that they tell the error of their mean, which jittering makes small.
    """
    means = []
    for batch in range(_BATCHES):
        points = disk_points(samples // _BATCHES, seed * _BATCHES + batch)
        found = probe.sample(out, points)
        means.append(_power(material, out, found.into, found.value.astype(np.float64)).mean(axis=0))
    return np.array(means)


# --- samplers -------------------------------------------------------------------------------------


def fit_sampler(probe: Probe, out: Floats, samples: int, generator: np.random.Generator) -> SamplerFit:
    """Count samples in 24 × 32 cells of the sphere, and compare with the density that is told."""
    points = generator.random((samples, 3))
    sample = probe.sample(out, _on_disk(points[:, 0], points[:, 1], points[:, 2]))
    counted = (sample.density > 0) & sample.value.any(axis=1)
    into = sample.into[counted].astype(np.float64)
    row = np.clip(((1 - np.arccos(np.clip(into[:, 2], -1, 1)) / np.pi) * _ROWS).astype(int), 0, _ROWS - 1)
    column = (np.arctan2(into[:, 1], into[:, 0]) % (2 * np.pi) / (2 * np.pi) * _COLUMNS).astype(int) % _COLUMNS
    observed = np.bincount(row * _COLUMNS + column, minlength=_ROWS * _COLUMNS)
    grid, cell = sphere_grid(_ROWS * _FINE, _COLUMNS * _FINE)
    density = probe.evaluate(out, grid).density.astype(np.float64) * cell * samples
    expected = density.reshape(_ROWS, _FINE, _COLUMNS, _FINE).sum(axis=(1, 3)).reshape(-1)
    untold = 1 - expected.sum() / samples
    deviation = 0.0
    if expected.sum() > 0.01 * samples:
        # A cell of the grid is known to what the quadrature makes of its density.
        deviation = chi_square_deviation(observed, expected * observed.sum() / expected.sum())
    return SamplerFit(deviation, 1 - counted.sum() / samples, float(untold))
