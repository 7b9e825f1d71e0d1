"""Meshes with fewer triangles."""

from __future__ import annotations

import math
import warnings

import numpy as np
import numpy.typing as npt

from isophote.convert.triangulate import triangulate
from isophote.errors import GeometryError, IsophoteWarning
from isophote.kernels.measure.collapse import collapse_edges, prepare_collapse
from isophote.kernels.measure.rings import MOST_AROUND, fill_rings
from isophote.shapes.mesh import Mesh

__all__ = ["simplify"]


def simplify(mesh: Mesh, faces: int | None = None, *, error: float | None = None) -> Mesh:
    """A mesh of at most `faces` triangles, or of as few as keep within `error` of it, or both.

    Edges become points, the one that moves the surface least first; `error` is the root mean square of the distances
    from such a point to the planes that it stands for, in the mesh's unit. The mesh is connected as before: no hole is
    opened or closed, boundaries stay where they are, and no triangle turns over; so some meshes cannot be brought
    below a number of triangles. Polygons are cut into triangles first. Attributes and labels are left out, with an
    `IsophoteWarning`.

    Raises `GeometryError` where neither is given, or one has no meaning.
    Source: Garland, Heckbert, "Surface Simplification Using Quadric Error Metrics", 1997.
    """
    wanted, most = _goal(faces, error)
    if mesh.attributes or mesh.labels:
        left_out = ", ".join([*mesh.attributes, *mesh.labels])
        warnings.warn(f"simplify leaves out attributes and labels: {left_out}", IsophoteWarning, stacklevel=2)
    cut = triangulate(mesh).triangles
    distinct = (cut[:, 0] != cut[:, 1]) & (cut[:, 1] != cut[:, 2]) & (cut[:, 2] != cut[:, 0])
    triangles = np.array(cut[distinct], np.int32)
    if len(triangles) == 0:
        raise GeometryError("the mesh has no triangles to simplify")
    # About the middle, and in units of the size: quadrics of far places cancel.
    low, high = mesh.bounds.astype(np.float64)
    middle, size = (low + high) / 2, float((high - low).max()) or 1.0
    positions = (mesh.vertices.astype(np.float64) - middle) / size
    _run(positions, triangles, wanted, most / size)
    kept = triangles[triangles[:, 0] >= 0]
    used, renumbered = np.unique(kept, return_inverse=True)
    return Mesh(positions[used] * size + middle, renumbered.reshape(-1, 3))


def _goal(faces: int | None, error: float | None) -> tuple[int, float]:
    if faces is None and error is None:
        raise GeometryError("simplify: give `faces`, the triangles to keep, or `error`, how far the surface may move")
    if faces is not None and (isinstance(faces, bool) or not isinstance(faces, int | np.integer) or faces < 1):
        raise GeometryError(f"simplify: faces must be a whole number above 0, not {faces!r}")
    if error is not None and not (isinstance(error, int | float) and math.isfinite(error) and error >= 0):
        raise GeometryError(f"simplify: error must be a finite number, 0 or above, not {error!r}")
    return (0 if faces is None else int(faces)), (math.inf if error is None else float(error))


def _run(positions: npt.NDArray[np.float64], triangles: npt.NDArray[np.int32], wanted: int, most: float) -> None:
    """Collapse edges in place."""
    count = len(positions)
    heads, following = np.full(count, -1, np.int32), np.empty(3 * len(triangles), np.int32)
    quadrics, on_rim = np.zeros((count, 11)), np.zeros(count, np.uint8)
    fill_rings(triangles, heads, following)
    prepare_collapse(positions, triangles, heads, following, quadrics, on_rim)
    room = 4 * len(triangles) + 4 * MOST_AROUND
    scratch = (np.empty(MOST_AROUND, np.int32), np.empty(MOST_AROUND, np.int32), np.empty(11))
    heap = (np.empty(room), np.empty((room, 4), np.int32))
    ages = np.zeros(count, np.int32)
    collapse_edges(
        positions, triangles, heads, following, quadrics, on_rim, ages, *heap, *scratch, len(triangles), wanted, most
    )
