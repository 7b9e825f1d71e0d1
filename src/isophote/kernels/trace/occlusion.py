"""How open the sky is above points: rays into the hemisphere, counted where they meet nothing.

    V = 1/π ∫ v(ω) cosθ dω        b = ∫ v(ω) ω cosθ dω / |…|        v = 1 where a ray of length `reach` is free

(Zhukov, Iones, Kronin: "An Ambient Light Illumination Model", 1998; b is the bent normal, Landis 2002.)
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.bundle_rays import BUNDLE
from isophote.kernels.base.jit import device, kernel
from isophote.kernels.trace import wave as rows
from isophote.kernels.trace.batch import find_blocked, find_blocked_otherwise
from isophote.kernels.trace.bundles import blocked_in_bundles, in_bundles
from isophote.kernels.trace.holes import share_left
from isophote.kernels.trace.openings import COSINE, GIVEN, OPENINGS, UNIFORM, aim, draw_around_z, lifted, normal_of
from isophote.kernels.trace.tables import SCENE
from isophote.kernels.trace.wave import row_vec3

__all__ = ["COSINE", "GIVEN", "OPENINGS", "UNIFORM", "find_openings"]

# So few rays of a point go by themselves.
_FEWEST = np.int64(8)
_ZERO = np.float64(0)

open_scene, open_openings, open_wave = SCENE.open, OPENINGS.open, rows.WAVE.open


@device
def _end_of_point(openings, begun, i, count):
    """(point of column `i`, the first column of another point), where column 0 is ray number `begun`."""
    k = (begun + i) // openings.samples
    return k, min(count, (k + 1) * openings.samples - begun)


@device
def _add_up(scene, openings, wave, k, first, last):
    """Add the free rays of columns first ≤ i < last, all of point `k`."""
    whole, x, y, z = _ZERO, _ZERO, _ZERO, _ZERO
    for i in range(first, last):
        if wave.ints[rows.BLOCKED, i] == 0:
            weight = np.float64(wave.floats[rows.DENSITY, i] * share_left(scene, wave, i))
            direction = row_vec3(wave.floats, rows.SHADOW_DIRECTION, i)
            whole += weight
            x += weight * direction.x
            y += weight * direction.y
            z += weight * direction.z
    sums = openings.open
    sums[k, 0] += whole
    sums[k, 1] += x
    sums[k, 2] += y
    sums[k, 3] += z


@device
def _find_blocked_in_bundles(scene, openings, wave, begun, count):
    first = np.int64(0)
    while first < count:
        k, last = _end_of_point(openings, begun, first, count)
        start, normal = lifted(openings, k), normal_of(openings, k)
        blocked_in_bundles(scene.geometry, wave, start, normal, openings.reach, first, last)
        first = last
    find_blocked_otherwise(scene, wave, count)


@kernel
def find_openings(scene_words, opening_words, wave_words, first_point, last_point):
    """Trace the rays of points first_point ≤ k < last_point and add up the free ones."""
    scene, openings, wave = open_scene(scene_words), open_openings(opening_words), open_wave(wave_words)
    size = wave.floats.columns // BUNDLE * BUNDLE
    bundled = openings.samples >= _FEWEST and in_bundles(scene.geometry)
    end = last_point * openings.samples
    for begun in range(first_point * openings.samples, end, size):
        count = min(size, end - begun)
        draw_around_z(openings, wave, begun, count)
        first = np.int64(0)
        while first < count:
            k, last = _end_of_point(openings, begun, first, count)
            aim(openings, wave, k, first, last)
            first = last
        if bundled:
            _find_blocked_in_bundles(scene, openings, wave, begun, count)
        else:
            find_blocked(scene, wave, count, openings.warp == GIVEN)
        first = np.int64(0)
        while first < count:
            k, last = _end_of_point(openings, begun, first, count)
            _add_up(scene, openings, wave, k, first, last)
            first = last
