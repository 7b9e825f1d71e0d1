"""How much light clear media take: coefficients, and colours at a distance."""

from __future__ import annotations

import math

from isophote.errors import SceneError
from isophote.scene.colour import Colour, ColourLike
from isophote.scene.colour import colour as as_colour

__all__ = ["as_coefficients", "coefficients_of_tint"]


def as_coefficients(value: ColourLike) -> Colour:
    """Absorption coefficients in 1/m by channels, of a number or three. Raises `SceneError` for names of colours."""
    if isinstance(value, str):
        raise SceneError(
            f"absorption is in 1/m, a number or three, not {value!r}; .tinted takes a colour at a distance"
        )
    return as_colour(value)


def coefficients_of_tint(colour: ColourLike, at: float) -> Colour:
    """σ = −ln(colour) / at: what makes white light this colour after `at` metres.

    Raises `SceneError` for channels that are 0 or above 1, and distances that are not above 0.
    """
    tint = as_colour(colour)
    if isinstance(at, bool) or not isinstance(at, int | float) or not 0 < at < math.inf:
        raise SceneError(f"a tint's distance, at, must be a number above 0, not {at!r}")
    if not all(0 < channel <= 1 for channel in tint):
        raise SceneError(f"every channel of a tint must be above 0 and at most 1, not {tint}")
    # Adding zero makes −0 of ln 1 a plain 0.
    red, green, blue = (-math.log(channel) / at + 0.0 for channel in tint)
    return red, green, blue
