"""Textures as PNG files, for scene files that hold pictures."""

from __future__ import annotations

import warnings
from io import BytesIO
from os import fspath
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt
from PIL import Image as Pillow

from isophote.errors import IsophoteWarning
from isophote.io.files import StrPath
from isophote.scene.colour import linear_to_srgb, srgb_to_linear
from isophote.scene.image_texture import ImageTexture
from isophote.scene.texture import Texture

__all__ = ["encode_texture", "is_exact", "picture_of"]

Pixels: TypeAlias = npt.NDArray[Any]


def picture_of(texture: Texture | None, path: StrPath) -> ImageTexture | None:
    """A texture that is a picture; None, with an `IsophoteWarning`, for a formula, which files cannot hold."""
    if texture is None or isinstance(texture, ImageTexture):
        return texture
    warnings.warn(
        f"{fspath(path)}: a {type(texture).__name__} is left out, since the file can hold only pictures; "
        "isophote.bake_texture makes one of it",
        IsophoteWarning,
        stacklevel=6,
    )
    return None


def is_exact(texture: ImageTexture, space: str) -> bool:
    """Whether a PNG in this colour space, "srgb" or "linear", holds the texture's very pixels."""
    return texture.pixels.dtype == np.uint8 and texture.colour_space == space


def encode_texture(texture: ImageTexture, space: str) -> bytes:
    """The bytes of a PNG with the texture's pixels, at 8 bits in the colour space."""
    pixels = texture.pixels if is_exact(texture, space) else _as_bytes(texture, space)
    buffer = BytesIO()
    Pillow.fromarray(pixels[..., 0] if pixels.shape[2:] == (1,) else pixels).save(buffer, "PNG")
    return buffer.getvalue()


def _as_bytes(texture: ImageTexture, space: str) -> Pixels:
    """The pixels at 8 bits in another colour space; a fourth channel has none."""
    given = texture.pixels if texture.pixels.ndim == 3 else texture.pixels[..., None]
    values = np.clip(given / (255.0 if given.dtype == np.uint8 else 1.0), 0.0, 1.0)
    if texture.colour_space != space:
        values[..., :3] = (linear_to_srgb if space == "srgb" else srgb_to_linear)(values[..., :3])
    return np.floor(values * 255.0 + 0.5).astype(np.uint8)
