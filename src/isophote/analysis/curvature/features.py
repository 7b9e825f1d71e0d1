"""Lines along which a surface bends most: sharp edges, ridges and valleys."""

from __future__ import annotations

import math
from typing import TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.analysis.curvature.discrete import half_edge_pairs
from isophote.analysis.curvature.fan import Fans, fans
from isophote.analysis.curvature.fit import principal_curvatures
from isophote.errors import GeometryError
from isophote.shapes.mesh import Mesh

__all__ = ["FeatureLines", "feature_lines"]

Floats: TypeAlias = npt.NDArray[np.float64]


@attrs.frozen(eq=False)
class FeatureLines:
    """Feature lines of a mesh.

    `sharp` (k, 2): vertices of edges whose faces meet at more than the angle asked for. `ridges`, `valleys` (k, 2, 3):
    ends of segments within triangles, along which the largest curvature is greatest, or the smallest least, across
    the line. `ridge_strength`, `valley_strength` (k,) are the curvatures there, in 1 / length.
    """

    sharp: npt.NDArray[np.int32]
    ridges: Floats
    valleys: Floats
    ridge_strength: Floats
    valley_strength: Floats


def feature_lines(
    mesh: Mesh, angle_degrees: float = 40.0, strength: float = 0.0, degree: int = 3, rings: int = 2
) -> FeatureLines:
    """Sharp edges of a mesh, and ridges and valleys of the surface that it stands for.

    A ridge is where the derivative of k1 along its own direction changes its sign from + to −, and k1 > |k2|; a
    valley is a ridge of the surface turned inside out. Lines weaker than `strength` (in 1 / length) are left out.
    `degree` and `rings` are those of `principal_curvatures`. Raises `GeometryError` for angles beyond 0 to 180 degrees.

    Source: Ohtake, Belyaev, Seidel, "Ridge-Valley Lines on Meshes via Implicit Surface Fitting", 2004.
    """
    if not 0 <= angle_degrees <= 180:
        raise GeometryError(f"angle_degrees must be from 0 to 180, not {angle_degrees!r}")
    fan = fans(mesh)
    found = principal_curvatures(mesh, degree, rings)
    ridges, high = _crest(fan, found.k1, found.k2, found.direction1, strength)
    valleys, low = _crest(fan, -found.k2, -found.k1, found.direction2, strength)
    return FeatureLines(_sharp(fan, math.radians(angle_degrees)), ridges, valleys, high, -low)


def _sharp(fan: Fans, angle: float) -> npt.NDArray[np.int32]:
    pairs, _ = half_edge_pairs(fan)
    t = fan.positions[fan.triangles]
    n = np.cross(t[:, 1] - t[:, 0], t[:, 2] - t[:, 0])
    first, second = n[pairs[:, 0] // 3], n[pairs[:, 1] // 3]
    between = np.arctan2(np.linalg.norm(np.cross(first, second), axis=1), (first * second).sum(axis=1))
    chosen = pairs[between > angle, 0]
    f, i = chosen // 3, chosen % 3
    return np.stack([fan.triangles[f, i], fan.triangles[f, (i + 1) % 3]], axis=1)


def _gradients(fan: Fans, values: Floats) -> tuple[Floats, Floats]:
    """(m, 3) gradients of a linear function on each triangle, and (m,) areas; 0 on triangles without area."""
    p = fan.positions[fan.triangles]
    n = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
    square = (n * n).sum(axis=1)
    v = values[fan.triangles]
    total = sum(v[:, i, None] * np.cross(n, p[:, (i + 2) % 3] - p[:, (i + 1) % 3]) for i in range(3))
    with np.errstate(divide="ignore", invalid="ignore"):
        gradients = np.where(square[:, None] > 0, total / square[:, None], 0.0)
    return gradients, np.sqrt(square) / 2


def _crest(fan: Fans, k: Floats, other: Floats, direction: Floats, strength: float) -> tuple[Floats, Floats]:
    """Segments along which k has a maximum across, and k there."""
    known = np.isfinite(k)
    gradients, areas = _gradients(fan, np.where(known, k, 0.0))
    total = np.zeros_like(fan.positions)
    for i in range(3):
        np.add.at(total, fan.triangles[:, i], gradients * areas[:, None])
    weight = np.bincount(fan.triangles.reshape(-1), np.repeat(areas, 3), len(k))
    rise = (total * direction).sum(axis=1) / np.where(weight > 0, weight, 1.0)
    bends = known & (k > np.abs(other)) & (k > strength)
    chosen = fan.triangles[bends[fan.triangles].all(axis=1)]
    # Directions have no sense of their own: within a triangle they follow that of its first corner.
    t = direction[chosen]
    sense = np.where((t * t[:, :1]).sum(axis=2) < 0, -1.0, 1.0)
    t, e = t * sense[:, :, None], rise[chosen] * sense
    falls = _falls(fan.positions[chosen], e, t.sum(axis=1))
    crossed = (e > 0) != (e[:, [1, 2, 0]] > 0)
    pick = falls & (crossed.sum(axis=1) == 2)
    return _segments(fan.positions[chosen[pick]], k[chosen[pick]], e[pick], crossed[pick])


def _falls(p: Floats, e: Floats, along: Floats) -> npt.NDArray[np.bool_]:
    """Whether e gets less along the direction: the zero is a maximum then, not a minimum."""
    n = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
    slope = sum(e[:, i, None] * np.cross(n, p[:, (i + 2) % 3] - p[:, (i + 1) % 3]) for i in range(3))
    result: npt.NDArray[np.bool_] = (slope * along).sum(axis=1) < 0
    return result


def _segments(p: Floats, k: Floats, e: Floats, crossed: npt.NDArray[np.bool_]) -> tuple[Floats, Floats]:
    """The zero line of a linear function on triangles that it crosses: segments (k, 2, 3), and the mean of k there."""
    rows = np.arange(len(p))
    ends, strengths = [], []
    for side in (crossed.argmax(axis=1), 2 - crossed[:, ::-1].argmax(axis=1)):
        following = (side + 1) % 3
        a, b = e[rows, side], e[rows, following]
        w = (a / (a - b))[:, None]
        ends.append(p[rows, side] * (1 - w) + p[rows, following] * w)
        strengths.append(k[rows, side] * (1 - w[:, 0]) + k[rows, following] * w[:, 0])
    return np.stack(ends, axis=1), (strengths[0] + strengths[1]) / 2
