"""Panes of glass as single surfaces."""

from __future__ import annotations

from typing import Any

import attrs

from isophote.errors import SceneError
from isophote.scene.absorption import as_coefficients, coefficients_of_tint
from isophote.scene.colour import WHITE, Colour, ColourLike
from isophote.scene.colour import colour as as_colour
from isophote.scene.fields import as_number, non_negative, positive
from isophote.scene.material_base import Material, albedo

__all__ = ["ThinGlass"]

_CLEAR: Colour = (0.0, 0.0, 0.0)


@attrs.frozen
class ThinGlass(Material):
    """A pane: one surface that stands for a plate of glass with parallel faces, `thickness` metres apart.

    Light that goes through goes straight on, tinted by the way inside; with F Fresnel's share at a face of index `ior`
    in air and A = exp(−σ thickness / cosθ'), θ' the angle inside,

        T = (1 − F)² A / (1 − F² A²),  R = F (1 + A T),

    all ways to and fro inside added up, each times `colour`. `absorption` is σ in 1/m, by channels. With `ior=1`
    nothing is reflected, and the pane is a sheet that tints. Source: Born, Wolf, "Principles of Optics", 7th edition,
    section 7.6, without interference.
    """

    ior: float = attrs.field(default=1.5, converter=as_number, validator=positive)
    colour: Colour = attrs.field(default=WHITE, converter=as_colour, validator=albedo)
    thickness: float = attrs.field(default=0.0, converter=as_number, validator=non_negative)
    absorption: Colour = attrs.field(default=_CLEAR, converter=as_coefficients)

    @classmethod
    def tinted(cls, colour: ColourLike, **rest: Any) -> ThinGlass:
        """A pane through which white light, straight on, has become `colour`, reflections apart."""
        if "absorption" in rest or "thickness" in rest:
            raise SceneError("ThinGlass.tinted: the colour says what is absorbed; give no absorption or thickness")
        return cls(absorption=coefficients_of_tint(colour, 1.0), thickness=1.0, **rest)
