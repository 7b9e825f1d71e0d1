"""Surfaces with holes: leaves, fences and gauze as single faces."""

from __future__ import annotations

from typing import Any

import attrs

from isophote.errors import SceneError
from isophote.scene.fields import as_number, instance_of, non_negative, one_of
from isophote.scene.image_texture import ImageTexture
from isophote.scene.material import Glass
from isophote.scene.material_base import Material, NumberParameter, number_or_texture
from isophote.scene.material_base import roughness as fraction_or_texture
from isophote.scene.texture import Texture

__all__ = ["ALPHA", "Cutout", "alpha_channel"]

# Channels of a texture that say how opaque a surface is.
_RED, ALPHA = 0, 3
_WITH_ALPHA = 4


def _part(instance: Any, attribute: attrs.Attribute[Any], value: Any) -> None:
    instance_of("a material", Material)(instance, attribute, value)
    if isinstance(value, Glass | Cutout):
        hint = "; ThinGlass is a pane that can have holes" if isinstance(value, Glass) else ""
        raise SceneError(f"Cutout: a {type(value).__name__} cannot be cut out{hint}")


@attrs.frozen
class Cutout(Material):
    """Any material on a surface that is only there in part.

    `alpha` is the opacity, a number from 0 to 1 or a texture: of a picture with four channels the fourth, of others the
    first. With `mode="blend"` so much of the light meets the material, and 1 − alpha goes straight on as if nothing
    were there; with "mask" all of it meets the material where alpha is `cutoff` or more, and none elsewhere.
    What shines and is cut out is met by chance in path tracing, and lights nothing else in ray tracing.
    """

    material: Material = attrs.field(validator=_part)
    alpha: NumberParameter = attrs.field(converter=number_or_texture, validator=fraction_or_texture)
    mode: str = attrs.field(default="blend", validator=one_of("blend", "mask"), kw_only=True)
    cutoff: float = attrs.field(default=0.5, converter=as_number, validator=non_negative, kw_only=True)


def alpha_channel(texture: Texture) -> int:
    """Which channel of a texture says how opaque a surface is."""
    return ALPHA if isinstance(texture, ImageTexture) and texture.channels == _WITH_ALPHA else _RED
