"""Connected components of meshes."""

from __future__ import annotations

from typing import NamedTuple

import attrs
import numpy as np
import numpy.typing as npt

from isophote.analysis.arrays import read_only
from isophote.analysis.connectivity.stars import Faces
from isophote.kernels.measure.pieces import join_vertices, number_pieces, size_pieces

__all__ = ["Components", "Pieces", "find_pieces"]


class Pieces(NamedTuple):
    """Sizes of the connected pieces, (k,) int64 each, and the piece of each vertex, -1 where no face uses it."""

    vertices: npt.NDArray[np.int64]
    edges: npt.NDArray[np.int64]
    faces: npt.NDArray[np.int64]
    of_vertex: npt.NDArray[np.int32]

    def __len__(self) -> int:
        return len(self.vertices)


def find_pieces(faces: Faces, degree: npt.NDArray[np.int32]) -> Pieces:
    """The connected pieces, in the order of their least vertices."""
    parent = np.arange(faces.vertex_count, dtype=np.int32)
    join_vertices(faces.indices, faces.flat_offsets, parent)
    count = number_pieces(parent, degree)
    vertices, ends, face_counts = np.zeros((3, count), np.int64)
    size_pieces(parent, degree, faces.indices, faces.flat_offsets, vertices, ends, face_counts)
    return Pieces(vertices, ends // 2, face_counts, parent)


@attrs.frozen(eq=False)
class Components:
    """The components of a mesh: what is connected through faces and vertices, in the order of their least vertices.

    `vertices`, `edges`, `faces`, `boundary_loops` are (k,) counts, `closed`, `manifold`, `oriented`, `orientable` are
    (k,) flags with the meaning that they have in `Topology`. `of_vertex`, (n,) int32, is the component of each vertex
    of the mesh, -1 where no face uses it.
    """

    vertices: npt.NDArray[np.int64] = attrs.field(converter=read_only)
    edges: npt.NDArray[np.int64] = attrs.field(converter=read_only)
    faces: npt.NDArray[np.int64] = attrs.field(converter=read_only)
    boundary_loops: npt.NDArray[np.int64] = attrs.field(converter=read_only)
    closed: npt.NDArray[np.bool_] = attrs.field(converter=read_only)
    manifold: npt.NDArray[np.bool_] = attrs.field(converter=read_only)
    oriented: npt.NDArray[np.bool_] = attrs.field(converter=read_only)
    orientable: npt.NDArray[np.bool_] = attrs.field(converter=read_only)
    of_vertex: npt.NDArray[np.int32] = attrs.field(converter=read_only, repr=False)

    def __len__(self) -> int:
        return len(self.vertices)

    @property
    def euler(self) -> npt.NDArray[np.int64]:
        """(k,) χ = V − E + F."""
        return self.vertices - self.edges + self.faces

    @property
    def genus(self) -> npt.NDArray[np.int64]:
        """(k,) number of handles, g = (2 − b − χ) / 2; -1 for what is not manifold or not orientable."""
        return np.where(self.manifold & self.orientable, (2 - self.boundary_loops - self.euler) // 2, -1)

    @property
    def crosscaps(self) -> npt.NDArray[np.int64]:
        """(k,) number of crosscaps of what is manifold and not orientable, 2 − b − χ; 0 for the orientable, -1 else."""
        crosscaps = np.where(self.orientable, 0, 2 - self.boundary_loops - self.euler)
        return np.where(self.manifold, crosscaps, -1)
