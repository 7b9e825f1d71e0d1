"""Delaunay triangulations as Voronoi diagrams see them: the middles of circles, and the edges between triangles."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.analysis.crew import pieces, run
from isophote.analysis.diagrams.order import Scaled
from isophote.kernels.measure import diagram

__all__ = ["Dual", "Edges", "told"]

FloatArray: TypeAlias = npt.NDArray[np.float64]
IntArray: TypeAlias = npt.NDArray[np.int32]

# Triangles whose edges and middles are made while they are in a processor's cache.
_GRAIN = 16384


class Edges(NamedTuple):
    """What triangles tell.

    middles (m, 2) of their circles; edges (e, 2), the triangles on both sides, -1 for none; sites (e, 2), names of the
    sites to the left and to the right; signs (e,) int8, 0 where four sites lie on a circle; how many are wrong, and
    how many lie on a circle.
    """

    middles: FloatArray
    edges: IntArray
    sites: IntArray
    signs: npt.NDArray[np.int8]
    wrong: int
    ties: int


class Dual(NamedTuple):
    """A Delaunay triangulation: `corners` are numbers of sites, whose numbers as points are `names`; `hull` and
    `representative` are numbers of points."""

    names: IntArray
    corners: IntArray
    neighbours: IntArray
    hull: IntArray
    representative: IntArray
    edges: Edges


def told(sites: Scaled, names: IntArray, corners: IntArray, neighbours: IntArray) -> Edges:
    """The middles and edges of triangles with their neighbours, on all processors."""
    ranges = list(pieces(len(corners), _GRAIN))
    rows = np.cumsum([0, *run(diagram.count_edges, [(neighbours, *piece) for piece in ranges])]).tolist()
    middles, count = np.empty((len(corners), 2)), rows[-1]
    edges, between, signs = np.empty((count, 2), np.int32), np.empty((count, 2), np.int32), np.empty(count, np.int8)
    places, triangles = sites.places.reshape(-1), corners.reshape(-1)
    flat = edges.reshape(-1), between.reshape(-1)

    def tell(begin: int, end: int, row: int, stop: int) -> tuple[int, int]:
        diagram.centres(places, triangles, begin, end, middles.reshape(-1))
        diagram.write_edges(triangles, neighbours.reshape(-1), begin, end, row, stop, *flat)
        found: tuple[int, int] = diagram.edge_signs(places, triangles, *flat, row, stop, signs)
        diagram.name_rows(names, row, stop, flat[1])
        return found

    counts = run(tell, [(*piece, *span) for piece, span in zip(ranges, pairwise(rows), strict=True)])
    if sites.exponent:
        with np.errstate(over="ignore"):
            middles = np.ldexp(middles, sites.exponent)
    return Edges(middles, edges, between, signs, sum(wrong for wrong, _ in counts), sum(ties for _, ties in counts))
