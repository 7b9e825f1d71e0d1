"""What every method asks of a surface's material."""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.surface import MATERIAL
from isophote.kernels.base.jit import device
from isophote.kernels.base.vec import vec3
from isophote.kernels.light.texture import look_up

__all__ = ["surface_colour", "surface_emission"]


@device
def surface_colour(scene, surface):
    """The material's colour at a surface, texture included."""
    material = np.int64(scene.surfaces.items[surface.item, MATERIAL])
    values = scene.materials.values
    colour = vec3(values[material, 0], values[material, 1], values[material, 2])
    texture = np.int64(scene.materials.textures[material])
    if texture >= 0:
        return colour * look_up(scene.textures, texture, surface.u, surface.v)
    return colour


@device
def surface_emission(scene, surface):
    """(radiance that the material emits, whether from both sides)."""
    material = np.int64(scene.surfaces.items[surface.item, MATERIAL])
    values = scene.materials.values
    return vec3(values[material, 3], values[material, 4], values[material, 5]), values[material, 7] != 0
