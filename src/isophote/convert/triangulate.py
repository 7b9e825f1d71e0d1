"""Polygon meshes cut into triangles."""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.errors import GeometryError
from isophote.shapes.mesh import Mesh

__all__ = ["Triangles", "triangulate"]

Points: TypeAlias = npt.NDArray[np.float64]
Corners: TypeAlias = npt.NDArray[np.int64]

# Diagonals of about the same length are one length: rounding must not choose between those of a square.
_CLEARLY = 1 - 1e-9

# The corners of the triangles of a quad that is cut from 0 to 2, and of one that is cut from 1 to 3.
_PATTERNS = np.array([[(0, 1, 2), (0, 2, 3)], [(0, 1, 3), (1, 2, 3)]], np.int64)

# Quads at a time: so many that their coordinates stay in the cache.
_CHUNK = 8192


class Triangles(NamedTuple):
    """The triangles of a mesh, face by face in the mesh's order, each turned as its face is.

    `triangles` (t, 3) int32 are vertex numbers, `corners` (t, 3) int64 the places in `Mesh.indices` that
    they come from (for attributes at corners), `face` (t,) int32 the faces that they are part of.
    """

    triangles: npt.NDArray[np.int32]
    face: npt.NDArray[np.int32]
    corners: Corners


def triangulate(mesh: Mesh) -> Triangles:
    """The triangles of a mesh: k − 2 for each face of k corners.

    Faces may be concave. A quad is cut along the diagonal that lies inside it; where both do along the shorter one,
    unless the only other face at one of its corners shares both edges there and has that diagonal too. Larger polygons
    are cut by clipping ears in the projection along Newell's normal. No vertex is added, moved or left out;
    collinear and repeated points give triangles without area, and a face that crosses itself still gives
    k − 2 triangles whose signed areas add up to the face's. A mesh of triangles is passed on without copying.
    """
    sizes = mesh.face_sizes
    if (sizes == 3).all():
        return _as_they_are(mesh)
    first = np.concatenate([np.zeros(1, np.int64), np.cumsum(sizes - 2)])
    if first[-1] > np.iinfo(np.int32).max:
        raise GeometryError(f"{int(first[-1]):,} triangles are more than 32-bit numbers can name")
    corners = np.empty((int(first[-1]), 3), np.int64)
    starts = mesh.offsets[:-1]
    for size in (3, 4):
        chosen = np.flatnonzero(sizes == size)
        if len(chosen):
            patterns = _PATTERNS[0, :1] if size == 3 else _PATTERNS[_cuts(mesh, chosen)]
            corners[first[chosen, None] + np.arange(size - 2)] = starts[chosen, None, None] + patterns
    large = np.flatnonzero(sizes > 4)
    if len(large):
        _clip_polygons(mesh, large, first, corners)
    face = np.repeat(np.arange(mesh.face_count, dtype=np.int32), sizes - 2)
    return Triangles(mesh.indices[corners], face, corners)


def _as_they_are(mesh: Mesh) -> Triangles:
    count = mesh.face_count
    return Triangles(
        mesh.indices.reshape(-1, 3),
        np.arange(count, dtype=np.int32),
        np.arange(3 * count, dtype=np.int64).reshape(-1, 3),
    )


def _cuts(mesh: Mesh, quads: Corners) -> npt.NDArray[np.int8]:
    """(q,) whether quads are cut from their corner 0 to 2, 0, or from 1 to 3, 1."""
    cut, is_free = np.empty(len(quads), np.int8), np.empty(len(quads), np.bool_)
    for start in range(0, len(quads), _CHUNK):
        part = slice(start, start + _CHUNK)
        own = mesh.offsets[quads[part], None] + np.arange(4)
        cut[part], is_free[part] = _shorter_inside(_unit_sized(mesh.vertices[mesh.indices[own]]))
    _part_twins(mesh, quads, cut, is_free)
    return cut


def _part_twins(mesh: Mesh, quads: Corners, cut: npt.NDArray[np.int8], is_free: npt.NDArray[np.bool_]) -> None:
    """Change cuts that would join two vertices which another face joins too, where that face and the quad are the only
    ones at a vertex and share both of its edges."""
    thin = np.bincount(mesh.indices) == 2
    if not thin.any():
        return
    at = np.flatnonzero(thin[mesh.indices])
    pairs = at[np.argsort(mesh.indices[at], kind="stable")].reshape(-1, 2)
    face = np.searchsorted(mesh.offsets, pairs, side="right") - 1
    first, size = mesh.offsets[face], mesh.face_sizes[face]
    corner = pairs - first
    before = mesh.indices[first + (corner - 1) % size]
    after = mesh.indices[first + (corner + 1) % size]
    twins = ((before == before[:, ::-1]) & (after == after[:, ::-1])) | (before == after[:, ::-1])
    chosen = np.flatnonzero(twins.all(axis=1) & (size <= 4).all(axis=1) & (face[:, 0] != face[:, 1]))
    if len(chosen) == 0:
        return
    is_quad, quad = size[chosen] == 4, np.searchsorted(quads, face[chosen])
    quad[~is_quad] = 0
    # The diagonal past corner 0 or 2 is that from 1 to 3. A triangle has its third side there.
    past = (1 - corner[chosen] % 2).astype(np.int8)
    joins = (cut[quad] == past) | ~is_quad
    movable = is_quad & is_free[quad]
    later = movable[:, 1].astype(np.int64)
    rows = np.flatnonzero(joins.all(axis=1) & movable.any(axis=1))
    cut[quad[rows, later[rows]]] = 1 - past[rows, later[rows]]


def _unit_sized(quads: Points) -> Points:
    """(3, 4, q): quads moved to the origin and scaled to about 1, so that no product over- or underflows."""
    moved = np.ascontiguousarray((quads * 0.5).transpose(2, 1, 0))
    moved -= moved[:, :1].copy()
    # A power of two rounds nothing: straight corners stay straight.
    exponent = np.frexp(np.abs(moved).max(axis=(0, 1)))[1]
    scaled: Points = np.ldexp(moved, -exponent)
    return scaled


def _shorter_inside(p: Points) -> tuple[npt.NDArray[np.bool_], npt.NDArray[np.bool_]]:
    """(q,) whether quads are best cut from corner 1 to 3, rather than from 0 to 2; and whether both are possible.

    A diagonal lies inside where both of its triangles turn as the whole quad does.
    """
    edges = np.roll(p, -1, axis=1) - p
    even, odd = p[:, 2] - p[:, 0], p[:, 3] - p[:, 1]
    normal = _cross(even, odd)
    turn = [_dot(_cross(edges[:, k - 1], edges[:, k]), normal) for k in range(4)]
    inside_0_2, inside_1_3 = np.minimum(turn[1], turn[3]), np.minimum(turn[0], turn[2])
    shorter = _dot(odd, odd) < _CLEARLY * _dot(even, even)
    both: npt.NDArray[np.bool_] = (inside_0_2 > 0) & (inside_1_3 > 0)
    return np.where(both, shorter, inside_1_3 > inside_0_2), both


def _cross(a: Points, b: Points) -> Points:
    return np.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def _dot(a: Points, b: Points) -> Points:
    dot: Points = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    return dot


def _clip_polygons(mesh: Mesh, faces: Corners, first: Corners, corners: Corners) -> None:
    """Write the triangles of `faces` into `corners` from row `first[face]` on."""
    # Loaded here, so that meshes of triangles and quads never wait for the compiler.
    from isophote.kernels.forms.polygon import clip_ears

    clip_ears(mesh.vertices, mesh.indices, mesh.offsets, faces, first, corners)
