"""Half-edges as arrays."""

from __future__ import annotations

import attrs
import numpy as np
import numpy.typing as npt

from isophote.analysis.arrays import read_only
from isophote.analysis.connectivity.stars import Faces, gather, pick_sound_faces, twins
from isophote.shapes.mesh import Mesh

__all__ = ["HalfEdges", "half_edges"]

_DEGENERATE = -4


@attrs.frozen(eq=False)
class HalfEdges:
    """One half-edge for each corner of a mesh, (h,) int32 each: from `vertex` to the next corner's vertex.

    Half-edge i starts at corner i in the order of `Mesh.indices`. `next` is the half-edge that follows in its `face`.
    `twin` runs along the same edge in the other direction, so that twin[twin[i]] = i and vertex[twin[i]] =
    vertex[next[i]], wherever twin[i] ≥ 0. Else it says why there is none: -1 at the boundary, -2 at an edge of three or
    more faces, -3 where the other face runs the same way (`orient` mends it), -4 in a face that names a vertex twice.
    """

    twin: npt.NDArray[np.int32] = attrs.field(converter=read_only)
    next: npt.NDArray[np.int32] = attrs.field(converter=read_only)
    vertex: npt.NDArray[np.int32] = attrs.field(converter=read_only)
    face: npt.NDArray[np.int32] = attrs.field(converter=read_only)

    def __len__(self) -> int:
        return len(self.twin)


def half_edges(mesh: Mesh) -> HalfEdges:
    """The half-edges of any mesh; see `HalfEdges`. Raises `GeometryError` for more than 2^30 − 1 corners."""
    faces = pick_sound_faces(mesh)
    twin = twins(gather(faces), opposed=True)
    following = np.arange(1, len(mesh.indices) + 1, dtype=np.int32)
    following[mesh.offsets[1:] - 1] = mesh.offsets[:-1]
    face = np.repeat(np.arange(mesh.face_count, dtype=np.int32), mesh.face_sizes)
    return HalfEdges(_of_all_corners(mesh, faces, twin), following, mesh.indices, face)


def _of_all_corners(mesh: Mesh, faces: Faces, twin: npt.NDArray[np.int32]) -> npt.NDArray[np.int32]:
    """Twins by the corners of the mesh, from those by the corners of sound faces."""
    if faces.kept is None:
        return twin
    sound = np.zeros(mesh.face_count, np.bool_)
    sound[faces.kept] = True
    corners = np.flatnonzero(np.repeat(sound, mesh.face_sizes)).astype(np.int32)
    result = np.full(len(mesh.indices), _DEGENERATE, np.int32)
    result[corners] = np.where(twin >= 0, corners[twin], twin)
    return result
