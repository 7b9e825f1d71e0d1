"""A mesh as kernels of curvature see it: triangles, and the corners at each vertex."""

from __future__ import annotations

from functools import cached_property
from typing import Any, NamedTuple, TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.analysis.crew import pieces, run
from isophote.convert.triangulate import triangulate
from isophote.errors import GeometryError
from isophote.kernels.measure.fans import (
    ANGLE,
    AREA,
    UNIFORM,
    corner_lists,
    fan_curvatures,
    fan_normals,
    neighbour_lists,
)
from isophote.shapes.mesh import Mesh

__all__ = ["WEIGHTS", "Fans", "Sums", "fans"]

Floats: TypeAlias = npt.NDArray[np.float64]

WEIGHTS = {"angle": ANGLE, "area": AREA, "uniform": UNIFORM}
_PIECE = 16_384


class Sums(NamedTuple):
    """What fan_curvatures gathers at each vertex."""

    angles: Floats
    areas: Floats
    means: Floats
    images: Floats


@attrs.frozen(eq=False)
class Fans:
    """`positions` (n, 3) float64, `triangles` (m, 3) int32, and corners at each vertex (kernels/measure/fans.py)."""

    positions: Floats
    triangles: npt.NDArray[np.int32]
    starts: npt.NDArray[np.int64]
    corners: npt.NDArray[np.int64]

    def normals(self, weights: str) -> Floats:
        """(n, 3) unit normals; zeros where there are no triangles or where they cancel."""
        out = np.zeros((len(self.positions), 3))
        jobs = ((*self._arrays, WEIGHTS[weights], a, b, out) for a, b in pieces(len(out), _PIECE))
        run(fan_normals, jobs)
        return out

    @cached_property
    def sums(self) -> Sums:
        """Angles, areas, mean curvature vectors and normals' images at each vertex."""
        n = len(self.positions)
        sums = Sums(np.zeros(n), np.zeros(n), np.zeros((n, 3)), np.zeros((n, 2)))
        normals = self.normals("angle")
        run(fan_curvatures, ((*self._arrays, normals, a, b, *sums) for a, b in pieces(n, _PIECE)))
        return sums

    @cached_property
    def neighbours(self) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int32]]:
        """Starts (n + 1,) and vertices: those that share an edge with each vertex."""
        first, found = np.empty_like(self.starts), np.empty(2 * len(self.corners), np.int32)
        mark = np.full(len(self.positions), -1, np.int32)
        count = neighbour_lists(self.triangles, self.starts, self.corners, mark, first, found)
        return first, found[:count]

    @cached_property
    def on_boundary(self) -> npt.NDArray[np.bool_]:
        """(n,): whether a vertex lies on an edge with one triangle, or three and more."""
        t = self.triangles.astype(np.int64)
        ends = np.concatenate([t[:, [0, 1]], t[:, [1, 2]], t[:, [2, 0]]])
        keys = ends.min(axis=1) * len(self.positions) + ends.max(axis=1)
        edges, counts = np.unique(keys, return_counts=True)
        odd = edges[counts != 2]
        result = np.zeros(len(self.positions), bool)
        result[odd // len(self.positions)] = True
        result[odd % len(self.positions)] = True
        return result

    @property
    def _arrays(self) -> tuple[npt.NDArray[Any], ...]:
        return self.positions, self.triangles, self.starts, self.corners


def fans(mesh: Mesh) -> Fans:
    """The fans of a mesh of triangles or polygons, which are triangulated. Raises `GeometryError` for no faces."""
    if not isinstance(mesh, Mesh):
        raise GeometryError(f"curvature is of a Mesh, not of {type(mesh).__name__}; isophote.to_mesh makes one")
    if mesh.face_count == 0:
        raise GeometryError("a mesh without faces has no normals or curvatures")
    positions = np.ascontiguousarray(mesh.vertices, np.float64)
    triangles = np.ascontiguousarray(triangulate(mesh).triangles, np.int32)
    starts = np.zeros(len(positions) + 1, np.int64)
    corners = np.empty(triangles.size, np.int64)
    corner_lists(triangles, starts, corners)
    return Fans(positions, triangles, starts, corners)
