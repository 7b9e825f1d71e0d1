"""How thick the walls of a solid are."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from isophote.analysis.crew import pieces, run
from isophote.analysis.prepared import prepared
from isophote.kernels.measure.thickness import thicknesses
from isophote.shapes.mesh import Mesh

__all__ = ["thickness"]

_A_JOB = 4096


def thickness(mesh: Mesh) -> npt.NDArray[np.float64]:
    """(m,) float64: for each face of a solid how thick the wall behind its middle is, in the mesh's units.

    Measured by a ray: from the face's centroid against its normal, to the next surface. (Balls that touch the face
    would be cut by its neighbours wherever flat faces stand for a curved surface.) Faces must look outward, or all
    inward. Infinite where nothing lies behind, NaN for faces without area. A face of more than three corners has the
    least of its triangles. Walls thinner than two millionths of the mesh's size are missed.
    """
    ready = prepared(mesh)
    # Twice halved, no difference or sum of coordinates overflows.
    corners = mesh.vertices[ready.triangles.triangles] * 0.25
    unit = corners * float(np.ldexp(1.0, -int(np.frexp(np.abs(corners).max())[1])))
    normals = np.cross(unit[:, 1] - unit[:, 0], unit[:, 2] - unit[:, 0])
    if np.einsum("ij,ij->", unit[:, 0] - unit[0, 0], normals) < 0:
        normals = -normals
    lengths = np.linalg.norm(normals, axis=1)
    sound = np.flatnonzero(lengths > 0)
    points = np.ascontiguousarray(4 * (corners[sound].sum(axis=1) / 3))
    units = normals[sound] / lengths[sound, None]
    found = np.empty(len(sound))
    words = ready.distance.table.words
    run(thicknesses, [(words, points, units, *p, found) for p in pieces(len(sound), _A_JOB)])
    least = np.full(mesh.face_count, np.nan)
    np.fmin.at(least, ready.triangles.face[sound], found)
    return least
