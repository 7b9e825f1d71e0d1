"""Colours: linear Rec. 709 triples, from names, hexadecimal sRGB and numbers."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt
from PIL import ImageColor

from isophote.errors import SceneError

__all__ = ["WHITE", "Colour", "ColourLike", "colour", "linear_to_srgb", "srgb_to_linear"]

Colour: TypeAlias = tuple[float, float, float]
ColourLike: TypeAlias = str | float | Sequence[float] | npt.NDArray[Any]

WHITE: Colour = (1.0, 1.0, 1.0)

_KNEE = 0.04045 / 12.92


def srgb_to_linear(values: npt.ArrayLike) -> npt.NDArray[Any]:
    """Linear values of sRGB-encoded ones: c / 12.92 up to 0.04045, else ((c + 0.055) / 1.055)^2.4.

    Any shape; 0 to 1, and beyond it by the same formula, negative values mirrored. float32 stays float32,
    everything else gives float64. Source: IEC 61966-2-1.
    """
    c = _floats(values)
    a = np.abs(c)
    curve = np.power((a + 0.055) / 1.055, 2.4, dtype=c.dtype)
    linear: npt.NDArray[Any] = np.copysign(np.where(a <= 0.04045, a / 12.92, curve), c)
    return linear


def linear_to_srgb(values: npt.ArrayLike) -> npt.NDArray[Any]:
    """sRGB-encoded values of linear ones: 12.92 c up to 0.04045 / 12.92, else 1.055 c^(1/2.4) - 0.055.

    Any shape; 0 to 1, and beyond it by the same formula, negative values mirrored. float32 stays float32,
    everything else gives float64. The curve changes its piece where that of `srgb_to_linear` does; the customary
    0.0031308 would leave a gap of values that do not come back. Source: IEC 61966-2-1.
    """
    c = _floats(values)
    a = np.abs(c)
    curve = 1.055 * np.power(a, 1 / 2.4, dtype=c.dtype) - 0.055
    encoded: npt.NDArray[Any] = np.copysign(np.where(a <= _KNEE, 12.92 * a, curve), c)
    return encoded


def colour(value: ColourLike) -> Colour:
    """The linear Rec. 709 triple of a colour.

    A CSS name ("tomato") or "#c84" / "#cc8844" is decoded from sRGB; a number is a grey and a triple is
    (red, green, blue), both linear already, 0 or above, and may exceed 1. Raises `SceneError` for
    anything else.
    """
    if isinstance(value, str):
        return _named(value)
    try:
        given = np.asarray(value, np.float64)
    except (TypeError, ValueError):
        given = np.empty(0)
    if given.shape not in ((), (3,)):
        raise SceneError(
            f"a colour is a name, '#rrggbb', a number or a linear triple (red, green, blue), but this is {value!r}"
        )
    triple = np.broadcast_to(given, 3).tolist()
    if not all(math.isfinite(channel) and channel >= 0 for channel in triple):
        raise SceneError(f"the channels of a colour must be finite and 0 or above, but are {value!r}")
    red, green, blue = triple
    return red, green, blue


def _named(name: str) -> Colour:
    try:
        encoded = ImageColor.getrgb(name.strip())
    except ValueError:
        raise SceneError(f"{name!r} is not a colour: use a CSS name such as 'tomato', '#c84' or '#cc8844'") from None
    if len(encoded) != 3:
        raise SceneError(f"{name!r} has an opacity; a colour has only red, green and blue")
    red, green, blue = srgb_to_linear(np.array(encoded) / 255).tolist()
    return red, green, blue


def _floats(values: npt.ArrayLike) -> npt.NDArray[Any]:
    given = np.asarray(values)
    return given if given.dtype == np.float32 else given.astype(np.float64)
