"""Curvatures of the mesh itself, a surface that is flat but for its edges and vertices."""

from __future__ import annotations

from typing import TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.analysis.curvature.fan import Fans, fans
from isophote.analysis.curvature.fit import principal_curvatures
from isophote.errors import GeometryError
from isophote.shapes.mesh import Mesh

__all__ = [
    "CurvatureTotals",
    "angle_deficit",
    "curvature_totals",
    "gaussian_curvature",
    "half_edge_pairs",
    "mean_curvature",
]

Floats: TypeAlias = npt.NDArray[np.float64]


def angle_deficit(mesh: Mesh) -> Floats:
    """(n,) 2π − Σθ at vertices inside, π − Σθ at those on the boundary; 0 at vertices without faces.

    It is the integral of Gaussian curvature over the vertex's surroundings; its sum over a mesh is 2πχ (Descartes).
    """
    return _deficit(fans(mesh))


def _deficit(fan: Fans) -> Floats:
    whole = np.where(fan.on_boundary, np.pi, 2 * np.pi)
    return np.where(np.diff(fan.starts) == 0, 0.0, whole - fan.sums.angles)


def gaussian_curvature(mesh: Mesh, method: str = "fit") -> Floats:
    """(n,) Gaussian curvature K = k1 · k2 at the vertices, in 1 / length².

    `method`: "fit", from `principal_curvatures`, of order 2 in the size of the triangles; "deficit", angle deficit
    over mixed area, exact in total but not convergent at each vertex of an irregular mesh; "image", the limit of the
    ratio of areas that defines it: that of the normals' image on the unit sphere over that of the triangles around.
    NaN where there is no surface to speak of; on the boundary "deficit" and "image" count only what is there.

    Source: Meyer et al., "Discrete Differential-Geometry Operators", 2003.
    """
    if method == "fit":
        found = principal_curvatures(mesh)
        return found.k1 * found.k2
    if method not in ("deficit", "image"):
        raise GeometryError(f'method must be "fit", "deficit" or "image", not {method!r}')
    fan = fans(mesh)
    with np.errstate(divide="ignore", invalid="ignore"):
        if method == "deficit":
            return np.where(fan.sums.areas > 0, _deficit(fan) / fan.sums.areas, np.nan)
        image, around = fan.sums.images.T
        return np.where(around > 0, image / around, np.nan)


def mean_curvature(mesh: Mesh, method: str = "fit") -> Floats:
    """(n,) mean curvature H = (k1 + k2) / 2 at the vertices, in 1 / length; positive where bent like a sphere.

    `method`: "fit", from `principal_curvatures`, of order 2; "cotangent", |Σ (cot α + cot β)(p − q)| / 4A with the
    mixed area A, signed by the normal: of order 2 where the mesh is regular. NaN where there is no surface.

    Source: Meyer et al., 2003; Pinkall, Polthier, "Computing Discrete Minimal Surfaces", 1993.
    """
    if method == "fit":
        found = principal_curvatures(mesh)
        return (found.k1 + found.k2) / 2
    if method != "cotangent":
        raise GeometryError(f'method must be "fit" or "cotangent", not {method!r}')
    fan = fans(mesh)
    sums = fan.sums
    along = (sums.means * fan.normals("angle")).sum(axis=1)
    size = np.linalg.norm(sums.means, axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(sums.areas > 0, np.copysign(size, along) / sums.areas, np.nan)


@attrs.frozen
class CurvatureTotals:
    """Both sides of the theorem of Gauss and Bonnet: ∫K dA + ∫κ ds = 2πχ.

    `gaussian` is the sum of the angle deficits inside, `boundary` the turning of the boundary, `euler` χ; `mean` is
    ∫H dA by the edges' dihedral angles, Σ |e| φ / 2 (Steiner), over edges with two faces; `error` what rounding leaves.
    """

    gaussian: float
    boundary: float
    mean: float
    area: float
    euler: int
    error: float


def curvature_totals(mesh: Mesh) -> CurvatureTotals:
    """Total curvatures of a mesh; see `CurvatureTotals`."""
    fan = fans(mesh)
    deficit = _deficit(fan)
    inside = float(deficit[~fan.on_boundary].sum())
    boundary = float(deficit[fan.on_boundary].sum())
    used = int((np.diff(fan.starts) > 0).sum())
    pairs, single = half_edge_pairs(fan)
    euler = used - len(pairs) - single + len(fan.triangles)
    t = fan.positions[fan.triangles]
    normals = np.cross(t[:, 1] - t[:, 0], t[:, 2] - t[:, 0])
    area = float(np.linalg.norm(normals, axis=1).sum() / 2)
    mean = _mean_total(fan, pairs, normals)
    return CurvatureTotals(inside, boundary, mean, area, euler, inside + boundary - 2 * np.pi * euler)


def half_edge_pairs(fan: Fans) -> tuple[npt.NDArray[np.int64], int]:
    """Half-edges 3f + i of each edge with two triangles, (k, 2), and how many other edges there are."""
    t = fan.triangles.astype(np.int64)
    ends = np.stack([t, np.roll(t, -1, axis=1)], axis=2).reshape(-1, 2)
    keys = ends.min(axis=1) * len(fan.positions) + ends.max(axis=1)
    order = np.argsort(keys, kind="stable")
    _, first, counts = np.unique(keys[order], return_index=True, return_counts=True)
    two = first[counts == 2]
    return np.stack([order[two], order[two + 1]], axis=1), int((counts != 2).sum())


def _mean_total(fan: Fans, pairs: npt.NDArray[np.int64], normals: Floats) -> float:
    f, i = pairs[:, 0] // 3, pairs[:, 0] % 3
    start, end = fan.triangles[f, i], fan.triangles[f, (i + 1) % 3]
    edge = fan.positions[end] - fan.positions[start]
    size = np.linalg.norm(edge, axis=1)
    n, m = normals[f], normals[pairs[:, 1] // 3]
    # A convex edge has a positive angle.
    sine = (np.cross(n, m) * edge).sum(axis=1) / np.where(size == 0, 1.0, size)
    angle = np.arctan2(sine, (n * m).sum(axis=1))
    return float((size * angle).sum() / 2)
