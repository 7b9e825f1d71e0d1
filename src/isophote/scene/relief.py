"""Surfaces whose light falls as if they were turned: normal maps and bumps."""

from __future__ import annotations

from typing import Any

import attrs

from isophote.errors import SceneError
from isophote.scene.compound import inner_material
from isophote.scene.fields import as_number, finite, instance_of
from isophote.scene.image_texture import ImageTexture
from isophote.scene.material_base import Material
from isophote.scene.texture import Texture

__all__ = ["Bump", "NormalMap", "unturned"]


def _part(instance: Any, attribute: attrs.Attribute[Any], value: Any) -> None:
    inner_material(instance, attribute, value)
    kind = type(instance).__name__
    if isinstance(value, NormalMap | Bump):
        raise SceneError(f"{kind}: {attribute.name} is turned by a {type(value).__name__} already, and is turned once")


def _directions(instance: Any, attribute: attrs.Attribute[Any], value: Any) -> None:
    instance_of("a Texture", Texture)(instance, attribute, value)
    if isinstance(value, ImageTexture) and value.channels == 1:
        raise SceneError(
            f"{type(instance).__name__}: {attribute.name} needs three channels, x, y and z of normals, but has one; "
            "iso.Bump takes heights"
        )
    if isinstance(value, ImageTexture) and value.colour_space != "linear":
        raise SceneError(
            f"{type(instance).__name__}: {attribute.name} holds directions, not colours; load it with "
            "colour_space='linear'"
        )


@attrs.frozen
class NormalMap(Material):
    """Any material under a tangent-space normal map: light falls as if the surface were turned, its shape stays.

    A texel (r, g, b) stands for the normal (2 r − 1) `scale` t + (2 g − 1) `scale` b + (2 b − 1) n, with the surface's
    normal n, the tangent t along which texture coordinate u grows, and b, v upward: glTF's and OpenGL's convention.
    A mesh's tangents are its attribute "tangent", or those of `tangents`, after MikkTSpace. The texture must be linear.

    Facets that look away are hidden by upright ones beside them, so that nothing is black that can be seen, and no
    light is made or lost (Schüßler et al., "Microfacet-based Normal Mapping", 2017).
    """

    material: Material = attrs.field(validator=_part)
    texture: Texture = attrs.field(validator=_directions)
    scale: float = attrs.field(default=1.0, converter=as_number, validator=finite)


@attrs.frozen
class Bump(Material):
    """Any material on a surface with bumps: light falls as if it rose by `scale` times the height, its shape stays.

    `height` is a texture of any kind, whose first channel counts; `scale`, and so the heights, are in the shape's own
    units. The normal is n − `scale` ∇h, with the gradient in the surface by differences: it takes no tangents, and with
    textures of space no texture coordinates either (Blinn, "Simulation of Wrinkled Surfaces", SIGGRAPH 1978; Mikkelsen,
    "Bump Mapping Unparametrized Surfaces on the GPU", 2010). Facets that look away are as with `NormalMap`.
    """

    material: Material = attrs.field(validator=_part)
    height: Texture = attrs.field(validator=instance_of("a Texture", Texture))
    scale: float = attrs.field(default=1.0, converter=as_number, validator=finite)


def unturned(material: Material) -> Material:
    """What a normal map or a bump lies on, or the material itself."""
    return material.material if isinstance(material, NormalMap | Bump) else material
