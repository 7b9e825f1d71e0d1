"""What is seen beyond all surfaces: the sky."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.lower.texture_probe import texture_values
from isophote.scene.light import Environment, Light, Sky, direction_to_uv

__all__ = ["sky_radiance"]

Points: TypeAlias = npt.NDArray[np.float64]


def sky_radiance(lights: Sequence[Light], directions: Points) -> Points:
    """(n, 3): the radiance, W/(m² sr), of the skies among lights in directions (n, 3) of any length."""
    radiance = np.zeros((len(directions), 3))
    for light in lights:
        if isinstance(light, Sky):
            radiance += light.radiance_rgb
        elif isinstance(light, Environment):
            uv = direction_to_uv(directions, light.rotation)
            radiance += light.strength * texture_values(light.texture, uv)[:, :3].astype(np.float64)
    return radiance
