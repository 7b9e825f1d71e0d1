"""Where a mesh meets itself."""

from __future__ import annotations

import threading

import attrs
import numpy as np
import numpy.typing as npt

from isophote.analysis.arrays import read_only
from isophote.analysis.crew import pieces, run
from isophote.analysis.prepared import prepared
from isophote.errors import GeometryError
from isophote.kernels.accel.layout import BLOCK, LANES
from isophote.kernels.measure.self_join import find_flat, join
from isophote.shapes.mesh import Mesh

__all__ = ["SelfIntersections", "self_intersections"]

_A_JOB = 4096
_ROOM = 256
_MOST = 1 << 24


@attrs.frozen(eq=False)
class SelfIntersections:
    """Where a mesh meets itself. `pairs` (k, 2) int32: the faces that meet, the lower number first, in ascending order.

    A pair of the same number is a face of more than three corners that meets itself.
    """

    pairs: npt.NDArray[np.int32]

    @property
    def embedded(self) -> bool:
        """Whether no two faces meet anywhere but in the vertices and edges that they share."""
        return len(self.pairs) == 0


def self_intersections(mesh: Mesh) -> SelfIntersections:
    """All pairs of faces of `mesh` that meet anywhere but in the vertices and edges that they share.

    Exact for all doubles: faces that only touch meet; so do coplanar faces that overlap, faces that are folded back
    over their common edge, and faces with the same three vertices. Vertices at one place are one vertex, and faces of
    more than three corners are taken as their triangles; a face without area is the segment or point that it is.
    Raises `GeometryError` where there are more than 16 million pairs.
    """
    ready = prepared(mesh)
    arrays = ready.distance.table.arrays
    nodes, blocks = arrays["nodes"], arrays["blocks"]
    vertices = np.require(mesh.vertices, np.float64, ["C", "W"])
    triangles = _one_place_one_number(vertices)[ready.triangles.triangles]
    flat = np.empty(len(triangles), np.uint8)
    run(find_flat, [(vertices, triangles, *piece, flat) for piece in pieces(len(triangles), _A_JOB)])

    lock, total = threading.Lock(), list[int]()

    def find(begin: int, end: int) -> npt.NDArray[np.int32]:
        pairs = np.empty((_ROOM, 2), np.int32)
        count = join(nodes, blocks, vertices, triangles, flat, begin, end, pairs, _MOST)
        with lock:
            total.append(count)
            if sum(total) > _MOST:
                raise GeometryError(
                    f"the mesh meets itself in more than {_MOST:,} pairs of triangles; are faces repeated?"
                )
        if count > len(pairs):
            pairs = np.empty((count, 2), np.int32)
            join(nodes, blocks, vertices, triangles, flat, begin, end, pairs, _MOST)
        return pairs[:count].copy()

    found = run(find, list(pieces(len(blocks) // BLOCK * LANES, _A_JOB)))
    faces = np.sort(ready.triangles.face[np.concatenate(found)], axis=1)
    return SelfIntersections(read_only(np.unique(faces, axis=0).reshape(-1, 2)))


def _one_place_one_number(vertices: npt.NDArray[np.float64]) -> npt.NDArray[np.int32]:
    """(n,) for each vertex the number of one vertex at the same place."""
    order = np.lexsort(vertices.T)
    placed = vertices[order]
    new = np.ones(len(order), bool)
    new[1:] = (placed[1:] != placed[:-1]).any(axis=1)
    number = np.empty(len(order), np.int32)
    number[order] = order[np.flatnonzero(new)[np.cumsum(new) - 1]]
    return number
