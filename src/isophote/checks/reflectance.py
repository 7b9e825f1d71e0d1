"""Every material: reciprocal, no brighter than what lights it, sampled as it tells; white ones lose nothing."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial

from isophote.checks.check import Check, Effort, Measured, farthest, mean_of
from isophote.checks.materials import MATERIALS, WHITE, material_of, probe_of
from isophote.checks.scatter import direction, fit_sampler, reciprocity_gap, reflected_power, sampled_power
from isophote.scene.material import Glass

__all__ = ["CHECKS"]

_ANGLES = (0.0, 0.7, 1.2, 1.45)
_TURN = 0.4
_PAIRS, _SAMPLES, _DIRECTIONS = 2000, 2**18, 100_000
# What single precision makes of both ways, at worst where light is only just refracted, and what quadrature, and tables
# of what facets reflect, are good to.
_ROUNDING, _REFRACTED, _QUADRATURE, _TABLES = 2e-4, 2e-3, 1e-3, 3e-3
# Of 768 cells: once in 3 million times.
_DEVIATIONS = 5.0


def _reciprocity(name: str, effort: Effort) -> Measured:
    material = material_of(name)
    gap = reciprocity_gap(material, probe_of(material), effort.samples(_PAIRS), effort.generator())
    return Measured(gap, 0, _REFRACTED if isinstance(material, Glass) else _ROUNDING, at_most=True)


def _most_power(name: str, effort: Effort) -> Measured:
    material, cells = material_of(name), 256 if effort.factor == 1 else 512
    most = [reflected_power(material, probe_of(material), direction(a, _TURN), cells).max() for a in _ANGLES]
    return Measured(float(max(most)), 1, _TABLES, at_most=True)


def _sampled_power(name: str, effort: Effort) -> Measured:
    material, out = material_of(name), direction(0.7, _TURN)
    exact = reflected_power(material, probe_of(material), out)
    power = sampled_power(material, probe_of(material), out, effort.samples(_SAMPLES), effort.seed)
    return farthest(mean_of(power[:, k], exact[k], _QUADRATURE) for k in range(3))


def _sampler(name: str, effort: Effort) -> Measured:
    material, generator = material_of(name), effort.generator()
    samples = effort.samples(_DIRECTIONS)
    most = max(fit_sampler(probe_of(material), direction(a, 0.5), samples, generator).deviation for a in _ANGLES)
    return Measured(most, 0, _DEVIATIONS, at_most=True)


def _furnace(name: str, effort: Effort) -> Measured:
    """The angle at which what comes back is farthest from all of it."""
    material, samples = WHITE[name], effort.samples(_SAMPLES)
    powers = (sampled_power(material, probe_of(material), direction(a, 0.3), samples, effort.seed) for a in _ANGLES)
    return farthest(mean_of(power[:, 0], 1, _TABLES) for power in powers)


# They send light to single directions alone: there is no density, and no pair of directions to turn round.
_SINGLE = ("Mirror", "Metal, smooth", "Glass, smooth", "ThinGlass")


def _each(law: str, names: Iterable[str], measure: Callable[[str, Effort], Measured]) -> list[Check]:
    return [Check(f"materials: {law}", name, partial(measure, name)) for name in names]


_SCATTERING = [name for name in MATERIALS if name not in _SINGLE]
CHECKS = [
    *_each("reciprocity, largest |f(a, b) − f(b, a)| in parts of f", _SCATTERING, _reciprocity),
    *_each("energy, largest share of light that leaves", MATERIALS, _most_power),
    *_each("white furnace, share of light that white gives back", WHITE, _furnace),
    *_each("samplers, mean weight against quadrature", MATERIALS, _sampled_power),
    *_each("samplers, χ² of directions in standard deviations", _SCATTERING, _sampler),
]
