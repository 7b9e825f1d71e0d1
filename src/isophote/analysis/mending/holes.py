"""Boundary loops closed with triangles."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from isophote.analysis.arrays import distinct
from isophote.analysis.connectivity.boundary import Chains, look_closer, passed_vertices, trace
from isophote.analysis.connectivity.stars import Faces, gather, pick_sound_faces
from isophote.analysis.connectivity.topology import survey
from isophote.analysis.mending.edit import Edit, Longs, unchanged
from isophote.kernels.measure import stars as kernels
from isophote.shapes.mesh import Mesh

__all__ = ["Filling", "fill_holes"]

# Time grows with the third power of the edges of a loop; larger ones become a fan around their middle.
_MOST_EDGES = 1000


class Filling(NamedTuple):
    """What `fill_holes` did: the vertices of the loops that it closed, and of those that it left open."""

    filled: tuple[Longs, ...]
    left: tuple[Longs, ...]


class _Loop(NamedTuple):
    """The vertices of a loop in the direction that new faces take, and the face at each edge."""

    vertices: Longs
    faces: Longs


def fill_holes(mesh: Mesh, most_edges: int | None) -> tuple[Edit, Filling]:
    """Close each boundary loop of at most `most_edges` edges (None: all).

    A loop gets the triangles of least area that use no edge which is there already; one of more than 1,000 edges, or
    for which there are none, a new vertex in its middle and a fan. The rim of a single triangle stays open, for its
    lid would be the same triangle again; so do walks that end at edges of three or more faces.
    """
    faces = pick_sound_faces(mesh)
    loops, chains = _loops(faces)
    chosen = [
        loop
        for loop in loops
        if (most_edges is None or len(loop.vertices) <= most_edges)
        and not (len(loop.vertices) == 3 and (loop.faces == loop.faces[0]).all())
    ]
    ids = {id(loop) for loop in chosen}
    left = (*(loop.vertices for loop in loops if id(loop) not in ids), *chains)
    if not chosen:
        return unchanged(mesh), Filling((), left)
    lids = _lids(mesh, faces, chosen)
    return _edit(mesh, chosen, lids), Filling(tuple(loop.vertices for loop in chosen), left)


def _loops(faces: Faces) -> tuple[list[_Loop], tuple[Longs, ...]]:
    """The closed walks along the boundary, and the vertices of the open ones."""
    stars = gather(faces)
    _, kind = survey(stars)
    details = look_closer(stars, np.flatnonzero(kind > kernels.INSIDE))
    walks = trace(details)
    passed, starts, is_open = passed_vertices(faces, walks)
    chains = tuple(passed[starts[i] : starts[i + 1]].astype(np.int64) for i in np.flatnonzero(is_open))
    return [_loop(faces, walks, i) for i in np.flatnonzero(~is_open).tolist()], chains


def _loop(faces: Faces, walks: Chains, number: int) -> _Loop:
    part = slice(int(walks.starts[number]), int(walks.starts[number + 1]))
    half_edges, backward = walks.half_edges[part], walks.backward[part]
    vertices = faces.indices[np.where(backward, faces.ahead(half_edges), half_edges)].astype(np.int64)
    beside = faces.of_half_edges(half_edges)
    # New faces run against the half-edges, or against most of them where the mesh is not oriented.
    if 2 * int(backward.sum()) > len(backward):
        return _Loop(vertices, beside)
    return _Loop(vertices[::-1], beside[::-1])


def _lids(mesh: Mesh, faces: Faces, loops: list[_Loop]) -> list[npt.NDArray[np.int64] | None]:
    """For each loop triangles of positions in it, (k - 2, 3); None for a fan."""
    known = _edges_between(faces, np.concatenate([loop.vertices for loop in loops]))
    return [_lid(mesh.vertices, known, loop.vertices) for loop in loops]


def _lid(points: npt.NDArray[np.float64], known: Longs, ring: Longs) -> npt.NDArray[np.int64] | None:
    from isophote.kernels.measure.holes import least_area

    size = len(ring)
    if size == 3:
        return np.array([[0, 1, 2]])
    if size > _MOST_EDGES:
        return None
    low, high = np.minimum(ring[:, None], ring), np.maximum(ring[:, None], ring)
    taken = np.isin(low << 32 | high, known)
    cost, apex = np.empty((size, size)), np.empty((size, size), np.int64)
    triangles = np.empty((size - 2, 3), np.int64)
    # A power of two rounds nothing, and keeps areas in range.
    corners = points[ring] / 2 - points[ring[0]] / 2
    corners = np.ldexp(corners, -int(np.frexp(np.abs(corners).max())[1]))
    return triangles if least_area(corners, taken, cost, apex, np.empty(2 * size, np.int64), triangles) else None


def _edges_between(faces: Faces, vertices: Longs) -> Longs:
    """The edges, packed into one number, both of whose ends are among `vertices`."""
    chosen = np.zeros(faces.vertex_count, np.bool_)
    chosen[vertices] = True
    begins = np.flatnonzero(chosen[faces.indices])
    a = faces.indices[begins].astype(np.int64)
    b = faces.indices[faces.ahead(begins)].astype(np.int64)
    both = chosen[b]
    return distinct((np.minimum(a, b) << 32 | np.maximum(a, b))[both])


def _edit(mesh: Mesh, loops: list[_Loop], lids: list[npt.NDArray[np.int64] | None]) -> Edit:
    """The mesh with the new triangles behind its faces, and the middles of fans behind its vertices."""
    edit = unchanged(mesh)
    parts: list[Longs] = []
    middles: list[Longs] = []
    for loop, lid in zip(loops, lids, strict=True):
        ring = loop.vertices
        if lid is None:
            middle = np.full(len(ring), len(mesh.vertices) + len(middles))
            parts.append(np.stack([ring, np.roll(ring, -1), middle], axis=1))
            middles.append(ring)
        else:
            parts.append(ring[lid])
    triangles = np.concatenate(parts)
    added = len(triangles)
    return Edit(
        np.concatenate([edit.vertex, np.full(len(middles), -1)]),
        np.concatenate([edit.indices, triangles.reshape(-1)]),
        np.concatenate([edit.offsets, edit.offsets[-1] + 3 * np.arange(1, added + 1)]),
        np.concatenate([edit.corner, np.full(3 * added, -1)]),
        np.concatenate([edit.face, np.full(added, -1)]),
        middles,
    )
