"""Angles of triangulations of the plane, and which of two has the better ones."""

from __future__ import annotations

from typing import Protocol, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.analysis.triangulation.given import finite_points, triangle_corners
from isophote.errors import GeometryError

__all__ = ["compare_equiangularity", "equiangularity"]

FloatArray: TypeAlias = npt.NDArray[np.float64]


class _Triangulation(Protocol):
    """What has angles, such as a `Delaunay`."""

    def equiangularity(self) -> FloatArray:
        """All angles, ascending."""


def equiangularity(points: npt.ArrayLike, triangles: npt.ArrayLike) -> FloatArray:
    """All angles of triangles in the plane, in radians, ascending: (3 m,) float64.

    Among all triangulations of a set of points, this vector is lexicographically greatest for a Delaunay one (Sibson,
    "Locally Equiangular Triangulations", 1978). Points are (n, 2), triangles (m, 3) numbers of points. Raises
    `GeometryError` for other shapes, coordinates that are not finite, and points that are not there.
    """
    places = finite_points(points, 2)
    corners = places[triangle_corners(triangles, len(places))]
    sides = np.roll(corners, -1, axis=1) - corners
    before = -np.roll(sides, 1, axis=1)
    cross = sides[..., 0] * before[..., 1] - sides[..., 1] * before[..., 0]
    dot = (sides * before).sum(axis=-1)
    return np.sort(np.arctan2(np.abs(cross), dot), axis=None)


def compare_equiangularity(a: _Triangulation, b: _Triangulation, tolerance: float = 1e-9) -> int:
    """1 where triangulation a is more equiangular than b, -1 where it is less, 0 where they are equal.

    Compares the ascending angles of both, from the least on, at the first place where they differ by more than
    `tolerance` (radians). Raises `GeometryError` where the numbers of triangles differ, as for different points.
    """
    first, second = a.equiangularity(), b.equiangularity()
    if len(first) != len(second):
        raise GeometryError(f"triangulations of {len(first) // 3} and of {len(second) // 3} triangles do not compare")
    differing = np.flatnonzero(np.abs(first - second) > tolerance)
    if len(differing) == 0:
        return 0
    return 1 if first[differing[0]] > second[differing[0]] else -1
