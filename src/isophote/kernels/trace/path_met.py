"""What a path meets that shines: surfaces, lamps, the sky.

What could have been aimed at too counts by the power heuristic, w = p² / (p² + q²) (Veach, Guibas: "Optimally Combining
Sampling Techniques", 1995).
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.surface import triangle_light
from isophote.kernels.base.jit import device
from isophote.kernels.base.vec import dot, maximum_component, vec3
from isophote.kernels.light.emitter import lamp_radiance, light_density
from isophote.kernels.light.environment import environment_density, environment_radiance
from isophote.kernels.trace import wave as rows
from isophote.kernels.trace.cone import cone_radius
from isophote.kernels.trace.pick import chance_of_light
from isophote.kernels.trace.shading import surface_emission
from isophote.kernels.trace.wave import add_radiance, row_vec3

__all__ = ["add_emitted", "add_lamp", "add_sky"]

_ZERO, _ONE = np.float32(0), np.float32(1)


@device
def _power_weight(p, q):
    """Share of the technique of density `p` beside one of density `q`."""
    return p * p / (p * p + q * q)


@device
def _weight_of_meeting(lights, wave, i, k, scattered, origin, to_light):
    """Share of a scattered ray of density `scattered` that meets light `k`, which could have been aimed at too."""
    if scattered == _ZERO:
        return _ONE
    chance = chance_of_light(lights, wave.ask, k, origin, row_vec3(wave.floats, rows.FROM_NORMAL, i))
    return _power_weight(scattered, chance * light_density(lights, k, origin, to_light))


@device
def _sky(tables, direction, scattered):
    """Radiance of a ray that meets nothing, weighted."""
    environment = tables.lights.environment
    radiance = environment_radiance(environment, direction)
    if environment.height == 0 or scattered == _ZERO:
        return radiance
    # A picture of the sky is always the last light; the constant part is not aimed at by itself.
    k = tables.lights.kinds.rows - 1
    chance = tables.lights.cdf[k + 1] - tables.lights.cdf[k]
    aimed = chance * environment_density(environment, direction)
    return radiance * _power_weight(scattered, aimed)


@device
def _emitted(tables, wave, i, surface, hit, direction, origin, scattered):
    """Radiance that a surface emits along the ray that met it, weighted."""
    radius = cone_radius(wave, i, hit.t)
    emitted, two_sided = surface_emission(tables, surface, hit, direction, radius, wave.scratch)
    if maximum_component(emitted) <= _ZERO:
        return emitted
    if not two_sided and dot(direction, surface.normal) >= _ZERO:
        return vec3(_ZERO, _ZERO, _ZERO)
    k = triangle_light(tables.surfaces, surface.item, surface.triangle)
    if k < 0:
        return emitted
    return emitted * _weight_of_meeting(tables.lights, wave, i, k, scattered, origin, surface.place - origin)


@device
def add_emitted(tables, wave, i, surface, hit, direction, carried):
    """Add what a surface emits along the ray in column `i` that met it, to a path that carries `carried`."""
    origin, scattered = row_vec3(wave.floats, rows.ORIGIN, i), wave.floats[rows.DENSITY, i]
    emitted = _emitted(tables, wave, i, surface, hit, direction, origin, scattered)
    if maximum_component(emitted) > _ZERO:
        add_radiance(wave, np.int64(wave.ints[rows.OWNER, i]), carried * emitted)


@device
def add_lamp(tables, wave, i, carried):
    """Add what a disk or sphere light sends along the ray in column `i` that met it."""
    floats, k = wave.floats, wave.longs[rows.HIT_INSTANCE, i]
    origin, direction = row_vec3(floats, rows.ORIGIN, i), row_vec3(floats, rows.DIRECTION, i)
    to_light = direction * floats[rows.HIT_T, i]
    radiance = lamp_radiance(tables.lights, k, origin + to_light, direction)
    weight = _weight_of_meeting(tables.lights, wave, i, k, floats[rows.DENSITY, i], origin, to_light)
    add_radiance(wave, np.int64(wave.ints[rows.OWNER, i]), carried * radiance * weight)


@device
def add_sky(tables, wave, i, carried):
    """Add the sky's light along the ray in column `i`, which met nothing."""
    sky = _sky(tables, row_vec3(wave.floats, rows.DIRECTION, i), wave.floats[rows.DENSITY, i])
    add_radiance(wave, np.int64(wave.ints[rows.OWNER, i]), carried * sky)
