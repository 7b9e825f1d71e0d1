"""How far points are from a mesh, and where it is closest."""

from __future__ import annotations

import attrs
import numpy as np
import numpy.typing as npt

from isophote.analysis.arrays import read_only
from isophote.analysis.crew import pieces, run
from isophote.analysis.prepared import points_for, prepared
from isophote.kernels.measure.closest import closest_points
from isophote.kernels.measure.signed import signed_distances
from isophote.shapes.mesh import Mesh

__all__ = ["ClosestPoints", "closest_point", "distance", "signed_distance"]

_A_JOB = 8192


@attrs.frozen(eq=False)
class ClosestPoints:
    """The points of a mesh that are closest to n given ones.

    `points` (n, 3) float64 and `distance` (n,) float64, in the mesh's units; `face` (n,) int32, the face each lies on
    (of several at the same distance, the first); `barycentric` (n, 3) float64, not negative and of sum 1, the weights
    of the vertices `vertices` (n, 3) int32: those of the face, or of the triangle of it if it has more corners.
    """

    points: npt.NDArray[np.float64]
    distance: npt.NDArray[np.float64]
    face: npt.NDArray[np.int32]
    barycentric: npt.NDArray[np.float64]
    vertices: npt.NDArray[np.int32]


def closest_point(mesh: Mesh, points: npt.ArrayLike) -> ClosestPoints:
    """The point of `mesh` that is closest to each of `points`, (n, 3).

    Double precision throughout. The tree over the mesh is kept for further queries of the same mesh. Raises
    `GeometryError` for points that are not finite or not (n, 3).
    """
    ready = prepared(mesh)
    query = points_for(points, ready.distance)
    count = len(query)
    places, weights = np.empty((count, 3)), np.empty((count, 3))
    far, numbers = np.empty(count), np.empty(count, np.int32)
    words = ready.distance.table.words
    run(closest_points, [(words, query, *piece, places, far, numbers, weights) for piece in pieces(count, _A_JOB)])
    face, corners = ready.triangles.face[numbers], ready.triangles.triangles[numbers]
    return ClosestPoints(*(read_only(array) for array in (places, far, face, weights, corners)))


def distance(mesh: Mesh, points: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """(n,) float64: distances of `points`, (n, 3), from the nearest point of `mesh`. Errors as `closest_point`."""
    ready = prepared(mesh)
    query = points_for(points, ready.distance)
    far, none, no_numbers = np.empty(len(query)), np.empty((0, 3)), np.empty(0, np.int32)
    words = ready.distance.table.words
    run(closest_points, [(words, query, *piece, none, far, no_numbers, none) for piece in pieces(len(query), _A_JOB)])
    return far


def signed_distance(mesh: Mesh, points: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """(n,) float64: the distance of each of `points`, (n, 3), to `mesh`, negative inside, 0 on the mesh.

    Inside is where `contains` says so: where the mesh winds round the point more than half a time, so that meshes with
    holes, overlaps and intersections have an inside too. Errors as `closest_point`.
    """
    ready = prepared(mesh)
    query = points_for(points, ready.distance)
    far = np.empty(len(query))
    run(signed_distances, [(ready.distance.table.words, query, *p, far) for p in pieces(len(query), _A_JOB)])
    return far
