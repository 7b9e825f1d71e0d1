"""What microfacets reflect in all, by quadrature: the tables of kernels/brdf/albedo.py."""

from __future__ import annotations

from functools import lru_cache
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.kernels.brdf.albedo import COSINES, ROUGHNESSES

__all__ = ["coat_table", "mean_conductor", "ring_chances", "split_tables"]

Floats: TypeAlias = npt.NDArray[np.float64]

_LEAST_ALPHA, _LEAST_COSINE = 1e-3, 1e-4
# Points of the unit disk that visible normals come from: rings by angles of half a turn, the other half being its
# mirror image. Rings lie closer together towards the rim, where grazing light decides.
_RINGS, _ANGLES = 48, 24


def _fresnel(cosine: Floats, ior: float) -> Floats:
    """Reflected share of unpolarised light at a smooth boundary, by Fresnel's equations."""
    sine2 = (1 - cosine**2) / ior**2
    inside = np.sqrt(np.maximum(1 - sine2, 0.0))
    parallel = (ior * cosine - inside) / (ior * cosine + inside)
    perpendicular = (cosine - ior * inside) / (cosine + ior * inside)
    share: Floats = np.where(sine2 >= 1, 1.0, (parallel**2 + perpendicular**2) / 2)
    return share


def mean_conductor(n: Floats, k: Floats) -> Floats:
    """2 ∫ F cosθ d(cosθ) of a smooth conductor of index n + ik, a channel each."""
    nodes, weights = np.polynomial.legendre.leggauss(64)
    cosine, weight = ((nodes + 1) / 2)[:, None], weights[:, None]
    index2 = (n + 1j * k) ** 2
    inside = np.sqrt(index2 - (1 - cosine**2))
    perpendicular = np.abs((cosine - inside) / (cosine + inside)) ** 2
    parallel = np.abs((index2 * cosine - inside) / (index2 * cosine + inside)) ** 2
    mean: Floats = (weight * cosine * (perpendicular + parallel) / 2).sum(axis=0)
    return mean


def ring_chances(values: npt.NDArray[np.float32]) -> Floats:
    """Cumulative chances of the rings of half directions of a table of measured reflectance, (rings + 1,), by what they
    reflect of light that comes from not too flat."""
    rings, steep = len(values), values.shape[1] * 2 // 3
    edges = 1 - np.cos(np.pi / 2 * (np.arange(rings + 1) / rings) ** 2)
    middle = np.cos(np.pi / 2 * ((np.arange(rings) + 0.5) / rings) ** 2)
    weight = values[:, :steep].mean(axis=(1, 2, 3), dtype=np.float64) * middle * np.diff(edges)
    # Every ring has some chance, so that no direction is left to the other way of sampling alone.
    weight = weight / max(weight.sum(), 1e-30) + 0.01 * np.diff(edges)
    return np.concatenate([[0.0], np.cumsum(weight) / weight.sum()])


def _grid() -> tuple[Floats, Floats]:
    """Roughness and cosθ of the tables' rows and columns."""
    return np.linspace(0, 1, ROUGHNESSES), np.maximum(np.linspace(0, 1, COSINES) ** 2, _LEAST_COSINE)


@lru_cache(maxsize=1)
def _reflections() -> tuple[Floats, Floats]:
    """(cosine of the facet, G1 of where it reflects to; 0 through the surface), (roughness, cosθ, point) each."""
    roughness, cosine = _grid()
    alpha = np.maximum(roughness**2, _LEAST_ALPHA)[:, None, None]
    out_x, out_z = np.sqrt(1 - cosine**2)[None, :, None], cosine[None, :, None]
    r2 = 1 - ((np.arange(_RINGS) + 0.5) / _RINGS) ** 2
    weight = 2 * (np.arange(_RINGS) + 0.5) / _RINGS
    angle = np.pi * (np.arange(_ANGLES) + 0.5) / _ANGLES
    r2, angle = (a.reshape(-1) for a in np.meshgrid(r2, angle, indexing="ij"))
    size = np.sqrt((alpha * out_x) ** 2 + out_z**2)
    x, z = alpha * out_x / size, out_z / size
    cap = (1 - r2) * (1 + z) - z
    rim = np.sqrt(np.maximum(1 - cap**2, 0.0))
    h = np.stack(np.broadcast_arrays(alpha * (rim * np.cos(angle) + x), alpha * rim * np.sin(angle), cap + z))
    h = h / np.sqrt((h**2).sum(axis=0))
    facet = h[0] * out_x + h[2] * out_z
    into = 2 * facet * h - np.stack(np.broadcast_arrays(out_x, 0.0, out_z))
    into_z = into[2]
    slope2 = alpha**2 * (into[0] ** 2 + into[1] ** 2) / np.maximum(into_z, 1e-9) ** 2
    masking = np.where(into_z > 0, 2 / (1 + np.sqrt(1 + slope2)), 0.0)
    return facet, masking * np.repeat(weight, _ANGLES)


def _table(share: Floats, counted: Floats) -> npt.NDArray[np.float32]:
    """The table of a Fresnel share of each facet, and its means over the hemisphere."""
    albedo = (share * counted).mean(axis=2)
    # cosθ = t²: 2 ∫ E cosθ d(cosθ) = 4 ∫ E t³ dt, E linear between columns.
    t = np.linspace(0, 1, COSINES)
    fine = np.linspace(0, 1, 40 * COSINES + 1)
    middle = (fine[1:] + fine[:-1]) / 2
    means = [4 * (np.interp(middle, t, row) * middle**3).mean() for row in albedo]
    return np.concatenate([albedo.reshape(-1), means]).astype(np.float32)


@lru_cache(maxsize=16)
def coat_table(ior: float) -> npt.NDArray[np.float32]:
    """E of a dielectric boundary, seen from outside."""
    facet, counted = _reflections()
    return _table(_fresnel(facet, ior), counted)


@lru_cache(maxsize=1)
def split_tables() -> npt.NDArray[np.float32]:
    """A and B, one after the other, for E = f₀ A + B by Schlick's approximation; A + B is that of perfect mirrors."""
    facet, counted = _reflections()
    fifth = np.maximum(1 - facet, 0.0) ** 5
    return np.concatenate([_table(1 - fifth, counted), _table(fifth, counted)])
