"""Textures of any kind baked into pictures over texture coordinates, for files and programs that know only those."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt
from scipy.ndimage import distance_transform_edt

from isophote.errors import GeometryError, RenderError
from isophote.lower.texture_probe import texture_values
from isophote.rendering.occlusion.atlas import Atlas, atlas_of
from isophote.scene.colour import linear_to_srgb
from isophote.scene.image_texture import ImageTexture
from isophote.scene.scene import Item
from isophote.scene.texture import Texture
from isophote.shapes.mesh import Mesh

__all__ = ["bake_texture"]

Floats: TypeAlias = npt.NDArray[np.float32]
Points: TypeAlias = npt.NDArray[np.float64]

_LARGEST = 8192
_TEXELS_AT_ONCE = 2**18


def bake_texture(
    texture: Texture,
    subject: Mesh | Item | None = None,
    *,
    size: int = 1024,
    gutter: int = 4,
    colour_space: str | None = None,
) -> ImageTexture:
    """A picture of `size` × `size` texels that looks like a texture, on a mesh or over the unit square.

    On a mesh, or an item that is one, each texel has the mean colour of its patch of the surface, by the mesh's own
    texture coordinates; the texels within `gutter` of a face's repeat the nearest of those, all others have the mean
    colour. Without, the texture is looked up at (u, v), and in its own space at (u, v, 0). The picture has three
    channels, or four where the texture is anywhere not opaque; of float32, linear, or of 8 bits in a `colour_space`,
    "srgb" as files want it for colours, "linear" for numbers.

    Raises `GeometryError` for a mesh without texture coordinates, for coordinates that are not within 0 to 1 and for
    overlapping faces (`unwrap` makes others); `RenderError` for other subjects and sizes.
    """
    if not isinstance(texture, Texture):
        raise RenderError(f"bake_texture: the first argument must be a Texture, not {texture!r}")
    for name, value, least in (("size", size, 1), ("gutter", gutter, 0)):
        if isinstance(value, bool) or not isinstance(value, int | np.integer) or not least <= value <= _LARGEST:
            raise RenderError(f"bake_texture: {name} must be a whole number from {least} to {_LARGEST}, not {value!r}")
    if colour_space not in (None, "srgb", "linear"):
        raise RenderError(f"bake_texture: colour_space must be 'srgb', 'linear' or None, not {colour_space!r}")
    if subject is None:
        texels = _over_square(texture, int(size))
    else:
        item = subject if isinstance(subject, Item) else Item(_mesh(subject))
        try:
            atlas = atlas_of(_mesh(item.shape), int(size))
        except GeometryError as error:
            raise GeometryError(f"bake_texture: {error}") from None
        texels = _spread(atlas.covered, _over_atlas(texture, atlas, item.transform.matrix), int(gutter))
    opaque = bool((texels[..., 3] == 1).all())
    pixels = _encoded(texels[..., : 3 if opaque else 4], colour_space)
    return ImageTexture(pixels, colour_space or "linear", wrap="repeat" if subject is None else "clamp")


def _encoded(texels: Floats, colour_space: str | None) -> Floats | npt.NDArray[np.uint8]:
    if colour_space is None:
        return texels
    levels = np.clip(texels, 0, 1)
    if colour_space == "srgb":
        levels[..., :3] = linear_to_srgb(levels[..., :3])
    encoded: npt.NDArray[np.uint8] = np.floor(levels * np.float32(255) + np.float32(0.5)).astype(np.uint8)
    return encoded


def _mesh(shape: object) -> Mesh:
    if not isinstance(shape, Mesh):
        raise RenderError(
            f"bake_texture: only a Mesh has an atlas, not a {type(shape).__name__}; isophote.to_mesh makes a mesh of a "
            "field, and isophote.unwrap its atlas"
        )
    return shape


def _centres(rows: npt.NDArray[np.intp], columns: npt.NDArray[np.intp], size: int) -> Points:
    """(n, 2) texture coordinates of the middles of texels."""
    return np.column_stack([(columns + 0.5) / size, 1 - (rows + 0.5) / size])


def _over_square(texture: Texture, size: int) -> Floats:
    texels = np.empty((size, size, 4), np.float32)
    step = max(1, _TEXELS_AT_ONCE // size)
    axes = np.array([[0.5 / size, 0, 0], [0, 0.5 / size, 0]])
    for first in range(0, size, step):
        rows, columns = np.indices((min(step, size - first), size)).reshape(2, -1)
        uv = _centres(rows + first, columns, size)
        own = np.column_stack([uv, np.zeros(len(uv))])
        found = texture_values(texture, uv, own, uv_axes=axes[:, :2], own_axes=axes)
        texels[first : first + step] = found.reshape(-1, size, 4)
    return texels


def _over_atlas(texture: Texture, atlas: Atlas, matrix: Points) -> Floats:
    """(n, 4): the values at the covered texels."""
    size = len(atlas.covered)
    rows, columns = np.nonzero(atlas.covered)
    slopes = _slopes(atlas) * (0.5 / size)
    values = np.empty((len(rows), 4), np.float32)
    square = np.eye(2) * (0.5 / size)
    for first in range(0, len(rows), _TEXELS_AT_ONCE):
        some = slice(first, min(first + _TEXELS_AT_ONCE, len(rows)))
        own, _ = atlas.places(some.start, some.stop)
        axes = slopes[atlas.triangle[some]]
        values[some] = texture_values(
            texture,
            _centres(rows[some], columns[some], size),
            own,
            own @ matrix[:3, :3].T + matrix[:3, 3],
            uv_axes=square,
            own_axes=axes,
            world_axes=axes @ matrix[:3, :3].T,
        )
    return values


def _slopes(atlas: Atlas) -> Points:
    """(t, 2, 3): ∂P/∂u and ∂P/∂v of triangles; zeros where texture coordinates have no area."""
    edges = atlas.corners[:, 1:] - atlas.corners[:, :1]
    flat = atlas.uvs[:, 1:] - atlas.uvs[:, :1]
    area = np.linalg.det(flat)
    inverse = np.zeros_like(flat)
    real = area != 0
    inverse[real] = np.linalg.inv(flat[real])
    slopes: Points = inverse @ edges
    return slopes


def _spread(covered: npt.NDArray[np.bool_], values: Floats, gutter: int) -> Floats:
    """(h, w, 4): the values of the covered texels, repeated up to `gutter` texels away, and their mean beyond."""
    texels = np.empty((*covered.shape, 4), np.float32)
    texels[:] = values.mean(axis=0, dtype=np.float64)
    texels[covered] = values
    if gutter and not covered.all():
        distance, (rows, columns) = distance_transform_edt(~covered, return_indices=True)
        near = distance <= gutter
        texels[near] = texels[rows[near], columns[near]]
    return texels
