"""The stars of a mesh's vertices, which all of topology is read from."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.analysis.arrays import read_only
from isophote.analysis.crew import pieces, run
from isophote.errors import GeometryError
from isophote.kernels.measure import stars as kernels
from isophote.kernels.measure.pieces import repeats
from isophote.machine import processors
from isophote.shapes.mesh import Mesh

__all__ = ["Faces", "Stars", "as_mesh", "gather", "pick_sound_faces", "twins"]

Ints: TypeAlias = npt.NDArray[np.int32]
Longs: TypeAlias = npt.NDArray[np.int64]

_NONE: Ints = np.empty(0, np.int32)
# Read-only, as a mesh's own arrays are: kernels are compiled for each of the two by itself.
_NO_OFFSETS = read_only(np.empty(0, np.int64))
# Twice a half-edge's number, and one more, must fit into 32 bits.
_MOST_CORNERS = 2**30 - 1
_GRAIN = 1 << 16
# Each run of corners that is counted by itself takes four bytes a vertex.
_MOST_RUNS = 8


class Faces(NamedTuple):
    """The faces that name no vertex twice.

    `indices` and `offsets` are as in `Mesh`; `flat_offsets` is empty where all faces are triangles. `kept` are the
    numbers of the faces in the mesh, None where none was left out; `degenerate` those of the others.
    """

    vertex_count: int
    indices: Ints
    offsets: Longs
    flat_offsets: Longs
    kept: Longs | None
    degenerate: Longs

    @property
    def total(self) -> int:
        return len(self.offsets) - 1

    def number(self, faces: npt.NDArray[Any]) -> Longs:
        """The numbers in the mesh of faces of this list."""
        return faces.astype(np.int64) if self.kept is None else self.kept[faces]

    def of_half_edges(self, half_edges: npt.NDArray[Any]) -> Longs:
        """The faces, as numbered here, that half-edges belong to."""
        if len(self.flat_offsets) == 0:
            return half_edges.astype(np.int64) // 3
        return np.searchsorted(self.offsets, half_edges, side="right") - 1

    def ahead(self, half_edges: npt.NDArray[Any]) -> Longs:
        """The half-edges that follow these in their faces."""
        faces = self.of_half_edges(half_edges)
        following = half_edges.astype(np.int64) + 1
        return np.where(following == self.offsets[faces + 1], self.offsets[faces], following)


class Stars(NamedTuple):
    """The corners at each vertex: those of vertex v are `star[starts[v]:starts[v + 1]]`, in increasing order.

    `following` and `preceding` are empty for triangles. `largest` is the largest number of corners at one vertex.
    """

    indices: Ints
    following: Ints
    preceding: Ints
    starts: Ints
    star: Ints
    largest: int

    @property
    def table(self) -> tuple[Ints, Ints, Ints, Ints, Ints]:
        """What kernels take."""
        return self.indices, self.following, self.preceding, self.starts, self.star

    def ranges(self) -> Iterator[tuple[int, int, npt.NDArray[np.uint64]]]:
        """Ranges of vertices, each with scratch for its stars."""
        for first, last in pieces(len(self.starts) - 1, _GRAIN):
            yield first, last, self._scratch(np.diff(self.starts[first : last + 1]))

    def ranges_of(self, chosen: Longs) -> Iterator[tuple[int, int, npt.NDArray[np.uint64]]]:
        """Ranges of a list of vertices, each with scratch for their stars."""
        for first, last in pieces(len(chosen), _GRAIN):
            yield first, last, self._scratch(self.starts[chosen[first:last] + 1] - self.starts[chosen[first:last]])

    @staticmethod
    def _scratch(sizes: Ints) -> npt.NDArray[np.uint64]:
        return np.empty(kernels.scratch_size(int(sizes.max())), np.uint64)


def pick_sound_faces(mesh: Mesh) -> Faces:
    """The faces of a mesh that name no vertex twice.

    Raises `GeometryError` for what is no mesh, and for more than 2^30 − 1 corners.
    """
    if not isinstance(mesh, Mesh):
        raise GeometryError(f"a Mesh is wanted, not a {type(mesh).__name__}; isophote.Mesh(vertices, faces) makes one")
    if len(mesh.indices) > _MOST_CORNERS:
        raise GeometryError(
            f"{len(mesh.indices):,} corners are too many: 2^30 − 1 are the most; take the mesh in parts"
        )
    triangles = len(mesh.indices) == 3 * mesh.face_count and bool((mesh.face_sizes == 3).all())
    flat = _NO_OFFSETS if triangles else mesh.offsets
    found = np.empty(mesh.face_count, np.bool_)
    stamp = _NONE if triangles else np.full(len(mesh.vertices), -1, np.int32)
    if repeats(mesh.indices, flat, stamp, found) == 0:
        return Faces(len(mesh.vertices), mesh.indices, mesh.offsets, flat, None, np.empty(0, np.int64))
    kept = np.flatnonzero(~found)
    offsets = np.concatenate([np.zeros(1, np.int64), np.cumsum(mesh.face_sizes[kept])])
    offsets = read_only(offsets)
    indices = read_only(mesh.indices[np.repeat(~found, mesh.face_sizes)])
    flat = _NO_OFFSETS if triangles else offsets
    return Faces(len(mesh.vertices), indices, offsets, flat, kept, np.flatnonzero(found))


def as_mesh(mesh: Mesh, faces: Faces) -> Mesh | None:
    """The mesh without its degenerate faces, attributes and labels; None where nothing is left."""
    if faces.kept is None:
        return mesh
    return Mesh.from_polygons(mesh.vertices, faces.indices, faces.offsets) if faces.total else None


def gather(faces: Faces) -> Stars:
    """Sort the corners by their vertices. The result does not depend on the number of processors."""
    corner_count = len(faces.indices)
    runs = max(1, min(processors(), _MOST_RUNS, corner_count // _GRAIN))
    bounds = [corner_count * i // runs for i in range(runs + 1)]
    counts = np.zeros((runs, faces.vertex_count), np.int32)
    starts = np.empty(faces.vertex_count + 1, np.int32)
    star = np.empty(corner_count, np.int32)
    run(kernels.count_corners, [(faces.indices, bounds[i], bounds[i + 1], counts[i]) for i in range(runs)])
    largest = kernels.first_places(counts, starts)
    run(kernels.fill_stars, [(faces.indices, bounds[i], bounds[i + 1], counts[i], star) for i in range(runs)])
    return Stars(faces.indices, *_neighbours(faces), starts, star, int(largest))


def _neighbours(faces: Faces) -> tuple[Ints, Ints]:
    """The corners after and before each one in its face; nothing for triangles."""
    if len(faces.flat_offsets) == 0:
        return _NONE, _NONE
    corners = np.arange(len(faces.indices), dtype=np.int32)
    following, preceding = corners + np.int32(1), corners - np.int32(1)
    following[faces.offsets[1:] - 1] = faces.offsets[:-1]
    preceding[faces.offsets[:-1]] = faces.offsets[1:] - 1
    return following, preceding


def twins(stars: Stars, *, opposed: bool) -> Ints:
    """(corners,) the half-edge across each edge of two faces; BOUNDARY or CROWDED where there is none.

    With `opposed` also OPPOSED where both half-edges run the same way.
    """
    twin = np.empty(len(stars.indices), np.int32)
    run(kernels.write_twins, [(*stars.table, *piece, opposed, twin) for piece in stars.ranges()])
    return twin
