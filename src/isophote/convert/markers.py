"""Points and edges made visible: balls and tubes, as meshes."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import numpy.typing as npt

from isophote.shapes.mesh import Mesh

__all__ = ["balls", "tubes"]

Points = npt.NDArray[np.float64]

_SIDES = 6
_GOLDEN = (1 + 5**0.5) / 2
# (0, ±1, ±golden ratio) and its rotations, on the unit sphere.
_ICOSAHEDRON = np.array(
    [np.roll((0, x, y * _GOLDEN), axis) for axis in range(3) for x in (-1, 1) for y in (-1, 1)]
) / np.hypot(1, _GOLDEN)


def _faces_around(corners: Points) -> npt.NDArray[np.int64]:
    """The triangles between corners that are as near to each other as corners get, looking outward."""
    apart = np.linalg.norm(corners[:, None] - corners, axis=2)
    near = np.isclose(apart, apart[apart > 0].min())
    rows = [(i, j, k) for i, j, k in combinations(range(len(corners)), 3) if near[i, j] and near[j, k] and near[k, i]]
    faces = np.array(rows)
    inward = np.linalg.det(corners[faces]) < 0
    faces[inward] = faces[inward][:, ::-1]
    return faces


_ICOSAHEDRON_FACES = _faces_around(_ICOSAHEDRON)


def balls(centres: npt.ArrayLike, radius: float) -> Mesh:
    """An icosahedron of this radius around each of the points, (k, 3), with k ≥ 1; faces look outward."""
    points = np.asarray(centres, np.float64)
    faces = _ICOSAHEDRON_FACES + 12 * np.arange(len(points))[:, None, None]
    return Mesh((points[:, None] + radius * _ICOSAHEDRON).reshape(-1, 3), faces.reshape(-1, 3))


def tubes(begins: npt.ArrayLike, ends: npt.ArrayLike, radius: float) -> Mesh:
    """A closed prism of six sides around each segment from `begins` to `ends`, (k, 3) each, with k ≥ 1.

    Prisms are a radius longer at both ends, so that those which share an end meet; faces look outward.
    """
    a, b = np.asarray(begins, np.float64), np.asarray(ends, np.float64)
    along = _unit(b - a)
    # The axis that the segment leans to least is never parallel to it.
    across = _unit(np.cross(along, np.eye(3)[np.abs(along).argmin(axis=1)]))
    turn = 2 * np.pi * np.arange(_SIDES) / _SIDES
    ring = np.cos(turn)[:, None] * across[:, None] + np.sin(turn)[:, None] * np.cross(along, across)[:, None]
    low, high = ((end + way * radius * along)[:, None] + radius * ring for end, way in ((a, -1), (b, 1)))
    here = np.arange(_SIDES)
    there = np.roll(here, -1)
    sides = np.stack([here, there, there + _SIDES, here + _SIDES], axis=1).reshape(-1)
    one = np.concatenate([sides, here[::-1], here + _SIDES])
    sizes = np.tile([4] * _SIDES + [_SIDES] * 2, len(a))
    indices = (one + 2 * _SIDES * np.arange(len(a))[:, None]).reshape(-1)
    offsets = np.concatenate([np.zeros(1, np.int64), np.cumsum(sizes)])
    return Mesh.from_polygons(np.concatenate([low, high], axis=1).reshape(-1, 3), indices, offsets)


def _unit(vectors: Points) -> Points:
    """Vectors of length 1; x for those without a length."""
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.where(length > 0, vectors / np.where(length > 0, length, 1), (1.0, 0.0, 0.0))
