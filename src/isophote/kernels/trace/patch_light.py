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

__all__ = ["direct_light"]

# Places of a patch, each with a ray to every light, and with so many into the sky.
_GRID, _SKY_RAYS = 4, 8
_PLACES = _GRID * _GRID
_ZERO, _ONE = np.float32(0), np.float32(1)
_FAR, _SHADOW_END = np.float32(np.inf), np.float32(1 - 1e-4)
_SOBOL, _DIMENSION = np.int64(SOBOL), np.int64(0)

open_scene, open_patches, open_wave = SCENE.open, PATCHES.open, rows.WAVE.open


@device
def _start(patches, node, i):
    """Place number i of a patch, above it."""
    place = on_patch(patches.corners, patches.sides, node, (i % _GRID + 0.5) / _GRID, (i // _GRID + 0.5) / _GRID)
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
def _aim_at(lights, patches, wave, node, k):
    """Rays from the places of a patch to light k, with the irradiance that each would bring."""
    floats, normal = wave.floats, _normal(patches, node)
    for i in range(_PLACES):
        start = _start(patches, node, i)
        u, v = pair(_SOBOL, k, node, i, _PLACES, _DIMENSION)
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
def _aim_up(scene, patches, wave, node, turn):
    """Rays from the places of a patch into the sky, in proportion to the cosine."""
    floats, normal = wave.floats, _normal(patches, node)
    tangent, bitangent = orthonormal(normal)
    for i in range(_PLACES):
        u, v = pair(_SOBOL, _DIMENSION, node, turn * _PLACES + i, _PLACES * _SKY_RAYS, _DIMENSION)
        x, y = to_disk(u, v)
        into = tangent * x + bitangent * y + normal * math.sqrt(max(_ZERO, _ONE - x * x - y * y))
        set_row_vec3(floats, rows.SHADOW_ORIGIN, i, _start(patches, node, i))
        set_row_vec3(floats, rows.SHADOW_DIRECTION, i, into)
        light = environment_radiance(scene.lights.environment, into) * (PI / np.float32(_SKY_RAYS))
        set_row_vec3(floats, rows.SHADOW_LIGHT, i, light)
        floats[rows.SHADOW_END, i] = _FAR


@device
def _collect(scene, wave, at_places):
    """Add the light of the rays that nothing blocks to the places' rows."""
    find_blocked(scene, wave, _PLACES, True)
    for i in range(_PLACES):
        if wave.ints[rows.BLOCKED, i] == 0:
            light = row_vec3(wave.floats, rows.SHADOW_LIGHT, i) * share_left(scene, wave, i)
            at_places[i, 0] += light.x
            at_places[i, 1] += light.y
            at_places[i, 2] += light.z


@kernel
def direct_light(scene_words, patch_words, wave_words, nodes, has_sky, at_places, found, first, last):
    """Irradiance of patches nodes[first ≤ i < last] from lights that are no meshes: its mean, and the difference
    between the brightest and the darkest of 16 places, into the rows of `found` (n, 4); `at_places` (16, 3) is scratch.
    """
    scene, patches, wave = open_scene(scene_words), open_patches(patch_words), open_wave(wave_words)
    lights = scene.lights
    # A picture of the sky is always the last light, and found by the cosine here.
    count = lights.kinds.rows - (1 if lights.environment.height > 0 else 0)
    for i in range(first, last):
        node = np.int64(nodes[i])
        at_places[:] = 0.0
        for k in range(count):
            kind = lights.kinds[k]
            if kind != TRIANGLE and kind != PARALLELOGRAM:
                _aim_at(lights, patches, wave, node, k)
                _collect(scene, wave, at_places)
        if has_sky:
            for turn in range(_SKY_RAYS):
                _aim_up(scene, patches, wave, node, turn)
                _collect(scene, wave, at_places)
        least, most = math.inf, 0.0
        for k in range(3):
            found[i, k] = 0.0
        for place in range(_PLACES):
            level = 0.0
            for k in range(3):
                found[i, k] += at_places[place, k] / _PLACES
                level += at_places[place, k] / 3
            least, most = min(least, level), max(most, level)
        found[i, 3] = most - least
