"""Metals, by their measured index of refraction."""

from __future__ import annotations

from typing import Any, TypeAlias

import attrs

from isophote.errors import SceneError
from isophote.scene.colour import WHITE, Colour
from isophote.scene.colour import colour as as_colour
from isophote.scene.material_base import (
    ColourParameter,
    Material,
    NumberParameter,
    albedo,
    colour_or_texture,
    roughness,
    roughness_pair,
)

__all__ = ["Metal"]

Index: TypeAlias = tuple[Colour, Colour]

_GOLD: Index = ((0.14, 0.37, 1.44), (3.98, 2.39, 1.60))


def _index(value: Any) -> Index:
    if not isinstance(value, tuple | list) or len(value) != 2:
        raise SceneError(f"Metal: index must be a pair (n, k) of colours, but is {value!r}")
    n, k = as_colour(value[0]), as_colour(value[1])
    if min(n) <= 0:
        raise SceneError(f"Metal: the index of refraction n must be above 0 in each channel, but is {n!r}")
    return n, k


@attrs.frozen
class Metal(Material):
    """A conductor, rough by microfacets: f = F D G / (4 cosθ_o cosθ_i), F by the complex index n + ik.

    `index` is the pair (n, k) for red, green and blue, relative to air; `roughness`, from 0, a mirror, to 1, is a
    number or a `Texture`, or a pair of them, along the direction in which texture coordinate u grows and across it, as
    on brushed metal: α = roughness². `colour` multiplies what is reflected. Both faces reflect. Light that bounces
    between facets is left out, so rough metals are darker than real ones.
    """

    index: Index = attrs.field(default=_GOLD, converter=_index)
    roughness: tuple[NumberParameter, NumberParameter] = attrs.field(
        default=(0.3, 0.3), converter=roughness_pair, validator=roughness
    )
    colour: ColourParameter = attrs.field(default=WHITE, converter=colour_or_texture, validator=albedo)
