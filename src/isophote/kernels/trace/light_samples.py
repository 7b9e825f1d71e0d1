"""Samples of lights for surfaces of a wave, as entries that ray tracing's tile calls (ray_lights.py).

draw_jobs(plan, tree, wave, first, count, begin, end)                          their sample numbers
sample_lights(scene, tree, wave, job, draw, first, h, count, at)               samples of lights, one by one
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.entry import entry, opener_at
from isophote.kernels.base.jit import device
from isophote.kernels.base.sampler import draw_pairs
from isophote.kernels.base.simd import load_int
from isophote.kernels.base.vec import vec3
from isophote.kernels.light.emitter import ENVIRONMENT, sample_group
from isophote.kernels.trace import ray_tree
from isophote.kernels.trace import wave as rows
from isophote.kernels.trace.painted_lights import tint_of_light
from isophote.kernels.trace.samples import FIRST
from isophote.kernels.trace.tables import PLAN, SCENE
from isophote.kernels.trace.wave import row_vec3, set_row_vec3

__all__ = ["FACTOR", "draw_jobs", "sample_lights"]

_ZERO, _ONE = np.float32(0), np.float32(1)
# Row of the wave, which nothing else needs here, for what the light of a sample is multiplied by.
FACTOR = np.int64(rows.DENSITY)

_scene_at, _plan_at = opener_at(SCENE), opener_at(PLAN)
_wave_at, _tree_at = opener_at(rows.WAVE), opener_at(ray_tree.TREE)


@device
def _column(tree, at):
    """Wave column of the ray that met the surface in column `at`."""
    return np.int64(load_int(tree.surfaces[ray_tree.COLUMN], at))


@entry
def draw_jobs(plan_words, tree_words, wave_words, first, count, begin, end):
    """Sample numbers of light samples begin … end − 1 for surfaces first … first + count − 1."""
    plan, tree, wave = _plan_at(plan_words), _tree_at(tree_words), _wave_at(wave_words)
    keys, jobs, ints = tree.keys, tree.jobs, wave.ints
    for h in range(count):
        keys[ray_tree.DRAW_KEY, h] = ints[rows.PIXEL, _column(tree, first + h)]
    for job in range(begin, end):
        several = jobs[job, 2]
        if several == 0:
            continue
        for h in range(count):
            sample = ints[rows.SAMPLE, _column(tree, first + h)]
            keys[ray_tree.DRAW_SAMPLE, h] = sample * several + jobs[job, 1]
        draw_pairs(
            plan.pattern,
            plan.seed,
            keys[ray_tree.DRAW_KEY],
            keys[ray_tree.DRAW_SAMPLE],
            plan.samples * several,
            FIRST + jobs[job, 0],
            count,
            tree.draws[2 * (job - begin)],
            tree.draws[2 * (job - begin) + 1],
        )
    return 0


@device
def _sample_one(tables, wave, group, several, place, u, v, at):
    """One sample of a light into wave column `at`; of an environment without the constant part of the sky, which counts
    as ambient light."""
    floats, lights = wave.floats, tables.lights
    row, chance, sample = sample_group(lights, group, place, u, v)
    if sample.density < _ZERO:
        floats[FACTOR, at] = _ZERO
        return
    into, radiance = vec3(sample.x, sample.y, sample.z), vec3(sample.red, sample.green, sample.blue)
    if lights.kinds[row] == ENVIRONMENT:
        constant = lights.environment.constant
        radiance = radiance - vec3(constant[0], constant[1], constant[2])
    radiance = radiance * tint_of_light(tables, row, place + into * sample.distance, wave.scratch)
    set_row_vec3(floats, rows.SHADOW_DIRECTION, at, into)
    set_row_vec3(floats, rows.SHADOW_LIGHT, at, radiance)
    floats[rows.SHADOW_END, at] = sample.distance
    floats[FACTOR, at] = _ONE / (sample.density * chance * np.float32(several)) if several > 0 else _ONE


@entry
def sample_lights(scene_words, tree_words, wave_words, job, draw, first, h, count, at):
    """Samples of a light of any kind for surfaces first + h … first + h + count − 1; see ray_lights.py."""
    scene, tree, wave = _scene_at(scene_words), _tree_at(tree_words), _wave_at(wave_words)
    group, several, draws = np.int64(tree.jobs[job, 0]), tree.jobs[job, 2], tree.draws
    for k in range(count):
        place = row_vec3(tree.surfaces, ray_tree.PLACE, first + h + k)
        _sample_one(scene, wave, group, several, place, draws[draw, h + k], draws[draw + 1, h + k], at + k)
    return 0
