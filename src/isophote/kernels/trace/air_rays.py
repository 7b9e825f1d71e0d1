"""Air that scatters light, in path tracing: free flights, aiming at lights from where they end, and shadows.

How far a ray flies is drawn from exp(−σs d) of one channel, as if that were picked once for the whole path, and weighed
by the mean of what all three would have had for densities of the path so far (Wilkie et al., "Hero Wavelength Spectral
Sampling", EGSR 2014). Their shares in that mean, by which the channel is picked, are kept in the column in which the
path began. What is absorbed on the way is a factor. Lights are aimed at and met as from surfaces (path.py),
with the phase function in the place of reflection.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.entry import entry, opener_at
from isophote.kernels.base.jit import device
from isophote.kernels.base.vec import dot, length, maximum_component, vec3
from isophote.kernels.light.air import (
    free_flight,
    left_of_light,
    phase,
    phase_direction,
    reached,
    scattered_at,
    way_through_air,
)
from isophote.kernels.light.emitter import sample_light
from isophote.kernels.light.medium import current_medium
from isophote.kernels.trace import wave as rows
from isophote.kernels.trace.air import SCATTERED
from isophote.kernels.trace.batch import LAMP
from isophote.kernels.trace.pick import pick_for
from isophote.kernels.trace.samples import draw
from isophote.kernels.trace.tables import PLAN, SCENE
from isophote.kernels.trace.wave import row_vec3, set_row_vec3

__all__ = ["dim_shadows", "scatter"]

_ZERO, _ONE, _THIRD = np.float32(0), np.float32(1), np.float32(1 / 3)
_FAR = np.float32(np.inf)
# A shadow ray ends this much short of its light, as in path.py.
_SHADOW_END = np.float32(1 - 1e-4)
# The sampling dimensions of flights, beyond those of paths and holes.
_FLIGHT = np.int64(2**21)

_scene_at, _plan_at, _wave_at = opener_at(SCENE), opener_at(PLAN), opener_at(rows.WAVE)


@device
def _aim(tables, wave, i, at, place, direction, carried):
    """Aim at a light from a place in the air; the shadow ray goes to wave column `at`. Returns how many were made."""
    floats, lights = wave.floats, tables.lights
    if lights.kinds.rows == 0:
        return np.int64(0)
    k, chance = pick_for(lights, wave.ask, place, vec3(_ZERO, _ZERO, _ZERO), floats[rows.PICK_U, i])
    if k < 0:
        return np.int64(0)
    sample = sample_light(lights, k, place, floats[rows.LIGHT_U, i], floats[rows.LIGHT_V, i])
    towards = vec3(sample.x, sample.y, sample.z)
    q = phase(tables.media.air, dot(direction, towards))
    p = chance * sample.density
    weight = p / (p * p + q * q) if p > _ZERO else _ONE / chance
    light = carried * vec3(sample.red, sample.green, sample.blue) * (weight * q)
    far = sample.distance == _FAR
    set_row_vec3(floats, rows.SHADOW_ORIGIN, at, place)
    set_row_vec3(floats, rows.SHADOW_DIRECTION, at, towards if far else towards * sample.distance)
    set_row_vec3(floats, rows.SHADOW_LIGHT, at, light)
    floats[rows.SHADOW_END, at] = _FAR if far else _SHADOW_END
    wave.ints[rows.SHADOW_OWNER, at] = wave.ints[rows.OWNER, i]
    wave.ints[rows.SHADOW_MEDIUM, at] = np.uint32(0)
    return np.int64((sample.density >= _ZERO) & (maximum_component(light) > _ZERO))


@device
def _weighed(wave, owner, densities, carried):
    """What a path carries over the mean of the channels' densities; the shares are those that make it 1."""
    mean = _THIRD * (densities.x + densities.y + densities.z)
    factor = _ONE / mean if mean > _ZERO else _ZERO
    set_row_vec3(wave.floats, rows.SHARES, owner, densities * factor)
    return carried * factor


@device
def _fly(tables, plan, wave, i, at, depth):
    """Fly with the ray in column `i` to where it meets something or is scattered. Returns how many shadow rays were
    made."""
    floats, air = wave.floats, tables.media.air
    origin, direction = row_vec3(floats, rows.ORIGIN, i), row_vec3(floats, rows.DIRECTION, i)
    near, far = way_through_air(air, origin, direction, floats[rows.HIT_T, i])
    if far <= near:
        return np.int64(0)
    carried, owner = row_vec3(floats, rows.CARRIED, i), np.int64(wave.ints[rows.OWNER, i])
    shares = row_vec3(floats, rows.SHARES, owner)
    flight = free_flight(air, shares, floats[rows.FLIGHT_U, i], floats[rows.FLIGHT_V, i])
    if near + flight >= far:
        carried = carried * left_of_light(air, far - near)
        set_row_vec3(floats, rows.CARRIED, i, _weighed(wave, owner, reached(air, shares, far - near), carried))
        return np.int64(0)
    scattering = vec3(air.scattering[0], air.scattering[1], air.scattering[2])
    carried = carried * scattering * left_of_light(air, flight)
    carried = _weighed(wave, owner, scattered_at(air, shares, flight), carried)
    place = origin + direction * (near + flight)
    made = np.int64(0)
    if depth < plan.max_depth:
        made = _aim(tables, wave, i, at, place, direction, carried)
    into, q = phase_direction(air, direction, floats[rows.SCATTER_U, i], floats[rows.SCATTER_V, i])
    set_row_vec3(floats, rows.ORIGIN, i, place)
    set_row_vec3(floats, rows.DIRECTION, i, into)
    set_row_vec3(floats, rows.CARRIED, i, carried)
    floats[rows.DENSITY, i] = q
    wave.longs[rows.HIT_SLOT, i], wave.longs[rows.HIT_INSTANCE, i] = LAMP, SCATTERED
    return made


@entry
def scatter(scene_address, plan_address, wave_address, count, depth):
    """Scatter the rays of a wave in the air. Returns the number of shadow rays that were made."""
    tables, plan, wave = _scene_at(scene_address), _plan_at(plan_address), _wave_at(wave_address)
    draw(plan, wave, count, _FLIGHT + depth, rows.FLIGHT_U)
    shadows = np.int64(0)
    if depth == 1:
        for i in range(count):
            set_row_vec3(wave.floats, rows.SHARES, i, vec3(_ONE, _ONE, _ONE))
    for i in range(count):
        if current_medium(tables.media, wave.longs[rows.INSIDE, i]) == 0:
            shadows += _fly(tables, plan, wave, i, shadows, depth)
    return shadows


@entry
def dim_shadows(scene_address, wave_address, count):
    """Take from the light of shadow rays through the air what that does."""
    tables, wave = _scene_at(scene_address), _wave_at(wave_address)
    floats, air = wave.floats, tables.media.air
    for i in range(count):
        if wave.ints[rows.SHADOW_MEDIUM, i] != 0:
            continue
        way = row_vec3(floats, rows.SHADOW_DIRECTION, i)
        size = length(way)
        end = _FAR if floats[rows.SHADOW_END, i] == _FAR else size
        near, far = way_through_air(air, row_vec3(floats, rows.SHADOW_ORIGIN, i), way * (_ONE / size), end)
        if far > near:
            light = row_vec3(floats, rows.SHADOW_LIGHT, i)
            set_row_vec3(floats, rows.SHADOW_LIGHT, i, light * left_of_light(air, far - near))
    return np.int64(0)
