"""Circles through triangles, and which of them are not empty."""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.analysis.triangulation.given import finite_points, triangle_corners
from isophote.errors import GeometryError
from isophote.kernels.measure import circles

__all__ = ["Circle", "circumcircle", "empty_circle_violations"]

FloatArray: TypeAlias = npt.NDArray[np.float64]


class Circle(NamedTuple):
    """`centre`, (..., 2) float64, and `radius`, (...) float64; NaN and infinity where three points lie on a line."""

    centre: FloatArray
    radius: FloatArray


def circumcircle(a: npt.ArrayLike, b: npt.ArrayLike, c: npt.ArrayLike) -> Circle:
    """The circle through the points a, b, c, each (..., 2), broadcast against each other.

    Computed in pairs of doubles: some last places of the result are right however flat the triangle. Raises
    `GeometryError` for other shapes and for coordinates that are not finite.
    """
    try:
        rows = np.concatenate(np.broadcast_arrays(*(np.asarray(p, np.float64) for p in (a, b, c))), axis=-1)
    except ValueError:
        raise GeometryError("a, b and c must be points of shape (..., 2) that fit together") from None
    if rows.ndim == 0 or rows.shape[-1] != 6 or not np.isfinite(rows).all():
        raise GeometryError("a, b and c must be finite points of shape (..., 2)")
    shape = rows.shape[:-1]
    centres, radii = np.empty((*shape, 2)), np.empty(shape)
    circles.circumcircles(rows.reshape(-1, 6), centres.reshape(-1, 2), radii.reshape(-1))
    return Circle(centres, radii)


def empty_circle_violations(
    points: npt.ArrayLike, triangles: npt.ArrayLike, everywhere: bool = False
) -> npt.NDArray[np.int32]:
    """Pairs (triangle, point), (k, 2) int32, of which the point lies strictly inside the triangle's circle; exact.

    Tried are the far corners of neighbouring triangles: where none of these lies inside, no point does (Delaunay's
    lemma), if the triangles are a triangulation. With `everywhere`, all points are tried with all triangles, in m n
    steps. Triangles, (m, 3), may go round either way. Raises `GeometryError` for other shapes, coordinates that are
    not finite, points that are not there, and for more than two triangles at a side.
    """
    places = finite_points(points, 2)
    corners = triangle_corners(triangles, len(places))
    if everywhere:
        return _all_violations(places, corners)
    far = np.empty_like(corners)
    circles.opposite_violations(places, corners, _neighbours(corners), far)
    triangle, side = np.nonzero(far >= 0)
    return np.stack([triangle.astype(np.int32), far[triangle, side]], axis=1)


def _all_violations(points: FloatArray, corners: npt.NDArray[np.int32]) -> npt.NDArray[np.int32]:
    pairs = np.empty((4096, 2), np.int32)
    count = circles.inner_points(points, corners, pairs)
    if count > len(pairs):
        pairs = np.empty((count, 2), np.int32)
        circles.inner_points(points, corners, pairs)
    return pairs[:count]


def _neighbours(corners: npt.NDArray[np.int32]) -> npt.NDArray[np.int32]:
    """For each side, opposite its corner, the triangle on its other side, or -1."""
    sides = np.sort(np.stack([corners[:, [1, 2, 0]], corners[:, [2, 0, 1]]], axis=-1).reshape(-1, 2), axis=1)
    order = np.lexsort((sides[:, 1], sides[:, 0]))
    same = (sides[order[1:]] == sides[order[:-1]]).all(axis=1)
    if (same[1:] & same[:-1]).any():
        side = sides[order[np.flatnonzero(same[1:] & same[:-1])[0]]]
        raise GeometryError(f"more than two triangles meet at the side between points {side[0]} and {side[1]}")
    neighbours = np.full(corners.size, -1, np.int32)
    first, second = order[:-1][same], order[1:][same]
    neighbours[first], neighbours[second] = second // 3, first // 3
    return neighbours.reshape(-1, 3)
