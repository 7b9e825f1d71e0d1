"""Tangents of meshes by their texture coordinates, for normal maps."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.convert.triangulate import Triangles, triangulate
from isophote.errors import GeometryError
from isophote.kernels.measure.tangent_space import find_directions, find_groups, match_edges, mean_tangents
from isophote.shapes.mesh import Attribute, Mesh

__all__ = ["corner_tangents", "tangents"]

Doubles: TypeAlias = npt.NDArray[np.float64]
Longs: TypeAlias = npt.NDArray[np.int64]


def tangents(mesh: Mesh) -> Attribute:
    """The directions at a mesh's corners along which texture coordinate u grows, for its attribute "tangent".

    (k, 4) float32: a unit vector across the corner's normal, and 1, or −1 where the texture is mirrored: the other axis
    of a normal map is b = sign · n × t, with n and t as they are blended between the corners. They are those of
    MikkTSpace, which baking programs and glTF mean, of the mesh's triangles. Without normals those of the faces count.

    Raises `GeometryError` for a mesh without texture coordinates.
    Source: Mikkelsen, "Simulation of Wrinkled Surfaces Revisited", 2008.
    """
    if not isinstance(mesh, Mesh):
        raise GeometryError(f"tangents: only a Mesh has tangents, not a {type(mesh).__name__}")
    if mesh.uvs is None:
        raise GeometryError("tangents: the mesh has no texture coordinates; isophote.unwrap makes some")
    cut = triangulate(mesh)
    values = np.zeros((len(mesh.indices), 4), np.float32)
    # Of a corner where several triangles of a face meet, the first counts.
    values[cut.corners.reshape(-1)[::-1]] = corner_tangents(mesh, cut).reshape(-1, 4)[::-1]
    rows, indices = np.unique(values, axis=0, return_inverse=True)
    return Attribute(rows, indices.reshape(-1))


def corner_tangents(mesh: Mesh, cut: Triangles) -> npt.NDArray[np.float32]:
    """(t, 3, 4): the tangents of the corners of a mesh's triangles, as `tangents` tells them."""
    points = mesh.vertices[cut.triangles]
    normals = _at_corners(mesh.normals, cut)[..., :3] if mesh.normals is not None else _face_normals(points)
    assert mesh.uvs is not None
    uvs = _at_corners(mesh.uvs, cut)[..., :2]
    whole = ~_is_degenerate(points)
    welded = _welded(points, normals, uvs)
    found = np.zeros((len(points), 3, 4), np.float64)
    found[..., 0], found[..., 3] = 1.0, -1.0
    if whole.any():
        found[whole] = _of_triangles(points[whole], normals[whole], uvs[whole], welded[whole])
        _copy_to_degenerate(found, welded, whole)
    return found.astype(np.float32)


def _at_corners(attribute: Attribute, cut: Triangles) -> Doubles:
    rows = cut.triangles if attribute.indices is None else np.maximum(attribute.indices[cut.corners], 0)
    values: Doubles = attribute.values[rows].astype(np.float64)
    return values


def _face_normals(points: Doubles) -> Doubles:
    across = np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0])
    size = np.linalg.norm(across, axis=1, keepdims=True)
    unit = np.divide(across, size, out=np.zeros_like(across), where=size > 0)
    return np.repeat(unit[:, None], 3, axis=1)


def _is_degenerate(points: Doubles) -> npt.NDArray[np.bool_]:
    a, b, c = (points[:, k] for k in range(3))
    same: npt.NDArray[np.bool_] = (a == b).all(axis=1) | (b == c).all(axis=1) | (c == a).all(axis=1)
    return same


def _welded(points: Doubles, normals: Doubles, uvs: Doubles) -> Longs:
    """(t, 3): one number for corners that agree in everything."""
    rows = np.concatenate([points, normals, uvs], axis=2).reshape(-1, 8) + 0.0
    keys = np.ascontiguousarray(rows).view(np.dtype((np.void, rows.dtype.itemsize * 8))).reshape(-1)
    _, numbers = np.unique(keys, return_inverse=True)
    return np.asarray(numbers, np.int64).reshape(-1, 3)


def _of_triangles(points: Doubles, normals: Doubles, uvs: Doubles, corners: Longs) -> Doubles:
    """(t, 3, 4) of triangles whose corners are three places each."""
    count = len(points)
    directions = np.zeros((count, 3))
    turned, loose = np.zeros(count, np.uint8), np.zeros(count, np.uint8)
    find_directions(points, uvs, directions, turned, loose)
    neighbours = np.full((count, 3), -1, np.int64)
    match_edges(corners, _edge_order(corners), neighbours)
    groups = np.full((count, 3), -1, np.int64)
    groups_found = find_groups(corners, neighbours, turned, loose, np.empty(6 * count + 2, np.int64), groups)
    found = np.empty((count, 3, 4))
    mean_tangents(points, normals, directions, turned, loose, groups, np.zeros((groups_found, 3)), found)
    return found


def _edge_order(corners: Longs) -> Longs:
    """Edges 3 f + k by their least and greatest end, then by their triangle."""
    ends = np.roll(corners, -1, axis=1)
    least, greatest = np.minimum(corners, ends).reshape(-1), np.maximum(corners, ends).reshape(-1)
    order: npt.NDArray[Any] = np.lexsort((greatest, least))
    return order.astype(np.int64, copy=False)


def _copy_to_degenerate(found: Doubles, welded: Longs, whole: npt.NDArray[np.bool_]) -> None:
    """Give corners of triangles without area what another triangle has there."""
    if whole.all():
        return
    numbers, first = np.unique(welded[whole], return_index=True)
    known = found[whole].reshape(-1, 4)[first]
    lost = welded[~whole].reshape(-1)
    at = np.minimum(np.searchsorted(numbers, lost), len(numbers) - 1)
    there = numbers[at] == lost
    values = found[~whole].reshape(-1, 4)
    values[there] = known[at[there]]
    found[~whole] = values.reshape(-1, 3, 4)
