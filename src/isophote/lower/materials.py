"""Materials and textures into tables."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.kernels.base.table import Packed
from isophote.kernels.light import bsdf
from isophote.kernels.light.bsdf import MATERIALS
from isophote.lower.node import Cut, Node, Slot, no_nodes
from isophote.lower.textures import TextureTable
from isophote.scene.cutout import ALPHA, Cutout, alpha_channel
from isophote.scene.material import Emitter, Glass, Matte, Mirror, Principled
from isophote.scene.material_base import ColourParameter, Material, parts_of
from isophote.scene.nearest import nearest_principled
from isophote.scene.relief import NormalMap
from isophote.scene.texture import Texture

__all__ = [
    "MaterialTable",
    "aimed_emission_of",
    "emission_of",
    "emission_texture_of",
    "is_cut",
    "is_linked",
    "is_mapped",
]

Floats: TypeAlias = npt.NDArray[np.float32]

_BLACK = (0.0, 0.0, 0.0)


class _Row(NamedTuple):
    """One material: kind, colour, texture, emitted radiance, index of refraction, whether both sides emit, the number
    of single directions that light is sent to, the node of a kind that is called by address, and how it is cut out."""

    kind: int
    colour: tuple[float, float, float] = _BLACK
    texture: Texture | None = None
    emission: tuple[float, float, float] = _BLACK
    ior: float = 1.0
    two_sided: bool = False
    branches: int = 0
    node: Node | None = None
    cut: Cut | None = None
    emission_texture: Texture | None = None


def _row(material: Material) -> _Row:
    """The row of a material. Of those compiled into the tiles there are few; all others are called by address."""
    if isinstance(material, Cutout):
        return _row(material.material)._replace(cut=_cut(material))
    if isinstance(material, Emitter):
        body = _Row(bsdf.BLACK) if material.body is None else _row(material.body)
        shining = body._replace(emission=material.radiance, two_sided=material.two_sided)
        return shining._replace(emission_texture=material.texture)
    if isinstance(material, Matte):
        return _shown(bsdf.MATTE, material.colour)
    if isinstance(material, Mirror):
        return _Row(bsdf.MIRROR, material.colour, branches=1)
    if isinstance(material, Glass) and material.is_smooth:
        return _Row(bsdf.GLASS, material.colour, ior=material.ior, branches=2)
    return _linked(material)


def _linked(material: Material) -> _Row:
    # Loaded where there is such a material: others are drawn sooner without.
    from isophote.lower.lobes import node_of

    if isinstance(material, Cutout):
        return _linked(material.material)._replace(cut=_cut(material))
    node, shown = node_of(material), nearest_principled(material)
    return _Row(
        bsdf.LINKED,
        shown.colour,
        shown.colour_texture,
        material.emission if isinstance(material, Principled) else _BLACK,
        two_sided=isinstance(material, Principled) and material.two_sided,
        branches=node.branches,
        node=node,
        emission_texture=material.emission_texture if isinstance(material, Principled) else None,
        cut=_cut_of_principled(material) if isinstance(material, Principled) else None,
    )


def _cut(cutout: Cutout) -> Cut:
    alpha, cutoff = cutout.alpha, cutout.cutoff if cutout.mode == "mask" else -1.0
    if isinstance(alpha, Texture):
        return Cut(Slot((1.0, 1.0, 1.0), alpha, alpha_channel(alpha)), cutoff)
    return Cut(Slot.of(alpha), cutoff)


def _cut_of_principled(material: Principled) -> Cut | None:
    if material.alpha_mode == "opaque":
        return None
    cutoff = material.alpha_cutoff if material.alpha_mode == "mask" else -1.0
    return Cut(Slot((material.opacity,) * 3, material.colour_texture, ALPHA), cutoff)


def _shown(kind: int, colour: ColourParameter) -> _Row:
    return _Row(kind, (1.0, 1.0, 1.0), colour) if isinstance(colour, Texture) else _Row(kind, colour)


def emission_of(material: Material) -> tuple[tuple[float, float, float], bool]:
    """(radiance that a material emits, whether on both sides)."""
    row = _row(material)
    return row.emission, row.two_sided


def aimed_emission_of(material: Material) -> tuple[tuple[float, float, float], bool]:
    """What `emission_of` says of surfaces that are aimed at as lights; none of cut-outs, which are met by chance: who
    aims does not know of holes."""
    row = _row(material)
    return (row.emission, row.two_sided) if row.cut is None else (_BLACK, False)


def emission_texture_of(material: Material) -> Texture | None:
    """The texture that multiplies what a material emits."""
    return _row(material).emission_texture


def is_cut(material: Material) -> bool:
    """Whether a material has holes, or may let a part of the light straight through."""
    return _row(material).cut is not None


def is_mapped(material: Material) -> bool:
    """Whether a normal map lies on a material, or on one inside it."""
    return any(
        isinstance(part, NormalMap) or (isinstance(part, Principled) and part.normal_texture is not None)
        for part in parts_of(material)
    )


def is_linked(material: Material) -> bool:
    """Whether the kernels of a material are not those of rendering methods, but compiled by themselves."""
    return _row(material).kind == bsdf.LINKED


class MaterialTable:
    """Numbers materials as they come; equal ones share a row. With `all_linked` those, too, that are compiled into the
    tiles of rendering methods get nodes."""

    def __init__(self, all_linked: bool = False) -> None:
        self._all_linked = all_linked
        self._numbers: dict[Material, int] = {}
        self._textures = TextureTable()

    def number(self, material: Material) -> int:
        """Row of a material."""
        return self._numbers.setdefault(material, len(self._numbers))

    @property
    def materials(self) -> tuple[Material, ...]:
        """All materials that were numbered, in their order."""
        return tuple(self._numbers)

    def build(self, to_own: Callable[[], Floats] | None = None) -> tuple[Packed, Packed]:
        """The tables of all materials that were numbered, and of their textures, to which `to_own` gives the spaces of
        items (kernels/texture/contract.py). Raises `SceneError` where a material has too many parts."""
        rows = [_linked(material) if self._all_linked else _row(material) for material in self._numbers]
        textures = [-1 if row.texture is None else self._textures.number(row.texture) for row in rows]
        shining = [-1 if row.emission_texture is None else self._textures.number(row.emission_texture) for row in rows]
        values = [(*row.colour, *row.emission, row.ior, float(row.two_sided)) for row in rows]
        scatters = [
            row.kind == bsdf.MATTE if row.node is None else row.node.scatters * (1 + row.node.through) for row in rows
        ]
        materials = MATERIALS.pack(
            kinds=np.array([row.kind for row in rows], np.int32),
            textures=np.array(textures, np.int32),
            emission_textures=np.array(shining, np.int32),
            values=np.array(values, np.float32).reshape(-1, 8),
            scatters=np.array(scatters, np.int32),
            branches=np.array([row.branches for row in rows], np.int32),
            **self._nodes([row.node for row in rows], [row.cut for row in rows]),
        )
        return materials, self._textures.build(to_own)

    def _nodes(self, roots: Sequence[Node | None], cuts: Sequence[Cut | None]) -> dict[str, Any]:
        if not any(roots) and not any(cuts):
            return no_nodes(len(roots))
        # As in _linked.
        from isophote.lower.node_table import NodeTable

        return NodeTable(self._textures.number).add_all(roots, cuts)
