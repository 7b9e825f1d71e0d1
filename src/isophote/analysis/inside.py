"""Inside and outside of meshes."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from isophote.analysis.crew import pieces, run
from isophote.analysis.prepared import points_for, prepared
from isophote.kernels.measure.winding import winding_numbers as fill
from isophote.shapes.mesh import Mesh

__all__ = ["contains", "winding_number"]

_A_JOB = 16_384


def winding_number(mesh: Mesh, points: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """(n,) float64: how often `mesh` winds round each of `points`, (n, 3): the solid angle of its faces over 4π.

    For a closed, oriented mesh whole numbers, and the right ones for all doubles: 1 inside, 0 outside, 2 where it
    overlaps itself, -1 inside a mesh whose faces look inward. A point on such a mesh counts as moved from it by
    nothing but a sign, along (ε, ε², ε³). For meshes with holes a smooth function between, to about 1e-15; on the mesh
    itself it jumps, and there one of the two values comes out. Faces of more than three corners are taken as their
    triangles. (Jacobson, Kavan, Sorkine-Hornung: "Robust Inside-Outside Segmentation using Generalized Winding
    Numbers", 2013.) Raises `GeometryError` for points that are not finite or not (n, 3).
    """
    return _winding(mesh, points)[0]


def contains(mesh: Mesh, points: npt.ArrayLike) -> npt.NDArray[np.bool_]:
    """(n,) bool: whether each of `points`, (n, 3), lies in the solid that `mesh` bounds, or on its surface.

    Inside is where |winding number| > 1/2: exact for closed meshes, sensible for those with holes, overlaps and
    intersections. Whether a point lies on the surface is decided exactly. Faces must look consistently outward or
    inward. Errors as `winding_number`.
    """
    winding, on = _winding(mesh, points)
    inside: npt.NDArray[np.bool_] = (np.abs(winding) > 0.5) | (on != 0)
    return inside


def _winding(mesh: Mesh, points: npt.ArrayLike) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int32]]:
    ready = prepared(mesh)
    query = points_for(points, ready.distance)
    numbers, on = np.empty(len(query)), np.empty(len(query), np.int32)
    words = ready.distance.table.words
    run(fill, [(words, query, *piece, numbers, on) for piece in pieces(len(query), _A_JOB)])
    return numbers, on
