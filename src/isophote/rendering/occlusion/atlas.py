"""The texels of a mesh's atlas: which face each shows, and where on it."""

from __future__ import annotations

from typing import TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.convert.triangulate import Triangles, triangulate
from isophote.errors import GeometryError
from isophote.kernels.light.uv_cover import cover_texels
from isophote.shapes.mesh import Attribute, Mesh

__all__ = ["Atlas", "atlas_of"]

Points: TypeAlias = npt.NDArray[np.float64]

# How far coordinates may lie outside the unit square by rounding, and the part of the texels that may belong to several
# faces: edges of charts that were packed for another size.
_OUTSIDE = 1e-5
_CROWDED = 0.01
# Places at the very edge of a face may lie within what stands there; those that were moved there go this part of the
# way to the middle of their triangle.
_INWARD = 1e-3


@attrs.frozen(eq=False)
class Atlas:
    """Where on a mesh the n covered texels of an atlas lie.

    `covered` (h, w) bool: texels that a face touches; row 0 is the top, v = 1. `triangle` (n,) is the number among
    `corners` (t, 3, 3), `normals` (t, 3, 3) and `uvs` (t, 3, 2), and `weights` (n, 3) are barycentric, all of them in
    the order of `covered`'s True.
    """

    covered: npt.NDArray[np.bool_]
    triangle: npt.NDArray[np.int32]
    weights: npt.NDArray[np.float32]
    corners: Points
    normals: Points
    uvs: Points

    def places(self, first: int, last: int) -> tuple[Points, Points]:
        """(points, unit normals), (n, 3) each, of the texels first ≤ i < last, in the mesh's own space."""
        chosen = self.triangle[first:last]
        w = self.weights[first:last].astype(np.float64)
        w[:, 0] = 1 - w[:, 1] - w[:, 2]
        corners = self.corners[chosen]
        normals = np.einsum("nk,nkd->nd", w, self.normals[chosen])
        length = np.linalg.norm(normals, axis=1, keepdims=True)
        flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        # Where normals of the corners cancel, the face's own is left.
        normals = np.where(length > 1e-6, normals, flat)
        return np.einsum("nk,nkd->nd", w, corners), normals / np.linalg.norm(normals, axis=1, keepdims=True)


def atlas_of(mesh: Mesh, size: int) -> Atlas:
    """The texels of a square atlas of `size` texels a side.

    Normals are the mesh's attribute "normal", else those of its triangles. Faces without area or without coordinates
    have no texels. Raises `GeometryError` for a mesh without texture coordinates, for coordinates that are not within
    0 to 1, and where more than a hundredth of the covered texels lie within several faces.
    """
    if mesh.uvs is None:
        raise GeometryError("the mesh has no texture coordinates; isophote.unwrap(mesh) makes some")
    cut = triangulate(mesh)
    corners = mesh.vertices[cut.triangles]
    flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    uvs, known = _at_corners(mesh.uvs, cut, 2)
    used = np.flatnonzero(known & (np.linalg.norm(flat, axis=1) > 0))
    if len(used) == 0:
        raise GeometryError("no face of the mesh has an area and texture coordinates")
    corners, uvs = corners[used], uvs[used]
    _check_square(uvs)
    owner, weights = _covered(uvs, size)
    covered = owner >= 0
    return Atlas(covered, owner[covered], weights, corners, _normals(mesh, cut, flat)[used], uvs)


def _at_corners(attribute: Attribute, cut: Triangles, width: int) -> tuple[Points, npt.NDArray[np.bool_]]:
    """(values at the corners of triangles (t, 3, width), whether all three corners of a triangle have one)."""
    rows = cut.triangles if attribute.indices is None else attribute.indices[cut.corners]
    known: npt.NDArray[np.bool_] = np.all(rows >= 0, axis=1)
    return attribute.values[rows][..., :width].astype(np.float64), known


def _normals(mesh: Mesh, cut: Triangles, flat: Points) -> Points:
    """(t, 3, 3) normals at the corners of triangles, of length 1 where a triangle has an area."""
    length = np.linalg.norm(flat, axis=1, keepdims=True)
    own = np.repeat((flat / np.where(length > 0, length, 1))[:, None], 3, axis=1)
    if mesh.normals is None:
        return own
    given, known = _at_corners(mesh.normals, cut, 3)
    return np.where(known[:, None, None] & np.isfinite(given).all(axis=(1, 2), keepdims=True), given, own)


def _check_square(uvs: Points) -> None:
    if not np.isfinite(uvs).all() or uvs.min() < -_OUTSIDE or uvs.max() > 1 + _OUTSIDE:
        raise GeometryError(
            "texture coordinates must be within 0 and 1, for each face has to have texels of its own, but some are "
            f"from {uvs.min():.4g} to {uvs.max():.4g}; isophote.unwrap(mesh) makes others"
        )
    a, b = uvs[:, 1] - uvs[:, 0], uvs[:, 2] - uvs[:, 0]
    area = 0.5 * float(np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum())
    if area == 0:
        raise GeometryError(
            "no face has an area in texture coordinates, so none has texels; isophote.unwrap(mesh) makes others"
        )
    if area > 1 + _CROWDED:
        raise GeometryError(
            f"faces overlap in the atlas: they fill {area:.3g} times the unit square; isophote.unwrap(mesh) makes "
            "other coordinates"
        )


def _covered(uvs: Points, size: int) -> tuple[npt.NDArray[np.int32], npt.NDArray[np.float32]]:
    """(triangle of each texel (size, size), −1 where there is none; weights (n, 3) of the texels that have one)."""
    texels = np.stack([uvs[..., 0] * size, (1 - uvs[..., 1]) * size], axis=-1)
    owner = np.full((size, size), -1, np.int32)
    distance = np.full((size, size), np.inf, np.float32)
    weights = np.zeros((size, size, 2), np.float32)
    crowded = np.zeros((size, size), np.uint8)
    cover_texels(np.ascontiguousarray(texels), owner, distance, weights, crowded)
    covered = owner >= 0
    share = int(np.count_nonzero(crowded)) / max(1, int(np.count_nonzero(distance <= 0)))
    if share > _CROWDED:
        raise GeometryError(
            f"faces overlap in the atlas: {share:.1%} of their texels lie in several; isophote.unwrap(mesh) makes "
            "other coordinates"
        )
    found = np.zeros((np.count_nonzero(covered), 3), np.float32)
    found[:, 1:] = weights[covered]
    moved = distance[covered] > 0
    found[moved, 1:] += np.float32(_INWARD) * (np.float32(1 / 3) - found[moved, 1:])
    found[:, 0] = 1 - found[:, 1] - found[:, 2]
    return owner, found
