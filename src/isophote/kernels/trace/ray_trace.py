"""Ray tracing after Whitted: trees of rays from the camera.

    L = tint · (L_e + ambient + Σ_lights f cosθ E V + R L(reflected) + T L(refracted))

("An improved illumination model for shaded display", CACM 23(6), 1980.) The ambient term is a surface's colour times
the radiance of a constant sky, as if nothing stood in its way. Surfaces that scatter light are lit by all lights;
smooth ones branch the tree: mirrors by one ray, boundaries of clear media by two, split by Fresnel's equations.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.geometry import Hit
from isophote.kernels.accel.surface import MATERIAL, PUBLIC, offset_point
from isophote.kernels.base.jit import device, kernel
from isophote.kernels.base.vec import dot, maximum_component, vec3
from isophote.kernels.base.warp import to_disk
from isophote.kernels.brdf.contract import PARAMETERS
from isophote.kernels.light.emitter import lamp_radiance
from isophote.kernels.light.environment import environment_radiance
from isophote.kernels.light.medium import attenuation, current_medium, medium_ior, surface_boundary
from isophote.kernels.trace import ray_log, ray_tree
from isophote.kernels.trace import wave as rows
from isophote.kernels.trace.batch import LAMP
from isophote.kernels.trace.boundary import goes_smoothly, split_ray
from isophote.kernels.trace.cone import cone_radius, leaving_cone
from isophote.kernels.trace.direct import is_surface, surface_of
from isophote.kernels.trace.holes import has_holes, stop_at_any, surface_opacity
from isophote.kernels.trace.material import branch_material, sample_material
from isophote.kernels.trace.ray_lights import light_surfaces, prepare_surface, remember_surface
from isophote.kernels.trace.ray_log import LOG, log_camera, log_hit, log_terms
from isophote.kernels.trace.ray_matte import face_matte, has_ambient, matte_item, note_matte
from isophote.kernels.trace.ray_tree import TREE, branch, gather, next_level, start_trees, sum_levels, take
from isophote.kernels.trace.samples import Tile, are_neighbours, develop
from isophote.kernels.trace.shading import surface_colour, surface_emission
from isophote.kernels.trace.tables import FILM, PLAN, SCENE
from isophote.kernels.trace.wave import add_radiance, row_vec3
from isophote.kernels.trace.wave_entries import ask_closest, ask_numbers, ask_start

__all__ = ["ray_trace_tile"]

_ZERO, _ONE = np.float32(0), np.float32(1)
# Sampling dimensions beyond those of lights.
_SCATTER, _PICK = np.int64(2**20), np.int64(2**20 + 1)
# Column of `Materials.spans`.
_OPENNESS = np.int64(4)

open_scene, open_plan, open_film, open_wave = SCENE.open, PLAN.open, FILM.open, rows.WAVE.open
open_tree, open_log = TREE.open, LOG.open


@device
def _meet_light(tables, tree, wave, log, i):
    """What a ray gathers that meets no surface: the sky, or a lamp."""
    floats, longs = wave.floats, wave.longs
    origin, direction, t = row_vec3(floats, rows.ORIGIN, i), row_vec3(floats, rows.DIRECTION, i), floats[rows.HIT_T, i]
    if longs[rows.HIT_SLOT, i] == LAMP:
        met, number = ray_log.LAMP, np.int64(tables.lights.numbers[longs[rows.HIT_INSTANCE, i]])
        emitted = lamp_radiance(tables.lights, longs[rows.HIT_INSTANCE, i], origin + direction * t, direction)
    else:
        met, number = ray_log.NOTHING, np.int64(-1)
        emitted = environment_radiance(tables.lights.environment, direction)
    tint = attenuation(tables.media, current_medium(tables.media, wave.longs[rows.INSIDE, i]), t)
    nothing = vec3(_ZERO, _ZERO, _ZERO)
    log_terms(log, tree.rays[ray_tree.RAY_LOGGED, i], met, number, t, tint, emitted, nothing)
    add_radiance(wave, i, row_vec3(floats, rows.CARRIED, i) * tint * emitted)


@device
def _emitted(tables, surface, hit, direction, radius, scratch):
    emitted, two_sided = surface_emission(tables, surface, hit, direction, radius, scratch)
    if two_sided or dot(direction, surface.normal) < _ZERO:
        return emitted
    return vec3(_ZERO, _ZERO, _ZERO)


@device
def _openness(tables, surface, scratch):
    """What an occlusion texture leaves of ambient light; the surface's parameters are in the scratch."""
    materials, material = tables.materials, np.int64(tables.surfaces.items[surface.item, MATERIAL])
    slot = np.int64(materials.spans[material, _OPENNESS])
    at = PARAMETERS + 3 * slot
    return scratch[at] + scratch[at + 3] if slot > 0 else _ONE


@device
def _ambient(tables, wave, i, surface):
    """What a surface scatters of a constant sky with nothing in its way but what an occlusion texture tells; of matte
    ones, colour times radiance."""
    floats = tables.lights.environment.constant
    constant = vec3(floats[0], floats[1], floats[2])
    if maximum_component(constant) <= _ZERO:
        return constant
    floats = wave.floats
    u, v, pick = floats[rows.SCATTER_U, i], floats[rows.SCATTER_V, i], floats[rows.PICK_U, i]
    x, y = to_disk(u, v)
    _, weight, density = sample_material(tables, surface, x, y, pick, wave.scratch)
    # Single directions are branches of the tree.
    return constant * weight * _openness(tables, surface, wave.scratch) if density > _ZERO else constant * _ZERO


@device
def _start(surface, into):
    return offset_point(surface.place, surface.normal, surface.error, into)


@device
def _branch_glass(tables, plan, tree, wave, log, level, i, surface, hit, direction, boundary, carried):
    """The rays that leave a boundary of clear media; where it lies within a medium of higher priority, it is none."""
    if boundary.before == boundary.behind:
        start, weight = _start(surface, direction), vec3(_ONE, _ONE, _ONE)
        kind, inside = ray_log.PASSED, boundary.inside
        cone = leaving_cone(tables, plan, wave, i, surface, hit, direction, direction, _ZERO)
        branch(tree, log, wave, plan.max_depth, level, i, kind, inside, start, direction, carried, weight, cone)
        return
    ratio = medium_ior(tables.media, boundary.behind) / medium_ior(tables.media, boundary.before)
    share, reflected, refracted = split_ray(surface, direction, ratio)
    inside, radius = wave.longs[rows.INSIDE, i], cone_radius(wave, i, hit.t)
    colour = surface_colour(tables, surface, hit, direction, radius, wave.scratch)
    for k in range(2):
        into = reflected if k == 0 else refracted
        # Radiance is squeezed into a smaller cone behind the boundary (bsdf.py).
        weight = colour * (share if k == 0 else (_ONE - share) / (ratio * ratio))
        kind = ray_log.REFLECTED if k == 0 else ray_log.REFRACTED
        if share < _ONE or k == 0:
            cone, start = (
                leaving_cone(tables, plan, wave, i, surface, hit, direction, into, _ZERO),
                _start(surface, into),
            )
            branch(tree, log, wave, plan.max_depth, level, i, kind, inside, start, into, carried, weight, cone)
        inside = boundary.inside


@device
def _branch_any(tables, plan, tree, wave, log, level, i, surface, hit, direction, boundary, carried):
    """The rays in all single directions that a material sends light to."""
    material = np.int64(tables.surfaces.items[surface.item, MATERIAL])
    for k in range(tables.materials.branches[material]):
        into, weight = branch_material(tables, surface, k, wave.scratch)
        if maximum_component(weight) > _ZERO:
            back = dot(into, surface.normal) * dot(direction, surface.normal) < _ZERO
            kind = ray_log.REFLECTED if back else ray_log.PASSED
            inside = wave.longs[rows.INSIDE, i] if back else boundary.inside
            cone, start = (
                leaving_cone(tables, plan, wave, i, surface, hit, direction, into, _ZERO),
                _start(surface, into),
            )
            branch(tree, log, wave, plan.max_depth, level, i, kind, inside, start, into, carried, weight, cone)


@device
def _branch_through(tables, plan, tree, wave, log, level, i, surface, hit, direction, carried, opacity):
    """The ray that goes straight on through a cut-out; `carried` holds its opacity, which is above 0, already."""
    share = (_ONE - opacity) / opacity
    kind, inside, weight = ray_log.PASSED, wave.longs[rows.INSIDE, i], vec3(share, share, share)
    start, cone = (
        _start(surface, direction),
        leaving_cone(tables, plan, wave, i, surface, hit, direction, direction, _ZERO),
    )
    branch(tree, log, wave, plan.max_depth, level, i, kind, inside, start, direction, carried, weight, cone)


@device
def _meet_surface(tables, plan, tree, wave, log, level, i, lit):
    """What a ray gathers at a surface, apart from lights, and the rays that leave it. Returns 1 if lights shine on it,
    which is noted in column `lit`, else 0."""
    floats, longs = wave.floats, wave.longs
    origin, direction, t = row_vec3(floats, rows.ORIGIN, i), row_vec3(floats, rows.DIRECTION, i), floats[rows.HIT_T, i]
    hit = Hit(t, floats[rows.HIT_W1, i], floats[rows.HIT_W2, i], longs[rows.HIT_SLOT, i], longs[rows.HIT_INSTANCE, i])
    surface = surface_of(tables, origin, direction, hit, wave.scratch)
    material = np.int64(tables.surfaces.items[surface.item, MATERIAL])
    inside = wave.longs[rows.INSIDE, i]
    boundary = surface_boundary(tables.media, material, inside, dot(direction, surface.normal) < _ZERO)
    radius, opacity = cone_radius(wave, i, t), _ONE
    if has_holes(tables):
        opacity = surface_opacity(tables, surface, hit, direction, radius, wave.scratch)
    prepare_surface(tables, surface, boundary, hit, direction, radius, wave.scratch)
    tint = attenuation(tables.media, boundary.before, t) * opacity
    carried = row_vec3(floats, rows.CARRIED, i) * tint
    emitted, ambient = _emitted(tables, surface, hit, direction, radius, wave.scratch), vec3(_ZERO, _ZERO, _ZERO)
    scatters = tables.materials.scatters[material] != 0 and not goes_smoothly(tables, material, boundary)
    if scatters:
        remember_surface(tables, tree, log, lit, i, surface, boundary, carried, wave.scratch)
        ambient = _ambient(tables, wave, i, surface)
    logged = tree.rays[ray_tree.RAY_LOGGED, i]
    number = np.int64(tables.surfaces.items[surface.item, PUBLIC])
    log_terms(log, logged, ray_log.SURFACE, number, t, tint, emitted, ambient)
    log_hit(log, logged, tables, hit, surface)
    add_radiance(wave, i, carried * (emitted + ambient))
    if goes_smoothly(tables, material, boundary):
        _branch_glass(tables, plan, tree, wave, log, level, i, surface, hit, direction, boundary, carried)
    else:
        _branch_any(tables, plan, tree, wave, log, level, i, surface, hit, direction, boundary, carried)
    if opacity < _ONE:
        _branch_through(tables, plan, tree, wave, log, level, i, surface, hit, direction, carried, opacity)
    return np.int64(scatters)


@device
def _shade(tables, plan, tree, wave, log, level, count):
    """What every ray gathers, lights apart. Returns how many surfaces lights shine on."""
    if has_ambient(tables):
        ask_numbers(tree.entries, plan, wave, count, _PICK, np.int64(rows.PICK_U))
        ask_numbers(tree.entries, plan, wave, count, _SCATTER, np.int64(rows.SCATTER_U))
    told = log.rays.rows > 0 or tree.tint != 0 or has_holes(tables)
    lit, slots, instances = np.int64(0), wave.longs[rows.HIT_SLOT], wave.longs[rows.HIT_INSTANCE]
    slot, instance, item = np.int64(-1), np.int64(0), np.int64(-1)
    for i in range(count):
        if is_surface(slots[i]):
            # Rays side by side meet the same triangle more often than not.
            if slots[i] >= 0 and (slots[i] != slot or instances[i] != instance):
                slot, instance = slots[i], instances[i]
                item = matte_item(tables, slot, instance)
            if not told and note_matte(tables, tree, wave, lit, i, item):
                lit += 1
                continue
            lit += _meet_surface(tables, plan, tree, wave, log, level, i, lit)
        else:
            _meet_light(tables, tree, wave, log, i)
    face_matte(tree, lit)
    return lit


@device
def _count_rays(plan, tree, wave, count):
    """Add the trees' rays to their pixels."""
    pixels = plan.width * plan.height
    for i in range(count):
        place = np.int64(wave.ints[rows.PLACE, i])
        tree.traced[place - pixels if place >= pixels else place] += tree.rays[ray_tree.COUNT, i]


@kernel
def ray_trace_tile(scene_words, plan_words, film_words, wave_words, tree_words, log_words, x0, x1, y0, y1):
    """Ray-trace the samples that the pixels x0 ≤ x < x1, y0 ≤ y < y1 are short of, onto the film."""
    tables, plan = open_scene(scene_words), open_plan(plan_words)
    film, wave = open_film(film_words), open_wave(wave_words)
    tree, log = open_tree(tree_words), open_log(log_words)
    tile, levels = Tile(x0, x1, y0, y1), plan.max_depth
    begun = np.int64(0)
    # A tile without pixels needs no tables (rendering/warm.py).
    trees, place = begun, begun
    if x0 < x1 and y0 < y1:
        trees, place = ask_start(tree.entries, tables, plan, film, tile, begun, wave)
    while trees > 0:
        together = are_neighbours(trees, begun, place)
        start_trees(tree, levels, trees)
        for i in range(trees):
            tree.rays[ray_tree.RAY_LOGGED, i] = log_camera(log, wave, i)
        count, level = trees, np.int64(0)
        while count > 0:
            if has_holes(tables):
                stop_at_any(wave, count)
            # Rays of one pixel leave the camera together; later ones go every way.
            ask_closest(tree.entries, tables, wave, count, together and level == 0)
            lit = _shade(tables, plan, tree, wave, log, level, count)
            light_surfaces(tables, plan, tree, wave, log, lit, together and level == 0)
            gather(tree, wave, level, count)
            level = next_level(tree, levels, level)
            count = take(tree, wave, level) if level > 0 else np.int64(0)
        sum_levels(tree, wave, levels, trees)
        develop(plan, trees, wave, film)
        _count_rays(plan, tree, wave, trees)
        begun = place
        trees, place = ask_start(tree.entries, tables, plan, film, tile, place, wave)
