"""Delaunay triangulations as lower hulls: points are lifted to a paraboloid, whose lower facets are the simplices.

Brown, "Voronoi diagrams from convex hulls", 1979. Independent of the other ways to triangulate, and a check of them.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.analysis.predicates import orient2d, orient3d
from isophote.analysis.triangulation.facets import Facets, lifted_facets
from isophote.analysis.triangulation.plane import Triangles
from isophote.analysis.triangulation.space import Tetrahedra, same_points
from isophote.errors import GeometryError

__all__ = ["boundary_cycle", "lifted_plane", "lifted_space", "outer_facets", "qhull_simplices"]

FloatArray: TypeAlias = npt.NDArray[np.float64]
IntArray: TypeAlias = npt.NDArray[np.int32]


def lifted_plane(points: FloatArray) -> Triangles:
    """The Delaunay triangulation of points (n, 2)."""
    corners, neighbours, representative = _lower(points)
    return Triangles(corners, neighbours, boundary_cycle(corners, neighbours), representative)


def lifted_space(points: FloatArray) -> Tetrahedra:
    """The Delaunay triangulation of points (n, 3)."""
    corners, neighbours, representative = _lower(points)
    return Tetrahedra(corners, neighbours, outer_facets(corners, neighbours), representative)


def _lower(points: FloatArray) -> tuple[IntArray, IntArray, IntArray]:
    representative = same_points(points)
    distinct = np.unique(representative)
    facets = lifted_facets(np.ascontiguousarray(points[distinct]))
    if facets is None:
        raise GeometryError(
            "all points lie on one circle or line, or sphere or plane, so their lifted hull is flat; triangulate them "
            "directly"
        )
    corners = distinct[facets.corners].astype(np.int32)
    places = [points[corners[:, k]] for k in range(corners.shape[1])]
    lower = (orient2d(*places) if len(places) == 3 else orient3d(*places)) > 0
    number = np.full(len(lower) + 1, -1, np.int32)
    number[:-1][lower] = np.arange(np.count_nonzero(lower), dtype=np.int32)
    return corners[lower], number[facets.neighbours[lower]], representative


def boundary_cycle(corners: IntArray, neighbours: IntArray) -> IntArray:
    """Points along the outer boundary of triangles, counterclockwise; it goes round once."""
    sides = outer_facets(corners, neighbours)
    following = dict(zip(sides[:, 0].tolist(), sides[:, 1].tolist(), strict=True))
    cycle = [int(sides[0, 0])]
    while following[cycle[-1]] != cycle[0]:
        cycle.append(following[cycle[-1]])
    return np.array(cycle, np.int32)


def outer_facets(corners: IntArray, neighbours: IntArray) -> IntArray:
    """The facets of simplices across which there is none, turned so that the outside is on their positive side.

    Sides of triangles have their triangle to the left; faces of tetrahedra are counterclockwise from outside.
    """
    found = []
    for k in range(corners.shape[1]):
        rest = [j for j in range(corners.shape[1]) if j != k]
        if len(rest) == 2 and k == 1:
            rest = [2, 0]
        if len(rest) == 3 and k % 2 == 0:
            rest = [rest[1], rest[0], rest[2]]
        found.append(corners[neighbours[:, k] < 0][:, rest])
    return np.concatenate(found)


def qhull_simplices(points: FloatArray) -> tuple[Facets, IntArray]:
    """Simplices and the first of equal points, of four dimensions and more, by Qhull's lifted hull."""
    from scipy.spatial import Delaunay as QhullDelaunay
    from scipy.spatial import QhullError

    representative = same_points(points)
    distinct = np.unique(representative)
    try:
        found = QhullDelaunay(points[distinct])
    except (QhullError, ValueError) as error:
        raise GeometryError(
            f"Qhull finds no triangulation of {len(distinct)} distinct points of {points.shape[1]} dimensions: "
            f"{str(error).splitlines()[0]}"
        ) from None
    return Facets(distinct[found.simplices].astype(np.int32), found.neighbors.astype(np.int32)), representative
