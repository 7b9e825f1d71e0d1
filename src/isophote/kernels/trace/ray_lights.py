"""Direct light: every light on every surface of a wave, by shadow rays.

    L = Σ f(out, into) cosθ E   for points, spots and suns,
    L = 1/n Σ f(out, into) cosθ L_light / density   for lights with a size, by n shadow rays each

None is picked by chance. The n places on a light, and those of all samples of a pixel together, are spread evenly.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.surface import MATERIAL, Surface
from isophote.kernels.base.entry import call_entry, element_address, table_address
from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import bits, load_int, lowest_bit, select, splat16, store_int
from isophote.kernels.base.simd_lanes import lane_numbers
from isophote.kernels.base.vec import dot, load_vec3, maximum_component, vec3
from isophote.kernels.base.warp import INV_PI
from isophote.kernels.base.wide import (
    counts_up,
    load_lanes,
    load_wide,
    store_lanes,
    store_wide,
    wide,
    wide_dot,
    wide_select,
    zero_lanes,
)
from isophote.kernels.brdf import contract
from isophote.kernels.light.bsdf import LINKED, MATTE
from isophote.kernels.light.emitter_lanes import sample_lanes, sampled_in_lanes
from isophote.kernels.light.medium import Boundary, attenuation, medium_towards
from isophote.kernels.trace import light_samples, ray_tree
from isophote.kernels.trace import wave as rows
from isophote.kernels.trace.boundary import set_relative_index
from isophote.kernels.trace.cone import cone_radius
from isophote.kernels.trace.holes import has_holes, share_left
from isophote.kernels.trace.material import evaluate_material, prepare_material
from isophote.kernels.trace.ray_log import log_light, log_visible
from isophote.kernels.trace.shadow_tint import DIRECTION, END, LEFT
from isophote.kernels.trace.wave import add_radiance, hit_of, row_vec3, set_row_vec3
from isophote.kernels.trace.wave_entries import ask_blocked

__all__ = ["light_surfaces", "prepare_surface", "remember_surface"]

_ZERO, _ONE = np.float32(0), np.float32(1)
_FAR = np.float32(np.inf)
_START, _AIR = np.int64(0), np.int64(0)
# Sixteen bits: all lanes.
_ALL = np.int32(0xFFFF)
_FACTOR = np.int64(light_samples.FACTOR)
# As in path.py: a shadow ray ends this much short of its light.
_SHADOW_END = np.float32(1 - 1e-4)


@device
def remember_surface(tables, tree, log, at, i, surface, boundary, carried, scratch):
    """Note a surface that the ray in wave column `i` met and that was prepared, for lights to shine on, in column `at`.

    Matte surfaces in air are plain: all that a light needs to know of them is in rows that sixteen are loaded from.
    """
    floats, numbers = tree.surfaces, tree.surface_numbers
    set_row_vec3(floats, ray_tree.PLACE, at, surface.place)
    floats[ray_tree.ERROR, at] = surface.error
    store_int(floats[ray_tree.COLUMN], at, np.int32(i))
    material = np.int64(tables.surfaces.items[surface.item, MATERIAL])
    told = log.rays.rows + tree.tint
    if tables.materials.kinds[material] == MATTE and (boundary.before | boundary.behind | told) == 0:
        floats[ray_tree.PLAIN, at] = _ONE
        set_row_vec3(floats, ray_tree.NORMAL, at, load_vec3(scratch, contract.TRUE_NORMAL))
        set_row_vec3(floats, ray_tree.SHADING, at, load_vec3(scratch, contract.NORMAL))
        set_row_vec3(floats, ray_tree.SHARE, at, carried * load_vec3(scratch, contract.PARAMETERS) * INV_PI)
        return
    floats[ray_tree.PLAIN, at] = _ZERO
    set_row_vec3(floats, ray_tree.NORMAL, at, surface.normal)
    set_row_vec3(floats, ray_tree.SHADING, at, surface.shading)
    set_row_vec3(floats, ray_tree.SHARE, at, carried)
    floats[ray_tree.U, at], floats[ray_tree.V, at] = surface.u, surface.v
    numbers[ray_tree.BEFORE, at], numbers[ray_tree.BEHIND, at] = boundary.before, boundary.behind
    numbers[ray_tree.THROUGH, at] = boundary.inside
    numbers[ray_tree.ITEM, at], numbers[ray_tree.TRIANGLE, at] = surface.item, surface.triangle


@device
def _column(tree, at):
    """Wave column of the ray that met the surface in column `at`."""
    return np.int64(load_int(tree.surfaces[ray_tree.COLUMN], at))


@device
def _surface(tree, at):
    floats, numbers = tree.surfaces, tree.surface_numbers
    return Surface(
        row_vec3(floats, ray_tree.PLACE, at),
        row_vec3(floats, ray_tree.NORMAL, at),
        row_vec3(floats, ray_tree.SHADING, at),
        floats[ray_tree.ERROR, at],
        floats[ray_tree.U, at],
        floats[ray_tree.V, at],
        numbers[ray_tree.ITEM, at],
        numbers[ray_tree.TRIANGLE, at],
    )


@device
def prepare_surface(tables, surface, boundary, hit, direction, radius, scratch):
    """Make ready what a surface's material is evaluated with."""
    material = np.int64(tables.surfaces.items[surface.item, MATERIAL])
    prepare_material(tables, surface, hit, direction, radius, scratch)
    if tables.materials.kinds[material] == LINKED:
        set_relative_index(tables, material, boundary, dot(direction, surface.normal) < _ZERO, scratch)


@device
def _boundary(tree, at):
    numbers = tree.surface_numbers
    return Boundary(numbers[ray_tree.BEFORE, at], numbers[ray_tree.BEHIND, at], numbers[ray_tree.THROUGH, at])


@device
def _prepare(tables, tree, wave, surface, at):
    """`prepare_surface` for the surface in column `at`."""
    i = _column(tree, at)
    hit, direction = hit_of(wave, i), row_vec3(wave.floats, rows.DIRECTION, i)
    radius = cone_radius(wave, i, hit.t)
    prepare_surface(tables, surface, _boundary(tree, at), hit, direction, radius, wave.scratch)


@device
def _sample(tables, tree, wave, log, job, draw, first, h, count, at):
    """Samples of a light for surfaces first + h … first + h + count − 1 into wave columns from `at` on: the direction
    in place of the shadow ray's, the distance in place of its end, what arrives, and what that is multiplied by, 0
    where nothing arrives. Logs tell what all single samples are, so these are taken one by one."""
    floats, surfaces, draws = wave.floats, tree.surfaces, tree.draws
    group, several = np.int64(tree.jobs[job, 0]), tree.jobs[job, 2]
    if log.rays.rows == 0 and sampled_in_lanes(tables.lights, group):
        place, u, v = (
            load_wide(surfaces, ray_tree.PLACE, first + h),
            load_lanes(draws, draw, h),
            load_lanes(draws, draw + 1, h),
        )
        share = _ONE / np.float32(several) if several > 0 else _ONE
        row = np.int64(tables.lights.groups[group, 0])
        into, distance, radiance, factor = sample_lanes(tables.lights, row, place, u, v, share)
        store_wide(floats, rows.SHADOW_DIRECTION, at, into)
        store_wide(floats, rows.SHADOW_LIGHT, at, radiance)
        store_lanes(floats, rows.SHADOW_END, at, distance)
        store_lanes(floats, _FACTOR, at, factor)
        return
    addresses = table_address(tables), table_address(tree), table_address(wave)
    call_entry(tree.sample_lights, (*addresses, np.int64(job), np.int64(draw), first, h, count, at))


@device
def _evaluate(tables, tree, wave, log, s, k, begin, end, at):
    """Multiply what arrives at a surface that is not plain, in column `s`, the k-th of its sixteen, by what it scatters
    of that and by what media leave of it."""
    floats = wave.floats
    surface, boundary, i = _surface(tree, s), _boundary(tree, s), _column(tree, s)
    direction, inside = row_vec3(floats, rows.DIRECTION, i), wave.longs[rows.INSIDE, i]
    _prepare(tables, tree, wave, surface, s)
    for job in range(begin, end):
        c = at + (job - begin) * rows.LANES + k
        factor = floats[_FACTOR, c]
        if factor == _ZERO:
            continue
        into, distance = row_vec3(floats, rows.SHADOW_DIRECTION, c), floats[rows.SHADOW_END, c]
        # Tinted shadow rays tell the media themselves.
        medium = medium_towards(boundary, surface.normal, direction, into) if tree.tint == 0 else _AIR
        arriving = row_vec3(floats, rows.SHADOW_LIGHT, c) * attenuation(tables.media, medium, distance)
        value, _ = evaluate_material(tables, surface, into, wave.scratch)
        set_row_vec3(floats, rows.SHADOW_LIGHT, c, value * arriving)
        through = dot(surface.normal, into) * dot(surface.normal, direction) > _ZERO
        tree.rays[ray_tree.SHADOW_INSIDE, c] = boundary.inside if through else inside
        number = np.int64(tables.lights.groups[tree.jobs[job, 0], 3])
        ray, trial = tree.rays[ray_tree.RAY_LOGGED, i], np.int64(tree.jobs[job, 1])
        tree.rays[ray_tree.SHADOW_LOGGED, c] = log_light(
            log, ray, number, trial, into, distance, arriving, value, factor
        )


@device
def _aim_lanes(tree, wave, s, count, at):
    """Turn samples of a light for surfaces s … s + count − 1, in wave columns from `at` on, into shadow rays. Returns
    bit by bit which of them carry light."""
    floats, surfaces = wave.floats, tree.surfaces
    zero, one, far = splat16(_ZERO), splat16(_ONE), splat16(_FAR)
    into, distance = load_wide(floats, rows.SHADOW_DIRECTION, at), load_lanes(floats, rows.SHADOW_END, at)
    place, normal = load_wide(surfaces, ray_tree.PLACE, s), load_wide(surfaces, ray_tree.NORMAL, s)
    cosine, height = wide_dot(load_wide(surfaces, ray_tree.SHADING, s), into), wide_dot(normal, into)
    scattered = select((cosine > zero) & (height > zero), cosine, zero)
    factor = load_lanes(floats, _FACTOR, at)
    weight = factor * select(load_lanes(surfaces, ray_tree.PLAIN, s) > zero, scattered, one)
    light = load_wide(surfaces, ray_tree.SHARE, s) * load_wide(floats, rows.SHADOW_LIGHT, at) * weight
    carries = (light.x > zero) | (light.y > zero) | (light.z > zero)
    carries = carries & (factor > zero) & (lane_numbers() < splat16(np.float32(count)))
    error = load_lanes(surfaces, ray_tree.ERROR, s)
    start = place + normal * select(height >= zero, error, zero - error)
    # The light's place seen from the moved start, so that the ray still ends on it, at t = 1.
    finite = distance < far
    to_light = wide_select(finite, into * distance + (place - start), into)
    store_wide(floats, rows.SHADOW_ORIGIN, at, start)
    store_wide(floats, rows.SHADOW_DIRECTION, at, to_light)
    store_wide(floats, rows.SHADOW_LIGHT, at, light)
    store_lanes(floats, rows.SHADOW_END, at, select(finite, splat16(_SHADOW_END), far))
    store_lanes(wave.ints, rows.SHADOW_OWNER, at, load_lanes(surfaces, ray_tree.COLUMN, s))
    sent = load_lanes(surfaces, ray_tree.SENT, s)
    store_lanes(surfaces, ray_tree.SENT, s, sent + select(carries, one, zero))
    return bits(carries)


@device
def _move(tree, wave, source, to):
    """Move a shadow ray to an earlier wave column."""
    floats = wave.floats
    for row in range(rows.SHADOW_ORIGIN, rows.SHADOW_LIGHT + 3):
        floats[row, to] = floats[row, source]
    floats[rows.SHADOW_END, to] = floats[rows.SHADOW_END, source]
    wave.ints[rows.SHADOW_OWNER, to] = wave.ints[rows.SHADOW_OWNER, source]
    tree.rays[ray_tree.SHADOW_LOGGED, to] = tree.rays[ray_tree.SHADOW_LOGGED, source]
    tree.rays[ray_tree.SHADOW_INSIDE, to] = tree.rays[ray_tree.SHADOW_INSIDE, source]


@device
def _aim(tables, tree, wave, log, first, h, count, begin, end, made):
    """Shadow rays from surfaces first + h … first + h + count − 1, sixteen at most, to samples begin … end − 1 of
    lights, in wave columns from `made` on. Returns the column after the last."""
    at, surfaces = made, tree.surfaces
    store_lanes(surfaces, ray_tree.SENT, first + h, splat16(_ZERO))
    for job in range(begin, end):
        c = at + (job - begin) * rows.LANES
        _sample(tables, tree, wave, log, job, 2 * (job - begin), first, h, count, c)
    for k in range(count):
        if surfaces[ray_tree.PLAIN, first + h + k] == _ZERO:
            _evaluate(tables, tree, wave, log, first + h + k, k, begin, end, at)
    for job in range(begin, end):
        c = at + (job - begin) * rows.LANES
        left = _aim_lanes(tree, wave, first + h, count, c)
        if left == _ALL and c == made:
            made += rows.LANES
            continue
        while left != 0:
            _move(tree, wave, c + np.int64(lowest_bit(left)), made)
            left &= left - np.int32(1)
            made += 1
    sent, owners = tree.rays[ray_tree.COUNT], wave.ints[rows.OWNER]
    for k in range(first + h, first + h + count):
        sent[np.int64(owners[_column(tree, k)])] += np.int64(surfaces[ray_tree.SENT, k])
    return made


@device
def _left(tables, tree, wave, k):
    """What is left of the light of shadow ray `k`."""
    blocked, inside = wave.ints[rows.BLOCKED, k] != 0, tree.rays[ray_tree.SHADOW_INSIDE, k]
    if tree.tint == 0 or (not blocked and inside == 0):
        left = _ZERO if blocked else share_left(tables, wave, k)
        return vec3(left, left, left)
    ray, scratch = tree.shadow, wave.scratch
    for row in range(3):
        ray[row] = wave.floats[rows.SHADOW_ORIGIN + row, k]
        ray[DIRECTION + row] = wave.floats[rows.SHADOW_DIRECTION + row, k]
    ray[END] = wave.floats[rows.SHADOW_END, k]
    scene, at = table_address(tables), element_address(scratch, _START)
    call_entry(tree.tint, (scene, at, np.int64(scratch.rows), element_address(ray, _START), inside))
    return load_vec3(ray, LEFT)


@device
def _collect(tables, tree, wave, log, count):
    """Add what is left of the light of shadow rays."""
    logging, floats, ints = log.rays.rows > 0, wave.floats, wave.ints
    whole = not (logging or tree.tint != 0 or has_holes(tables))
    k = np.int64(0)
    while k < count:
        if whole and k + rows.LANES <= count and counts_up(ints, rows.SHADOW_OWNER, k):
            i, nothing = np.int64(ints[rows.SHADOW_OWNER, k]), splat16(_ZERO)
            light = load_wide(floats, rows.SHADOW_LIGHT, k)
            light = wide_select(zero_lanes(ints, rows.BLOCKED, k), light, wide(nothing, nothing, nothing))
            store_wide(floats, rows.RADIANCE, i, load_wide(floats, rows.RADIANCE, i) + light)
            k += rows.LANES
            continue
        i = np.int64(ints[rows.SHADOW_OWNER, k])
        left = _left(tables, tree, wave, k)
        if maximum_component(left) > _ZERO:
            add_radiance(wave, i, row_vec3(wave.floats, rows.SHADOW_LIGHT, k) * left)
            if logging:
                log_visible(log, tree.rays[ray_tree.SHADOW_LOGGED, k], left)
        k += 1


@device
def light_surfaces(tables, plan, tree, wave, log, count, coherent):
    """Add the light of all lights to the rays that met surfaces 0 … count − 1."""
    jobs = tree.jobs.rows
    if jobs == 0:
        return
    several, part = tree.draws.columns, tree.draws.rows // 2
    for first in range(0, count, several):
        here = min(several, count - first)
        # All samples of lights at once, or, where there are more than a wave holds, those of sixteen surfaces in parts.
        for begin in range(0, jobs, part):
            end = min(begin + part, jobs)
            addresses = table_address(plan), table_address(tree), table_address(wave)
            call_entry(tree.draw_jobs, (*addresses, first, here, begin, end))
            made = np.int64(0)
            for h in range(0, here, rows.LANES):
                count_here = min(here - h, np.int64(rows.LANES))
                made = _aim(tables, tree, wave, log, first, h, count_here, begin, end, made)
            ask_blocked(tree.entries, tables, wave, made, coherent)
            _collect(tables, tree, wave, log, made)
