"""Power diagrams: Voronoi diagrams of points with weights."""

from __future__ import annotations

from functools import cached_property
from typing import TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.analysis.arrays import read_only
from isophote.analysis.diagrams.cells import Cells
from isophote.analysis.diagrams.region import Region, region
from isophote.analysis.triangulation.given import finite_points
from isophote.errors import GeometryError
from isophote.kernels.measure import cells

__all__ = ["PowerDiagram", "power_diagram"]

FloatArray: TypeAlias = npt.NDArray[np.float64]
IntArray: TypeAlias = npt.NDArray[np.int32]

_SITES_A_SQUARE = 2
_PARTNERS_A_SITE = 8


@attrs.frozen(eq=False, repr=False, slots=False)
class PowerDiagram:
    """For each site p with weight w, all x at which |x - p|² - w is least, clipped to a polygon.

    points    (n, 2) float64
    weights   (n,) float64: squares of radii, where sites are circles; a site of little weight may have no cell
    region    the polygon that cells are clipped to
    pairs     (k, 2) int32: sites whose cells share an edge within the convex hull of the bounds, each pair twice
    """

    points: FloatArray
    weights: FloatArray
    region: Region
    pairs: IntArray

    @property
    def bounds(self) -> FloatArray:
        """(k, 2) float64: the corners of the polygon that cells are clipped to, counterclockwise."""
        return self.region.corners

    @cached_property
    def cells(self) -> Cells:
        """The cells of all sites, clipped to `bounds`."""
        count = len(self.points)
        starts = np.zeros(count + 1, np.int64)
        np.cumsum(np.bincount(self.pairs[:, 0], minlength=count), out=starts[1:])
        present = _present(self.points, self.weights, starts)
        return Cells(self.points, self.weights, starts, self.pairs[:, 1].copy(), self.region, present)

    def __repr__(self) -> str:
        return f"PowerDiagram({len(self.points)} sites, {int((self.cells.areas > 0).sum())} cells)"


def _present(points: FloatArray, weights: FloatArray, starts: npt.NDArray[np.int64]) -> npt.NDArray[np.bool_]:
    """Sites that have partners; where none has, the one cell is that of the greatest weight, first of all."""
    present: npt.NDArray[np.bool_] = np.diff(starts) > 0
    if len(points) and not present.any():
        present[int(np.argmax(weights))] = True
    return present


def power_diagram(points: npt.ArrayLike, weights: npt.ArrayLike, bounds: npt.ArrayLike | None = None) -> PowerDiagram:
    """The power diagram of points (n, 2) with weights (n,): the Voronoi diagram where all are equal.

    Each cell is cut out of the bounds by the lines to the sites around, ring by ring of a grid, until those that follow
    are too far away (as in Rycroft's Voro++, 2009). `bounds` are as in `voronoi`. Of points that are equal the one with
    the greatest weight has a cell, the first of several. Rounded; n² steps at worst, where weights differ by more than
    the square of the size. Raises `GeometryError` as `voronoi` does, and for weights that are not finite.
    """
    places = finite_points(points, 2)
    try:
        heavy = np.ascontiguousarray(np.broadcast_to(np.asarray(weights, np.float64), len(places)))
    except (TypeError, ValueError):
        raise GeometryError(f"weights must be a number for each of {len(places)} points") from None
    if not np.isfinite(heavy).all():
        raise GeometryError("weights must be finite")
    within = region(bounds, places)
    return PowerDiagram(read_only(places), read_only(heavy), within, read_only(_pairs(places, heavy, within)))


def _pairs(points: FloatArray, weights: FloatArray, within: Region) -> IntArray:
    """(k, 2) sites and their partners, in the order of the sites."""
    sites = _heaviest(points, weights)
    if len(sites) == 0:
        return np.empty((0, 2), np.int32)
    places, heavy = np.ascontiguousarray(points[sites]), np.ascontiguousarray(weights[sites])
    low, high = places.min(axis=0), places.max(axis=0)
    side = max(int(np.sqrt(len(sites) / _SITES_A_SQUARE)), 1)
    width = max(float((high - low).max()) / side, np.finfo(np.float64).tiny)
    grid = np.clip((places - low) / width, 0, side - 1).astype(np.int32)
    square = grid[:, 1].astype(np.int64) * side + grid[:, 0]
    first, following = np.full(side * side, -1, np.int32), np.full(len(sites), -1, np.int32)
    order = np.argsort(square, kind="stable")
    same = square[order[1:]] == square[order[:-1]]
    following[order[:-1][same]] = order[1:][same]
    heads = order[np.concatenate([[True], ~same])]
    first[square[heads]] = heads
    fixed = (places, heavy, grid, first, following, side, width, within.around, 0, len(sites))
    found = np.empty((_PARTNERS_A_SITE * len(sites), 2), np.int32)
    count = cells.power_partners(*fixed, found)
    if count > len(found):
        found = np.empty((count, 2), np.int32)
        cells.power_partners(*fixed, found)
    pairs: IntArray = sites[found[:count]].astype(np.int32)
    return pairs[np.argsort(pairs[:, 0], kind="stable")]


def _heaviest(points: FloatArray, weights: FloatArray) -> npt.NDArray[np.int64]:
    """The sites, ascending, of which of several at the same place only the heaviest."""
    order = np.lexsort((np.arange(len(points)), -weights, points[:, 1], points[:, 0]))
    new = np.ones(len(points), np.bool_)
    np.any(points[order[1:]] != points[order[:-1]], axis=1, out=new[1:])
    sites: npt.NDArray[np.int64] = np.sort(order[new])
    return sites
