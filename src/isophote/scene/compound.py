"""Surfaces under a clear coat, and materials of materials."""

from __future__ import annotations

from typing import Any

import attrs

from isophote.errors import SceneError
from isophote.scene.colour import Colour
from isophote.scene.cutout import Cutout
from isophote.scene.fields import as_number
from isophote.scene.material import Emitter, Principled
from isophote.scene.material_base import (
    ColourParameter,
    Material,
    NumberParameter,
    albedo,
    colour_or_texture,
    number_or_texture,
    roughness,
)

__all__ = ["Coated", "Mix", "Plastic", "inner_material"]

_LIGHT_GREY: Colour = (0.8, 0.8, 0.8)
_LARGEST_INDEX = 10.0


def inner_material(instance: Any, attribute: attrs.Attribute[Any], value: Any) -> None:
    """A validator of what may be inside another: without holes, and not shining, which could not be aimed at."""
    kind = type(instance).__name__
    if not isinstance(value, Material):
        raise SceneError(f"{kind}: {attribute.name} must be a material, but is {value!r}")
    if isinstance(value, Cutout):
        raise SceneError(f"{kind}: {attribute.name} has holes; write Cutout({kind}(...), alpha) instead")
    if isinstance(value, Emitter) or (isinstance(value, Principled) and max(value.emission) > 0):
        raise SceneError(f"{kind}: {attribute.name} shines; write Emitter(radiance, body={kind}(...)) instead")


def _coat_index(instance: Any, attribute: attrs.Attribute[Any], value: Any) -> None:
    if not isinstance(value, float) or not 1 < value <= _LARGEST_INDEX:
        raise SceneError(
            f"{type(instance).__name__}: ior must be a number above 1, at most {_LARGEST_INDEX:g}, but is {value!r}"
        )


@attrs.frozen
class Plastic(Material):
    """A matte body under a clear coat, with the light that the coat reflects back into the body.

    `colour` is the albedo of the body. The coat, of index of refraction `ior`, reflects by Fresnel's equations from a
    surface as rough as `roughness` says, from 0, a mirror, to 1; α = roughness². `colour` and `roughness` may be
    textures.
    """

    colour: ColourParameter = attrs.field(default=_LIGHT_GREY, converter=colour_or_texture, validator=albedo)
    roughness: NumberParameter = attrs.field(default=0.2, converter=number_or_texture, validator=roughness)
    ior: float = attrs.field(default=1.5, converter=as_number, validator=_coat_index)


@attrs.frozen
class Coated(Material):
    """Any material, `base`, under a clear coat of lacquer: f = f_coat + (1 − E(θ_o)) (1 − E(θ_i)) f_base.

    E is what the coat reflects in all, of index of refraction `ior` and with a surface as rough as `roughness`, a
    number from 0 to 1 or a texture. Light that the coat sends back down is left out, so that coated things are darker.
    """

    base: Material = attrs.field(validator=inner_material)
    roughness: NumberParameter = attrs.field(default=0.0, converter=number_or_texture, validator=roughness)
    ior: float = attrs.field(default=1.5, converter=as_number, validator=_coat_index)


@attrs.frozen
class Mix(Material):
    """Two materials side by side, too fine to tell apart: (1 − amount) of `first`, `amount` of `second`.

    `amount` is a number from 0 to 1, or a texture.
    """

    first: Material = attrs.field(validator=inner_material)
    second: Material = attrs.field(validator=inner_material)
    amount: NumberParameter = attrs.field(default=0.5, converter=number_or_texture, validator=roughness)
