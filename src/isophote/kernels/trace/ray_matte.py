"""Matte surfaces in air that neither shine nor have a texture: most of what rays meet, sixteen at a time.

A hit on a triangle is noted first, ray by ray: corners, weights, what the ray carries. Then what surface_of and
prepare_surface would say is worked out for all such hits of a wave by lanes. Nothing branches there, and nothing of
them is told to a log.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.geometry import Hit
from isophote.kernels.accel.layout import BLOCK, LANES
from isophote.kernels.accel.surface import (
    FIRST_TRIANGLE,
    MATERIAL,
    NORMALS,
    blend_corners,
    corner_at,
    item_of,
    triangle_number,
)
from isophote.kernels.accel.surface_lanes import face_lanes, place_lanes
from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import select, splat16, store_int
from isophote.kernels.base.vec import dot, maximum_component, vec3
from isophote.kernels.base.warp import INV_PI
from isophote.kernels.base.wide import load_lanes, load_wide, store_lanes, store_wide, wide_select
from isophote.kernels.light.bsdf import MATTE
from isophote.kernels.trace import ray_tree
from isophote.kernels.trace import wave as rows
from isophote.kernels.trace.direct import direct_item, surface_of
from isophote.kernels.trace.shading import seen_normal
from isophote.kernels.trace.wave import add_radiance, row_vec3, set_row_vec3

__all__ = ["face_matte", "has_ambient", "matte_item", "note_matte"]

_ZERO, _ONE = np.float32(0), np.float32(1)
# What the row PLAIN holds of hits on triangles until their normals are worked out.
_NOTED = np.float32(2)
_NONE = np.int64(-1)


@device
def has_ambient(tables):
    """Whether the sky is constant, or has a part that is."""
    constant = tables.lights.environment.constant
    return maximum_component(vec3(constant[0], constant[1], constant[2])) > _ZERO


@device
def _is_plain(tables, material):
    materials, values = tables.materials, tables.materials.values
    emits = maximum_component(vec3(values[material, 3], values[material, 4], values[material, 5])) > _ZERO
    if materials.kinds[material] != MATTE or emits or materials.textures[material] >= 0:
        return False
    return tables.media.of_material[material] == 0


@device
def _share(tables, wave, i, material):
    """What a ray carries, times the colour of the surface; the ambient light that it gathers there is added."""
    values, constant = tables.materials.values, tables.lights.environment.constant
    colour = vec3(values[material, 0], values[material, 1], values[material, 2])
    share = row_vec3(wave.floats, rows.CARRIED, i) * colour
    add_radiance(wave, i, share * vec3(constant[0], constant[1], constant[2]))
    return share * INV_PI


@device
def _remember(tree, at, i, surface, direction, share):
    """Note a plain surface that a ray met, for lights to shine on, in column `at`."""
    floats = tree.surfaces
    normal = seen_normal(surface, direction)
    side = _ONE if dot(direction, normal) < _ZERO else -_ONE
    floats[ray_tree.PLAIN, at] = _ONE
    floats[ray_tree.ERROR, at] = surface.error
    store_int(floats[ray_tree.COLUMN], at, np.int32(i))
    set_row_vec3(floats, ray_tree.PLACE, at, surface.place)
    set_row_vec3(floats, ray_tree.NORMAL, at, surface.normal * side)
    set_row_vec3(floats, ray_tree.SHADING, at, normal * side)
    set_row_vec3(floats, ray_tree.SHARE, at, share)


@device
def _note_triangle(tables, tree, wave, at, i, item, triangle, share):
    """Note a hit on a triangle in column `at`: its corners in place of the place and the normals."""
    floats, surfaces, blocks = tree.surfaces, tables.surfaces, tables.geometry.blocks
    slot, w1, w2 = wave.longs[rows.HIT_SLOT, i], wave.floats[rows.HIT_W1, i], wave.floats[rows.HIT_W2, i]
    first = slot // LANES * BLOCK + slot % LANES
    floats[ray_tree.PLAIN, at] = _NOTED
    store_int(floats[ray_tree.COLUMN], at, np.int32(i))
    set_row_vec3(floats, ray_tree.PLACE, at, corner_at(blocks, first))
    set_row_vec3(floats, ray_tree.NORMAL, at, corner_at(blocks, first + 3 * LANES))
    set_row_vec3(floats, ray_tree.SHADING, at, corner_at(blocks, first + 6 * LANES))
    set_row_vec3(floats, ray_tree.SHARE, at, share)
    set_row_vec3(floats, ray_tree.FROM, at, row_vec3(wave.floats, rows.DIRECTION, i))
    floats[ray_tree.U, at], floats[ray_tree.V, at] = w1, w2
    blended, normals = vec3(_ZERO, _ZERO, _ZERO), np.int64(surfaces.items[item, NORMALS])
    if normals >= 0:
        blended = blend_corners(surfaces.normals, surfaces.normal_corners, normals + triangle, _ONE - w1 - w2, w1, w2)
    set_row_vec3(floats, ray_tree.BLENDED, at, blended)


@device
def matte_item(tables, slot, instance):
    """The item of a triangle whose surface is plain, or −1."""
    if tables.geometry.identity[instance] == 0:
        return _NONE
    item = item_of(tables.surfaces, instance, triangle_number(tables.geometry, slot))
    items = tables.surfaces.items
    # Where normals are blended, some ambient light would come from below the true surface.
    if not _is_plain(tables, np.int64(items[item, MATERIAL])) or (items[item, NORMALS] >= 0 and has_ambient(tables)):
        return _NONE
    return item


@device
def note_matte(tables, tree, wave, at, i, item):
    """Note the surface that ray `i` met in column `at`, if it is plain; `item`: of a triangle what `matte_item` says.
    Returns whether it is."""
    floats, longs = wave.floats, wave.longs
    slot, instance = longs[rows.HIT_SLOT, i], longs[rows.HIT_INSTANCE, i]
    if longs[rows.INSIDE, i] != 0:
        return False
    items = tables.surfaces.items
    if slot >= 0:
        if item < 0:
            return False
        share = _share(tables, wave, i, np.int64(items[item, MATERIAL]))
        triangle = triangle_number(tables.geometry, slot) - items[item, FIRST_TRIANGLE]
        _note_triangle(tables, tree, wave, at, i, item, triangle, share)
        return True
    hit = Hit(floats[rows.HIT_T, i], _ZERO, _ZERO, slot, instance)
    material = np.int64(items[direct_item(tables, hit), MATERIAL])
    if not _is_plain(tables, material):
        return False
    direction = row_vec3(floats, rows.DIRECTION, i)
    surface = surface_of(tables, row_vec3(floats, rows.ORIGIN, i), direction, hit, wave.scratch)
    _remember(tree, at, i, surface, direction, _share(tables, wave, i, material))
    return True


@device
def face_matte(tree, count):
    """Work out places and normals of the hits on triangles that are noted among surfaces 0 … count − 1."""
    floats = tree.surfaces
    for at in range(0, count, rows.LANES):
        a, b, c = (
            load_wide(floats, ray_tree.PLACE, at),
            load_wide(floats, ray_tree.NORMAL, at),
            load_wide(floats, ray_tree.SHADING, at),
        )
        w1, w2 = load_lanes(floats, ray_tree.U, at), load_lanes(floats, ray_tree.V, at)
        plain, error = load_lanes(floats, ray_tree.PLAIN, at), load_lanes(floats, ray_tree.ERROR, at)
        noted = plain > splat16(_ONE)
        place, slack, normal = place_lanes(a, b, c, w1, w2)
        blended, direction = load_wide(floats, ray_tree.BLENDED, at), load_wide(floats, ray_tree.FROM, at)
        normal, shading = face_lanes(normal, blended, direction)
        store_wide(floats, ray_tree.PLACE, at, wide_select(noted, place, a))
        store_wide(floats, ray_tree.NORMAL, at, wide_select(noted, normal, b))
        store_wide(floats, ray_tree.SHADING, at, wide_select(noted, shading, c))
        store_lanes(floats, ray_tree.ERROR, at, select(noted, slack, error))
        store_lanes(floats, ray_tree.PLAIN, at, select(noted, splat16(_ONE), plain))
