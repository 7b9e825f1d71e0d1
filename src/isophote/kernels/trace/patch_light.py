"""Light that patches get from what is no patch: points, suns, spots, disks, spheres and the sky."""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.base.double3 import row3
from isophote.kernels.base.jit import device, kernel
from isophote.kernels.base.sampler import SOBOL, pair
from isophote.kernels.base.vec import dot, orthonormal, vec3
from isophote.kernels.base.warp import PI, to_disk
from isophote.kernels.light.emitter import PARALLELOGRAM, TRIANGLE, sample_light
from isophote.kernels.light.environment import environment_radiance
from isophote.kernels.light.form_factor import on_patch
from isophote.kernels.trace import wave as rows
from isophote.kernels.trace.batch import find_blocked
from isophote.kernels.trace.exchange import PATCHES
from isophote.kernels.trace.holes import share_left
from isophote.kernels.trace.tables import SCENE
from isophote.kernels.trace.wave import row_vec3, set_row_vec3

__all__ = ["PLACES", "direct_light"]

# Places of a patch, each with a ray to every light, and so many into the sky at least.
_GRID, _SKY_RAYS = 4, 128
PLACES = _GRID * _GRID
# Steps of a lattice over the square, 1 / φ and 1 / φ² with φ³ = φ + 1: edges of shadows run along no row of it.
_STEP_U, _STEP_V = 0.7548776662466927, 0.5698402909980532
_ZERO, _ONE = np.float32(0), np.float32(1)
_FAR, _SHADOW_END = np.float32(np.inf), np.float32(1 - 1e-4)
_SOBOL, _DIMENSION = np.int64(SOBOL), np.int64(0)

open_scene, open_patches, open_wave = SCENE.open, PATCHES.open, rows.WAVE.open


@device
def _place(i, count):
    """Place number i of `count` on the unit square: the cells of a grid, or a lattice where there are more."""
    if count == PLACES:
        return (i % _GRID + 0.5) / _GRID, (i // _GRID + 0.5) / _GRID
    u, v = 0.5 + i * _STEP_U, 0.5 + i * _STEP_V
    return u - math.floor(u), v - math.floor(v)


@device
def _is_open(patches, node, i, count):
    """Whether place number i of a patch lies within no solid."""
    u, v = _place(i, count)
    return (patches.covered[node] >> (np.int64(u * _GRID) + _GRID * np.int64(v * _GRID))) & 1 == 0


@device
def _start(patches, node, i, count):
    """Place number i of a patch, above it."""
    u, v = _place(i, count)
    place = on_patch(patches.corners, patches.sides, node, u, v)
    normal = row3(patches.normals, node)
    return vec3(
        np.float32(place.x + patches.bias * normal.x),
        np.float32(place.y + patches.bias * normal.y),
        np.float32(place.z + patches.bias * normal.z),
    )


@device
def _normal(patches, node):
    normal = row3(patches.normals, node)
    return vec3(np.float32(normal.x), np.float32(normal.y), np.float32(normal.z))


@device
def _aim_at(lights, patches, wave, node, k, block, count):
    """Rays from sixteen of the places of a patch to light k, with the irradiance that each would bring."""
    floats, normal = wave.floats, _normal(patches, node)
    for i in range(PLACES):
        start = _start(patches, node, block + i, count)
        u, v = pair(_SOBOL, k, node, block + i, count, _DIMENSION)
        sample = sample_light(lights, k, start, u, v)
        direction = vec3(sample.x, sample.y, sample.z)
        cosine = dot(normal, direction)
        far = sample.distance == _FAR
        weight = _ZERO
        if cosine > _ZERO and sample.density >= _ZERO:
            weight = cosine / sample.density if sample.density > _ZERO else cosine
        set_row_vec3(floats, rows.SHADOW_ORIGIN, i, start)
        set_row_vec3(floats, rows.SHADOW_DIRECTION, i, direction if far else direction * sample.distance)
        set_row_vec3(floats, rows.SHADOW_LIGHT, i, vec3(sample.red, sample.green, sample.blue) * weight)
        floats[rows.SHADOW_END, i] = _FAR if far else _SHADOW_END


@device
def _aim_up(scene, patches, wave, node, turn, turns, block, count):
    """Rays from sixteen of the places of a patch into the sky, in proportion to the cosine."""
    floats, normal = wave.floats, _normal(patches, node)
    tangent, bitangent = orthonormal(normal)
    for i in range(PLACES):
        u, v = pair(_SOBOL, _DIMENSION, node, turn * count + block + i, count * turns, _DIMENSION)
        x, y = to_disk(u, v)
        into = tangent * x + bitangent * y + normal * math.sqrt(max(_ZERO, _ONE - x * x - y * y))
        set_row_vec3(floats, rows.SHADOW_ORIGIN, i, _start(patches, node, block + i, count))
        set_row_vec3(floats, rows.SHADOW_DIRECTION, i, into)
        light = environment_radiance(scene.lights.environment, into) * (PI / np.float32(turns))
        set_row_vec3(floats, rows.SHADOW_LIGHT, i, light)
        floats[rows.SHADOW_END, i] = _FAR


@device
def _collect(scene, wave, at_places):
    """Add the light of the rays that nothing blocks to the places' rows."""
    find_blocked(scene, wave, PLACES, True)
    for i in range(PLACES):
        if wave.ints[rows.BLOCKED, i] == 0:
            light = row_vec3(wave.floats, rows.SHADOW_LIGHT, i) * share_left(scene, wave, i)
            at_places[i, 0] += light.x
            at_places[i, 1] += light.y
            at_places[i, 2] += light.z


@device
def _gather(scene, patches, wave, node, has_sky, block, count, at_places):
    """The light of sixteen of the places of a patch, into `at_places`."""
    lights = scene.lights
    at_places[:] = 0.0
    # A picture of the sky is always the last light, and found by the cosine here.
    for k in range(lights.kinds.rows - (1 if lights.environment.height > 0 else 0)):
        kind = lights.kinds[k]
        if kind != TRIANGLE and kind != PARALLELOGRAM:
            _aim_at(lights, patches, wave, node, k, block, count)
            _collect(scene, wave, at_places)
    if has_sky:
        turns = max(np.int64(1), _SKY_RAYS // count)
        for turn in range(turns):
            _aim_up(scene, patches, wave, node, turn, turns, block, count)
            _collect(scene, wave, at_places)


@kernel
def direct_light(scene_words, patch_words, wave_words, nodes, has_sky, count, at_places, found, first, last):
    """Irradiance of patches nodes[first ≤ i < last] from lights that are no meshes, by `count` places of each, a
    multiple of 16: its mean over what lies within no solid, the difference between the brightest and the darkest place,
    and the brightest, into the rows of `found` (n, 5); `at_places` (16, 3) is scratch.
    """
    scene, patches, wave = open_scene(scene_words), open_patches(patch_words), open_wave(wave_words)
    for i in range(first, last):
        node = np.int64(nodes[i])
        least, most, opened = math.inf, 0.0, 0
        red, green, blue = 0.0, 0.0, 0.0
        for block in range(0, count, PLACES):
            _gather(scene, patches, wave, node, has_sky, block, count, at_places)
            for place in range(PLACES):
                if not _is_open(patches, node, block + place, count):
                    continue
                opened += 1
                red, green, blue = red + at_places[place, 0], green + at_places[place, 1], blue + at_places[place, 2]
                level = (at_places[place, 0] + at_places[place, 1] + at_places[place, 2]) / 3
                least, most = min(least, level), max(most, level)
        if opened > 0:
            found[i, 0], found[i, 1], found[i, 2] = red / opened, green / opened, blue / opened
            found[i, 3], found[i, 4] = most - least, most
