"""Normals at the vertices of a mesh."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from isophote.analysis.curvature.fan import WEIGHTS, fans
from isophote.errors import GeometryError
from isophote.shapes.mesh import Mesh

__all__ = ["vertex_normals"]


def vertex_normals(mesh: Mesh, weights: str = "angle") -> npt.NDArray[np.float64]:
    """(n, 3) unit normals at the vertices: the sum of the faces' normals by a weight, N = Σ wᵢ Nᵢ / |Σ wᵢ Nᵢ|.

    `weights`: "angle", the face's angle at the vertex, which is the limit of the mean normal within a circle around
    the vertex as the circle shrinks, and doesn't change with how faces are cut into triangles; "area", the area of
    the triangle; "uniform", 1. Zeros at vertices without faces, and where normals cancel. Polygons count by their
    triangles.

    Source: Thürmer, Wüthrich, "Computing Vertex Normals from Polygonal Facets", 1998.
    """
    if weights not in WEIGHTS:
        raise GeometryError(f"weights must be one of {', '.join(map(repr, WEIGHTS))}, not {weights!r}")
    return fans(mesh).normals(weights)
