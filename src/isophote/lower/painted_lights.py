"""Lights whose radiance a texture varies: where on it their triangles lie."""

from __future__ import annotations

from typing import Any, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.scene.texture import Texture
from isophote.shapes.mesh import Mesh

__all__ = ["Paint", "corner_uvs", "mean_luminance", "paint_fields", "paint_rows"]

Points: TypeAlias = npt.NDArray[np.float64]

# Texture coordinates at a triangle's first corner and along its two edges, then the map to the shape's own space.
_COLUMNS = 18
_LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
# Places of a triangle that its mean is taken from: weights of its second and third corner.
_WEIGHTS = np.array([(1, 1), (4, 1), (1, 4), (2, 2)]) / 6


class Paint(NamedTuple):
    """A texture that multiplies what a surface emits, and the row of its material."""

    texture: Texture
    material: int


def corner_uvs(mesh: Mesh, corners: npt.NDArray[np.int64]) -> Points:
    """(t, 3, 2): texture coordinates at the corners of triangles; as weights of corners where a mesh has none."""
    attribute = mesh.uvs
    if attribute is None:
        return np.tile(np.array([(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)]), (len(corners), 1, 1))
    rows = mesh.indices if attribute.indices is None else np.maximum(attribute.indices, 0)
    values: Points = np.asarray(attribute.values[rows[corners], :2], np.float64)
    return values


def paint_rows(uvs: Points, to_own: Points) -> Points:
    """(t, 18) of triangles."""
    own = np.tile(to_own[:3].reshape(-1), (len(uvs), 1))
    return np.concatenate([uvs[:, 0], uvs[:, 1] - uvs[:, 0], uvs[:, 2] - uvs[:, 0], own], axis=1)


def mean_luminance(texture: Texture, corners: Points, uvs: Points, to_own: Points) -> Points:
    """(t,): about the mean luminance of a texture over triangles, by which they are picked."""
    # Loaded where a light has a texture.
    from isophote.lower.texture_probe import texture_values

    total = np.zeros(len(corners))
    for a, b in _WEIGHTS:
        weights = np.array([1 - a - b, a, b])
        world, uv = np.einsum("k,tkc->tc", weights, corners), np.einsum("k,tkc->tc", weights, uvs)
        # About the quarter of the triangle around the place.
        around, uv_around = (rows[:, 1:] - rows[:, :1] for rows in (corners / 4, uvs / 4))
        found = texture_values(
            texture,
            uv,
            world @ to_own[:3, :3].T + to_own[:3, 3],
            world,
            uv_axes=uv_around,
            own_axes=around @ to_own[:3, :3].T,
            world_axes=around,
        )
        total += found[:, :3] @ _LUMINANCE / len(_WEIGHTS)
    return np.maximum(total, 0.0)


def paint_fields(painted: dict[int, tuple[int, Points]], count: int) -> dict[str, Any]:
    """Fields of the table of `count` lights; of those that a texture varies, by the number of the first of some that
    follow each other: the material, and a row for each."""
    if not painted:
        none = np.zeros(0, np.int32)
        return {"painted": none, "paint": np.zeros((0, _COLUMNS), np.float32), "paint_materials": none, "tint": 0}
    # As in mean_luminance.
    from isophote.kernels.trace.painted_lights import light_tint

    numbers, row = np.full(count, -1, np.int32), 0
    for first, (_, rows) in painted.items():
        numbers[first : first + len(rows)] = np.arange(row, row + len(rows))
        row += len(rows)
    lengths = [len(rows) for _, rows in painted.values()]
    return {
        "painted": numbers,
        "paint": np.concatenate([rows for _, rows in painted.values()]).astype(np.float32),
        "paint_materials": np.repeat([material for material, _ in painted.values()], lengths).astype(np.int32),
        "tint": light_tint.address,
    }
