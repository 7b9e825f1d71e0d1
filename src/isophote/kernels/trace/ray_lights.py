"""Direct light: every light on every surface of a wave, by shadow rays.

    L = Σ f(out, into) cosθ E   for points, spots and suns,
    L = 1/n Σ f(out, into) cosθ L_light / density   for lights with a size, by n shadow rays each

None is picked by chance. The n places on a light, and those of all samples of a pixel together, are spread evenly.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.geometry import Hit
from isophote.kernels.accel.surface import MATERIAL, Surface, offset_point
from isophote.kernels.base.entry import call_entry, element_address, table_address
from isophote.kernels.base.jit import device
from isophote.kernels.base.sampler import draw_pairs
from isophote.kernels.base.vec import dot, load_vec3, maximum_component, vec3
from isophote.kernels.light.bsdf import LINKED
from isophote.kernels.light.emitter import ENVIRONMENT, sample_group
from isophote.kernels.light.medium import Boundary, attenuation, medium_towards
from isophote.kernels.trace import ray_tree
from isophote.kernels.trace import wave as rows
from isophote.kernels.trace.batch import find_blocked
from isophote.kernels.trace.boundary import set_relative_index
from isophote.kernels.trace.cone import cone_radius
from isophote.kernels.trace.holes import share_left
from isophote.kernels.trace.material import evaluate_material, prepare_material
from isophote.kernels.trace.painted_lights import tint_of_light
from isophote.kernels.trace.ray_log import log_light, log_visible
from isophote.kernels.trace.samples import FIRST
from isophote.kernels.trace.shadow_tint import DIRECTION, END, LEFT
from isophote.kernels.trace.wave import add_radiance, row_vec3, set_row_vec3

__all__ = ["light_surfaces", "prepare_surface", "remember_surface"]

_ZERO, _ONE = np.float32(0), np.float32(1)
_FAR = np.float32(np.inf)
_START, _AIR = np.int64(0), np.int64(0)
# As in path.py: a shadow ray ends this much short of its light.
_SHADOW_END = np.float32(1 - 1e-4)


@device
def remember_surface(tree, at, i, surface, boundary, carried):
    """Note a surface that the ray in wave column `i` met, for lights to shine on, in column `at`."""
    floats, numbers = tree.surfaces, tree.surface_numbers
    set_row_vec3(floats, ray_tree.PLACE, at, surface.place)
    set_row_vec3(floats, ray_tree.NORMAL, at, surface.normal)
    set_row_vec3(floats, ray_tree.SHADING, at, surface.shading)
    set_row_vec3(floats, ray_tree.SHARE, at, carried)
    floats[ray_tree.ERROR, at] = surface.error
    floats[ray_tree.U, at], floats[ray_tree.V, at] = surface.u, surface.v
    numbers[ray_tree.COLUMN, at] = i
    numbers[ray_tree.BEFORE, at], numbers[ray_tree.BEHIND, at] = boundary.before, boundary.behind
    numbers[ray_tree.THROUGH, at] = boundary.inside
    numbers[ray_tree.ITEM, at], numbers[ray_tree.TRIANGLE, at] = surface.item, surface.triangle


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
def _draw_jobs(plan, tree, wave, first, count):
    """Sample numbers of all lights for surfaces first … first + count − 1."""
    keys, jobs = tree.keys, tree.jobs
    for h in range(count):
        i = tree.surface_numbers[ray_tree.COLUMN, first + h]
        keys[ray_tree.DRAW_KEY, h] = wave.ints[rows.PIXEL, i]
    for job in range(jobs.rows):
        several = jobs[job, 2]
        if several == 0:
            continue
        for h in range(count):
            i = tree.surface_numbers[ray_tree.COLUMN, first + h]
            keys[ray_tree.DRAW_SAMPLE, h] = wave.ints[rows.SAMPLE, i] * several + jobs[job, 1]
        draw_pairs(
            plan.pattern,
            plan.seed,
            keys[ray_tree.DRAW_KEY],
            keys[ray_tree.DRAW_SAMPLE],
            plan.samples * several,
            FIRST + jobs[job, 0],
            count,
            tree.draws[2 * job],
            tree.draws[2 * job + 1],
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
    floats, longs = wave.floats, wave.longs
    i = tree.surface_numbers[ray_tree.COLUMN, at]
    hit = Hit(
        floats[rows.HIT_T, i],
        floats[rows.HIT_W1, i],
        floats[rows.HIT_W2, i],
        longs[rows.HIT_SLOT, i],
        longs[rows.HIT_INSTANCE, i],
    )
    direction = row_vec3(floats, rows.DIRECTION, i)
    radius = cone_radius(wave, i, hit.t)
    prepare_surface(tables, surface, _boundary(tree, at), hit, direction, radius, wave.scratch)


@device
def _arriving(tables, row, sample, medium):
    """What arrives through a medium; of an environment without the constant part of the sky, which counts as ambient
    light."""
    lights = tables.lights
    radiance = vec3(sample.red, sample.green, sample.blue)
    if lights.kinds[row] == ENVIRONMENT:
        constant = lights.environment.constant
        radiance = radiance - vec3(constant[0], constant[1], constant[2])
    return radiance * attenuation(tables.media, medium, sample.distance)


@device
def _aim(tables, tree, wave, log, at, h, first, surface, job):
    """A shadow ray from a surface to a place on a light, in wave column `at`. Returns how many were made: 1 or 0."""
    floats, jobs = wave.floats, tree.jobs
    group, several = np.int64(jobs[job, 0]), jobs[job, 2]
    u, v = tree.draws[2 * job, h], tree.draws[2 * job + 1, h]
    row, chance, sample = sample_group(tables.lights, group, surface.place, u, v)
    if sample.density < _ZERO:
        return 0
    into = vec3(sample.x, sample.y, sample.z)
    i = tree.surface_numbers[ray_tree.COLUMN, first + h]
    boundary, direction = _boundary(tree, first + h), row_vec3(floats, rows.DIRECTION, i)
    medium = medium_towards(boundary, surface.normal, direction, into)
    # Tinted shadow rays tell the media themselves.
    arriving = _arriving(tables, row, sample, medium if tree.tint == 0 else _AIR)
    arriving = arriving * tint_of_light(tables, row, surface.place + into * sample.distance, wave.scratch)
    through = dot(surface.normal, into) * dot(surface.normal, direction) > _ZERO
    tree.rays[ray_tree.SHADOW_INSIDE, at] = boundary.inside if through else wave.longs[rows.INSIDE, i]
    value, _ = evaluate_material(tables, surface, into, wave.scratch)
    factor = _ONE / (sample.density * chance * np.float32(several)) if several > 0 else _ONE
    light = row_vec3(tree.surfaces, ray_tree.SHARE, first + h) * value * arriving * factor
    trial = np.int64(jobs[job, 1])
    ray, number = tree.rays[ray_tree.RAY_LOGGED, i], np.int64(tables.lights.groups[group, 3])
    logged = log_light(log, ray, number, trial, sample, arriving, value, factor)
    start = offset_point(surface.place, surface.normal, surface.error, into)
    # The light's place seen from the moved start, so that the ray still ends on it, at t = 1.
    far = sample.distance == _FAR
    to_light = into if far else into * sample.distance + (surface.place - start)
    set_row_vec3(floats, rows.SHADOW_ORIGIN, at, start)
    set_row_vec3(floats, rows.SHADOW_DIRECTION, at, to_light)
    set_row_vec3(floats, rows.SHADOW_LIGHT, at, light)
    floats[rows.SHADOW_END, at] = _FAR if far else _SHADOW_END
    wave.ints[rows.SHADOW_OWNER, at] = i
    tree.rays[ray_tree.SHADOW_LOGGED, at] = logged
    return np.int64(maximum_component(light) > _ZERO)


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
    for k in range(count):
        i = np.int64(wave.ints[rows.SHADOW_OWNER, k])
        tree.rays[ray_tree.COUNT, np.int64(wave.ints[rows.OWNER, i])] += 1
        left = _left(tables, tree, wave, k)
        if maximum_component(left) > _ZERO:
            add_radiance(wave, i, row_vec3(wave.floats, rows.SHADOW_LIGHT, k) * left)
            log_visible(log, tree.rays[ray_tree.SHADOW_LOGGED, k], left)


@device
def light_surfaces(tables, plan, tree, wave, log, count, coherent):
    """Add the light of all lights to the rays that met surfaces 0 … count − 1."""
    jobs, size = tree.jobs.rows, wave.floats.columns
    if jobs == 0:
        return
    several = tree.draws.columns
    for first in range(0, count, several):
        here = min(several, count - first)
        _draw_jobs(plan, tree, wave, first, here)
        # All jobs at once, or, where there are more than a wave holds, those of a single surface in parts.
        for begin in range(0, jobs, size):
            made = np.int64(0)
            for h in range(here):
                surface = _surface(tree, first + h)
                _prepare(tables, tree, wave, surface, first + h)
                for job in range(begin, min(begin + size, jobs)):
                    made += _aim(tables, tree, wave, log, made, h, first, surface, job)
            find_blocked(tables, wave, made, coherent)
            _collect(tables, tree, wave, log, made)
