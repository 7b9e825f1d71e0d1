"""Polygons that diagrams are clipped to."""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.analysis.arrays import read_only
from isophote.analysis.predicates import orient2d
from isophote.errors import GeometryError

__all__ = ["Region", "region"]

FloatArray: TypeAlias = npt.NDArray[np.float64]

# What is left free around the points on each side, in parts of their greater extent.
_MARGIN = 0.1


class Region(NamedTuple):
    """`corners` (k, 2) of a simple polygon, counterclockwise; `around`, a convex one around it, the same if it is."""

    corners: FloatArray
    around: FloatArray

    @property
    def area(self) -> float:
        """The area of the polygon."""
        return _area(self.corners)


def region(bounds: npt.ArrayLike | None, points: FloatArray) -> Region:
    """A polygon (k, 2), or the box of the points with some room if None."""
    if bounds is None:
        corners = _box(points)
        return Region(corners, corners)
    try:
        corners = np.array(bounds, np.float64)
    except (TypeError, ValueError):
        raise GeometryError("bounds must be the corners of a polygon, (k, 2) numbers") from None
    if corners.ndim != 2 or corners.shape[1] != 2 or len(corners) < 3:
        raise GeometryError(f"bounds must be three corners or more of a polygon, (k, 2), but are {corners.shape}")
    if not np.isfinite(corners).all():
        raise GeometryError("bounds have a corner that is not finite")
    if (corners[0] == corners[-1]).all():
        corners = corners[:-1]
    corners = corners[(corners != np.roll(corners, 1, axis=0)).any(axis=1)]
    area = _area(corners)
    if len(corners) < 3 or area == 0:
        raise GeometryError("bounds enclose no area")
    corners = read_only(np.ascontiguousarray(corners[::-1] if area < 0 else corners))
    crossing = _crossing(corners)
    if crossing is not None:
        raise GeometryError(f"bounds cross themselves: edges {crossing[0]} and {crossing[1]} meet")
    turns = orient2d(np.roll(corners, 1, axis=0), corners, np.roll(corners, -1, axis=0))
    return Region(corners, corners if (turns >= 0).all() else _corners_of(corners.min(axis=0), corners.max(axis=0)))


def _box(points: FloatArray) -> FloatArray:
    if len(points) == 0:
        return _corners_of(np.zeros(2), np.ones(2))
    # By columns: along the long axis NumPy takes twenty times as long.
    low, high = (np.array([fold(points[:, 0]), fold(points[:, 1])]) for fold in (np.min, np.max))
    with np.errstate(over="ignore"):
        margin = _MARGIN * float((high - low).max())
    if not margin > 0:
        margin = 1.0 if not np.abs(low).max() > 0 else float(np.abs(low).max())
    limit = np.finfo(np.float64).max / 4
    return _corners_of(np.maximum(low - margin, -limit), np.minimum(high + margin, limit))


def _corners_of(low: FloatArray, high: FloatArray) -> FloatArray:
    corners = np.array([(low[0], low[1]), (high[0], low[1]), (high[0], high[1]), (low[0], high[1])])
    return read_only(corners)


def _area(corners: FloatArray) -> float:
    p = corners - corners[0]
    q = np.roll(p, -1, axis=0)
    return float((p[:, 0] * q[:, 1] - q[:, 0] * p[:, 1]).sum() / 2)


def _crossing(corners: FloatArray) -> tuple[int, int] | None:
    """Two edges that are not neighbours and meet, or neighbours that run back over each other."""
    after = np.roll(corners, -1, axis=0)
    count = len(corners)
    low, high = np.minimum(corners, after), np.maximum(corners, after)
    for i in range(count):
        others = np.flatnonzero((low <= high[i]).all(axis=1) & (high >= low[i]).all(axis=1))
        others = others[(others > i) & (others != i + 1) & ~((i == 0) & (others == count - 1))]
        if len(others) == 0:
            continue
        a, b, c, d = corners[i], after[i], corners[others], after[others]
        straddle = (orient2d(a, b, c) * orient2d(a, b, d) <= 0) & (orient2d(c, d, a) * orient2d(c, d, b) <= 0)
        if straddle.any():
            return i, int(others[np.flatnonzero(straddle)[0]])
    return None
