"""Cells of diagrams of points, clipped to a polygon, made when they are asked for."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import TypeAlias, overload

import attrs
import numpy as np
import numpy.typing as npt

from isophote.analysis.arrays import read_only
from isophote.analysis.crew import pieces, run
from isophote.analysis.diagrams.pieces import cut_by_lines
from isophote.analysis.diagrams.region import Region
from isophote.kernels.measure import cells

__all__ = ["Cell", "Cells"]

FloatArray: TypeAlias = npt.NDArray[np.float64]
IntArray: TypeAlias = npt.NDArray[np.int32]

_GRAIN = 32768
_NO_CORNERS = read_only(np.empty((0, 2)))


@attrs.frozen(eq=False)
class Cell:
    """The part of the bounds that belongs to a site.

    site         (2,) float64
    polygon      (k, 2) float64, counterclockwise; the largest of `pieces`, no corners where there is none
    pieces       polygons; more than one only where the bounds are not convex
    area         of all pieces
    neighbours   (m,) int32, ascending: sites whose cells share an edge with this one, within the bounds or beyond
    """

    site: FloatArray
    polygon: FloatArray
    pieces: tuple[FloatArray, ...]
    area: float
    neighbours: IntArray


@attrs.frozen(eq=False, repr=False, slots=False)
class Cells(Sequence[Cell]):
    """The cells of sites, in their order; each is made when it is asked for, areas and centroids all at once."""

    points: FloatArray
    weights: FloatArray
    starts: npt.NDArray[np.int64]
    partners: IntArray
    region: Region
    present: npt.NDArray[np.bool_]

    def __len__(self) -> int:
        return len(self.points)

    @overload
    def __getitem__(self, index: int) -> Cell: ...
    @overload
    def __getitem__(self, index: slice) -> list[Cell]: ...

    def __getitem__(self, index: int | slice) -> Cell | list[Cell]:
        if isinstance(index, slice):
            return [self._cell(i) for i in range(*index.indices(len(self)))]
        return self._cell(range(len(self))[index])

    def __iter__(self) -> Iterator[Cell]:
        return map(self._cell, range(len(self)))

    def _cell(self, i: int) -> Cell:
        around = read_only(np.sort(self.partners[self.starts[i] : self.starts[i + 1]]))
        parts = tuple(read_only(part) for part in self._polygons(i)) if self.present[i] else ()
        areas = [_area(part) for part in parts]
        largest = parts[int(np.argmax(areas))] if parts else _NO_CORNERS
        return Cell(self.points[i], largest, parts, float(sum(areas)), around)

    def _polygons(self, i: int) -> list[FloatArray]:
        begin, end = self.starts[i], self.starts[i + 1]
        corners, around = self.region
        rows = self._rows(i)
        if len(rows) == 0:
            return []
        if corners is not around and (rows[:, 2] < 0).any():
            partners = self.partners[begin:end]
            lines = self.points[partners] - self.points[i]
            heights = ((lines**2).sum(axis=1) + self.weights[i] - self.weights[partners]) / 2
            return [part + self.points[i] for part in cut_by_lines(corners - self.points[i], lines, heights)]
        polygon = rows[:, :2]
        polygon = polygon[(polygon != np.roll(polygon, 1, axis=0)).any(axis=1)]
        return [polygon + self.points[i]] if len(polygon) > 2 else []

    def _rows(self, i: int) -> FloatArray:
        """Corners relative to the site, with the site beyond the edge from each."""
        fixed = (self.points, self.weights, i, self.partners, *self.starts[i : i + 2], *self.region)
        rows = np.empty((64, 3))
        count = cells.cell_polygon(*fixed, rows)
        if count > len(rows):
            rows = np.empty((count, 3))
            cells.cell_polygon(*fixed, rows)
        return rows[:count]

    @cached_property
    def _measures(self) -> FloatArray:
        measures = np.empty((len(self), 3))
        fixed = (self.points, self.weights, self.starts, self.partners, self.region.corners, self.region.around)
        run(cells.measure_cells, [(*fixed, *piece, measures) for piece in pieces(len(self), _GRAIN)])
        measures[~self.present, 0] = 0
        return read_only(measures)

    @property
    def areas(self) -> FloatArray:
        """(n,) float64: the areas of all cells."""
        areas: FloatArray = self._measures[:, 0]
        return areas

    @property
    def centroids(self) -> FloatArray:
        """(n, 2) float64: the centroids of all cells; the site where a cell has no area."""
        centroids: FloatArray = self._measures[:, 1:]
        return centroids

    def __repr__(self) -> str:
        return f"Cells({len(self)})"


def _area(polygon: FloatArray) -> float:
    p = polygon - polygon[0]
    q = np.roll(p, -1, axis=0)
    return float((p[:, 0] * q[:, 1] - q[:, 0] * p[:, 1]).sum() / 2)
