"""Materials and textures into tables."""

from __future__ import annotations

from functools import singledispatch
from typing import NamedTuple

import numpy as np

from isophote.kernels.base.table import Packed
from isophote.kernels.light import bsdf, texture
from isophote.kernels.light.bsdf import MATERIALS
from isophote.kernels.light.texture import TEXTURES
from isophote.scene.colour import srgb_to_linear
from isophote.scene.material import Emitter, Glass, Material, Matte, Mirror, Principled
from isophote.scene.texture import Texture

__all__ = ["MaterialTable", "emission_of"]

_WRAP = {"repeat": texture.REPEAT, "clamp": texture.CLAMP, "mirror": texture.MIRROR}
_FILTER = {"bilinear": texture.BILINEAR, "nearest": texture.NEAREST}
_FLOAT_TEXELS = 2


class _Row(NamedTuple):
    """One material: kind, colour, texture, emitted radiance, index of refraction, whether both sides emit."""

    kind: int
    colour: tuple[float, float, float] = (0.0, 0.0, 0.0)
    texture: Texture | None = None
    emission: tuple[float, float, float] = (0.0, 0.0, 0.0)
    ior: float = 1.0
    two_sided: bool = False


@singledispatch
def _row(material: object) -> _Row:
    raise TypeError(f"no row for a {type(material).__name__}")


@_row.register
def _(material: Matte) -> _Row:
    if isinstance(material.colour, Texture):
        return _Row(bsdf.MATTE, (1.0, 1.0, 1.0), material.colour)
    return _Row(bsdf.MATTE, material.colour)


@_row.register
def _(material: Mirror) -> _Row:
    return _Row(bsdf.MIRROR, material.colour)


@_row.register
def _(material: Glass) -> _Row:
    return _Row(bsdf.GLASS, material.colour, ior=material.ior)


@_row.register
def _(material: Emitter) -> _Row:
    return _Row(bsdf.BLACK, emission=material.radiance, two_sided=material.two_sided)


@_row.register
def _(material: Principled) -> _Row:
    return _Row(bsdf.MATTE, material.colour, material.colour_texture, material.emission, two_sided=material.two_sided)


def emission_of(material: Material) -> tuple[tuple[float, float, float], bool]:
    """(radiance that a material emits, whether on both sides)."""
    row = _row(material)
    return row.emission, row.two_sided


class MaterialTable:
    """Numbers materials as they come; equal ones share a row."""

    def __init__(self) -> None:
        self._numbers: dict[Material, int] = {}
        self._textures: dict[Texture, int] = {}

    def number(self, material: Material) -> int:
        """Row of a material."""
        return self._numbers.setdefault(material, len(self._numbers))

    def build(self) -> tuple[Packed, Packed]:
        """The tables of all materials that were numbered."""
        rows = [_row(material) for material in self._numbers]
        textures = [-1 if row.texture is None else self._texture(row.texture) for row in rows]
        values = [(*row.colour, *row.emission, row.ior, float(row.two_sided)) for row in rows]
        materials = MATERIALS.pack(
            kinds=np.array([row.kind for row in rows], np.int32),
            textures=np.array(textures, np.int32),
            values=np.array(values, np.float32).reshape(-1, 8),
        )
        return materials, _lower_textures(tuple(self._textures))

    def _texture(self, image: Texture) -> int:
        return self._textures.setdefault(image, len(self._textures))


def _lower_textures(images: tuple[Texture, ...]) -> Packed:
    codes = np.zeros((len(images), 6), np.int64)
    small, large = [np.zeros((0, 3), np.uint8)], [np.zeros((0, 3), np.float32)]
    starts = [0, 0]
    for k, image in enumerate(images):
        width, height = image.size
        pixels = image.pixels.reshape(height, width, -1)
        rgb = np.broadcast_to(pixels[..., :1], (height, width, 3)) if image.channels == 1 else pixels[..., :3]
        rgb = rgb.reshape(-1, 3)
        is_bytes = rgb.dtype == np.uint8
        if not is_bytes and image.colour_space == "srgb":
            rgb = srgb_to_linear(rgb)
        row = int(image.colour_space == "linear") if is_bytes else _FLOAT_TEXELS
        first = starts[0 if is_bytes else 1]
        codes[k] = first, width, height, _WRAP[image.wrap], _FILTER[image.filter], row
        (small if is_bytes else large).append(rgb)
        starts[0 if is_bytes else 1] += len(rgb)
    steps = np.arange(256) / 255
    return TEXTURES.pack(
        codes=codes,
        bytes=np.ascontiguousarray(np.concatenate(small)),
        floats=np.ascontiguousarray(np.concatenate(large), np.float32),
        decode=np.stack([srgb_to_linear(steps), steps]).astype(np.float32),
    )
