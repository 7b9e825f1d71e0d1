"""Path tracing: the rendering equation by random walks from the camera.

    L_o = L_e + ∫ f L_i cosθ dω   (Kajiya, 1986)

At each surface light is gathered in two ways, by aiming at a light and by following the scattered ray, and the two
are weighted by the power heuristic w = p² / (p² + q²) (Veach, Guibas: "Optimally Combining Sampling Techniques",
1995). Paths end by chance, in proportion to what they carry. Matte surfaces are taken sixteen at a time, others one by
one.

A constant sky is found by scattered rays alone: for them it has no variance but that of what stands in the way.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.surface import MATERIAL, offset_point
from isophote.kernels.base.jit import device, kernel
from isophote.kernels.base.vec import dot, maximum_component, vec3
from isophote.kernels.base.warp import to_disk
from isophote.kernels.light.bsdf import BLACK, LINKED
from isophote.kernels.light.emitter import sample_light
from isophote.kernels.light.medium import (
    attenuation,
    current_medium,
    medium_ior,
    medium_towards,
    surface_boundary,
)
from isophote.kernels.trace import wave as rows
from isophote.kernels.trace.air import SCATTERED, dim_shadow_rays, scatter_in_air
from isophote.kernels.trace.batch import LAMP, add_unblocked
from isophote.kernels.trace.boundary import goes_smoothly, set_relative_index
from isophote.kernels.trace.cone import carry_cone, cone_radius
from isophote.kernels.trace.direct import is_surface, surface_of
from isophote.kernels.trace.holes import has_holes
from isophote.kernels.trace.material import evaluate_linked, lit_side, prepare_linked, sample_linked
from isophote.kernels.trace.matte_lanes import gather_matte, move_path, move_shadow, scatter_matte
from isophote.kernels.trace.painted_lights import tint_of_light
from isophote.kernels.trace.path_met import add_emitted, add_lamp, add_sky
from isophote.kernels.trace.pick import pick_for
from isophote.kernels.trace.samples import FIRST, Tile, are_neighbours, develop
from isophote.kernels.trace.shading import mirror_ray, scatter_glass_ray, surface_colour
from isophote.kernels.trace.tables import FILM, PLAN, SCENE
from isophote.kernels.trace.wave import hit_of, row_vec3, set_row_vec3
from isophote.kernels.trace.wave_entries import ENTRIES, ask_blocked, ask_closest, ask_numbers, ask_start

__all__ = ["path_trace_tile"]

_ZERO, _ONE = np.float32(0), np.float32(1)
_FAR = np.float32(np.inf)
# A shadow ray ends this much short of its light, in parts of its length, lest it meets the light itself.
_SHADOW_END = np.float32(1 - 1e-4)
# Paths that carry less than this play for their life, where all light is aimed at, and where there is a sky that is
# only met by chance: there, those that live and carry more make noise. Measured: a room is 1.1 times as efficient by
# the first, and a body under a sky has two thirds of the noise by the second.
_WORTH_AIMED, _WORTH_MET = np.float32(0.5), np.float32(0.25)

open_scene, open_plan, open_film = SCENE.open, PLAN.open, FILM.open
open_wave, open_entries = rows.WAVE.open, ENTRIES.open

# Sampling dimensions (pairs of numbers): three for each ray of the path.
_PICK, _LIGHT, _SCATTER, _PER_RAY = np.int64(0), np.int64(1), np.int64(2), np.int64(3)
# Beyond those: what chances rays have to go through cut-outs.
_HOLES = np.int64(2**20)


@device
def _draw_step(entries, plan, wave, count, depth):
    """Sample numbers of one step for every path: PICK_U picks a light and one of several lobes or rays, PICK_V ends
    paths, LIGHT is a place on the light, SCATTER a point of the unit disk."""
    first = FIRST + _PER_RAY * (depth - 1)
    ask_numbers(entries, plan, wave, count, first + _PICK, np.int64(rows.PICK_U))
    ask_numbers(entries, plan, wave, count, first + _LIGHT, np.int64(rows.LIGHT_U))
    ask_numbers(entries, plan, wave, count, first + _SCATTER, np.int64(rows.SCATTER_U))
    # Scattering starts from a point of the unit disk; here it is made for eight paths at a time.
    u, v = wave.floats[rows.SCATTER_U], wave.floats[rows.SCATTER_V]
    for i in range(count):
        u[i], v[i] = to_disk(u[i], v[i])


@device
def _aim(tables, wave, i, at, surface, boundary, lit, carried):
    """Aim at a light on the side of the normal `lit`, or anywhere if that is zero, from a surface whose material is
    prepared; the shadow ray goes to wave column `at`. Returns how many were made."""
    lights = tables.lights
    if lights.kinds.rows == 0:
        return 0
    floats = wave.floats
    k, chance = pick_for(lights, wave.ask, surface.place, lit, floats[rows.PICK_U, i])
    if k < 0:
        return 0
    sample = sample_light(lights, k, surface.place, floats[rows.LIGHT_U, i], floats[rows.LIGHT_V, i])
    direction = vec3(sample.x, sample.y, sample.z)
    value, q = evaluate_linked(tables, surface, direction, wave.scratch)
    # w / p for the power heuristic's w = p² / (p² + q²) is p / (p² + q²).
    p = chance * sample.density
    weight = p / (p * p + q * q) if p > _ZERO else _ONE / chance
    light = carried * value * vec3(sample.red, sample.green, sample.blue) * weight
    light = light * tint_of_light(tables, k, surface.place + direction * sample.distance, wave.scratch)
    # Light that nothing blocks comes through one medium all the way.
    medium = medium_towards(boundary, surface.normal, row_vec3(floats, rows.DIRECTION, i), direction)
    if medium != 0:
        light = light * attenuation(tables.media, medium, sample.distance)
    start = offset_point(surface.place, surface.normal, surface.error, direction)
    # The light's place seen from the moved start, so that the ray still ends on it, at t = 1.
    far = sample.distance == _FAR
    to_light = direction if far else direction * sample.distance + (surface.place - start)
    # Written whether it counts or not, and overwritten by the next: a branch here would be guessed wrong half the time.
    set_row_vec3(floats, rows.SHADOW_ORIGIN, at, start)
    set_row_vec3(floats, rows.SHADOW_DIRECTION, at, to_light)
    set_row_vec3(floats, rows.SHADOW_LIGHT, at, light)
    floats[rows.SHADOW_END, at] = _FAR if far else _SHADOW_END
    wave.ints[rows.SHADOW_OWNER, at] = wave.ints[rows.OWNER, i]
    wave.ints[rows.SHADOW_MEDIUM, at] = np.uint32(medium)
    return np.int64((sample.density >= _ZERO) & (maximum_component(light) > _ZERO))


@device
def _survives(worth_tracing, plan, depth, carried, u):
    """Factor on what the path carries after a game of chance, 0 if it ends; fair because survivors carry more (also in
    matte_lanes.py).

    Paths that carry little play: to end those that carry much would save rays but cost more in noise.
    """
    worth = maximum_component(carried) / worth_tracing
    if depth < plan.roulette_depth or worth >= _ONE:
        return _ONE
    return _ONE / worth if u < worth else _ZERO


@device
def _go_on(tables, worth_tracing, plan, wave, depth, i, to, surface, shading, into, carried, density, inside):
    """Write the ray that goes on from a surface to wave column `to`. Returns how many were written: 1, or 0 where the
    path ends."""
    floats, ints = wave.floats, wave.ints
    factor = _survives(worth_tracing, plan, depth, carried, floats[rows.PICK_V, i])
    start = offset_point(surface.place, surface.normal, surface.error, into)
    # Written whether the path lives or not, as in _aim.
    set_row_vec3(floats, rows.ORIGIN, to, start)
    set_row_vec3(floats, rows.DIRECTION, to, into)
    set_row_vec3(floats, rows.CARRIED, to, carried * factor)
    if tables.lights.tree.entry != 0:
        set_row_vec3(floats, rows.FROM_NORMAL, to, shading)
    floats[rows.DENSITY, to] = density
    floats[rows.HIT_T, to] = _FAR
    ints[rows.PIXEL, to] = ints[rows.PIXEL, i]
    ints[rows.SAMPLE, to] = ints[rows.SAMPLE, i]
    ints[rows.OWNER, to] = ints[rows.OWNER, i]
    wave.longs[rows.INSIDE, to] = inside
    return np.int64(factor * maximum_component(carried) > _ZERO)


@device
def _go_on_in_air(worth_tracing, plan, wave, depth, i, to, inside):
    """As _go_on, where the air has scattered the ray."""
    if depth == plan.max_depth:
        return np.int64(0)
    floats, ints = wave.floats, wave.ints
    carried = row_vec3(floats, rows.CARRIED, i)
    factor = _survives(worth_tracing, plan, depth, carried, floats[rows.PICK_V, i])
    # Rows of three, and then those of one.
    for row in (rows.ORIGIN, rows.DIRECTION):
        set_row_vec3(floats, row, to, row_vec3(floats, row, i))
    for row in (rows.DENSITY, rows.WIDTH, rows.SPREAD):
        floats[row, to] = floats[row, i]
    for row in (rows.PIXEL, rows.SAMPLE, rows.OWNER):
        ints[row, to] = ints[row, i]
    set_row_vec3(floats, rows.CARRIED, to, carried * factor)
    set_row_vec3(floats, rows.FROM_NORMAL, to, vec3(_ZERO, _ZERO, _ZERO))
    floats[rows.HIT_T, to] = _FAR
    wave.longs[rows.INSIDE, to] = inside
    return np.int64(factor * maximum_component(carried) > _ZERO)


@device
def _cross_glass(media, surface, direction, boundary, inside, colour, u):
    """(direction, weight, media that it is in) of the reflected or the refracted ray of a smooth boundary; within a
    medium of higher priority there is none."""
    ratio = medium_ior(media, boundary.behind) / medium_ior(media, boundary.before)
    side = dot(direction, surface.normal)
    into, factor = scatter_glass_ray(surface, direction, ratio if side < _ZERO else _ONE / ratio, u)
    weight = colour * factor if boundary.before != boundary.behind else vec3(_ONE, _ONE, _ONE)
    return into, weight, boundary.inside if dot(into, surface.normal) * side > _ZERO else inside


@device
def _meet_none(tables, plan, wave, i, depth, worth, to):
    """The path in column `i` met no surface, but a lamp, the sky, or air that scatters. Returns how many rays were
    written to column `to`."""
    floats, longs = wave.floats, wave.longs
    inside, slot = longs[rows.INSIDE, i], longs[rows.HIT_SLOT, i]
    if slot == LAMP and longs[rows.HIT_INSTANCE, i] == SCATTERED:
        return _go_on_in_air(worth, plan, wave, depth, i, to, inside)
    carried = row_vec3(floats, rows.CARRIED, i)
    carried = carried * attenuation(tables.media, current_medium(tables.media, inside), floats[rows.HIT_T, i])
    if slot == LAMP:
        add_lamp(tables, wave, i, carried)
    else:
        add_sky(tables, wave, i, carried)
    return np.int64(0)


@device
def _meet_surface(tables, plan, wave, i, depth, worth, to, at):
    """Emission, aiming and scattering of the path in column `i`, which met a surface that is not matte. Returns how
    many rays were written to column `to`, and how many shadow rays to column `at`."""
    floats, longs = wave.floats, wave.longs
    none, shadows = np.int64(0), np.int64(0)
    origin, direction = row_vec3(floats, rows.ORIGIN, i), row_vec3(floats, rows.DIRECTION, i)
    carried, inside = row_vec3(floats, rows.CARRIED, i), longs[rows.INSIDE, i]
    hit = hit_of(wave, i)
    surface = surface_of(tables, origin, direction, hit, wave.scratch)
    material = np.int64(tables.surfaces.items[surface.item, MATERIAL])
    kind = tables.materials.kinds[material]
    boundary = surface_boundary(tables.media, material, inside, dot(direction, surface.normal) < _ZERO)
    carried = carried * attenuation(tables.media, boundary.before, hit.t)
    add_emitted(tables, wave, i, surface, hit, direction, carried)
    if depth == plan.max_depth or kind == BLACK:
        return none, none
    radius, smoothly = cone_radius(wave, i, hit.t), goes_smoothly(tables, material, boundary)
    normal, density = direction, _ZERO
    # What is called by address looks its textures up by itself.
    if smoothly or kind != LINKED:
        colour = surface_colour(tables, surface, hit, direction, radius, wave.scratch)
        if smoothly:
            u = floats[rows.PICK_U, i]
            into, weight, inside = _cross_glass(tables.media, surface, direction, boundary, inside, colour, u)
        else:
            into, weight = mirror_ray(surface, direction), colour
    else:
        prepare_linked(tables, surface, hit, direction, radius, wave.scratch)
        set_relative_index(tables, material, boundary, dot(direction, surface.normal) < _ZERO, wave.scratch)
        normal = lit_side(tables, material, wave.scratch)
        if tables.materials.scatters[material] != 0:
            shadows = _aim(tables, wave, i, at, surface, boundary, normal, carried)
        x, y = floats[rows.SCATTER_U, i], floats[rows.SCATTER_V, i]
        into, weight, density = sample_linked(tables, surface, x, y, floats[rows.PICK_U, i], wave.scratch)
        inside = boundary.inside if dot(into, surface.normal) * dot(direction, surface.normal) > _ZERO else inside
    carried = carried * weight
    going = _go_on(tables, worth, plan, wave, depth, i, to, surface, normal, into, carried, density, inside)
    if going > 0:
        carry_cone(tables, plan, wave, i, to, surface, hit, direction, into, density)
    return going, shadows


@device
def _shade(tables, plan, wave, count, depth, shadows):
    """Emission, aiming and scattering of every path; so many shadow rays are there already. Returns (paths that go on,
    shadow rays)."""
    alive, constant = np.int64(0), tables.lights.environment.constant
    worth = _WORTH_MET if constant[0] + constant[1] + constant[2] > _ZERO else _WORTH_AIMED
    for first in range(0, count, rows.LANES):
        here = min(count - first, np.int64(rows.LANES))
        matte, aimed, going = gather_matte(tables, wave, first, here), np.int32(0), np.int32(0)
        if matte != 0 and depth < plan.max_depth:
            aimed, going = scatter_matte(tables, plan, wave, first, depth, worth, matte)
        for lane in range(here):
            i, bit = first + lane, np.int32(1) << np.int32(lane)
            if matte & bit:
                if aimed & bit:
                    move_shadow(tables, wave, i, lane, shadows)
                    shadows += 1
                if going & bit:
                    move_path(tables, plan, wave, i, lane, alive)
                    alive += 1
            elif is_surface(wave.longs[rows.HIT_SLOT, i]):
                went, made = _meet_surface(tables, plan, wave, i, depth, worth, alive, shadows)
                alive, shadows = alive + went, shadows + made
            else:
                alive += _meet_none(tables, plan, wave, i, depth, worth, alive)
    return alive, shadows


@kernel
def path_trace_tile(scene_words, plan_words, film_words, wave_words, entry_words, x0, x1, y0, y1):
    """Path-trace the samples that the pixels x0 ≤ x < x1, y0 ≤ y < y1 are short of, onto the film."""
    tables, plan = open_scene(scene_words), open_plan(plan_words)
    film, wave, entries = open_film(film_words), open_wave(wave_words), open_entries(entry_words)
    tile = Tile(x0, x1, y0, y1)
    begun = np.int64(0)
    # A tile without pixels needs no tables (rendering/warm.py).
    count, place = begun, begun
    if x0 < x1 and y0 < y1:
        count, place = ask_start(entries, tables, plan, film, tile, begun, wave)
    while count > 0:
        alive, together = count, are_neighbours(count, begun, place)
        for depth in range(1, plan.max_depth + 1):
            if has_holes(tables):
                ask_numbers(entries, plan, wave, alive, _HOLES + depth, np.int64(rows.PICK_U))
            # Rays of one pixel leave the camera together; later ones go every way.
            ask_closest(entries, tables, wave, alive, together and depth == 1)
            _draw_step(entries, plan, wave, alive, depth)
            in_air = scatter_in_air(tables, plan, wave, alive, depth)
            alive, shadows = _shade(tables, plan, wave, alive, depth, in_air)
            dim_shadow_rays(tables, wave, shadows)
            ask_blocked(entries, tables, wave, shadows, together and depth == 1)
            add_unblocked(tables, wave, shadows)
            if alive == 0:
                break
        develop(plan, count, wave, film)
        begun = place
        count, place = ask_start(entries, tables, plan, film, tile, place, wave)
