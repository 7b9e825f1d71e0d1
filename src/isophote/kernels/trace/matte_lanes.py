"""Matte surfaces sixteen at a time: aiming at lights, and scattering, for a group of columns of a wave.

A column's surface is found by itself, since what triangles and materials hold is all over memory; its corners and its
colour are put side by side with those of its neighbours (`gather_matte`), and then all is worked out in registers
(`scatter_matte`). Lanes of columns that met something else are worked out too, and never looked at.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.layout import BLOCK
from isophote.kernels.accel.layout import LANES as TRIANGLES
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
from isophote.kernels.base.simd import bits, maximum, select, splat16, square_root
from isophote.kernels.base.vec import vec3
from isophote.kernels.base.warp import INV_PI
from isophote.kernels.base.wide import (
    load_lanes,
    load_wide,
    store_lanes,
    store_wide,
    wide,
    wide_dot,
    wide_select,
)
from isophote.kernels.light.bsdf import MATTE
from isophote.kernels.light.emitter import PARALLELOGRAM, sample_light
from isophote.kernels.light.emitter_lanes import sample_lanes, sampled_in_lanes
from isophote.kernels.light.medium import attenuation, current_medium
from isophote.kernels.trace import wave as rows
from isophote.kernels.trace.cone import carry_scattered_cone, cone_radius
from isophote.kernels.trace.direct import direct_item, is_surface, surface_of
from isophote.kernels.trace.painted_lights import tint_of_light
from isophote.kernels.trace.path_met import add_emitted
from isophote.kernels.trace.pick import pick_for
from isophote.kernels.trace.shading import surface_colour
from isophote.kernels.trace.wave import hit_of, row_vec3, set_row_vec3

__all__ = ["gather_matte", "move_path", "move_shadow", "scatter_matte"]

_ZERO, _ONE = np.float32(0), np.float32(1)
_FAR = np.float32(np.inf)
_START, _AIR, _ONLY = np.int64(0), np.int64(0), np.int64(0)
# A shadow ray ends this much short of its light, in parts of its length, lest it meets the light itself.
_SHADOW_END = np.float32(1 - 1e-4)

# Rows of `Wave.lanes`. Of surfaces: a triangle's corners, the interpolated normal or zero, place, normal and shading
# normal on the side that is seen, error, colour, and whether place and normals are known already.
_A, _B, _C, _BLEND, _PLACE, _NORMAL, _SHADING, _COLOUR = (np.int64(k) for k in range(0, 24, 3))
_ERROR, _KNOWN = np.int64(24), np.int64(25)
# Of lights: direction, what arrives, distance, one over the density, the chance of that light, and whether scattering
# could have found it.
_INTO, _RADIANCE = np.int64(26), np.int64(29)
_DISTANCE, _FACTOR, _CHANCE, _MET = (np.int64(k) for k in range(32, 36))
# Of rays that leave: where they start, the shadow ray's direction, light and end, the path's direction, what it carries
# and the density of its scattering.
_FROM, _LIGHT, _END, _CARRIED, _DENSITY = np.int64(36), np.int64(39), np.int64(42), np.int64(43), np.int64(46)
# No longer needed by then.
_SHADOW_INTO, _ON = _A, _B


@device
def _gather_corners(tables, wave, lane, hit, item, number):
    """Corners of a triangle that stands where its object does."""
    blocks, surfaces, lanes = tables.geometry.blocks, tables.surfaces, wave.lanes
    at, w1, w2 = hit.slot // TRIANGLES * BLOCK + hit.slot % TRIANGLES, hit.weight1, hit.weight2
    set_row_vec3(lanes, _A, lane, corner_at(blocks, at))
    set_row_vec3(lanes, _B, lane, corner_at(blocks, at + 3 * TRIANGLES))
    set_row_vec3(lanes, _C, lane, corner_at(blocks, at + 6 * TRIANGLES))
    first, blend = np.int64(surfaces.items[item, NORMALS]), vec3(_ZERO, _ZERO, _ZERO)
    if first >= 0:
        row = first + number - np.int64(surfaces.items[item, FIRST_TRIANGLE])
        blend = blend_corners(surfaces.normals, surfaces.normal_corners, row, _ONE - w1 - w2, w1, w2)
    set_row_vec3(lanes, _BLEND, lane, blend)
    lanes[_KNOWN, lane] = _ZERO


@device
def _know(lanes, lane, surface):
    """Note a surface that is known whole."""
    set_row_vec3(lanes, _PLACE, lane, surface.place)
    set_row_vec3(lanes, _NORMAL, lane, surface.normal)
    set_row_vec3(lanes, _BLEND, lane, surface.shading)
    lanes[_ERROR, lane], lanes[_KNOWN, lane] = surface.error, _ONE


@device
def _gather(tables, wave, i, lane):
    """Put the surface that the ray in column `i` met into a lane, if it is matte; whether it is."""
    floats, surfaces, materials = wave.floats, tables.surfaces, tables.materials
    hit = hit_of(wave, i)
    number, whole = np.int64(0), hit.slot < 0
    if whole:
        item = direct_item(tables, hit)
    else:
        number = triangle_number(tables.geometry, hit.slot)
        item = item_of(surfaces, hit.instance, number)
        whole = tables.geometry.identity[hit.instance] == 0
    material = np.int64(surfaces.items[item, MATERIAL])
    if materials.kinds[material] != MATTE:
        return False
    inside, carried = wave.longs[rows.INSIDE, i], row_vec3(floats, rows.CARRIED, i)
    if inside != 0:
        carried = carried * attenuation(tables.media, current_medium(tables.media, inside), hit.t)
        set_row_vec3(floats, rows.CARRIED, i, carried)
    values = materials.values
    colour = vec3(values[material, 0], values[material, 1], values[material, 2])
    emits = max(values[material, 3], max(values[material, 4], values[material, 5])) > _ZERO
    if whole or emits or materials.textures[material] >= 0:
        direction = row_vec3(floats, rows.DIRECTION, i)
        surface = surface_of(tables, row_vec3(floats, rows.ORIGIN, i), direction, hit, wave.scratch)
        _know(wave.lanes, lane, surface)
        colour = surface_colour(tables, surface, hit, direction, cone_radius(wave, i, hit.t), wave.scratch)
        add_emitted(tables, wave, i, surface, hit, direction, carried)
    else:
        _gather_corners(tables, wave, lane, hit, item, number)
    set_row_vec3(wave.lanes, _COLOUR, lane, colour)
    return True


@device
def gather_matte(tables, wave, first, count):
    """Put the matte surfaces that columns first … first + count − 1 met into lanes, and add what they emit; which lanes
    they are in, bit by bit."""
    matte = np.int32(0)
    for lane in range(count):
        if is_surface(wave.longs[rows.HIT_SLOT, first + lane]) and _gather(tables, wave, first + lane, lane):
            matte |= np.int32(1) << np.int32(lane)
    return matte


@device
def _find_surfaces(wave, first):
    """Places, and normals on the side that is seen, as `surface_at` and `seen_normal` have them one by one."""
    floats, lanes = wave.floats, wave.lanes
    place, error, normal = place_lanes(
        load_wide(lanes, _A, _START),
        load_wide(lanes, _B, _START),
        load_wide(lanes, _C, _START),
        load_lanes(floats, rows.HIT_W1, first),
        load_lanes(floats, rows.HIT_W2, first),
    )
    known = load_lanes(lanes, _KNOWN, _START) > splat16(_ZERO)
    normal = wide_select(known, load_wide(lanes, _NORMAL, _START), normal)
    normal, shading = face_lanes(normal, load_wide(lanes, _BLEND, _START), load_wide(floats, rows.DIRECTION, first))
    store_wide(lanes, _PLACE, _START, wide_select(known, load_wide(lanes, _PLACE, _START), place))
    store_wide(lanes, _NORMAL, _START, normal)
    store_wide(lanes, _SHADING, _START, shading)
    store_lanes(lanes, _ERROR, _START, select(known, load_lanes(lanes, _ERROR, _START), error))


@device
def _sample_lights(tables, wave, first, matte):
    """A light for each surface, picked by chance, and a place on it."""
    lights, floats, lanes = tables.lights, wave.floats, wave.lanes
    if lights.kinds.rows == 1 and sampled_in_lanes(lights, _ONLY):
        place = load_wide(lanes, _PLACE, _START)
        u, v = load_lanes(floats, rows.LIGHT_U, first), load_lanes(floats, rows.LIGHT_V, first)
        into, distance, radiance, factor = sample_lanes(lights, _ONLY, place, u, v, _ONE)
        store_wide(lanes, _INTO, _START, into)
        store_wide(lanes, _RADIANCE, _START, radiance)
        store_lanes(lanes, _DISTANCE, _START, distance)
        store_lanes(lanes, _FACTOR, _START, factor)
        store_lanes(lanes, _CHANCE, _START, splat16(lights.cdf[1] - lights.cdf[0]))
        store_lanes(lanes, _MET, _START, splat16(np.float32(lights.kinds[0] == PARALLELOGRAM)))
    else:
        for lane in range(rows.LANES):
            if matte >> np.int32(lane) & 1:
                _sample_light(tables, wave, first + lane, lane)
    if tables.media.values.rows > 1:
        _dim_lights(tables.media, wave, first, matte)


@device
def _dim_lights(media, wave, first, matte):
    """Take what media leave of light that nothing blocks: it comes through one all the way."""
    lanes = wave.lanes
    for lane in range(rows.LANES):
        inside = wave.longs[rows.INSIDE, first + lane]
        if matte >> np.int32(lane) & 1 and inside != 0:
            left = attenuation(media, current_medium(media, inside), lanes[_DISTANCE, lane])
            set_row_vec3(lanes, _RADIANCE, lane, row_vec3(lanes, _RADIANCE, lane) * left)


@device
def _sample_light(tables, wave, i, lane):
    lights, floats, lanes = tables.lights, wave.floats, wave.lanes
    place, shading = row_vec3(lanes, _PLACE, lane), row_vec3(lanes, _SHADING, lane)
    lanes[_FACTOR, lane] = _ZERO
    k, chance = pick_for(lights, wave.ask, place, shading, floats[rows.PICK_U, i])
    if k < 0:
        return
    sample = sample_light(lights, k, place, floats[rows.LIGHT_U, i], floats[rows.LIGHT_V, i])
    into = vec3(sample.x, sample.y, sample.z)
    radiance = vec3(sample.red, sample.green, sample.blue)
    radiance = radiance * tint_of_light(tables, k, place + into * sample.distance, wave.scratch)
    set_row_vec3(lanes, _INTO, lane, into)
    set_row_vec3(lanes, _RADIANCE, lane, radiance)
    met = sample.density > _ZERO
    lanes[_DISTANCE, lane], lanes[_CHANCE, lane], lanes[_MET, lane] = sample.distance, chance, np.float32(met)
    lanes[_FACTOR, lane] = _ONE / sample.density if met else (_ONE if sample.density == _ZERO else _ZERO)


@device
def _aim(wave, weight):
    """Shadow rays toward the lights of all lanes, of paths that carry `weight` on; bits of those that carry light."""
    lanes = wave.lanes
    zero, far = splat16(_ZERO), splat16(_FAR)
    normal, into = load_wide(lanes, _NORMAL, _START), load_wide(lanes, _INTO, _START)
    distance, factor = load_lanes(lanes, _DISTANCE, _START), load_lanes(lanes, _FACTOR, _START)
    density = wide_dot(load_wide(lanes, _SHADING, _START), into) * splat16(INV_PI)
    # w / p for the power heuristic's w = p² / (p² + q²), p being the light's chance over `factor`.
    chance, q = load_lanes(lanes, _CHANCE, _START), density * load_lanes(lanes, _MET, _START) * factor
    share = density * (chance * factor / (chance * chance + q * q))
    light = weight * load_wide(lanes, _RADIANCE, _START) * share
    seen = (density > zero) & (wide_dot(normal, into) > zero) & (factor > zero)
    finite, offset = distance < far, normal * load_lanes(lanes, _ERROR, _START)
    # The light's place seen from the moved start, so that the ray still ends on it, at t = 1.
    store_wide(lanes, _SHADOW_INTO, _START, wide_select(finite, into * distance - offset, into))
    store_wide(lanes, _LIGHT, _START, light)
    store_lanes(lanes, _END, _START, select(finite, splat16(_SHADOW_END), far))
    return bits(seen & ((light.x > zero) | (light.y > zero) | (light.z > zero)))


@device
def _frame(n):
    """Two unit vectors that make a right-handed frame with each unit vector, as `orthonormal` has them."""
    one = splat16(_ONE)
    sign = select(n.z >= splat16(_ZERO), one, splat16(_ZERO) - one)
    a = splat16(-_ONE) / (sign + n.z)
    b, x = n.x * n.y * a, sign * n.x
    return wide(one + x * n.x * a, sign * b, splat16(_ZERO) - x), wide(b, sign + n.y * n.y * a, splat16(_ZERO) - n.y)


@device
def _scatter(plan, wave, first, depth, worth_tracing, weight):
    """Scattered rays of all lanes, in proportion to the cosine, of paths that carry `weight` on; bits of those that go
    on. Those that carry little play for it (`_survives` in path.py)."""
    floats, lanes = wave.floats, wave.lanes
    zero, one = splat16(_ZERO), splat16(_ONE)
    normal, shading = load_wide(lanes, _NORMAL, _START), load_wide(lanes, _SHADING, _START)
    x, y = load_lanes(floats, rows.SCATTER_U, first), load_lanes(floats, rows.SCATTER_V, first)
    z = square_root(maximum(zero, one - x * x - y * y))
    tangent, bitangent = _frame(shading)
    into = tangent * x + bitangent * y + shading * z
    worth = maximum(weight.x, maximum(weight.y, weight.z))
    goes = (wide_dot(into, normal) > zero) & (worth > zero)
    if depth >= plan.roulette_depth:
        worth = worth * splat16(_ONE / worth_tracing)
        goes = goes & ((worth >= one) | (load_lanes(floats, rows.PICK_V, first) < worth))
        weight = weight * select(worth < one, one / worth, one)
    store_wide(lanes, _ON, _START, into)
    store_wide(lanes, _CARRIED, _START, weight)
    store_lanes(lanes, _DENSITY, _START, z * splat16(INV_PI))
    return bits(goes)


@device
def scatter_matte(tables, plan, wave, first, depth, worth_tracing, matte):
    """Aim at lights from the surfaces in the lanes `matte`, and scatter their paths, which are worth tracing if they
    carry as much as that. Returns (lanes that have a shadow ray, lanes whose path goes on), bit by bit."""
    lanes = wave.lanes
    _find_surfaces(wave, first)
    place, normal = load_wide(lanes, _PLACE, _START), load_wide(lanes, _NORMAL, _START)
    store_wide(lanes, _FROM, _START, place + normal * load_lanes(lanes, _ERROR, _START))
    weight = load_wide(wave.floats, rows.CARRIED, first) * load_wide(lanes, _COLOUR, _START)
    aimed = np.int32(0)
    if tables.lights.kinds.rows > 0:
        _sample_lights(tables, wave, first, matte)
        aimed = _aim(wave, weight) & matte
    return aimed, _scatter(plan, wave, first, depth, worth_tracing, weight) & matte


@device
def move_shadow(tables, wave, i, lane, to):
    """Write the shadow ray in a lane, of the path in column `i`, to column `to`."""
    floats, ints, lanes = wave.floats, wave.ints, wave.lanes
    set_row_vec3(floats, rows.SHADOW_ORIGIN, to, row_vec3(lanes, _FROM, lane))
    set_row_vec3(floats, rows.SHADOW_DIRECTION, to, row_vec3(lanes, _SHADOW_INTO, lane))
    set_row_vec3(floats, rows.SHADOW_LIGHT, to, row_vec3(lanes, _LIGHT, lane))
    floats[rows.SHADOW_END, to] = lanes[_END, lane]
    ints[rows.SHADOW_OWNER, to] = ints[rows.OWNER, i]
    medium = current_medium(tables.media, wave.longs[rows.INSIDE, i])
    ints[rows.SHADOW_MEDIUM, to] = np.uint32(medium)


@device
def move_path(tables, plan, wave, i, lane, to):
    """Write the ray that goes on, from a lane, of the path in column `i`, to column `to`."""
    floats, ints, lanes = wave.floats, wave.ints, wave.lanes
    density = lanes[_DENSITY, lane]
    carry_scattered_cone(tables, plan, wave, i, to, floats[rows.HIT_T, i], density)
    set_row_vec3(floats, rows.ORIGIN, to, row_vec3(lanes, _FROM, lane))
    set_row_vec3(floats, rows.DIRECTION, to, row_vec3(lanes, _ON, lane))
    set_row_vec3(floats, rows.CARRIED, to, row_vec3(lanes, _CARRIED, lane))
    if tables.lights.tree.entry != 0:
        set_row_vec3(floats, rows.FROM_NORMAL, to, row_vec3(lanes, _SHADING, lane))
    floats[rows.DENSITY, to] = density
    floats[rows.HIT_T, to] = _FAR
    ints[rows.PIXEL, to] = ints[rows.PIXEL, i]
    ints[rows.SAMPLE, to] = ints[rows.SAMPLE, i]
    ints[rows.OWNER, to] = ints[rows.OWNER, i]
    wave.longs[rows.INSIDE, to] = wave.longs[rows.INSIDE, i]
