"""Points and triangles as they are given, checked."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.errors import GeometryError

__all__ = ["finite_points", "point_numbers", "triangle_corners"]

FloatArray: TypeAlias = npt.NDArray[np.float64]
# Half-edges of a triangulation, six a point, are numbered by int32.
_MOST_POINTS = 2**31 // 6 - 1


def finite_points(points: npt.ArrayLike, dimension: int | None = None) -> FloatArray:
    """Points as contiguous (n, d) float64."""
    try:
        array = np.ascontiguousarray(points, np.float64)
    except (TypeError, ValueError):
        raise GeometryError("points must be numbers, of shape (n, d)") from None
    if array.size == 0 and array.ndim <= 1:
        array = array.reshape(0, dimension or 2)
    wanted = "d" if dimension is None else dimension
    if array.ndim != 2 or (dimension is not None and array.shape[1] != dimension):
        raise GeometryError(f"points must have shape (n, {wanted}), but have {array.shape}")
    if len(array) > _MOST_POINTS:
        raise GeometryError(f"at most {_MOST_POINTS:,} points can be triangulated, not {len(array):,}")
    if not np.isfinite(array).all():
        wrong = np.flatnonzero(~np.isfinite(array).all(axis=1))
        raise GeometryError(f"{len(wrong)} points are not finite, the first is number {wrong[0]}: {array[wrong[0]]}")
    return array


def point_numbers(numbers: npt.ArrayLike, columns: int, count: int, what: str) -> npt.NDArray[np.int32]:
    """Rows of numbers of points, (k, columns) int32."""
    array: npt.NDArray[Any] = np.asarray(numbers)
    if array.size == 0:
        return np.empty((0, columns), np.int32)
    if array.ndim != 2 or array.shape[1] != columns or not np.issubdtype(array.dtype, np.integer):
        raise GeometryError(f"{what} must be (k, {columns}) whole numbers, but are {array.shape} of {array.dtype}")
    wrong = np.flatnonzero(((array < 0) | (array >= count)).any(axis=1))
    if len(wrong):
        raise GeometryError(
            f"{what} name points that are not there: row {wrong[0]} is {array[wrong[0]].tolist()}, of {count} points"
        )
    return np.ascontiguousarray(array, np.int32)


def triangle_corners(triangles: npt.ArrayLike, count: int) -> npt.NDArray[np.int32]:
    """Triangles as (m, 3) int32 numbers of `count` points."""
    return point_numbers(triangles, 3, count, "triangles")
