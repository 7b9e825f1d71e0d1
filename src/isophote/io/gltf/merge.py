"""Placed meshes as one mesh."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.shapes.mesh import Attribute, FaceLabels, Mesh

__all__ = ["merged"]

Array: TypeAlias = npt.NDArray[Any]
Matrix: TypeAlias = npt.NDArray[np.float64]
Placed: TypeAlias = tuple[Mesh, Matrix]


def merged(placed: Sequence[Placed], materials: Sequence[str | None]) -> Mesh:
    """One mesh of triangle meshes with attributes per vertex, each placed by its matrix (4, 4) to world space.

    A matrix that mirrors turns its triangles around, so that their front stays in front. `materials` names what
    each mesh is made of, for the labels. Attributes that some of the meshes lack become attributes of corners.
    """
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh, _ in placed)])
    vertices = np.concatenate([mesh.vertices @ matrix[:3, :3].T + matrix[:3, 3] for mesh, matrix in placed])
    faces = np.concatenate(
        [_outward(mesh, matrix) + start for (mesh, matrix), start in zip(placed, starts[:-1], strict=True)]
    )
    counts = [mesh.face_count for mesh, _ in placed]
    labels = _labels(materials, counts)
    return Mesh(vertices, faces, attributes=_attributes(placed), labels=labels)


def _outward(mesh: Mesh, matrix: Matrix) -> npt.NDArray[np.int64]:
    faces = mesh.indices.reshape(-1, 3).astype(np.int64)
    return faces[:, [0, 2, 1]] if np.linalg.det(matrix[:3, :3]) < 0 else faces


def _labels(materials: Sequence[str | None], counts: Sequence[int]) -> dict[str, FaceLabels]:
    names = tuple(dict.fromkeys(name for name in materials if name is not None))
    if not names:
        return {}
    numbers = [-1 if name is None else names.index(name) for name in materials]
    return {"material": FaceLabels(names, np.repeat(numbers, counts))}


def _attributes(placed: Sequence[Placed]) -> dict[str, Attribute]:
    names = dict.fromkeys(name for mesh, _ in placed for name in mesh.attributes)
    return {name: _attribute(name, placed) for name in names}


def _attribute(name: str, placed: Sequence[Placed]) -> Attribute:
    """One attribute of all meshes: per vertex, or per corner with -1 where some of the meshes lack it."""
    having = [(mesh, matrix) for mesh, matrix in placed if name in mesh.attributes]
    values = [_values(mesh, name, matrix) for mesh, matrix in having]
    width = max(v.shape[1] for v in values)
    rows = np.concatenate([_widened(v, width) for v in values])
    if len(having) == len(placed):
        return Attribute(rows)
    indices, start = [], 0
    for mesh, matrix in placed:
        if name in mesh.attributes:
            indices.append(_outward(mesh, matrix).ravel() + start)
            start += len(mesh.attributes[name].values)
        else:
            indices.append(np.full(len(mesh.indices), -1, np.int64))
    return Attribute(rows, np.concatenate(indices))


def _values(mesh: Mesh, name: str, matrix: Matrix) -> Array:
    values = mesh.attributes[name].values
    if name == "tangent":
        return _carried(values, matrix)
    return _turned(values, matrix) if name == "normal" else values


def _carried(tangents: Array, matrix: Matrix) -> Array:
    """Tangents in world space, of length 1; a matrix that mirrors turns the other axis around."""
    along = tangents[:, :3] @ matrix[:3, :3].T
    size = np.linalg.norm(along, axis=1, keepdims=True)
    sign = tangents[:, 3:] * (-1.0 if np.linalg.det(matrix[:3, :3]) < 0 else 1.0)
    return np.concatenate([along / np.where(size > 0, size, 1.0), sign], axis=1).astype(np.float32)


def _turned(normals: Array, matrix: Matrix) -> Array:
    """Normals in world space, of length 1: by the cofactors of the matrix, which need no inverse."""
    a, b, c = matrix[:3, :3].T
    cofactors = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=1)
    if np.linalg.det(matrix[:3, :3]) < 0:
        cofactors = -cofactors
    turned = normals @ cofactors.T
    lengths = np.linalg.norm(turned, axis=1, keepdims=True)
    return np.asarray(np.divide(turned, lengths, out=np.zeros_like(turned), where=lengths > 0), np.float32)


def _widened(values: Array, width: int) -> Array:
    """Colours without alpha among such that have it are opaque."""
    missing = width - values.shape[1]
    return np.pad(values, ((0, 0), (0, missing)), constant_values=1) if missing else values
