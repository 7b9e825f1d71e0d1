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
    """(q, 2, 3) corners of the two triangles of each quad, whose corners are `own`, (q, 4).

    A diagonal lies inside where both of its triangles turn as the whole quad does.
    """
    p = _unit_sized(vertices[indices[own]])
    normal = np.cross(p[:, 2] - p[:, 0], p[:, 3] - p[:, 1])
    turn = np.stack([_turns(p, normal, k) for k in range(4)])
    # The diagonal 0-2 makes triangles with their tips at 1 and 3, the diagonal 1-3 with theirs at 2 and 0.
    first, second = np.minimum(turn[1], turn[3]), np.minimum(turn[0], turn[2])
    shorter = _squares(p[:, 1] - p[:, 3]) < _CLEARLY * _squares(p[:, 0] - p[:, 2])
    both = (first > 0) & (second > 0)
    other = np.where(both, shorter, second > first)
    pattern = np.where(other[:, None], [0, 1, 3, 1, 2, 3], [0, 1, 2, 0, 2, 3])
    return np.take_along_axis(own, pattern, axis=1).reshape(-1, 2, 3)


def _unit_sized(quads: Points) -> Points:
    """Quads moved to the origin and scaled to about 1, so that no product over- or underflows."""
    moved = quads * 0.5
    moved -= moved[:, :1].copy()
    extent = np.abs(moved).max(axis=(1, 2), keepdims=True)
    moved /= np.where(extent > 0, extent, 1.0)
    return moved


def _turns(p: Points, normal: Points, k: int) -> Points:
    """Twice the signed area of corner `k` with its neighbours, times the length of the quad's normal."""
    before, at, after = p[:, k - 1], p[:, k], p[:, (k + 1) % 4]
    turns: Points = np.einsum("qi,qi->q", np.cross(at - before, after - at), normal)
    return turns


def _squares(edges: Points) -> Points:
    squares: Points = np.einsum("qi,qi->q", edges, edges)
    return squares


def _clip_polygons(mesh: Mesh, faces: Corners, first: Corners, corners: Corners) -> None:
    """Write the triangles of `faces` into `corners` from row `first[face]` on."""
    # Loaded here, so that meshes of triangles and quads never wait for the compiler.
    from isophote.kernels.forms.polygon import clip_ears

    clip_ears(mesh.vertices, mesh.indices, mesh.offsets, faces, first, corners)
