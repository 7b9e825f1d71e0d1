"""Ambient occlusion of what each pixel shows: one ray into the hemisphere for each ray of the camera."""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.accel.geometry import Hit
from isophote.kernels.accel.surface import offset_point
from isophote.kernels.base.jit import device, kernel
from isophote.kernels.base.table import DOUBLE_BOXES, FLOAT, Table
from isophote.kernels.base.vec import dot, orthonormal, vec3
from isophote.kernels.base.warp import to_disk
from isophote.kernels.trace import wave as rows
from isophote.kernels.trace.batch import find_blocked, trace_rays
from isophote.kernels.trace.direct import surface_of
from isophote.kernels.trace.holes import has_holes, share_left
from isophote.kernels.trace.samples import FIRST, Tile, are_neighbours, develop, draw, start_paths
from isophote.kernels.trace.shading import seen_normal
from isophote.kernels.trace.tables import FILM, PLAN, SCENE
from isophote.kernels.trace.wave import add_radiance, row_vec3, set_row_vec3

__all__ = ["SKY", "occlusion_tile"]

# `reach`: length of the rays; `bent` (pixels, 3): sums of the directions of free rays.
SKY = Table("OcclusionSky", reach=FLOAT, bent=DOUBLE_BOXES)

_ZERO, _ONE = np.float32(0), np.float32(1)
_NONE = np.int64(-1)
# Sampling dimension of what chances rays have to go through cut-outs.
_HOLES = np.int64(2**20)

open_scene, open_plan, open_film, open_wave = SCENE.open, PLAN.open, FILM.open, rows.WAVE.open
open_sky = SKY.open


@device
def _aim(scene, sky, wave, i, at):
    """Write the ray above what column `i` hit to column `at` of the shadow rays."""
    floats, longs = wave.floats, wave.longs
    origin, direction = row_vec3(floats, rows.ORIGIN, i), row_vec3(floats, rows.DIRECTION, i)
    t, w1, w2 = floats[rows.HIT_T, i], floats[rows.HIT_W1, i], floats[rows.HIT_W2, i]
    hit = Hit(t, w1, w2, longs[rows.HIT_SLOT, i], longs[rows.HIT_INSTANCE, i])
    surface = surface_of(scene, origin, direction, hit, wave.scratch)
    normal = seen_normal(surface, direction)
    normal = normal if dot(direction, normal) < _ZERO else -normal
    tangent, bitangent = orthonormal(normal)
    x, y = to_disk(floats[rows.LIGHT_U, i], floats[rows.LIGHT_V, i])
    into = tangent * x + bitangent * y + normal * math.sqrt(max(_ZERO, _ONE - x * x - y * y))
    set_row_vec3(floats, rows.SHADOW_ORIGIN, at, offset_point(surface.place, surface.normal, surface.error, into))
    set_row_vec3(floats, rows.SHADOW_DIRECTION, at, into)
    floats[rows.SHADOW_END, at] = sky.reach
    wave.ints[rows.SHADOW_OWNER, at] = i
    # Below the true surface, which the shading normal does not know of, nothing is open.
    return np.int64(dot(into, surface.normal) * dot(direction, surface.normal) < _ZERO)


@kernel
def occlusion_tile(scene_words, plan_words, sky_words, film_words, wave_words, x0, x1, y0, y1):
    """How open the sky is above what the pixels x0 ≤ x < x1, y0 ≤ y < y1 show, as greys on the film; 1 where they show
    nothing."""
    scene, plan, sky = open_scene(scene_words), open_plan(plan_words), open_sky(sky_words)
    film, wave = open_film(film_words), open_wave(wave_words)
    tile = Tile(x0, x1, y0, y1)
    begun = np.int64(0)
    count, place = start_paths(scene, plan, film, tile, begun, wave)
    while count > 0:
        if has_holes(scene):
            draw(plan, wave, count, FIRST + _HOLES, rows.PICK_U)
        trace_rays(scene, wave, count, are_neighbours(count, begun, place))
        draw(plan, wave, count, FIRST, rows.LIGHT_U)
        rays = np.int64(0)
        for i in range(count):
            if wave.longs[rows.HIT_SLOT, i] == _NONE:
                add_radiance(wave, i, vec3(_ONE, _ONE, _ONE))
            else:
                rays += _aim(scene, sky, wave, i, rays)
        find_blocked(scene, wave, rays, False)
        for k in range(rays):
            if wave.ints[rows.BLOCKED, k] == 0:
                owner = np.int64(wave.ints[rows.SHADOW_OWNER, k])
                left = share_left(scene, wave, k)
                add_radiance(wave, owner, vec3(left, left, left))
                _bend(sky, wave, np.int64(wave.ints[rows.PLACE, owner]), k, left)
        develop(plan, count, wave, film)
        begun = place
        count, place = start_paths(scene, plan, film, tile, place, wave)


@device
def _bend(sky, wave, pixel, k, left):
    """Add the direction of ray `k`, as far as it is free, to its pixel's."""
    direction = row_vec3(wave.floats, rows.SHADOW_DIRECTION, k) * left
    sky.bent[pixel, 0] += direction.x
    sky.bent[pixel, 1] += direction.y
    sky.bent[pixel, 2] += direction.z
