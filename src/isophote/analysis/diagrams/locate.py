"""Nearest sites, by walking from cell to cell."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.analysis.crew import pieces, run
from isophote.analysis.triangulation.given import finite_points
from isophote.errors import GeometryError
from isophote.kernels.measure import diagram

if TYPE_CHECKING:
    from isophote.analysis.diagrams.cells import Cells

__all__ = ["nearest_sites", "partner_lists"]

FloatArray: TypeAlias = npt.NDArray[np.float64]
IntArray: TypeAlias = npt.NDArray[np.int32]

_GRAIN = 65536
# Sites for each square of the grid that walks start from.
_SITES_A_SQUARE = 2


def partner_lists(pairs: IntArray, count: int) -> tuple[npt.NDArray[np.int64], IntArray]:
    """(starts, partners): those of site i are partners[starts[i]:starts[i + 1]]."""
    starts, partners = np.zeros(count + 1, np.int64), np.empty(2 * len(pairs), np.int32)
    diagram.link_sites(pairs, starts, partners)
    return starts, partners


def nearest_sites(cells: Cells, points: npt.ArrayLike) -> IntArray:
    """(q,) the nearest site to each of points (q, 2)."""
    queries = finite_points(points, 2)
    sites = np.flatnonzero(cells.present)
    if len(sites) == 0:
        raise GeometryError("there are no sites, so none is nearest")
    places = cells.points[sites]
    low, high = places.min(axis=0), places.max(axis=0)
    side = max(int(np.sqrt(len(sites) / _SITES_A_SQUARE)), 1)
    extent = np.maximum(high - low, np.finfo(np.float64).tiny)

    def square(where: FloatArray) -> npt.NDArray[np.int64]:
        at = np.clip((where - low) / extent * side, 0, side - 1).astype(np.int64)
        number: npt.NDArray[np.int64] = at[:, 1] * side + at[:, 0]
        return number

    # Squares without sites have some other one; walks from there are longer, and end at the same.
    start = np.full(side * side, sites[0], np.int32)
    start[square(places)] = sites
    found, first = np.empty(len(queries), np.int32), start[square(queries)]
    fixed = (cells.points, cells.starts, cells.partners, first, queries)
    run(diagram.nearest_sites, [(*fixed, *piece, found) for piece in pieces(len(queries), _GRAIN)])
    return found
