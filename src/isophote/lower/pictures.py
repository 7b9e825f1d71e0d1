"""Pictures into tables: their texels, and the means of them that filters need."""

from __future__ import annotations

from collections.abc import Hashable
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.kernels.texture import contract
from isophote.kernels.texture.contract import IN_FLOATS, PLAIN, SRGB
from isophote.latest import Latest
from isophote.scene.colour import srgb_to_linear
from isophote.scene.image_texture import ImageTexture

__all__ = ["PictureTable", "pyramid"]

Texels: TypeAlias = npt.NDArray[np.generic]
Floats: TypeAlias = npt.NDArray[np.float32]

_WRAP = {"repeat": contract.REPEAT, "clamp": contract.CLAMP, "mirror": contract.MIRROR}
_FILTERED = ("ewa", "trilinear")
# Where the search for the byte of a value begins, by so many parts of it.
_STEPS = 1024


class PictureTable:
    """The levels of all pictures, one after another."""

    def __init__(self) -> None:
        self._pictures: list[ImageTexture] = []

    def add(self, picture: ImageTexture) -> int:
        """Row of `codes` of a picture."""
        self._pictures.append(picture)
        return len(self._pictures) - 1

    def fields(self) -> dict[str, Any]:
        """Fields of the table of textures; those of the same pictures in the same order are the same arrays."""
        pixels = [picture.pixels for picture in self._pictures]
        settings: list[Hashable] = [(one.colour_space, one.filter, one.wraps) for one in self._pictures]
        kept = _latest.find(pixels)
        if kept is None or kept[0] != settings:
            levels = _Levels()
            for picture in self._pictures:
                levels.add(picture)
            kept = settings, levels.fields()
            _latest.keep(pixels, kept)
        return kept[1]


# The levels of the pictures of the scene lowered last: other lights or items need no new ones.
_latest: Latest[tuple[list[Hashable], dict[str, Any]]] = Latest()


class _Levels:
    """The levels of some pictures, gathered."""

    def __init__(self) -> None:
        self._codes: list[list[int]] = []
        self._levels: list[list[int]] = []
        self._parts: dict[bool, list[Texels]] = {
            True: [np.zeros((0, 4), np.uint8)],
            False: [np.zeros((0, 4), np.float32)],
        }
        self._counts = {True: 0, False: 0}

    def add(self, picture: ImageTexture) -> None:
        """The levels of one more."""
        width, height = picture.size
        texels = _with_alpha(picture)
        is_bytes = texels.dtype == np.uint8
        encoding = IN_FLOATS if not is_bytes else (PLAIN if picture.colour_space == "linear" else SRGB)
        levels = pyramid(texels, width, height, encoding) if picture.filter in _FILTERED else [texels]
        wrap_u, wrap_v = picture.wraps
        self._codes.append([len(self._levels), len(levels), _WRAP[wrap_u], _WRAP[wrap_v], encoding])
        for level in levels:
            self._levels.append([self._counts[is_bytes], width, height])
            self._parts[is_bytes].append(level)
            self._counts[is_bytes] += len(level)
            width, height = max(width // 2, 1), max(height // 2, 1)

    def fields(self) -> dict[str, Any]:
        """Fields of the table of textures."""
        return {
            "codes": np.array(self._codes, np.int64).reshape(-1, contract.CODE_WORDS),
            "levels": np.array(self._levels, np.int64).reshape(-1, 3),
            "bytes": np.concatenate(self._parts[True]),
            "floats": np.concatenate(self._parts[False]),
            "decode": _decode(),
        }


def _decode() -> Floats:
    """(2, 256): what bytes stand for, sRGB-encoded and plain."""
    steps = np.arange(256) / 255
    return np.stack([srgb_to_linear(steps), steps]).astype(np.float32)


def _with_alpha(picture: ImageTexture) -> Texels:
    """(texels, 4): the picture's pixels row by row, floats in linear light, opaque where it has no alpha."""
    pixels = picture.pixels.reshape(-1, picture.channels)
    is_bytes = pixels.dtype == np.uint8
    texels = np.full((len(pixels), 4), 255 if is_bytes else 1, pixels.dtype)
    texels[:, :3] = pixels if picture.channels == 1 else pixels[:, :3]
    if not is_bytes and picture.colour_space == "srgb":
        texels[:, :3] = srgb_to_linear(texels[:, :3])
    if picture.channels == 4:
        texels[:, 3] = pixels[:, 3]
    return texels


def pyramid(texels: Texels, width: int, height: int, encoding: int) -> list[Texels]:
    """The texels of all levels, (texels, 4) each and of the same type, from the picture itself down to a single one.

    Means are those of linear light, of the picture and not of rounded levels.
    """
    if width == height == 1:
        return [texels]
    # Loaded where there is a picture to filter.
    from isophote.kernels.texture.pyramid import encode, halve_bytes, halve_floats

    decode, levels = _decode(), [texels]
    limits = (decode[:, 1:] + decode[:, :-1]) / 2
    starts = np.stack([np.searchsorted(row, np.arange(_STEPS + 1, dtype=np.float32) / _STEPS) for row in limits])
    means: Floats | None = texels.astype(np.float32, copy=False) if encoding == IN_FLOATS else None
    while width > 1 or height > 1:
        half = np.empty((max(width // 2, 1) * max(height // 2, 1), 4), np.float32)
        if means is None:
            halve_bytes(texels, np.int64(width), np.int64(height), decode, np.int64(encoding), half)
        else:
            halve_floats(means, np.int64(width), np.int64(height), half)
        means, width, height = half, max(width // 2, 1), max(height // 2, 1)
        levels.append(half)
        if encoding != IN_FLOATS:
            levels[-1] = np.empty(half.shape, np.uint8)
            encode(half, limits, starts, np.int64(encoding), levels[-1])
    return levels
