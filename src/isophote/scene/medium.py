"""Media that scatter light: fog, smoke, dust in the air."""

from __future__ import annotations

from typing import Any, TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.errors import SceneError
from isophote.scene.absorption import as_coefficients
from isophote.scene.colour import Colour
from isophote.scene.fields import ArrayKey, as_number, frozen_array

__all__ = ["Medium"]

Box: TypeAlias = npt.NDArray[np.float64]


def _anisotropy(instance: Any, attribute: attrs.Attribute[Any], value: Any) -> None:
    if not isinstance(value, float) or not -1 < value < 1:
        raise SceneError(f"Medium: anisotropy must be a number above −1 and below 1, but is {value!r}")


def _box(value: npt.ArrayLike | None) -> Box | None:
    if value is None:
        return None
    try:
        box = np.array(value, np.float64)
    except (TypeError, ValueError):
        box = np.empty(0)
    if box.shape != (2, 3) or not np.isfinite(box).all() or not (box[0] < box[1]).all():
        raise SceneError(f"Medium: bounds must be two corners (2, 3), the lower one first, but are {value!r}")
    return frozen_array(box)


def _key(box: Box | None) -> ArrayKey | None:
    return None if box is None else ArrayKey(box)


@attrs.frozen
class Medium:
    """What fills the air of a scene evenly: light that goes d metres through it is scattered out of its way with
    `scattering` σs and swallowed with `absorption` σa, both in 1/m by channels, so that exp(−(σs + σa) d) is left.

    Scattered light goes on by Henyey and Greenstein's phase function, p = (1 − g²) / (4π (1 + g² − 2 g cosθ)^(3/2)),
    whose mean cosine g is `anisotropy`: above 0 forward, as in fog, 0 to all sides alike. `bounds`, (2, 3), is the box
    that it fills; without it fills all space, and no light comes through from skies and suns, which are infinitely far.
    There is none of it within glass. Raises `SceneError` for numbers out of range. Source: Henyey, Greenstein,
    "Diffuse Radiation in the Galaxy", Astrophysical Journal 93, 1941.
    """

    scattering: Colour = attrs.field(default=(0.0, 0.0, 0.0), converter=as_coefficients)
    absorption: Colour = attrs.field(default=(0.0, 0.0, 0.0), converter=as_coefficients)
    anisotropy: float = attrs.field(default=0.0, converter=as_number, validator=_anisotropy)
    bounds: Box | None = attrs.field(default=None, converter=_box, eq=_key)
