"""Voronoi diagrams, and their relaxation."""

from __future__ import annotations

from typing import Literal, TypeAlias

import numpy as np
import numpy.typing as npt
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from isophote.analysis.arrays import read_only
from isophote.analysis.diagrams.dual import Dual
from isophote.analysis.diagrams.region import region
from isophote.analysis.diagrams.result import Voronoi
from isophote.analysis.diagrams.sweep import divided, swept
from isophote.analysis.triangulation.given import finite_points
from isophote.errors import GeometryError

__all__ = ["lloyd", "voronoi"]

FloatArray: TypeAlias = npt.NDArray[np.float64]
IntArray: TypeAlias = npt.NDArray[np.int32]

_METHODS = {"dual": divided, "sweep": swept}


def voronoi(
    points: npt.ArrayLike, bounds: npt.ArrayLike | None = None, method: Literal["dual", "sweep"] = "dual"
) -> Voronoi:
    """The Voronoi diagram of points of the plane, (n, 2), its cells clipped to `bounds`.

    `bounds` are the corners of a simple polygon, (k, 2); without them, the box of the points with some room. From a
    Delaunay triangulation by dividing and conquering, on all processors; or with `method="sweep"` by Fortune's sweep
    ("A Sweepline Algorithm for Voronoi Diagrams", 1987), on one of them. What comes out is the same but for the order
    of vertices and edges. Which sites share an edge or a vertex is exact for all finite doubles;
    vertices are rounded. Equal points are one site. Raises `GeometryError` for other shapes, coordinates that are not
    finite, and bounds that cross themselves or enclose nothing.
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
    found = voronoi(points, bounds)
    for _ in range(iterations):
        found = voronoi(found.cells.centroids, found.bounds)
    return found


def _diagram(points: FloatArray, bounds: npt.ArrayLike | None, dual: Dual) -> Voronoi:
    vertices, edges, sites = _whole(dual) if dual.edges.ties else dual.edges[:3]
    if len(dual.corners) == 0:
        sites = np.stack([dual.hull[:-1], dual.hull[1:]], axis=1)
        edges = np.full(sites.shape, -1, np.int32)
    return Voronoi(
        read_only(points),
        read_only(vertices),
        read_only(edges),
        read_only(sites),
        read_only(dual.representative),
        region(bounds, points),
        dual,
    )


def _whole(dual: Dual) -> tuple[FloatArray, IntArray, IntArray]:
    """Vertices, edges and their sites, with one vertex for all triangles on a circle, and no edges between those."""
    told = dual.edges
    count, tied = len(dual.corners), told.signs == 0
    links = (np.ones(told.ties, np.bool_), tuple(told.edges[tied].T))
    classes = connected_components(coo_array(links, shape=(count, count)), directed=False)[1]
    _, first, number = np.unique(classes, return_index=True, return_inverse=True)
    # One more for the end of a ray.
    names = np.append(number, -1).astype(np.int32)
    return told.middles[first], names[told.edges[~tied]], told.sites[~tied]
