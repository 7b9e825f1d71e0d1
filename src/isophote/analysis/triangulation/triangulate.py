"""Delaunay triangulations of points, with constraints or without."""

from __future__ import annotations

from typing import Any, Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.analysis.arrays import read_only
from isophote.analysis.triangulation.complex import DelaunayComplex
from isophote.analysis.triangulation.constrained import Crossings, constrain_triangles
from isophote.analysis.triangulation.given import finite_points, point_numbers
from isophote.analysis.triangulation.lifted import lifted_plane, lifted_space, outer_facets, qhull_simplices
from isophote.analysis.triangulation.plane import Triangles, triangulate_plane
from isophote.analysis.triangulation.result import Delaunay
from isophote.analysis.triangulation.space import triangulate_space
from isophote.errors import GeometryError

__all__ = ["Method", "delaunay", "delaunay_complex", "delaunay_plane"]

FloatArray: TypeAlias = npt.NDArray[np.float64]
Method: TypeAlias = Literal["direct", "lifted"]


def delaunay(
    points: npt.ArrayLike,
    edges: npt.ArrayLike | None = None,
    *,
    method: Method = "direct",
    crossings: Crossings = "error",
) -> Any:
    """The Delaunay triangulation of points (n, d): inside the sphere of a simplex lies no point.

    A `Delaunay` of points of the plane, a `DelaunayComplex` of space and more dimensions. Exact for all finite doubles
    in the plane and in space: equal points, points in a line, plane, circle or sphere, and grids included. Of points on
    one circle, any triangulation is one; which is found depends on nothing but the points and their order.

    Method "direct" divides and conquers in the plane and inserts point by point in space; "lifted" takes the lower hull
    of the points lifted to a paraboloid, by quickhull with the same exact predicates, which is slower and independent.
    From four dimensions on it is Qhull's, with its rounding.

    `edges`, (k, 2) numbers of points, are constraints in the plane: each becomes one or several sides, and besides no
    point lies inside the circle of a triangle that could see it. They tell inside from outside by how often they wind
    around it (`Delaunay.winding`, `Delaunay.inside`): outlines go counterclockwise, holes clockwise. Where they do not
    close up, `winding` is 1 for what they enclose together. Constraints that cross elsewhere than in a given point are
    an error, or, with crossings="split", get a new point there, rounded, behind those given.

    Raises `GeometryError` for other shapes, coordinates that are not finite, points that are not there, lifted points
    that span nothing, and for constraints that cross (naming them) or join a point to itself.
    """
    places = finite_points(points)
    if method not in ("direct", "lifted"):
        raise GeometryError(f'the method must be "direct" or "lifted", not {method!r}')
    if places.shape[1] < 2:
        raise GeometryError(f"points must have shape (n, d), d >= 2, but have {places.shape}")
    if places.shape[1] > 2:
        if edges is not None:
            raise GeometryError("constraints are for points of the plane, (n, 2)")
        return delaunay_complex(places, method)
    if edges is None:
        return delaunay_plane(places, method)
    if crossings not in ("error", "split"):
        raise GeometryError(f'crossings must be "error" or "split", not {crossings!r}')
    return _constrained(places, _checked(edges, len(places)), method, crossings)


def _checked(edges: npt.ArrayLike, count: int) -> npt.NDArray[np.int32]:
    checked = point_numbers(edges, 2, count, "constraints")
    wrong = np.flatnonzero(checked[:, 0] == checked[:, 1])
    if len(wrong):
        raise GeometryError(f"constraint number {wrong[0]} joins point {checked[wrong[0], 0]} to itself")
    return checked


def _constrained(points: FloatArray, edges: npt.NDArray[np.int32], method: Method, crossings: Crossings) -> Delaunay:
    found = _triangles(points, method)
    if len(found.corners) == 0:
        return delaunay_plane(points, method)
    working, winding, representative = constrain_triangles(points, found, edges, crossings)
    count = working.triangle_count
    return Delaunay(
        read_only(working.points[: working.point_count].copy()),
        read_only(working.corners[:count].copy()),
        read_only(working.neighbours[:count].copy()),
        read_only(found.hull),
        read_only(representative),
        read_only(working.fixed[:count] != 0),
        read_only(winding),
    )


def _triangles(points: FloatArray, method: Method) -> Triangles:
    return triangulate_plane(points) if method == "direct" else lifted_plane(points)


def delaunay_plane(points: FloatArray, method: Method = "direct") -> Delaunay:
    """The Delaunay triangulation of finite points of the plane, (n, 2) float64."""
    found = _triangles(points, method)
    sides = found.corners.shape
    return Delaunay(
        read_only(points),
        read_only(found.corners),
        read_only(found.neighbours),
        read_only(found.hull),
        read_only(found.representative),
        read_only(np.zeros(sides, np.bool_)),
        read_only(np.zeros(sides[0], np.int32)),
    )


def delaunay_complex(points: FloatArray, method: Method = "direct") -> DelaunayComplex:
    """The Delaunay triangulation of finite points (n, d) float64, d at least 3."""
    if points.shape[1] == 3:
        found = triangulate_space(points) if method == "direct" else lifted_space(points)
        return DelaunayComplex(read_only(points), *map(read_only, found))
    (corners, neighbours), representative = qhull_simplices(points)
    hull = outer_facets(corners, neighbours)
    return DelaunayComplex(read_only(points), *map(read_only, (corners, neighbours, hull, representative)))
