"""Any isotropic material as a table of measured reflectance."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.errors import RenderError
from isophote.lower.probe import Probe
from isophote.scene.material_base import Material
from isophote.scene.measured import MEASURED_SHAPE, Measured

__all__ = ["measure_brdf"]

Directions: TypeAlias = npt.NDArray[np.float64]

# Cells that lie below the horizon hold what is seen from just above it, so that those next to them can be interpolated.
_HORIZON = 0.02


def measure_brdf(material: Material, name: str | None = None) -> Measured:
    """The table that measuring a material in all directions would give, without noise.

    The material is turned as its tangent lies: anisotropic ones are measured with the half direction along it. Light
    that goes through, or to single directions only, is not in the table. Raises `RenderError` where there is no other.
    """
    if not isinstance(material, Material):
        raise RenderError(f"measure_brdf: give a material, such as a Metal, not {material!r}")
    probe = Probe(material)
    if not probe.scatters:
        raise RenderError("measure_brdf: the material sends light to single directions only, which no table holds")
    out, into = _cells()
    values = probe.evaluate(out, into).value / into[:, 2:]
    return Measured(values.reshape(MEASURED_SHAPE), name=name)


def _cells() -> tuple[Directions, Directions]:
    """The directions of the cells' middles, (cells, 3) each."""
    halves, differences, turns, _ = MEASURED_SHAPE
    half = np.pi / 2 * ((np.arange(halves) + 0.5) / halves) ** 2
    difference = np.pi / 2 * (np.arange(differences) + 0.5) / differences
    turn = np.pi * (np.arange(turns) + 0.5) / turns
    half, difference, turn = (a.reshape(-1) for a in np.meshgrid(half, difference, turn, indexing="ij"))
    x, y, z = np.sin(difference) * np.cos(turn), np.sin(difference) * np.sin(turn), np.cos(difference)
    sine, cosine = np.sin(half), np.cos(half)
    into = np.stack([x * cosine + z * sine, y, z * cosine - x * sine], 1)
    out = np.stack([z * sine - x * cosine, -y, z * cosine + x * sine], 1)
    return _above(out), _above(into)


def _above(directions: Directions) -> Directions:
    raised: Directions = directions.copy()
    raised[:, 2] = np.maximum(raised[:, 2], _HORIZON)
    unit: Directions = raised / np.linalg.norm(raised, axis=1, keepdims=True)
    return unit
