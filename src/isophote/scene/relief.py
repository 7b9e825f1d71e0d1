"""Surfaces whose light falls as if they were turned: normal maps."""

from __future__ import annotations

from typing import Any

import attrs

from isophote.errors import SceneError
from isophote.scene.compound import inner_material
from isophote.scene.fields import as_number, finite, instance_of
from isophote.scene.image_texture import ImageTexture
from isophote.scene.material import Glass
from isophote.scene.material_base import Material
from isophote.scene.texture import Texture

__all__ = ["NormalMap"]


def _part(instance: Any, attribute: attrs.Attribute[Any], value: Any) -> None:
    inner_material(instance, attribute, value)
    kind = type(instance).__name__
    if isinstance(value, Glass) and value.is_smooth:
        raise SceneError(f"{kind}: smooth Glass cannot be turned; give it some roughness")
    if isinstance(value, NormalMap):
        raise SceneError(f"{kind}: {attribute.name} has a normal map already, and a surface has one")


def _directions(instance: Any, attribute: attrs.Attribute[Any], value: Any) -> None:
    instance_of("a Texture", Texture)(instance, attribute, value)
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
