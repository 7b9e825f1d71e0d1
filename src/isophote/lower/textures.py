"""Textures into tables."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.errors import SceneError
from isophote.kernels.base.table import Packed
from isophote.kernels.texture import contract
from isophote.kernels.texture.contract import CHILD_A, DATA, LOOK_UP, NODE_WORDS, PICTURE, TEXTURES
from isophote.scene.colour import srgb_to_linear
from isophote.scene.image_texture import ImageTexture
from isophote.scene.texture import Texture

__all__ = ["TextureTable"]

Floats: TypeAlias = npt.NDArray[np.float32]
Texels: TypeAlias = npt.NDArray[np.generic]

_WRAP = {"repeat": contract.REPEAT, "clamp": contract.CLAMP, "mirror": contract.MIRROR}
_FILTER = {"bilinear": contract.BILINEAR, "nearest": contract.NEAREST}
_PLAIN, _FLOATS = 1, 2
# So many entries may call each other on the way to a colour.
_DEEPEST = 100


class TextureTable:
    """Numbers textures as they come, those that they are made from included; equal ones share a node."""

    def __init__(self) -> None:
        self._numbers: dict[Texture, int] = {}
        self._nodes: list[list[int]] = []
        self._data: list[float] = []
        self._tables: list[Packed] = []
        self._depth = 0
        self._codes: list[list[int]] = []
        self._bytes: list[Texels] = [np.zeros((0, 4), np.uint8)]
        self._floats: list[Texels] = [np.zeros((0, 4), np.float32)]

    def number(self, texture: Texture) -> int:
        """The node of a texture."""
        if texture not in self._numbers:
            self._numbers[texture] = self._add(texture)
        return self._numbers[texture]

    def _add(self, texture: Texture) -> int:
        if isinstance(texture, ImageTexture):
            # Loaded where there is a picture: scenes without are drawn sooner.
            from isophote.kernels.texture.image import image

            return self._node(image.address, self._picture(texture))
        return self._formula(texture)

    def _formula(self, texture: Texture) -> int:
        # As in _add.
        from isophote.lower.procedural import node_of

        if self._depth >= _DEEPEST:
            raise SceneError(f"a texture is made of others more than {_DEEPEST} deep")
        self._depth += 1
        found = node_of(texture)
        children = [self.number(child) for child in found.children]
        self._depth -= 1
        own = 0 if found.table is None else found.table.words.ctypes.data
        self._tables += () if found.table is None else (found.table,)
        first = len(self._data)
        self._data += found.data
        return self._node(found.entry.address, own, first, children)

    def _node(self, address: int, picture: int = 0, data: int = 0, children: Sequence[int] = ()) -> int:
        node = [0] * NODE_WORDS
        node[LOOK_UP], node[PICTURE], node[DATA] = address, picture, data
        node[CHILD_A : CHILD_A + len(children)] = children
        self._nodes.append(node)
        return len(self._nodes) - 1

    def _picture(self, picture: ImageTexture) -> int:
        """Row of `codes` of a picture."""
        width, height = picture.size
        texels = _with_alpha(picture)
        is_bytes = texels.dtype == np.uint8
        row = _FLOATS if not is_bytes else (_PLAIN if picture.colour_space == "linear" else 0)
        parts = self._bytes if is_bytes else self._floats
        first = sum(map(len, parts))
        parts.append(texels)
        self._codes.append([first, width, height, _WRAP[picture.wrap], _FILTER[picture.filter], row])
        return len(self._codes) - 1

    def build(self, to_own: Callable[[], Floats] | None = None) -> Packed:
        """The table of all textures that were numbered; `to_own` gives its field where there are textures."""
        steps = np.arange(256) / 255
        packed = TEXTURES.pack(
            nodes=np.array(self._nodes, np.int64).reshape(-1, NODE_WORDS),
            codes=np.array(self._codes, np.int64).reshape(-1, 6),
            bytes=np.ascontiguousarray(np.concatenate(self._bytes)),
            floats=np.ascontiguousarray(np.concatenate(self._floats), np.float32),
            decode=np.stack([srgb_to_linear(steps), steps]).astype(np.float32),
            data=np.array(self._data, np.float32),
            to_own=to_own() if to_own is not None and self._nodes else np.zeros((0, 12), np.float32),
            **self._entries(),
        )
        # Nodes hold the addresses of these.
        return packed._replace(arrays=packed.arrays | {"tables": tuple(self._tables)})

    def _entries(self) -> dict[str, int]:
        if not self._nodes:
            return {"colour": 0, "curvature": 0}
        # As in _add.
        from isophote.kernels.trace.footprint import curvature_at
        from isophote.kernels.trace.textured import colour_at

        return {"colour": colour_at.address, "curvature": curvature_at.address}


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
