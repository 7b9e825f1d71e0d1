"""What a Voronoi diagram is."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from typing import TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.analysis.arrays import read_only
from isophote.analysis.diagrams.cells import Cells
from isophote.analysis.diagrams.dual import Dual
from isophote.analysis.diagrams.events import SweepEvent, sweep_events
from isophote.analysis.diagrams.locate import nearest_sites, partner_lists
from isophote.analysis.diagrams.region import Region
from isophote.analysis.triangulation.result import Delaunay

__all__ = ["Voronoi"]

FloatArray: TypeAlias = npt.NDArray[np.float64]
IntArray: TypeAlias = npt.NDArray[np.int32]


@attrs.frozen(eq=False, repr=False, slots=False)
class Voronoi:
    """The Voronoi diagram of points of the plane: for each site, all that is nearer to it than to any other.

    points           (n, 2) float64, the sites
    vertices         (v, 2) float64: what is equally near to three sites or more; more than three sites on one circle
                     make one vertex
    edges            (e, 2) int32 numbers of vertices; -1 at the second end of a ray, at both of a whole line
    edge_sites       (e, 2) int32: the sites to the left and to the right of an edge
    representative   (n,) int32: the first point that equals each; only such sites have cells
    region           the polygon that cells are clipped to
    """

    points: FloatArray
    vertices: FloatArray
    edges: IntArray
    edge_sites: IntArray
    representative: IntArray
    region: Region
    _dual: Dual

    @property
    def bounds(self) -> FloatArray:
        """(k, 2) float64: the corners of the polygon that cells are clipped to, counterclockwise."""
        return self.region.corners

    @cached_property
    def directions(self) -> FloatArray:
        """(e, 2) float64: the directions of edges, of unit length, from their first end to their second."""
        across = self.points[self.edge_sites[:, 0]] - self.points[self.edge_sites[:, 1]]
        with np.errstate(over="ignore"):
            across = across / np.abs(across).max(axis=1, keepdims=True)
        along = np.stack([across[:, 1], -across[:, 0]], axis=1)
        return read_only(along / np.hypot(along[:, 0], along[:, 1])[:, None])

    @cached_property
    def cells(self) -> Cells:
        """The cells of all points, clipped to `bounds`."""
        starts, partners = partner_lists(self.edge_sites, len(self.points))
        present = self.representative == np.arange(len(self.points))
        return Cells(self.points, np.zeros(len(self.points)), starts, partners, self.region, present)

    def neighbours(self, site: int) -> IntArray:
        """(m,) int32, ascending: the sites whose cells share an edge with that of a site."""
        cells = self.cells
        number = range(len(self.points))[site]
        return np.sort(cells.partners[cells.starts[number] : cells.starts[number + 1]])

    def delaunay(self) -> Delaunay:
        """The Delaunay triangulation of the points: the dual. Where more than three sites lie on a circle, one of
        several."""
        return self._triangulation

    @cached_property
    def _triangulation(self) -> Delaunay:
        corners = self._dual.names[self._dual.corners]
        return Delaunay(
            self.points,
            read_only(corners),
            read_only(self._dual.neighbours),
            read_only(self._dual.hull),
            self.representative,
            read_only(np.zeros(corners.shape, np.bool_)),
            read_only(np.zeros(len(corners), np.int32)),
        )

    def nearest(self, points: npt.ArrayLike) -> IntArray:
        """(q,) int32: the site nearest to each of points (q, 2); of equally near ones, any.

        Raises `GeometryError` where there are no sites, for other shapes, and for coordinates that are not finite.
        """
        return nearest_sites(self.cells, points)

    def replay(self) -> Iterator[SweepEvent]:
        """The states of Fortune's sweep over the points, event by event; see `SweepEvent`."""
        return sweep_events(self.points)

    def __repr__(self) -> str:
        rays = int((self.edges[:, 1] < 0).sum())
        count = int((self.representative == np.arange(len(self.points))).sum())
        return f"Voronoi({count} cells, {len(self.vertices)} vertices, {len(self.edges)} edges, {rays} of them endless)"
