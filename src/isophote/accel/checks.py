"""What accelerators ask of the triangles that they are built over."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.errors import GeometryError

__all__ = ["MOST_ITEMS", "checked_points", "checked_triangles"]

FloatArray: TypeAlias = npt.NDArray[np.float32]
IntArray: TypeAlias = npt.NDArray[np.int32]

# A leaf's code has 28 bits for its first block.
MOST_ITEMS = 1 << 28


def checked_points(values: npt.ArrayLike, what: str) -> FloatArray:
    """`values` as (n, 3) finite float32. Raises `GeometryError`."""
    with np.errstate(over="ignore"):
        points = np.require(values, np.float32, ["C", "W"])
    if points.ndim != 2 or points.shape[1] != 3:
        raise GeometryError(f"{what} must have shape (n, 3), but have {points.shape}")
    if not np.isfinite(points).all():
        raise GeometryError(f"{what} must be finite, and below 3.4e38")
    return points


def checked_triangles(triangles: npt.ArrayLike, position_count: int) -> IntArray:
    """`triangles` as (m, 3) int32, all from 0 to `position_count` - 1. Raises `GeometryError`."""
    corners = np.asarray(triangles)
    if corners.ndim != 2 or corners.shape[1] != 3 or not np.issubdtype(corners.dtype, np.integer):
        raise GeometryError(f"triangles must be (m, 3) whole numbers, but are {corners.shape} of {corners.dtype}")
    if len(corners) > MOST_ITEMS:
        raise GeometryError(f"a tree holds 2^28 triangles at most, not {len(corners):,}")
    if len(corners) and (corners.min() < 0 or corners.max() >= position_count):
        raise GeometryError(f"triangles name positions outside 0 to {position_count - 1}")
    return np.require(corners, np.int32, ["C", "W"])
