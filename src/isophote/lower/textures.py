"""Textures into tables."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.errors import SceneError
from isophote.kernels.base.table import Packed
from isophote.kernels.texture.contract import CHILD_A, DATA, LOOK_UP, NODE_WORDS, PICTURE, TEXTURES
from isophote.lower.pictures import PictureTable
from isophote.scene.image_texture import ImageTexture
from isophote.scene.texture import Texture

if TYPE_CHECKING:
    from isophote.kernels.base.entry import Entry

__all__ = ["TextureTable"]

Floats: TypeAlias = npt.NDArray[np.float32]

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
        self._pictures = PictureTable()

    def number(self, texture: Texture) -> int:
        """The node of a texture: by itself, or, while another is described, as a part of that."""
        if self._depth == 0 and not isinstance(texture, ImageTexture):
            # As in _picture_entry.
            from isophote.lower.procedural import spread_out

            texture = spread_out(texture)
        if texture not in self._numbers:
            self._numbers[texture] = self._add(texture)
        return self._numbers[texture]

    def _add(self, texture: Texture) -> int:
        if isinstance(texture, ImageTexture):
            return self._node(_picture_entry(texture.filter).address, self._pictures.add(texture))
        return self._formula(texture)

    def _formula(self, texture: Texture) -> int:
        # As in _picture_entry.
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

    def build(self, to_own: Callable[[], Floats] | None = None) -> Packed:
        """The table of all textures that were numbered; `to_own` gives its field where there are textures."""
        packed = TEXTURES.pack(
            nodes=np.array(self._nodes, np.int64).reshape(-1, NODE_WORDS),
            **self._pictures.fields(),
            data=np.array(self._data, np.float32),
            to_own=to_own() if to_own is not None and self._nodes else np.zeros((0, 12), np.float32),
            **self._entries(),
        )
        # Nodes hold the addresses of these.
        return packed._replace(arrays=packed.arrays | {"tables": tuple(self._tables)})

    def _entries(self) -> dict[str, int]:
        if not self._nodes:
            return {"colour": 0, "curvature": 0}
        # As in _picture_entry.
        from isophote.kernels.trace.footprint import curvature_at
        from isophote.kernels.trace.textured import colour_at

        return {"colour": colour_at.address, "curvature": curvature_at.address}


def _picture_entry(kind: str) -> Entry:
    """What looks pictures up by a filter. Loaded where there is such a picture: scenes without are drawn sooner."""
    if kind in ("nearest", "bilinear"):
        from isophote.kernels.texture import image

        return image.nearest if kind == "nearest" else image.bilinear
    from isophote.kernels.texture import filtered

    return filtered.elliptical if kind == "ewa" else filtered.trilinear
