"""What rendering methods ask of any material at a surface.

    prepare_material(scene, surface, hit, direction, radius, scratch)  once, then as often as it takes
    evaluate_material(scene, surface, into, scratch) → (f |cosθ|, density)
    sample_material(scene, surface, x, y, pick, scratch) → (into, f |cosθ| / density, density)
    branch_material(scene, surface, k, scratch) → (into, share)        0 ≤ k < materials.branches

`direction` is the ray's, `into` leaves the surface; both are unit vectors of the world. (x, y) is a point of the unit
disk, `pick` lies in [0, 1). A density of 0 says that the direction is the only one. Kinds whose `scatters` is 0 have
nothing to evaluate: lights need not be aimed at. The scratch holds contract.WORDS floats; tracing may use it between
surfaces.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.surface import MATERIAL
from isophote.kernels.base.entry import call_entry, element_address, table_address
from isophote.kernels.base.jit import device
from isophote.kernels.base.vec import dot, load_vec3, store_vec3, vec3
from isophote.kernels.base.warp import INV_PI
from isophote.kernels.brdf import contract
from isophote.kernels.light.bsdf import GLASS, LINKED, MATTE, MIRROR, fresnel_dielectric, scatter_matte
from isophote.kernels.trace.shading import mirror_ray, scatter_glass_ray, seen_normal, surface_colour, write_surface

__all__ = [
    "branch_material",
    "evaluate_linked",
    "evaluate_material",
    "lit_side",
    "prepare_linked",
    "prepare_material",
    "sample_linked",
    "sample_material",
    "turned_normal",
]

_ZERO, _ONE = np.float32(0), np.float32(1)
# Columns of `Materials.spans`, and what `Materials.scatters` says of light that goes through.
_ROOT, _TURNED, _THROUGH = np.int64(0), np.int64(5), np.int32(2)
_START = np.int64(0)


@device
def _material(scene, surface):
    return np.int64(scene.surfaces.items[surface.item, MATERIAL])


# --- kinds that are called by address ---------------------------------------------------------------------------------


@device
def prepare_linked(scene, surface, hit, direction, radius, scratch):
    """Write what the entries of a linked kind read."""
    write_surface(scene, surface, hit, direction, radius, scratch)
    call_entry(scene.materials.prepare, (table_address(scene), element_address(scratch, _START)))


@device
def lit_side(scene, material, scratch):
    """The shading normal on the side from which light counts, or zero where it comes through a linked kind, too."""
    through = scene.materials.scatters[material] == _THROUGH
    return load_vec3(scratch, contract.NORMAL) * (_ZERO if through else _ONE)


@device
def turned_normal(scene, surface, hit, direction, radius, scratch):
    """The shading normal, as a normal map or a bump turns it."""
    materials = scene.materials
    slot = np.int64(materials.spans[_material(scene, surface), _TURNED])
    if slot == 0:
        return surface.shading
    prepare_linked(scene, surface, hit, direction, radius, scratch)
    return load_vec3(scratch, contract.PARAMETERS + 3 * (slot - 1))


@device
def _call(scene, surface, column, scratch):
    materials = scene.materials
    root = np.int64(materials.spans[_material(scene, surface), _ROOT])
    arguments = (table_address(materials), root, element_address(scratch, _START))
    return call_entry(materials.nodes[root, column], arguments)


@device
def _to_world(scratch, v):
    tangent, bitangent = load_vec3(scratch, contract.TANGENT), load_vec3(scratch, contract.BITANGENT)
    return tangent * v.x + bitangent * v.y + load_vec3(scratch, contract.NORMAL) * v.z


@device
def _same_side(scratch, into, z):
    """Whether `into` leaves the true surface on the side on which it leaves the shaded one."""
    return (dot(load_vec3(scratch, contract.TRUE_NORMAL), into) > _ZERO) == (z > _ZERO)


@device
def evaluate_linked(scene, surface, into, scratch):
    """(f |cosθ|, density) of a linked kind towards `into`; light that would leak through the true surface is none."""
    local = vec3(
        dot(into, load_vec3(scratch, contract.TANGENT)),
        dot(into, load_vec3(scratch, contract.BITANGENT)),
        dot(into, load_vec3(scratch, contract.NORMAL)),
    )
    store_vec3(scratch, contract.INTO, local)
    if _call(scene, surface, contract.EVALUATE, scratch) == 0 or not _same_side(scratch, into, local.z):
        return vec3(_ZERO, _ZERO, _ZERO), _ZERO
    return load_vec3(scratch, contract.VALUE), scratch[contract.DENSITY]


@device
def sample_linked(scene, surface, x, y, pick, scratch):
    """(into, f |cosθ| / density, density) of a linked kind; black where the path ends."""
    scratch[contract.X], scratch[contract.Y], scratch[contract.PICK] = x, y, pick
    found = _call(scene, surface, contract.SAMPLE, scratch)
    local = load_vec3(scratch, contract.INTO)
    into = _to_world(scratch, local)
    if found == 0 or not _same_side(scratch, into, local.z):
        return into, vec3(_ZERO, _ZERO, _ZERO), _ONE
    return into, load_vec3(scratch, contract.VALUE), scratch[contract.DENSITY]


@device
def _branch_linked(scene, surface, k, scratch):
    materials = scene.materials
    root = np.int64(materials.spans[_material(scene, surface), _ROOT])
    arguments = (table_address(materials), root, element_address(scratch, _START), np.int64(k))
    found = call_entry(materials.nodes[root, contract.BRANCH], arguments)
    local = load_vec3(scratch, contract.INTO)
    into = _to_world(scratch, local)
    if found == 0 or not _same_side(scratch, into, local.z):
        return into, vec3(_ZERO, _ZERO, _ZERO)
    return into, load_vec3(scratch, contract.VALUE)


# --- any kind ---------------------------------------------------------------------------------------------------------


@device
def prepare_material(scene, surface, hit, direction, radius, scratch):
    """Write what the other functions read, for the ray of unit `direction` that met the surface; `radius` as for
    `write_surface`."""
    if scene.materials.kinds[_material(scene, surface)] == LINKED:
        prepare_linked(scene, surface, hit, direction, radius, scratch)
        return
    normal = seen_normal(surface, direction)
    side = _ONE if dot(direction, normal) < _ZERO else -_ONE
    store_vec3(scratch, contract.NORMAL, normal * side)
    store_vec3(scratch, contract.TRUE_NORMAL, surface.normal * side)
    store_vec3(scratch, contract.DIRECTION, direction)
    store_vec3(scratch, contract.PARAMETERS, surface_colour(scene, surface, hit, direction, radius, scratch))


@device
def evaluate_material(scene, surface, into, scratch):
    """(f |cosθ|, density) towards `into`; nothing of kinds that only branch."""
    kind = scene.materials.kinds[_material(scene, surface)]
    if kind == LINKED:
        return evaluate_linked(scene, surface, into, scratch)
    cosine = dot(load_vec3(scratch, contract.NORMAL), into)
    if kind != MATTE or cosine <= _ZERO or not _same_side(scratch, into, cosine):
        return vec3(_ZERO, _ZERO, _ZERO), _ZERO
    return load_vec3(scratch, contract.PARAMETERS) * (cosine * INV_PI), cosine * INV_PI


@device
def sample_material(scene, surface, x, y, pick, scratch):
    """(into, f |cosθ| / density, density); black where the path ends."""
    material = _material(scene, surface)
    kind = scene.materials.kinds[material]
    if kind == LINKED:
        return sample_linked(scene, surface, x, y, pick, scratch)
    colour = load_vec3(scratch, contract.PARAMETERS)
    if kind == MATTE:
        into, density = scatter_matte(load_vec3(scratch, contract.NORMAL), x, y)
        return into, colour if _same_side(scratch, into, _ONE) else colour * _ZERO, density
    direction = load_vec3(scratch, contract.DIRECTION)
    if kind == MIRROR:
        return mirror_ray(surface, direction), colour, _ZERO
    if kind == GLASS:
        into, factor = scatter_glass_ray(surface, direction, scene.materials.values[material, 6], pick)
        return into, colour * factor, _ZERO
    return direction, colour * _ZERO, _ONE


@device
def _branch_glass(surface, direction, ior, k):
    """The reflected (k = 0) or the refracted ray of smooth glass, and its share."""
    cosine = -dot(direction, seen_normal(surface, direction))
    share, _ = fresnel_dielectric(abs(cosine), ior if cosine > _ZERO else _ONE / ior)
    into, factor = scatter_glass_ray(surface, direction, ior, _ZERO if k == 0 else _ONE)
    return into, factor * (share if k == 0 else _ONE - share)


@device
def branch_material(scene, surface, k, scratch):
    """(into, share) of the k-th single direction that light is sent to, of `materials.branches` many; black if there
    is none, as of the refracted ray under total reflection."""
    material = _material(scene, surface)
    kind = scene.materials.kinds[material]
    if kind == LINKED:
        return _branch_linked(scene, surface, k, scratch)
    colour = load_vec3(scratch, contract.PARAMETERS)
    direction = load_vec3(scratch, contract.DIRECTION)
    if kind == MIRROR:
        return mirror_ray(surface, direction), colour
    if kind == GLASS:
        into, share = _branch_glass(surface, direction, scene.materials.values[material, 6], k)
        return into, colour * share
    return direction, colour * _ZERO
