"""What a Delaunay triangulation of space, or of more dimensions, is."""

from __future__ import annotations

from typing import TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.errors import GeometryError

__all__ = ["DelaunayComplex"]

FloatArray: TypeAlias = npt.NDArray[np.float64]
IntArray: TypeAlias = npt.NDArray[np.int32]


@attrs.frozen(eq=False)
class DelaunayComplex:
    """A Delaunay triangulation of points of d dimensions, d at least 3.

    points          (n, d) float64
    simplices       (m, d + 1) int32 numbers of points; in space `orient3d` of them is 1
    neighbours      (m, d + 1) int32 numbers of simplices, each across the facet opposite its corner; -1: outside
    hull            (h, d) int32: the outer facets; in space counterclockwise seen from outside
    representative  (n,) int32: the first point that equals each; only such points are corners
    """

    points: FloatArray
    simplices: IntArray
    neighbours: IntArray
    hull: IntArray
    representative: IntArray

    @property
    def tetrahedra(self) -> IntArray:
        """The simplices, in space."""
        if self.points.shape[1] != 3:
            raise GeometryError(f"points of {self.points.shape[1]} dimensions have simplices, not tetrahedra")
        return self.simplices

    @property
    def duplicates(self) -> IntArray:
        """Numbers of the points that equal an earlier one."""
        return np.flatnonzero(self.representative != np.arange(len(self.representative))).astype(np.int32)

    def __repr__(self) -> str:
        return f"DelaunayComplex({len(self.points)} points, {len(self.simplices)} simplices)"
