"""Convex hulls of points of the plane, of space and of more dimensions."""

from __future__ import annotations

from math import factorial
from typing import TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.analysis.arrays import read_only
from isophote.analysis.predicates import orient3d
from isophote.analysis.triangulation.facets import Facets, hull_facets
from isophote.analysis.triangulation.given import finite_points
from isophote.errors import GeometryError
from isophote.kernels.measure import hull2d

__all__ = ["ConvexHull", "convex_hull"]

FloatArray: TypeAlias = npt.NDArray[np.float64]
IntArray: TypeAlias = npt.NDArray[np.int32]


@attrs.frozen(eq=False)
class ConvexHull:
    """The convex hull of points of d dimensions.

    points      (n, d) float64
    vertices    (h,) int32 numbers of its corners: counterclockwise in the plane, else ascending
    facets      (f, d) int32: its sides, or triangles, counterclockwise seen from outside, or simplices
    neighbours  (f, d) int32: the facet opposite each corner
    """

    points: FloatArray
    vertices: IntArray
    facets: IntArray
    neighbours: IntArray

    @property
    def volume(self) -> float:
        """The volume, in the plane the area, in units of the points' to the power d."""
        if len(self.facets) == 0:
            return 0.0
        corners = self.points[self.facets] - self.points[self.vertices].mean(axis=0)
        return float(np.abs(np.linalg.det(corners)).sum() / factorial(self.points.shape[1]))

    @property
    def surface(self) -> float:
        """The area of the surface, in the plane the length of the boundary."""
        corners = self.points[self.facets]
        sides = corners[:, 1:] - corners[:, :1]
        gram = np.linalg.det(sides @ sides.transpose(0, 2, 1))
        return float(np.sqrt(np.maximum(gram, 0)).sum() / factorial(self.points.shape[1] - 1))

    def __repr__(self) -> str:
        return f"ConvexHull({len(self.points)} points, {len(self.vertices)} vertices, {len(self.facets)} facets)"


def convex_hull(points: npt.ArrayLike) -> ConvexHull:
    """The convex hull of points (n, d), d at least 2.

    Exact up to four dimensions: every point lies inside or on every facet. In the plane and in space, `vertices` are
    just the corners, without points inside of sides or faces; on a line in the plane they are its ends. Beyond four
    dimensions by Qhull, with its rounding. Raises `GeometryError` for other shapes, coordinates that are not finite, no
    points, and points of space (or more) that lie in one plane (or flat).
    """
    places = finite_points(points)
    dimension = places.shape[1]
    if dimension < 2 or len(places) == 0:
        raise GeometryError(f"a convex hull needs points (n, d), n >= 1 and d >= 2, but they are {places.shape}")
    if dimension == 2:
        return _plane_hull(places)
    if dimension > 4:
        return _of_facets(places, _by_qhull(places))
    facets = hull_facets(places)
    if facets is None:
        raise GeometryError(_flat(dimension))
    if dimension == 3:
        facets = _with_corners_only(places, facets)
    return _of_facets(places, facets)


def _flat(dimension: int) -> str:
    what = "plane" if dimension == 3 else "flat of fewer dimensions"
    return f"all points lie in one {what}: drop a coordinate for their hull in it"


def _plane_hull(points: FloatArray) -> ConvexHull:
    outer = _near_hull(points)
    order = outer[np.lexsort((points[outer, 1], points[outer, 0]))]
    ordered = points[order]
    differs = np.ones(len(ordered), np.bool_)
    differs[1:] = (ordered[1:] != ordered[:-1]).any(axis=1)
    hull = np.empty(2 * len(order), np.int32)
    vertices = hull[: hull2d.hull_chains(points, order[differs], hull)].copy()
    if len(vertices) == 1:
        sides = np.empty((0, 2), np.int32)
        return ConvexHull(read_only(points), read_only(vertices), read_only(sides), read_only(sides))
    facets = np.stack([vertices, np.roll(vertices, -1)], axis=1)
    number = np.arange(len(vertices), dtype=np.int32)
    neighbours = np.stack([np.roll(number, -1), np.roll(number, 1)], axis=1)
    return ConvexHull(read_only(points), read_only(vertices), read_only(facets), read_only(neighbours))


def _near_hull(points: FloatArray) -> IntArray:
    """Numbers of the points that do not lie strictly inside the polygon of the furthest in eight directions.

    The polygon may be wrong in last places, and is then no hull; a point inside it lies within the hull nevertheless,
    if the polygon is convex, which `near_hull` sees by strictly left turns alone.
    """
    polygon = np.empty(8, np.int32)
    hull2d.extreme_points(points, polygon)
    polygon = polygon[polygon != np.roll(polygon, 1)]
    found = np.empty(len(points), np.int32)
    if len(polygon) < 3:
        return np.arange(len(points), dtype=np.int32)
    return found[: hull2d.near_hull(points, polygon, found)]


def _with_corners_only(points: FloatArray, facets: Facets) -> Facets:
    """The facets without vertices inside of faces and edges: those where fewer than three creases meet."""
    used = np.unique(facets.corners)
    creases = np.zeros(len(points), np.int64)
    for k in range(3):
        across = facets.neighbours[:, k]
        far = facets.corners[across].sum(axis=1) - facets.corners[:, [(k + 1) % 3, (k + 2) % 3]].sum(axis=1)
        a, b, c = (points[facets.corners[:, j]] for j in range(3))
        crease = orient3d(a, b, c, points[far]) != 0
        for j in ((k + 1) % 3, (k + 2) % 3):
            np.add.at(creases, facets.corners[crease, j], 1)
    # Each crease was met from both its sides.
    corners = used[creases[used] >= 6]
    if len(corners) == len(used):
        return facets
    again = hull_facets(points[corners])
    assert again is not None
    return Facets(corners.astype(np.int32)[again.corners], again.neighbours)


def _of_facets(points: FloatArray, facets: Facets) -> ConvexHull:
    corners, neighbours = facets
    if points.shape[1] == 3:
        # A positive determinant is clockwise from where the point is.
        corners, neighbours = corners[:, [1, 0, 2]], neighbours[:, [1, 0, 2]]
    vertices = np.unique(corners).astype(np.int32)
    return ConvexHull(read_only(points), read_only(vertices), read_only(corners), read_only(neighbours))


def _by_qhull(points: FloatArray) -> Facets:
    from scipy.spatial import ConvexHull as QhullHull
    from scipy.spatial import QhullError

    try:
        hull = QhullHull(points)
    except QhullError as error:
        raise GeometryError(f"{_flat(points.shape[1])} (Qhull: {str(error).splitlines()[0]})") from None
    return Facets(hull.simplices.astype(np.int32), hull.neighbors.astype(np.int32))
