"""Materials as trees of nodes: the entries that are called for them, and their parameters."""

from __future__ import annotations

from functools import lru_cache, singledispatch
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.kernels.brdf import (
    ashikhmin_shirley,
    compound,
    conductor,
    diffuse,
    measured,
    phong,
    plastic,
    principled,
    rough_glass,
    thin_glass,
    turned,
    ward,
)
from isophote.kernels.trace.turned_normal import BUMP, NORMAL_MAP
from isophote.lower.albedo import coat_table, mean_conductor, ring_chances, split_tables
from isophote.lower.node import Node, Slot
from isophote.scene.colour import Colour
from isophote.scene.compound import Coated, Mix, Plastic
from isophote.scene.gloss import AshikhminShirley, Blinn, OrenNayar, Phong, Ward
from isophote.scene.image_texture import ImageTexture
from isophote.scene.material import Glass, Matte, Mirror, Principled
from isophote.scene.material_base import ColourParameter, Material, NumberParameter
from isophote.scene.measured import Measured
from isophote.scene.metal import Metal
from isophote.scene.relief import Bump, NormalMap
from isophote.scene.texture import Texture
from isophote.scene.thin_glass import ThinGlass

__all__ = ["node_of"]

Floats: TypeAlias = npt.NDArray[np.float32]

_RED, _GREEN, _BLUE = 0, 1, 2


@singledispatch
def node_of(material: Material) -> Node:
    """The node of a material."""
    raise TypeError(f"no node for a {type(material).__name__}")


def _is_smooth(*roughness: NumberParameter) -> bool:
    return all(not isinstance(part, Texture) and part == 0 for part in roughness)


def _slots(*parameters: Any) -> tuple[Slot, ...]:
    return tuple(Slot.of(parameter) for parameter in parameters)


@node_of.register
def _(material: Matte) -> Node:
    return Node((diffuse.evaluate_lambert, diffuse.sample_lambert, None), _slots(material.colour))


@node_of.register
def _(material: OrenNayar) -> Node:
    entries = diffuse.evaluate_oren_nayar, diffuse.sample_oren_nayar, None
    return Node(entries, _slots(material.colour, material.roughness))


@node_of.register
def _(material: Phong) -> Node:
    slots = _slots(material.colour, material.specular, material.exponent)
    return Node((phong.evaluate_phong, phong.sample_phong, None), slots)


@node_of.register
def _(material: Blinn) -> Node:
    slots = _slots(material.colour, material.specular, material.exponent)
    return Node((phong.evaluate_blinn, phong.sample_blinn, None), slots)


@node_of.register
def _(material: AshikhminShirley) -> Node:
    entries = ashikhmin_shirley.evaluate_ashikhmin_shirley, ashikhmin_shirley.sample_ashikhmin_shirley, None
    return Node(entries, _slots(material.colour, material.specular, *material.exponents), anisotropic=True)


@node_of.register
def _(material: Ward) -> Node:
    slots = _slots(material.colour, material.specular, *material.roughness)
    return Node((ward.evaluate_ward, ward.sample_ward, None), slots, anisotropic=True)


@node_of.register
def _(material: Mirror) -> Node:
    # A metal that reflects everything: n = 0, or next to it.
    return _smooth_metal(((1e-6,) * 3, (1.0,) * 3), material.colour)


def _smooth_metal(index: tuple[Colour, Colour], colour: ColourParameter) -> Node:
    entries = conductor.evaluate_nothing, conductor.sample_smooth, conductor.branch_smooth
    return Node(entries, _slots(*index, colour), branches=1, scatters=False)


@node_of.register
def _(material: Metal) -> Node:
    if _is_smooth(*material.roughness):
        return _smooth_metal(material.index, material.colour)
    n, k = (np.array(part) for part in material.index)
    mean = tuple(mean_conductor(n, k).tolist())
    slots = _slots(*material.index, material.colour, *material.roughness, mean)
    along, across = material.roughness
    if material.single_bounce:
        return Node((conductor.evaluate_single, conductor.sample_single, None), slots, anisotropic=along != across)
    entries = conductor.evaluate_conductor, conductor.sample_conductor, None
    return Node(entries, slots, split_tables(), anisotropic=along != across)


@node_of.register
def _(material: Glass) -> Node:
    slots = _slots(material.ior, material.colour, *material.roughness)
    if material.is_smooth:
        entries = conductor.evaluate_nothing, rough_glass.sample_glass, rough_glass.branch_glass
        return Node(entries, slots, branches=2, scatters=False)
    along, across = material.roughness
    rough = rough_glass.evaluate_rough_glass, rough_glass.sample_rough_glass, None
    return Node(rough, slots, anisotropic=along != across, through=True)


@node_of.register
def _(material: ThinGlass) -> Node:
    depth = tuple(channel * material.thickness for channel in material.absorption)
    entries = conductor.evaluate_nothing, thin_glass.sample_pane, thin_glass.branch_pane
    return Node(entries, _slots(material.ior, material.colour, depth), branches=2, scatters=False)


@lru_cache(maxsize=32)
def _coat(ior: float, smooth: bool) -> Floats:
    """Data of kernels/brdf/coat.py."""
    return np.concatenate([np.array([ior, smooth], np.float32), coat_table(ior)])


@node_of.register
def _(material: Plastic) -> Node:
    smooth = _is_smooth(material.roughness)
    entries = plastic.evaluate_plastic, plastic.sample_plastic, plastic.branch_plastic
    slots = _slots(material.roughness, material.colour)
    return Node(entries, slots, _coat(material.ior, smooth), branches=int(smooth))


@node_of.register
def _(material: Coated) -> Node:
    smooth, base = _is_smooth(material.roughness), node_of(material.base)
    return Node(
        (compound.evaluate_coated, compound.sample_coated, compound.branch_coated),
        _slots(material.roughness),
        _coat(material.ior, smooth),
        (base,),
        branches=base.branches + int(smooth),
        scatters=base.scatters or not smooth,
        anisotropic=base.anisotropic,
        through=base.through,
    )


@node_of.register
def _(material: Mix) -> Node:
    parts = node_of(material.first), node_of(material.second)
    return Node(
        (compound.evaluate_mix, compound.sample_mix, compound.branch_mix),
        _slots(material.amount),
        children=parts,
        branches=sum(part.branches for part in parts),
        scatters=any(part.scatters for part in parts),
        anisotropic=any(part.anisotropic for part in parts),
        through=any(part.through for part in parts),
    )


@node_of.register
def _(material: Principled) -> Node:
    texture = material.metallic_roughness_texture
    slots = (
        Slot(material.colour, material.colour_texture),
        Slot((material.metallic,) * 3, texture, _BLUE),
        Slot((material.roughness,) * 3, texture, _GREEN),
    )
    occlusion, strength = material.occlusion_texture, material.occlusion_strength
    # What is left of ambient light, 1 + strength (texel − 1), as a sum of two.
    left = () if occlusion is None else (Slot((1 - strength,) * 3), Slot((strength,) * 3, occlusion, _RED))
    entries = principled.evaluate_principled, principled.sample_principled, None
    node = Node(entries, slots + left, split_tables(), openness=len(slots) if left else 0)
    if material.normal_texture is None:
        return node
    return _turned(node, _normals(material.normal_texture, material.normal_scale))


@node_of.register
def _(material: NormalMap) -> Node:
    return _turned(node_of(material.material), _normals(material.texture, material.scale))


@node_of.register
def _(material: Bump) -> Node:
    height = material.height
    width, rows = height.size if isinstance(height, ImageTexture) else (0, 0)
    texels = (1 / width, 1 / rows) if width else (0.0, 0.0)
    return _turned(node_of(material.material), Slot((material.scale, *texels), height, BUMP))


def _normals(texture: Texture, scale: float) -> Slot:
    return Slot((scale, scale, 1.0), texture, NORMAL_MAP)


def _turned(base: Node, normal: Slot) -> Node:
    """A node as if its surface had the normal of a slot."""
    entries = turned.evaluate_turned, turned.sample_turned, turned.branch_turned
    return Node(
        entries,
        (normal,),
        children=(base,),
        branches=base.branches,
        scatters=base.scatters,
        anisotropic=base.anisotropic,
        openness=base.openness,
        through=base.through,
        turned=True,
    )


@node_of.register
def _(material: Measured) -> Node:
    values = np.maximum(material.values, 0)
    data = np.concatenate([values.reshape(-1), ring_chances(values)]).astype(np.float32)
    return Node((measured.evaluate_measured, measured.sample_measured, None), (), data)
