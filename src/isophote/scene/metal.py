"""Metals, by their measured index of refraction."""

from __future__ import annotations

from typing import Any, TypeAlias

import attrs

from isophote.errors import SceneError
from isophote.scene.colour import WHITE, Colour
from isophote.scene.colour import colour as as_colour
from isophote.scene.fields import as_flag
from isophote.scene.material_base import (
    ColourParameter,
    Material,
    NumberParameter,
    albedo,
    colour_or_texture,
    roughness,
    roughness_pair,
)

__all__ = ["METALS", "Metal"]

Index: TypeAlias = tuple[Colour, Colour]

# n and k for red, green and blue, by `rgb_of_spectrum`. Aluminium after Rakić, 1995; the others after Johnson and
# Christy, 1972 and 1974; measurements from refractiveindex.info, which are in the public domain (CC0).
METALS: dict[str, Index] = {
    "aluminium": ((1.441, 0.988, 0.585), (7.558, 6.566, 5.306)),
    "chromium": ((3.224, 3.117, 2.256), (3.291, 3.339, 3.113)),
    "copper": ((0.237, 1.037, 1.298), (3.244, 2.601, 2.353)),
    "gold": ((0.108, 0.489, 1.478), (3.509, 2.338, 1.809)),
    "iron": ((2.917, 2.921, 2.532), (3.065, 2.939, 2.742)),
    "nickel": ((2.01, 1.904, 1.719), (4.121, 3.574, 2.863)),
    "silver": ((0.055, 0.055, 0.043), (4.293, 3.543, 2.534)),
    "titanium": ((2.716, 2.511, 2.227), (3.791, 3.403, 2.999)),
}


def _index(value: Any) -> Index:
    if isinstance(value, str):
        if value not in METALS:
            raise SceneError(f"Metal: {value!r} is not known; use {', '.join(METALS)}, or a pair (n, k)")
        return METALS[value]
    if not isinstance(value, tuple | list) or len(value) != 2:
        raise SceneError(f"Metal: index must be a name or a pair (n, k) of numbers or triples, but is {value!r}")
    n, k = as_colour(value[0]), as_colour(value[1])
    if min(n) <= 0:
        raise SceneError(f"Metal: the index of refraction n must be above 0 in each channel, but is {n!r}")
    return n, k


@attrs.frozen
class Metal(Material):
    """A conductor, rough by microfacets: f = F D G / (4 cosθ_o cosθ_i), F by the complex index n + ik.

    `index` is a name ("aluminium", "chromium", "copper", "gold", "iron", "nickel", "silver", "titanium") or the pair
    (n, k), numbers or triples for red, green and blue, relative to air. `roughness`, from 0, a mirror, to 1, is a
    number or a `Texture`, or a pair of them, along the direction in which texture coordinate u grows and across it, as
    on brushed metal: α = roughness². `colour` multiplies what is reflected. Both faces reflect.

    Light that bounces from facet to facet is given back after Kulla and Conty ("Revisiting Physically Based Shading at
    Imageworks", 2017), so that rough metals are as bright as smooth ones; not so with `single_bounce`.
    """

    index: Index = attrs.field(default=METALS["aluminium"], converter=_index)
    roughness: tuple[NumberParameter, NumberParameter] = attrs.field(
        default=(0.3, 0.3), converter=roughness_pair, validator=roughness
    )
    colour: ColourParameter = attrs.field(default=WHITE, converter=colour_or_texture, validator=albedo)
    single_bounce: bool = attrs.field(default=False, converter=as_flag, kw_only=True)
