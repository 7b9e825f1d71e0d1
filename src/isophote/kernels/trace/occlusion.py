"""How open the sky is above points: rays into the hemisphere, counted where they meet nothing.

    V = 1/π ∫ v(ω) cosθ dω        b = ∫ v(ω) ω cosθ dω / |…|        v = 1 where a ray of length `reach` is free

(Zhukov, Iones, Kronin: "An Ambient Light Illumination Model", 1998; b is the bent normal, Landis 2002.)
"""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.accel.bundle import BUNDLE
from isophote.kernels.base.jit import device, kernel
from isophote.kernels.base.sampler import SOBOL, draw_pairs
from isophote.kernels.base.table import DOUBLE_BOXES, FLOAT, FLOAT_ROWS, FLOATS, INT, Table
from isophote.kernels.base.vec import orthonormal, vec3
from isophote.kernels.base.warp import to_disk
from isophote.kernels.trace import wave as rows
from isophote.kernels.trace.batch import find_blocked, find_blocked_otherwise
from isophote.kernels.trace.bundles import blocked_in_bundles, in_bundles
from isophote.kernels.trace.holes import share_left
from isophote.kernels.trace.tables import SCENE
from isophote.kernels.trace.wave import row_vec3, set_row_vec3

__all__ = ["COSINE", "GIVEN", "OPENINGS", "UNIFORM", "find_openings"]

# How directions are found: by chance in proportion to the cosine, by chance evenly over the hemisphere, or as given.
COSINE, UNIFORM, GIVEN = 0, 1, 2

# `points`, `normals` (n, 3); `bias` (n,): how far rays start above the points. `samples` rays of length `reach` for
# each. `directions` (samples, 4), where they are given: around +z, with the weight of each. `open` (n, 4): sums of
# weights of the free rays, and of their directions times weight.
OPENINGS = Table(
    "Openings",
    points=FLOAT_ROWS,
    normals=FLOAT_ROWS,
    bias=FLOATS,
    samples=INT,
    seed=INT,
    warp=INT,
    reach=FLOAT,
    directions=FLOAT_ROWS,
    open=DOUBLE_BOXES,
)

# So few rays of a point go by themselves.
_FEWEST = np.int64(8)
_ZERO, _ONE, _TWO = np.float32(0), np.float32(1), np.float32(2)
_DIMENSION = np.int64(0)
_SOBOL = np.int64(SOBOL)

open_scene, open_openings, open_wave = SCENE.open, OPENINGS.open, rows.WAVE.open


@device
def _number(openings, wave, first, count):
    """Point and sample of each column, from ray number `first` on."""
    ints = wave.ints
    point = first // openings.samples
    sample = first - point * openings.samples
    for i in range(count):
        ints[rows.PIXEL, i], ints[rows.SAMPLE, i] = point, sample
        # Counting on: divisions would take a tenth of the time of all else.
        sample += 1
        if sample == openings.samples:
            point, sample = point + 1, np.int64(0)


@device
def _local_direction(openings, wave, i):
    """(direction around +z, weight) of column `i`."""
    if openings.warp == GIVEN:
        k = np.int64(wave.ints[rows.SAMPLE, i])
        row = openings.directions
        return vec3(row[k, 0], row[k, 1], row[k, 2]), row[k, 3]
    x, y = to_disk(wave.floats[rows.LIGHT_U, i], wave.floats[rows.LIGHT_V, i])
    square = x * x + y * y
    if openings.warp == UNIFORM:
        # A ring of the disk becomes a ring of the hemisphere of as large a share (Shirley, Chiu 1997).
        wide = math.sqrt(max(_ZERO, _TWO - square))
        return vec3(x * wide, y * wide, _ONE - square), _ONE
    return vec3(x, y, math.sqrt(max(_ZERO, _ONE - square))), _ONE


@device
def _aim(openings, wave, count):
    """The ray of each column, and the weight of its sample."""
    floats = wave.floats
    if openings.warp != GIVEN:
        pixels, samples = wave.ints[rows.PIXEL], wave.ints[rows.SAMPLE]
        u, v = floats[rows.LIGHT_U], floats[rows.LIGHT_V]
        draw_pairs(_SOBOL, openings.seed, pixels, samples, openings.samples, _DIMENSION, count, u, v)
    last = np.int64(-1)
    normal = vec3(_ZERO, _ZERO, _ONE)
    start, tangent, bitangent = normal, normal, normal
    for i in range(count):
        k = np.int64(wave.ints[rows.PIXEL, i])
        if k != last:
            last, normal = k, _row(openings.normals, k)
            tangent, bitangent = orthonormal(normal)
            start = _row(openings.points, k) + normal * openings.bias[k]
        local, weight = _local_direction(openings, wave, i)
        direction = tangent * local.x + bitangent * local.y + normal * local.z
        set_row_vec3(floats, rows.SHADOW_ORIGIN, i, start)
        set_row_vec3(floats, rows.SHADOW_DIRECTION, i, direction)
        floats[rows.SHADOW_END, i] = openings.reach
        floats[rows.DENSITY, i] = weight


@device
def _row(values, k):
    """Row `k` of (n, 3) values."""
    return vec3(values[k, 0], values[k, 1], values[k, 2])


@kernel
def find_openings(scene_words, opening_words, wave_words, first_point, last_point):
    """Trace the rays of points first_point ≤ k < last_point and add up the free ones."""
    scene, openings, wave = open_scene(scene_words), open_openings(opening_words), open_wave(wave_words)
    size, sums = wave.floats.columns // BUNDLE * BUNDLE, openings.open
    last = last_point * openings.samples
    for first in range(first_point * openings.samples, last, size):
        count = min(size, last - first)
        _number(openings, wave, first, count)
        _aim(openings, wave, count)
        if openings.samples >= _FEWEST and in_bundles(scene.geometry):
            blocked_in_bundles(scene.geometry, openings, wave, count)
            find_blocked_otherwise(scene, wave, count)
        else:
            find_blocked(scene, wave, count, openings.warp == GIVEN)
        for i in range(count):
            if wave.ints[rows.BLOCKED, i] == 0:
                k = np.int64(wave.ints[rows.PIXEL, i])
                weight = np.float64(wave.floats[rows.DENSITY, i] * share_left(scene, wave, i))
                direction = row_vec3(wave.floats, rows.SHADOW_DIRECTION, i)
                sums[k, 0] += weight
                sums[k, 1] += weight * direction.x
                sums[k, 2] += weight * direction.y
                sums[k, 3] += weight * direction.z
