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

_ALONG_0_2 = (0, 1, 2, 0, 2, 3)
_ALONG_1_3 = (0, 1, 3, 1, 2, 3)

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

    Faces may be concave. A quad is cut along the diagonal that lies inside it, the shorter one where both do; larger
    polygons by clipping ears in the projection along Newell's normal. No vertex is added, moved or left out;
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
            own = starts[chosen, None] + np.arange(size)
            cut = own[:, None] if size == 3 else _cut_quads(mesh.vertices, mesh.indices, own)
            corners[first[chosen, None] + np.arange(size - 2)] = cut
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


def _cut_quads(vertices: Points, indices: npt.NDArray[np.int32], own: Corners) -> Corners:
    """(q, 2, 3) corners of the two triangles of each quad, whose corners are `own`, (q, 4)."""
    corners = np.empty((len(own), 2, 3), np.int64)
    for start in range(0, len(own), _CHUNK):
        chunk = own[start : start + _CHUNK]
        along_1_3 = _cut_along_1_3(_unit_sized(vertices[indices[chunk]]))
        pattern = np.where(along_1_3, *(np.array(p, np.int64)[:, None] for p in (_ALONG_1_3, _ALONG_0_2)))
        corners[start : start + _CHUNK] = np.take_along_axis(chunk, pattern.T, axis=1).reshape(-1, 2, 3)
    return corners


def _unit_sized(quads: Points) -> Points:
    """(3, 4, q): quads moved to the origin and scaled to about 1, so that no product over- or underflows."""
    moved = np.ascontiguousarray((quads * 0.5).transpose(2, 1, 0))
    moved -= moved[:, :1].copy()
    # A power of two rounds nothing: straight corners stay straight.
    exponent = np.frexp(np.abs(moved).max(axis=(0, 1)))[1]
    scaled: Points = np.ldexp(moved, -exponent)
    return scaled


def _cut_along_1_3(p: Points) -> npt.NDArray[np.bool_]:
    """(q,) whether a quad is cut from its corner 1 to 3, rather than from 0 to 2.

    A diagonal lies inside where both of its triangles turn as the whole quad does.
    """
    edges = np.roll(p, -1, axis=1) - p
    even, odd = p[:, 2] - p[:, 0], p[:, 3] - p[:, 1]
    normal = _cross(even, odd)
    turn = [_dot(_cross(edges[:, k - 1], edges[:, k]), normal) for k in range(4)]
    inside_0_2, inside_1_3 = np.minimum(turn[1], turn[3]), np.minimum(turn[0], turn[2])
    shorter = _dot(odd, odd) < _CLEARLY * _dot(even, even)
    cut: npt.NDArray[np.bool_] = np.where((inside_0_2 > 0) & (inside_1_3 > 0), shorter, inside_1_3 > inside_0_2)
    return cut


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
