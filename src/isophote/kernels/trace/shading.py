"""What every method asks of a surface's material."""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.surface import MATERIAL
from isophote.kernels.base.jit import device
from isophote.kernels.base.vec import dot, reflect, vec3
from isophote.kernels.light.bsdf import scatter_glass
from isophote.kernels.light.texture import look_up

__all__ = ["mirror_ray", "scatter_glass_ray", "seen_normal", "surface_colour", "surface_emission"]

_ZERO = np.float32(0)


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
def _passes(normal, before, after):
    """Whether a ray goes through the surface with this normal."""
    return dot(before, normal) * dot(after, normal) > _ZERO


@device
def seen_normal(surface, direction):
    """The shading normal; the true one where the ray sees the front of the one and the back of the other, as at the
    rims of smooth meshes."""
    same = dot(direction, surface.shading) * dot(direction, surface.normal) > _ZERO
    return surface.shading if same else surface.normal


@device
def mirror_ray(surface, direction):
    """Mirror direction at a surface, by the shading normal unless that leads through the true surface."""
    into = reflect(direction, surface.shading)
    return reflect(direction, surface.normal) if _passes(surface.normal, direction, into) else into


@device
def scatter_glass_ray(surface, direction, ior, u):
    """`scatter_glass` at a surface, by the shading normal unless the ray would be on the wrong side of the true one."""
    normal = seen_normal(surface, direction)
    into, factor = scatter_glass(-direction, normal, ior, u)
    if _passes(normal, direction, into) != _passes(surface.normal, direction, into):
        return scatter_glass(-direction, surface.normal, ior, u)
    return into, factor


@device
def surface_emission(scene, surface):
    """(radiance that the material emits, whether from both sides)."""
    material = np.int64(scene.surfaces.items[surface.item, MATERIAL])
    values = scene.materials.values
    return vec3(values[material, 3], values[material, 4], values[material, 5]), values[material, 7] != 0
