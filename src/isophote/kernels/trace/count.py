"""What rays visit on their way to what they meet first."""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.contract import DEPTH, NODES, PRIMITIVES, RAY_WORDS, clear_counts
from isophote.kernels.accel.geometry import RAY, Hit, closest_hit
from isophote.kernels.base.entry import element_address, floats_at
from isophote.kernels.base.jit import device, kernel
from isophote.kernels.base.simd import load_int, store_int
from isophote.kernels.base.vec import vec3
from isophote.kernels.trace import wave as rows
from isophote.kernels.trace.camera import camera_ray
from isophote.kernels.trace.direct import closest_direct
from isophote.kernels.trace.rays import first_fault, open_query
from isophote.kernels.trace.tables import SCENE

__all__ = ["count_pixels", "count_rays"]

_MIDDLE, _FAR = np.float32(0.5), np.float32(np.inf)
_ZERO = np.float32(0)

open_scene, open_wave = SCENE.open, rows.WAVE.open


@device
def _asked_always(scene):
    """Primitives and fields that every ray asks: no accelerator holds them."""
    boxes = scene.fields.boxes.things != 0
    return np.int64(scene.primitives.alone.rows) + (np.int64(0) if boxes else np.int64(scene.fields.numbers.rows))


@device
def _count(scene, origin, direction, limit, scratch, counts, i):
    ray = floats_at(element_address(scratch, RAY), RAY_WORDS)
    clear_counts(ray)
    store_int(ray, PRIMITIVES, np.int32(_asked_always(scene)))
    hit = Hit(limit, _ZERO, _ZERO, np.int64(-1), np.int64(0))
    if scene.geometry.blocks.rows > 0:
        hit = closest_hit(scene.geometry, origin, direction, limit, scratch)
    closest_direct(scene, origin, direction, hit, scratch)
    counts[0, i], counts[1, i], counts[2, i] = load_int(ray, NODES), load_int(ray, PRIMITIVES), load_int(ray, DEPTH)


@kernel
def count_rays(scene_words, query_words, wave_words, counts, first, last):
    """Nodes visited, triangles (and primitives, and fields) tested and deepest level of rays first ≤ i < last into rows
    0 to 2 of `counts`, (3, n) int32, over a scene whose accelerators are all entries; `query` gives origins, directions
    and limits. Returns as closest_rays does."""
    scene, query, wave = open_scene(scene_words), open_query(query_words), open_wave(wave_words)
    fault = first_fault(query, first, last)
    if fault[0] != 0:
        return fault
    o, d = query.origins, query.directions
    for i in range(first, last):
        origin, direction = vec3(o[i, 0], o[i, 1], o[i, 2]), vec3(d[i, 0], d[i, 1], d[i, 2])
        _count(scene, origin, direction, query.limit[i], wave.scratch, counts, i)
    return fault


@kernel
def count_pixels(scene_words, wave_words, counts, width, first, last):
    """As count_rays, of the camera's rays through the middles of the pixels first ≤ i < last, counted row by row."""
    scene, wave = open_scene(scene_words), open_wave(wave_words)
    for i in range(first, last):
        x, y = np.float32(i % width) + _MIDDLE, np.float32(i // width) + _MIDDLE
        origin, direction = camera_ray(scene.camera, x, y, _ZERO, _ZERO)
        _count(scene, origin, direction, _FAR, wave.scratch, counts, i)
