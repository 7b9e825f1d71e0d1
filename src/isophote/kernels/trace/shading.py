"""What every method asks of a surface's material."""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.surface import MATERIAL
from isophote.kernels.base.entry import call_entry, element_address, table_address
from isophote.kernels.base.jit import device, exact_apart
from isophote.kernels.base.simd import store_int
from isophote.kernels.base.vec import dot, load_vec3, reflect, store_vec3, vec3
from isophote.kernels.brdf import contract
from isophote.kernels.light.bsdf import scatter_glass

__all__ = ["mirror_ray", "scatter_glass_ray", "seen_normal", "surface_colour", "surface_emission", "write_surface"]

_ZERO = np.float32(0)
_START = np.int64(0)


@device
def write_surface(scene, surface, hit, direction, radius, scratch):
    """Write the surface that a ray of unit `direction` met, for entries that look textures up or scatter light;
    `radius` is the half-width of the ray's cone there (cone.py), 0 if nobody knows."""
    scratch[contract.RADIUS] = radius
    store_vec3(scratch, contract.PLACE, surface.place)
    store_vec3(scratch, contract.OUTWARD, surface.normal)
    store_vec3(scratch, contract.SHADING, surface.shading)
    store_vec3(scratch, contract.DIRECTION, direction)
    scratch[contract.U], scratch[contract.V] = surface.u, surface.v
    scratch[contract.WEIGHT1], scratch[contract.WEIGHT2] = hit.weight1, hit.weight2
    store_int(scratch, contract.HIT_SLOT, np.int32(hit.slot))
    store_int(scratch, contract.HIT_INSTANCE, np.int32(hit.instance))
    store_int(scratch, contract.ITEM, np.int32(surface.item))
    store_int(scratch, contract.TRIANGLE, np.int32(surface.triangle))
    store_int(scratch, contract.MATERIAL, np.int32(scene.surfaces.items[surface.item, MATERIAL]))


@exact_apart
def _texture_colour(scene, surface, hit, direction, radius, scratch, node):
    write_surface(scene, surface, hit, direction, radius, scratch)
    call_entry(scene.textures.colour, (table_address(scene), element_address(scratch, _START), node))
    return load_vec3(scratch, contract.VALUE)


@device
def surface_colour(scene, surface, hit, direction, radius, scratch):
    """The material's colour at a surface, texture included."""
    material = np.int64(scene.surfaces.items[surface.item, MATERIAL])
    values = scene.materials.values
    colour = vec3(values[material, 0], values[material, 1], values[material, 2])
    node = np.int64(scene.materials.textures[material])
    return colour if node < 0 else colour * _texture_colour(scene, surface, hit, direction, radius, scratch, node)


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
def surface_emission(scene, surface, hit, direction, radius, scratch):
    """(radiance that the material emits, texture included, whether from both sides)."""
    material = np.int64(scene.surfaces.items[surface.item, MATERIAL])
    values = scene.materials.values
    emitted, two_sided = vec3(values[material, 3], values[material, 4], values[material, 5]), values[material, 7] != 0
    node = np.int64(scene.materials.emission_textures[material])
    if node >= 0:
        emitted = emitted * _texture_colour(scene, surface, hit, direction, radius, scratch, node)
    return emitted, two_sided
