"""Shapes as the meshes that radiosity cuts into patches: what is flat exactly, with as few faces as it has."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.analysis.triangulation.triangulate import delaunay
from isophote.convert.contour import to_mesh
from isophote.errors import RenderError
from isophote.lower.primitive_table import primitive_of
from isophote.scene.scene import Item
from isophote.shapes.field.field import Field
from isophote.shapes.mesh import Attribute, Mesh
from isophote.shapes.primitive.primitive import Primitive

__all__ = ["surface_mesh"]

Points: TypeAlias = npt.NDArray[np.float64]

# Endless planes and slabs end so many diagonals of what has bounds away: all of them is cut into patches.
_REACH = 3.0
# Corners around a disk: the polygon has the disk's area.
_AROUND = 64
# Cells across the thinnest part of a field's box at least, as long as no more than so many lie along the longest.
_ACROSS, _ALONG = 6, 128
# A block's faces −x, +x, −y, +y, −z, +z as those outside see them: lower left, lower right, upper right, upper left.
_BLOCK = np.array(
    [
        [[-1, -1, -1], [-1, -1, 1], [-1, 1, 1], [-1, 1, -1]],
        [[1, -1, 1], [1, -1, -1], [1, 1, -1], [1, 1, 1]],
        [[-1, -1, -1], [1, -1, -1], [1, -1, 1], [-1, -1, 1]],
        [[-1, 1, 1], [1, 1, 1], [1, 1, -1], [-1, 1, -1]],
        [[1, -1, -1], [-1, -1, -1], [-1, 1, -1], [1, 1, -1]],
        [[-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]],
    ],
    np.float64,
)
_SQUARE = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], np.float64)


def surface_mesh(item: Item, cell: float, around: Points, name: str) -> Mesh:
    """The mesh of an item's shape, in its own space; curved fields with cells of `cell` metres or less.

    `around`, (2, 3), is the box of all that has bounds, in the world: what is flat and endless ends three diagonals
    beyond. Raises `RenderError` for shapes that have no such mesh.
    """
    shape = item.shape
    if isinstance(shape, Mesh):
        return shape
    exact = primitive_of(shape)
    if exact is not None:
        to_own: Points = np.linalg.inv(item.transform.matrix @ exact.matrix).astype(np.float64)
        found = _flat(exact, to_own, around)
        if found is not None:
            return found
    if not isinstance(shape, Field):
        raise RenderError(
            f"{name}: a {type(shape).__name__} has no surface that radiosity could cut into patches; give a field or a "
            "mesh"
        )
    sides = np.ptp(shape.bounds, axis=0)
    if not np.isfinite(sides).all():
        raise RenderError(
            f"{name}: of endless shapes radiosity knows planes and slabs alone; cut others, as by field & iso.box(...)"
        )
    finest = max(float(sides.min()) / _ACROSS, float(sides.max()) / _ALONG)
    return to_mesh(shape, cell=min(cell / _scale(item), finest), progress=False)


def _scale(item: Item) -> float:
    """By how much an item's transform enlarges, on average."""
    return float(np.cbrt(abs(np.linalg.det(item.transform.matrix[:3, :3]))))


def _flat(exact: Primitive, to_own: Points, around: Points) -> Mesh | None:
    """The mesh of a primitive whose surface is flat, None of others; `to_own` leads from the world to its space."""
    if exact.kind == "plane":
        middle, reach = _region(to_own, around)
        square = (2 * _SQUARE - 1) * reach + middle[[0, 2]] * [1, -1]
        corners = _placed(exact, _upright(square))
        # Texture coordinates are the shape's own metres.
        return _faces(corners, [[0, 1, 2, 3]], square * np.linalg.norm(exact.matrix[:3, [0, 2]], axis=0))
    if exact.kind == "disk":
        turn = 2 * np.pi * np.arange(_AROUND) / _AROUND
        size = np.sqrt(2 * np.pi / (_AROUND * np.sin(2 * np.pi / _AROUND)))
        ring = np.concatenate([[(0.0, 0.0)], size * np.stack([np.cos(turn), np.sin(turn)], axis=1)])
        fan = [[0, 1 + k, 1 + (k + 1) % _AROUND] for k in range(_AROUND)]
        return _faces(_placed(exact, _upright(ring)), fan, (ring + 1) / 2)
    if exact.kind == "convex":
        ring = exact.values.reshape(-1, 2)
        return _faces(_placed(exact, _upright(ring)), [list(range(len(ring)))], ring)
    if exact.kind == "polygon":
        places, edges = np.unique(exact.values.reshape(-1, 2), axis=0, return_inverse=True)
        cut = delaunay(places, _real(edges.reshape(-1, 2)), crossings="split")
        inside = cut.triangles[cut.winding % 2 != 0]
        return _faces(_placed(exact, _upright(cut.points)), inside.tolist(), cut.points)
    if exact.kind == "block":
        middle, reach = _region(to_own, around)
        ends = np.isinf(exact.values)
        half = np.where(ends, reach, exact.values)
        corners = _placed(exact, (_BLOCK * half + np.where(ends, middle, 0.0)).reshape(-1, 3))
        quads = np.arange(24).reshape(6, 4)
        turned = quads[:, ::-1] if np.linalg.det(exact.matrix[:3, :3]) < 0 else quads
        return _welded(corners, turned, np.tile(_SQUARE, (6, 1)))
    return None


def _region(to_own: Points, around: Points) -> tuple[Points, float]:
    """Middle of the box `around` in a primitive's space, and how far from there it ends."""
    corners = np.array([[around[i, 0], around[j, 1], around[k, 2]] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
    own = corners @ to_own[:3, :3].T + to_own[:3, 3]
    low, high = own.min(axis=0), own.max(axis=0)
    return (low + high) / 2, _REACH * float(np.linalg.norm(high - low))


def _upright(flat: Points) -> Points:
    """Places (x, −z) of the plane y = 0 in space."""
    return np.stack([flat[:, 0], np.zeros(len(flat)), -flat[:, 1]], axis=1)


def _placed(exact: Primitive, own: Points) -> Points:
    placed: Points = own @ exact.matrix[:3, :3].T + exact.matrix[:3, 3]
    return placed


def _real(edges: npt.NDArray[np.int64]) -> npt.NDArray[np.int64]:
    """Edges that join different points."""
    real: npt.NDArray[np.int64] = edges[edges[:, 0] != edges[:, 1]]
    return real


def _faces(corners: Points, faces: list[list[int]], uvs: Points) -> Mesh:
    return Mesh(corners, faces, attributes={"uv": uvs})


def _welded(corners: Points, quads: npt.NDArray[np.int64], uvs: Points) -> Mesh:
    """Faces that share the vertices where their corners are equal."""
    vertices, row = np.unique(corners, axis=0, return_inverse=True)
    own = Attribute(uvs[quads.reshape(-1)].astype(np.float32), np.arange(quads.size))
    return Mesh(vertices, row.reshape(-1)[quads].tolist(), attributes={"uv": own})
