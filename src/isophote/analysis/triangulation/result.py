"""What a Delaunay triangulation of the plane is."""

from __future__ import annotations

from typing import Literal, TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.analysis.triangulation.angles import equiangularity
from isophote.errors import GeometryError

__all__ = ["Delaunay", "WindingRule"]

FloatArray: TypeAlias = npt.NDArray[np.float64]
IntArray: TypeAlias = npt.NDArray[np.int32]
BoolArray: TypeAlias = npt.NDArray[np.bool_]
WindingRule: TypeAlias = Literal["nonzero", "evenodd", "positive", "negative"]


@attrs.frozen(eq=False)
class Delaunay:
    """A Delaunay triangulation of points of the plane, constrained or not.

    points          (n, 2) float64
    triangles       (m, 3) int32 numbers of points, counterclockwise
    neighbours      (m, 3) int32 numbers of triangles, each across the side opposite its corner; -1: outside
    hull            (h,) int32 numbers of the points on the outer boundary, counterclockwise, those in the middle of a
                    straight side too; where all points lie on a line, in order from end to end, and no triangles
    representative  (n,) int32: the first point that equals each; only such points are corners
    constrained     (m, 3) bool: whether the side opposite a corner is (part of) a constraint
    winding         (m,) int32: how often the constraints wind around a triangle, counterclockwise
    """

    points: FloatArray
    triangles: IntArray
    neighbours: IntArray
    hull: IntArray
    representative: IntArray
    constrained: BoolArray
    winding: IntArray

    @property
    def duplicates(self) -> IntArray:
        """Numbers of the points that equal an earlier one."""
        return np.flatnonzero(self.representative != np.arange(len(self.representative))).astype(np.int32)

    @property
    def edges(self) -> IntArray:
        """(e, 2) int32: the sides of triangles, each once; where all points lie on a line, the links of the chain."""
        if len(self.triangles) == 0:
            return np.stack([self.hull[:-1], self.hull[1:]], axis=1)
        first = self.neighbours < np.arange(len(self.triangles), dtype=np.int32)[:, None]
        return self._sides(first)

    @property
    def constraint_edges(self) -> IntArray:
        """(k, 2) int32: the sides that are constraints, each once, as the triangle after them goes."""
        first = self.neighbours < np.arange(len(self.triangles), dtype=np.int32)[:, None]
        return self._sides(first & self.constrained)

    def _sides(self, chosen: BoolArray) -> IntArray:
        sides = np.stack([self.triangles[:, [1, 2, 0]], self.triangles[:, [2, 0, 1]]], axis=-1)
        found: IntArray = sides[chosen]
        return found

    def inside(self, rule: WindingRule = "nonzero") -> BoolArray:
        """(m,) bool: which triangles lie inside the constraints, by a rule about `winding`."""
        rules = {
            "nonzero": self.winding != 0,
            "evenodd": self.winding % 2 != 0,
            "positive": self.winding > 0,
            "negative": self.winding < 0,
        }
        if rule not in rules:
            raise GeometryError(f"the winding rule must be one of {', '.join(rules)}, not {rule!r}")
        chosen: BoolArray = rules[rule]
        return chosen

    def equiangularity(self) -> FloatArray:
        """(3 m,) float64: all angles of the triangles in radians, ascending; see `compare_equiangularity`."""
        return equiangularity(self.points, self.triangles)

    def __repr__(self) -> str:
        return f"Delaunay({len(self.points)} points, {len(self.triangles)} triangles, {len(self.hull)} on the hull)"
