"""Materials: what a surface does with light."""

from __future__ import annotations

from typing import Any

import attrs

from isophote.errors import SceneError
from isophote.scene.absorption import as_coefficients, coefficients_of_tint
from isophote.scene.colour import WHITE, Colour, ColourLike
from isophote.scene.colour import colour as as_colour
from isophote.scene.fields import (
    as_flag,
    as_number,
    finite,
    fraction,
    instance_of,
    non_negative,
    one_of,
    optional,
    positive,
)
from isophote.scene.material_base import (
    ColourParameter,
    Material,
    NumberParameter,
    albedo,
    colour_or_texture,
    roughness,
    roughness_pair,
)
from isophote.scene.texture import Texture

__all__ = ["Emitter", "Glass", "Material", "Matte", "Mirror", "Principled"]

_LIGHT_GREY: Colour = (0.8, 0.8, 0.8)
_BLACK: Colour = (0.0, 0.0, 0.0)

_texture = optional(instance_of("a Texture or None", Texture))


@attrs.frozen
class Matte(Material):
    """Scatters light evenly to all sides: Lambert's f = colour / π, on both faces of the surface.

    `colour` is the albedo, the reflected part of the light: a colour or a `Texture`.
    """

    colour: ColourParameter = attrs.field(default=_LIGHT_GREY, converter=colour_or_texture, validator=albedo)


@attrs.frozen
class Mirror(Material):
    """Reflects light in the mirror direction, on both faces, times `colour` at every angle."""

    colour: Colour = attrs.field(default=WHITE, converter=as_colour, validator=albedo)


@attrs.frozen
class Glass(Material):
    """A boundary of a clear solid or liquid: Fresnel reflection and refraction by Snell's law.

    `ior` is the index of refraction inside the surface, opposite the normal; above 0, and may be below 1. Air is 1.
    `colour` multiplies what is reflected and what is transmitted at the surface. `absorption` is the coefficient σ, in
    1/m, by channels: exp(−σ d) is left of light after d metres inside (Beer and Lambert); `Glass.tinted` takes a
    colour at a distance instead. With `ior=1` light goes straight on and is tinted by thickness alone.

    Solids of glass may lie within each other, and the index outside is then that of the outer one. Where they overlap,
    as ice that sticks out of water, or water drawn a little into its glass, the one of the higher `priority` is there,
    or, of equals, the one that a ray entered last (Schmidt, Budge: "Simple Nested Dielectrics in Ray Traced Images",
    JGT 7(2), 2002). Surfaces must be closed for that. A camera may stand in it.

    `roughness` from 0, smooth, to 1, ground, is a number or a `Texture`, or a pair of them, along the direction in
    which texture coordinate u grows and across it: α = roughness², microfacets after Walter et al., EGSR 2007.
    """

    ior: float = attrs.field(default=1.5, converter=as_number, validator=positive)
    colour: Colour = attrs.field(default=WHITE, converter=as_colour, validator=albedo)
    absorption: Colour = attrs.field(default=_BLACK, converter=as_coefficients)
    priority: float = attrs.field(default=0.0, converter=as_number, validator=finite)
    roughness: tuple[NumberParameter, NumberParameter] = attrs.field(
        default=(0.0, 0.0), converter=roughness_pair, validator=roughness, kw_only=True
    )

    @property
    def is_smooth(self) -> bool:
        """Whether it has no facets that could be seen: no roughness, or light that goes straight on."""
        return self.ior == 1 or all(not isinstance(part, Texture) and part == 0 for part in self.roughness)

    @classmethod
    def tinted(cls, colour: ColourLike, at: float, **rest: Any) -> Glass:
        """Glass through `at` metres of which white light has become `colour`; `rest` as for `Glass`.

        σ = −ln(colour) / at, so that no channel of the colour may be 0 or above 1.
        """
        if "absorption" in rest:
            raise SceneError("Glass.tinted: the colour says what is absorbed; give no absorption beside it")
        return cls(absorption=coefficients_of_tint(colour, at), **rest)


@attrs.frozen
class Emitter(Material):
    """Shines with `radiance`, W/(m² sr) in each channel, evenly to all sides, and reflects as `body` does.

    It shines on the side of the normal; with `two_sided` on both. Without a `body` it reflects nothing. A `texture`
    multiplies the radiance.
    """

    radiance: Colour = attrs.field(converter=as_colour)
    two_sided: bool = attrs.field(default=False, converter=as_flag)
    body: Material | None = attrs.field(default=None)
    texture: Texture | None = attrs.field(default=None, kw_only=True, validator=_texture)

    @body.validator
    def _check_body(self, attribute: attrs.Attribute[Material | None], value: object) -> None:
        if value is not None and (not isinstance(value, Material) or isinstance(value, Emitter)):
            raise SceneError(f"Emitter: body must be a material that does not shine itself, or None, but is {value!r}")
        if isinstance(value, Principled) and max(value.emission) > 0:
            raise SceneError("Emitter: body shines itself; give its emission to the Emitter")


@attrs.frozen
class Principled(Material):
    """glTF's metallic-roughness material: a metal, a matte body under a clear coat, or a mix of both.

    The base colour is `colour` times `colour_texture`, by channels; its fourth channel times `opacity` is
    the opacity, used as `alpha_mode` says: not at all ("opaque"), cut at `alpha_cutoff` ("mask") or mixed
    ("blend"). `metallic` and `roughness`, 0 to 1, are multiplied by the blue and green channels of
    `metallic_roughness_texture`; `emission`, radiance in W/(m² sr), by `emission_texture`.
    `normal_texture` holds tangent-space normals, whose x and y are scaled by `normal_scale`;
    `occlusion_texture` darkens ambient light, 1 + strength (red − 1) by `occlusion_strength`: that of `RayTrace`, for
    which nothing stands in the way of a constant sky. Where light's way is traced, it plays no part.
    Source: glTF 2.0, section 3.9, "Materials".
    """

    colour: Colour = attrs.field(default=_LIGHT_GREY, converter=as_colour, validator=albedo)
    metallic: float = attrs.field(default=0.0, converter=as_number, validator=fraction)
    roughness: float = attrs.field(default=0.5, converter=as_number, validator=fraction)
    emission: Colour = attrs.field(default=_BLACK, converter=as_colour)
    opacity: float = attrs.field(default=1.0, converter=as_number, validator=fraction)
    alpha_mode: str = attrs.field(default="opaque", validator=one_of("opaque", "mask", "blend"))
    alpha_cutoff: float = attrs.field(default=0.5, converter=as_number, validator=non_negative)
    two_sided: bool = attrs.field(default=False, converter=as_flag)
    colour_texture: Texture | None = attrs.field(default=None, validator=_texture)
    metallic_roughness_texture: Texture | None = attrs.field(default=None, validator=_texture)
    normal_texture: Texture | None = attrs.field(default=None, validator=_texture)
    normal_scale: float = attrs.field(default=1.0, converter=as_number, validator=finite)
    occlusion_texture: Texture | None = attrs.field(default=None, validator=_texture)
    occlusion_strength: float = attrs.field(default=1.0, converter=as_number, validator=fraction)
    emission_texture: Texture | None = attrs.field(default=None, validator=_texture)
