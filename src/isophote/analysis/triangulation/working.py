"""Triangulations of the plane that are being changed: arrays with room for more points and triangles."""

from __future__ import annotations

from typing import Any, TypeAlias, TypeVar

import numpy as np
import numpy.typing as npt

from isophote.kernels.measure import constrain, insert

__all__ = ["Working"]

FloatArray: TypeAlias = npt.NDArray[np.float64]
IntArray: TypeAlias = npt.NDArray[np.int32]
_Scalar = TypeVar("_Scalar", bound=np.generic)

_STATE = 8


class Working:
    """The arrays of kernels/measure/plane_mesh.py and insert.py; the first `point_count` and `triangle_count` count."""

    def __init__(self, points: FloatArray, corners: IntArray, neighbours: IntArray, fixed: IntArray) -> None:
        self.state = np.zeros(_STATE, np.int64)
        self.state[insert.POINTS], self.state[insert.TRIANGLES] = len(points), len(corners)
        self.points = points.copy()
        self.corners, self.neighbours, self.fixed = corners.copy(), neighbours.copy(), fixed.copy()
        self.at = np.full(len(points), -1, np.int32)
        self.at[corners.reshape(-1)] = np.repeat(np.arange(len(corners), dtype=np.int32), 3)
        self.region = np.zeros(len(corners), np.int32)
        self.marks = np.zeros(len(corners), np.int64)

    @property
    def point_count(self) -> int:
        return int(self.state[insert.POINTS])

    @property
    def triangle_count(self) -> int:
        return int(self.state[insert.TRIANGLES])

    def grow(self, points: int) -> None:
        """Make room for so many points in all, and the triangles that these need."""
        triangles = self.triangle_count + 2 * (points - self.point_count)
        self.points, self.at = longer(self.points, points), longer(self.at, points)
        self.corners, self.neighbours = longer(self.corners, triangles), longer(self.neighbours, triangles)
        self.fixed, self.region = longer(self.fixed, triangles), longer(self.region, triangles)
        self.marks = longer(self.marks, triangles)
        self.starts = np.empty(points, np.int32)
        self.hole, self.rim = np.empty(triangles, np.int32), np.empty(3 * triangles, np.int32)
        self.news = np.empty((triangles + 2, 7), np.int32)

    @property
    def arrays(self) -> tuple[npt.NDArray[Any], ...]:
        """What the kernels of insert.py take."""
        own = self.points, self.corners, self.neighbours, self.fixed, self.at, self.region
        return *own, self.starts, self.marks, self.hole, self.rim, self.news

    def insert_point(self, x: float, y: float, near: int) -> int:
        """Insert a point, which lies in the hull and near another one; returns its number, or that of an equal one."""
        v = self.point_count
        if v == len(self.points):
            self.grow(2 * v + 16)
        self.points[v] = x, y
        found = int(insert.insert_point(*self.arrays, self.state, int(self.at[near]), v))
        if found == v:
            self.state[insert.POINTS] += 1
        return found

    def unfix(self, a: int, b: int) -> None:
        """Free the side between two points."""
        insert.unfix(self.corners, self.neighbours, self.fixed, self.at, a, b)

    def flip_all(self) -> None:
        """Make free sides Delaunay."""
        count = self.triangle_count
        own = self.corners[:count], self.neighbours[:count], self.fixed[:count]
        constrain.flip_all(self.points, *own, self.at)

    def winding(self, constraints: IntArray) -> tuple[IntArray, bool]:
        """Winding numbers of the triangles, and whether the constraints close up, so that they are well-defined."""
        count = self.triangle_count
        corners, neighbours = self.corners[:count], self.neighbours[:count]
        steps, winding = np.zeros((count, 3), np.int32), np.zeros(count, np.int32)
        constrain.add_winding(self.points, corners, neighbours, self.at, constraints, steps)
        seen, queue = np.zeros(count, np.bool_), np.empty(count, np.int32)
        return winding, bool(constrain.spread_winding(neighbours, steps, winding, seen, queue))


def longer(array: npt.NDArray[_Scalar], rows: int) -> npt.NDArray[_Scalar]:
    """An array with so many rows, those behind the first ones zeros."""
    grown = np.zeros((max(rows, len(array)), *array.shape[1:]), array.dtype)
    grown[: len(array)] = array
    return grown
