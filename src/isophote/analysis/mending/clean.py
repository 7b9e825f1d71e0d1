"""Faces that name a vertex twice, faces that are there twice, and vertices that no face uses."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from isophote.analysis.connectivity.stars import pick_sound_faces
from isophote.analysis.mending.edit import Edit, Longs, chosen_faces, unchanged
from isophote.shapes.mesh import Mesh

__all__ = ["drop_degenerate", "drop_duplicates", "drop_unused"]


def drop_degenerate(mesh: Mesh) -> tuple[Edit, Longs]:
    """Cut faces that name a vertex twice into simple ones, where three corners are left, and drop the rest.

    Returns the edit and the faces that were degenerate.
    """
    degenerate = pick_sound_faces(mesh).degenerate
    if len(degenerate) == 0:
        return unchanged(mesh), degenerate
    keep = np.ones(mesh.face_count, np.bool_)
    keep[degenerate] = False
    edit = chosen_faces(mesh, keep)
    larger = degenerate[mesh.face_sizes[degenerate] > 3]
    parts = [(int(face), part) for face in larger for part in _simple_parts(mesh, int(face))]
    if not parts:
        return edit, degenerate
    corner = np.concatenate([edit.corner, *(part for _, part in parts)])
    sizes = np.concatenate([np.diff(edit.offsets), [len(part) for _, part in parts]])
    face = np.concatenate([edit.face, [face for face, _ in parts]])
    return _in_order(mesh, edit, corner, sizes, face), degenerate


def _in_order(mesh: Mesh, edit: Edit, corner: Longs, sizes: Longs, face: Longs) -> Edit:
    """The edit with faces sorted by the old ones that they come from."""
    order = np.argsort(face, kind="stable")
    starts = np.concatenate([np.zeros(1, np.int64), np.cumsum(sizes)])[order]
    offsets = np.concatenate([np.zeros(1, np.int64), np.cumsum(sizes[order])])
    within = np.arange(offsets[-1]) - np.repeat(offsets[:-1], sizes[order])
    corner = corner[np.repeat(starts, sizes[order]) + within]
    return edit._replace(
        indices=mesh.indices[corner].astype(np.int64), offsets=offsets, corner=corner, face=face[order]
    )


def _simple_parts(mesh: Mesh, face: int) -> Iterator[Longs]:
    """The corners of the rings that a face falls into at the vertices that it passes again, those of three or more."""
    way: list[int] = []
    at: dict[int, int] = {}
    for corner in range(int(mesh.offsets[face]), int(mesh.offsets[face + 1])):
        vertex = int(mesh.indices[corner])
        if vertex in at:
            ring = way[at[vertex] :]
            del way[at[vertex] :]
            for left in ring:
                del at[int(mesh.indices[left])]
            if len(ring) >= 3:
                yield np.array(ring, np.int64)
        at[vertex] = len(way)
        way.append(corner)
    if len(way) >= 3:
        yield np.array(way, np.int64)


def drop_duplicates(mesh: Mesh) -> tuple[Edit, Longs]:
    """Keep the first of faces that pass the same vertices in the same cycle, either way round.

    Returns the edit and the faces that were dropped.
    """
    keep = np.ones(mesh.face_count, np.bool_)
    sizes = mesh.face_sizes
    for size in np.unique(sizes).tolist():
        faces = np.flatnonzero(sizes == size)
        rings = _canonical(mesh.indices[mesh.offsets[faces, None] + np.arange(size)])
        order = np.lexsort(rings.T)
        same = (rings[order[1:]] == rings[order[:-1]]).all(axis=1)
        keep[faces[order[1:][same]]] = False
    return chosen_faces(mesh, keep), np.flatnonzero(~keep)


def _canonical(rings: npt.NDArray[np.int32]) -> npt.NDArray[np.int32]:
    """(m, k) rings that begin at their least vertex and go on to the lesser of its neighbours."""
    size = rings.shape[1]
    first = rings.argmin(axis=1)[:, None]
    ahead = np.take_along_axis(rings, (first + np.arange(size)) % size, axis=1)
    backward = np.take_along_axis(rings, (first - np.arange(size)) % size, axis=1)
    return np.where(ahead[:, 1:2] <= ahead[:, -1:], ahead, backward)


def drop_unused(mesh: Mesh) -> tuple[Edit, Longs]:
    """Leave out the vertices that no face uses. Returns the edit and these vertices."""
    used = np.zeros(len(mesh.vertices), np.bool_)
    used[mesh.indices] = True
    number = np.cumsum(used) - 1
    edit = unchanged(mesh)._replace(vertex=np.flatnonzero(used), indices=number[mesh.indices])
    return edit, np.flatnonzero(~used)
