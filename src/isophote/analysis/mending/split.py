"""Vertices whose faces form several fans, taken apart."""

from __future__ import annotations

import numpy as np

from isophote.analysis.connectivity.stars import gather, pick_sound_faces
from isophote.analysis.connectivity.topology import survey
from isophote.analysis.crew import run
from isophote.analysis.mending.edit import Edit, Longs, unchanged
from isophote.kernels.measure import stars as kernels
from isophote.shapes.mesh import Mesh

__all__ = ["split_vertices"]


def split_vertices(mesh: Mesh) -> tuple[Edit, Longs]:
    """Give each fan at a vertex a vertex of its own, at the same place; edges of three or more faces come apart too.

    Returns the edit and the vertices that were split. Faces must not name a vertex twice; those that do are left as
    they are.
    """
    faces = pick_sound_faces(mesh)
    stars = gather(faces)
    _, kind = survey(stars)
    chosen = np.flatnonzero((kind & np.uint8(3)) == kernels.SINGULAR)
    if len(chosen) == 0:
        return unchanged(mesh), chosen
    fan = np.zeros(len(faces.indices), np.int32)
    fan_count = np.empty(len(chosen), np.int64)
    jobs = [
        (*stars.table, chosen, first, last, scratch, fan, fan_count) for first, last, scratch in stars.ranges_of(chosen)
    ]
    run(kernels.label_fans, jobs)
    # The first fan keeps the vertex, the others get new ones at the end.
    first_new = np.zeros(len(mesh.vertices), np.int64)
    first_new[chosen] = len(mesh.vertices) + np.concatenate([np.zeros(1, np.int64), np.cumsum(fan_count - 1)])[:-1]
    moved = np.flatnonzero(fan > 0)
    sound = np.ones(mesh.face_count, np.bool_)
    sound[faces.degenerate] = False
    corners = np.flatnonzero(np.repeat(sound, mesh.face_sizes))[moved]
    indices = mesh.indices.astype(np.int64)
    indices[corners] = first_new[faces.indices[moved]] + fan[moved] - 1
    vertex = np.concatenate([np.arange(len(mesh.vertices)), np.repeat(chosen, fan_count - 1)])
    split = chosen[fan_count > 1]
    return unchanged(mesh)._replace(vertex=vertex, indices=indices), split
