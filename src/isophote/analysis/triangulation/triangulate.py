"""Delaunay triangulations of points, with constraints or without."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from isophote.analysis.arrays import read_only
from isophote.analysis.triangulation.given import finite_points
from isophote.analysis.triangulation.plane import triangulate_plane
from isophote.analysis.triangulation.result import Delaunay

__all__ = ["delaunay"]


def delaunay(points: npt.ArrayLike) -> Delaunay:
    """The Delaunay triangulation of points of the plane, (n, 2): no point lies inside the circle of a triangle.

    Exact for all finite doubles: equal points, points on a line or a circle, and grids included. Of points on one
    circle, any triangulation is one; which is found depends on nothing but the points and their order. Raises
    `GeometryError` for other shapes and for coordinates that are not finite.
    """
    places = finite_points(points, 2)
    found = triangulate_plane(places)
    sides = found.corners.shape
    return Delaunay(
        read_only(places),
        read_only(found.corners),
        read_only(found.neighbours),
        read_only(found.hull),
        read_only(found.representative),
        read_only(np.zeros(sides, np.bool_)),
        read_only(np.zeros(sides[0], np.int32)),
    )
