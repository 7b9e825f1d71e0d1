"""Voronoi diagrams as duals of Delaunay triangulations."""

from __future__ import annotations

from typing import Literal, TypeAlias

import numpy as np
import numpy.typing as npt
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from isophote.analysis.arrays import read_only
from isophote.analysis.crew import pieces, run
from isophote.analysis.diagrams.region import region
from isophote.analysis.diagrams.result import Voronoi
from isophote.analysis.diagrams.sweep import Dual, Sides, divided, swept
from isophote.analysis.triangulation.given import finite_points
from isophote.analysis.triangulation.plane import Triangles
from isophote.analysis.triangulation.result import Delaunay
from isophote.errors import GeometryError
from isophote.kernels.measure import diagram

__all__ = ["lloyd", "voronoi"]

FloatArray: TypeAlias = npt.NDArray[np.float64]
IntArray: TypeAlias = npt.NDArray[np.int32]

_GRAIN = 65536
_METHODS = {"sweep": swept, "dual": divided}


def voronoi(
    points: npt.ArrayLike, bounds: npt.ArrayLike | None = None, method: Literal["sweep", "dual"] = "sweep"
) -> Voronoi:
    """The Voronoi diagram of points of the plane, (n, 2), its cells clipped to `bounds`.

    `bounds` are the corners of a simple polygon, (k, 2); without them, the box of the points with some room. By
    Fortune's sweep ("A Sweepline Algorithm for Voronoi Diagrams", 1987), or with `method="dual"` from a Delaunay
    triangulation by dividing and conquering; what comes out is the same. Which sites share an edge or a vertex is exact
    for all finite doubles; vertices are rounded. Equal points are one site. Raises `GeometryError` for other shapes,
    coordinates that are not finite, and bounds that cross themselves or enclose nothing.
    """
    if method not in _METHODS:
        raise GeometryError(f"the method must be one of {', '.join(_METHODS)}, not {method!r}")
    places = finite_points(points, 2)
    return _diagram(places, bounds, _METHODS[method](places))


def lloyd(points: npt.ArrayLike, bounds: npt.ArrayLike | None = None, iterations: int = 10) -> Voronoi:
    """The Voronoi diagram after moving each site to the centroid of its cell, so many times.

    Cells become more and more alike, and round (Lloyd, "Least squares quantization in PCM", 1982). `bounds` are as in
    `voronoi`, and hold the sites from the first iteration on. Raises `GeometryError` as `voronoi` does.
    """
    if isinstance(iterations, bool) or not isinstance(iterations, int | np.integer) or iterations < 0:
        raise GeometryError(f"iterations must be a whole number, 0 or more, not {iterations!r}")
    found = voronoi(points, bounds, "dual")
    for _ in range(iterations):
        found = voronoi(found.cells.centroids, found.bounds, "dual")
    return found


def _diagram(points: FloatArray, bounds: npt.ArrayLike | None, dual: Dual) -> Voronoi:
    found, sides, middles = dual
    vertices, vertex = _vertices(found, sides, middles)
    edges, sites = _edges(found, sides, vertex)
    flat = np.zeros(found.corners.shape, np.bool_)
    triangulation = Delaunay(
        read_only(points),
        read_only(found.corners),
        read_only(found.neighbours),
        read_only(found.hull),
        read_only(found.representative),
        read_only(flat),
        read_only(np.zeros(len(flat), np.int32)),
    )
    return Voronoi(
        read_only(points),
        read_only(vertices),
        read_only(edges),
        read_only(sites),
        read_only(found.representative),
        region(bounds, points),
        triangulation,
    )


def _vertices(found: Triangles, sides: Sides, middles: FloatArray) -> tuple[FloatArray, IntArray]:
    """(v, 2) vertices, and the number of that of each triangle: the same for triangles on one circle."""
    count = len(found.corners)
    if sides.ties == 0:
        return middles, np.arange(count, dtype=np.int32)
    triangle, side = np.nonzero((sides.signs == 0) & (found.neighbours >= 0))
    links = (np.ones(len(triangle), np.bool_), (triangle, found.neighbours[triangle, side]))
    classes = connected_components(coo_array(links, shape=(count, count)), directed=False)[1]
    _, first, number = np.unique(classes, return_index=True, return_inverse=True)
    return middles[first], number.astype(np.int32)


def _edges(found: Triangles, sides: Sides, vertex: IntArray) -> tuple[IntArray, IntArray]:
    """(e, 2) vertices of edges, and the sites to their left and right."""
    if len(found.corners) == 0:
        between = np.stack([found.hull[:-1], found.hull[1:]], axis=1)
        return np.full(between.shape, -1, np.int32), between
    ranges = list(pieces(len(found.corners), _GRAIN))
    counts = run(diagram.count_edges, [(found.neighbours, sides.signs, *piece) for piece in ranges])
    starts = np.cumsum([0, *counts]).tolist()
    edges, sites = np.empty((starts[-1], 2), np.int32), np.empty((starts[-1], 2), np.int32)
    fixed = (found.corners, found.neighbours, sides.signs, vertex)
    jobs = [(*fixed, *piece, at, edges, sites) for piece, at in zip(ranges, starts[:-1], strict=True)]
    run(diagram.write_edges, jobs)
    return edges, sites
