"""Meshes and points made ready for queries: checked, cut into triangles, with a tree kept for the next query."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from isophote.accel.mesh_distance import MeshDistance, build_mesh_distance
from isophote.convert.triangulate import Triangles, triangulate
from isophote.errors import GeometryError
from isophote.kernels.measure.mesh_distance import FURTHEST
from isophote.latest import Latest
from isophote.shapes.mesh import Mesh

__all__ = ["Prepared", "points_for", "prepared"]


class Prepared(NamedTuple):
    """A mesh's triangles, and its table for distances and winding numbers."""

    triangles: Triangles
    distance: MeshDistance


def _arrays(mesh: Mesh) -> tuple[npt.NDArray[Any], ...]:
    """The arrays that make a mesh what it is to queries. They cannot be written to, so they stand for the mesh."""
    return mesh.vertices, mesh.indices, mesh.offsets


_latest: Latest[Prepared] = Latest()


def prepared(mesh: Mesh) -> Prepared:
    """The mesh made ready for queries, or what was made of it for the last one."""
    found = _latest.find(_arrays(mesh))
    if found is None:
        triangles = triangulate(mesh)
        found = Prepared(triangles, build_mesh_distance(mesh.vertices, triangles.triangles))
        _latest.keep(_arrays(mesh), found)
    return found


def points_for(points: npt.ArrayLike, mesh: MeshDistance) -> npt.NDArray[np.float64]:
    """Query points as (n, 3) contiguous float64.

    Raises `GeometryError` for other shapes, points that are not finite, and points so far away that square distances
    overflow (1e60 sizes of the mesh).
    """
    try:
        # Writeable: for arrays that are not, kernels would be compiled once more.
        given = np.require(points, np.float64, ["C", "W"])
    except (TypeError, ValueError) as error:
        raise GeometryError(f"points must be numbers of shape (n, 3): {error}") from error
    if given.shape == (3,):
        given = given[None]
    if given.ndim != 2 or given.shape[1] != 3:
        raise GeometryError(f"points must have shape (n, 3), but have {given.shape}")
    furthest = FURTHEST / mesh.scale
    # NaN fails the comparison too.
    if not max(given.max(initial=0.0), -given.min(initial=0.0)) < furthest:
        bad = int(np.argmin(np.abs(given).max(axis=1) < furthest))
        raise GeometryError(f"point {bad} is not finite, or too far from the mesh: {given[bad].tolist()}")
    return given
