"""The tree's queries over arrays of rays."""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.geometry import Hit, closest_hit, occluded
from isophote.kernels.accel.layout import PACKET
from isophote.kernels.accel.surface import (
    FIRST_TRIANGLE,
    PUBLIC,
    face_number,
    item_of,
    triangle_number,
    true_normal,
)
from isophote.kernels.base.jit import device, kernel
from isophote.kernels.base.simd import absolute, bits, load16, maximum, splat16
from isophote.kernels.base.simd_rows import load_triples
from isophote.kernels.base.table import BYTES, FLOAT_ROWS, FLOATS, INTS, Table
from isophote.kernels.base.vec import vec3
from isophote.kernels.trace import wave as rows
from isophote.kernels.trace.batch import (
    blocked_in_packets,
    closest_direct_of_wave,
    closest_in_packets,
    find_blocked_directly,
    in_packets,
)
from isophote.kernels.trace.direct import direct_item, direct_part, has_direct, surface_of
from isophote.kernels.trace.tables import SCENE

__all__ = [
    "QUERY",
    "closest_rays",
    "describe_hits",
    "first_fault",
    "occluded_rays",
    "open_query",
    "open_scene",
    "open_wave",
]

# Rays and what is found, one row each: `limit` is the largest distance in lengths of the direction; `slot` and
# `instance` (−1: none) name the triangle for later questions.
QUERY = Table(
    "Query",
    origins=FLOAT_ROWS,
    directions=FLOAT_ROWS,
    limit=FLOATS,
    distance=FLOATS,
    uv=FLOAT_ROWS,
    item=INTS,
    primitive=INTS,
    slot=INTS,
    instance=INTS,
    blocked=BYTES,
)

_ZERO = np.float32(0)
# Beside the least component that boxes are tested with (bvh.py) shorter directions would be turned noticeably.
_SHORTEST = np.float32(1e-8)
_FAR, _NONE = np.float32(np.inf), np.int64(-1)
_ALL = np.int32(0xFFFF)

open_scene, open_query, open_wave = SCENE.open, QUERY.open, rows.WAVE.open


@device
def _sound(o, d, limit, first):
    """Whether sixteen rays from number `first` on make sense."""
    x, y, z = load_triples(o, first)
    u, v, w = load_triples(d, first)
    most = load16(limit, first)
    # x − x is 0 for finite x only.
    finite = ((x - x) + (y - y)) + ((z - z) + (u - u)) + ((v - v) + (w - w)) == splat16(_ZERO)
    long = maximum(absolute(u), maximum(absolute(v), absolute(w))) >= splat16(_SHORTEST)
    return bits(finite & long & (most == most)) == _ALL


@device
def first_fault(query, first, last):
    """(kind, number) of the first ray that makes no sense: kind 1 an origin or 2 a direction that is not finite, 3 a
    direction that is zero or too short, 4 a limit that is NaN, 0 for none."""
    o, d, limit = query.origins, query.directions, query.limit
    start = first
    while start + PACKET <= last and _sound(o, d, limit, start):
        start += PACKET
    for i in range(start, last):
        if (o[i, 0] - o[i, 0]) + (o[i, 1] - o[i, 1]) + (o[i, 2] - o[i, 2]) != 0:
            return 1, i
        if (d[i, 0] - d[i, 0]) + (d[i, 1] - d[i, 1]) + (d[i, 2] - d[i, 2]) != 0:
            return 2, i
        if max(abs(d[i, 0]), max(abs(d[i, 1]), abs(d[i, 2]))) < _SHORTEST:
            return 3, i
        if limit[i] != limit[i]:
            return 4, i
    return 0, 0


@device
def _load(query, wave, first, count, origin_row, limit_row):
    floats = wave.floats
    for i in range(count):
        for k in range(3):
            floats[origin_row + k, i] = query.origins[first + i, k]
            floats[origin_row + 3 + k, i] = query.directions[first + i, k]
        floats[limit_row, i] = query.limit[first + i]


@device
def _write(scene, query, i, hit):
    number = triangle_number(scene.geometry, hit.slot)
    item = item_of(scene.surfaces, hit.instance, number)
    query.distance[i] = hit.t
    query.uv[i, 0] = hit.weight1
    query.uv[i, 1] = hit.weight2
    query.item[i] = scene.surfaces.items[item, PUBLIC]
    triangle = number - scene.surfaces.items[item, FIRST_TRIANGLE]
    query.primitive[i] = face_number(scene.surfaces, item, triangle)
    query.slot[i] = hit.slot
    query.instance[i] = hit.instance


@device
def _write_miss(query, i):
    query.distance[i] = _FAR
    query.uv[i, 0] = query.uv[i, 1] = _ZERO
    query.item[i] = query.primitive[i] = query.slot[i] = query.instance[i] = -1


@device
def _row(values, i):
    return vec3(values[i, 0], values[i, 1], values[i, 2])


@device
def _closest_one_by_one(scene, query, wave, first, last):
    for i in range(first, last):
        origin, direction = _row(query.origins, i), _row(query.directions, i)
        hit = closest_hit(scene.geometry, origin, direction, query.limit[i], wave.scratch)
        if hit.slot < 0:
            _write_miss(query, i)
        else:
            _write(scene, query, i, hit)


@device
def _closest_in_packets(scene, query, wave, first, last):
    floats, longs = wave.floats, wave.longs
    size = floats.columns
    for start in range(first, last, size):
        count = min(size, last - start)
        _load(query, wave, start, count, rows.ORIGIN, rows.HIT_T)
        closest_in_packets(scene.geometry, wave, count)
        for i in range(count):
            slot = longs[rows.HIT_SLOT, i]
            if slot < 0:
                _write_miss(query, start + i)
            else:
                w1, w2 = floats[rows.HIT_W1, i], floats[rows.HIT_W2, i]
                _write(scene, query, start + i, Hit(floats[rows.HIT_T, i], w1, w2, slot, np.int64(0)))


@device
def _closest_direct(scene, query, wave, first, last):
    """Primitives and fields that lie before what rays first ≤ i < last have met so far; where there are no triangles,
    nothing was written of the rays before."""
    floats, longs = wave.floats, wave.longs
    size, fresh = floats.columns, scene.geometry.blocks.rows == 0
    for start in range(first, last, size):
        count = min(size, last - start)
        _load(query, wave, start, count, rows.ORIGIN, rows.HIT_T)
        for i in range(count):
            longs[rows.HIT_SLOT, i] = _NONE
            if not fresh and query.slot[start + i] != _NONE:
                floats[rows.HIT_T, i] = query.distance[start + i]
        closest_direct_of_wave(scene, wave, count)
        for i in range(count):
            slot, instance = longs[rows.HIT_SLOT, i], longs[rows.HIT_INSTANCE, i]
            if slot != _NONE:
                _write_direct(scene, query, start + i, Hit(floats[rows.HIT_T, i], _ZERO, _ZERO, slot, instance))
            elif fresh:
                _write_miss(query, start + i)


@device
def _write_direct(scene, query, i, hit):
    query.distance[i] = hit.t
    query.uv[i, 0] = query.uv[i, 1] = _ZERO
    query.item[i] = scene.surfaces.items[direct_item(scene, hit), PUBLIC]
    query.primitive[i] = direct_part(hit)
    query.slot[i], query.instance[i] = hit.slot, hit.instance


@kernel
def closest_rays(scene_words, query_words, wave_words, first, last, coherent):
    """The first hit of rays first ≤ i < last. Returns (kind, number) of the first of them that makes no sense, without
    tracing any: kind 1 origin, 2 direction, 3 its length, 4 limit, 0 where all are right."""
    scene, query, wave = open_scene(scene_words), open_query(query_words), open_wave(wave_words)
    fault = first_fault(query, first, last)
    if fault[0] != 0:
        return fault
    none = scene.geometry.blocks.rows == 0
    if not none and in_packets(scene.geometry, coherent):
        _closest_in_packets(scene, query, wave, first, last)
    elif not none:
        _closest_one_by_one(scene, query, wave, first, last)
    if none or has_direct(scene):
        _closest_direct(scene, query, wave, first, last)
    return fault


@device
def _blocked_in_packets(scene, query, wave, first, last):
    size = wave.floats.columns
    for start in range(first, last, size):
        count = min(size, last - start)
        _load(query, wave, start, count, rows.SHADOW_ORIGIN, rows.SHADOW_END)
        blocked_in_packets(scene.geometry, wave, count)
        for i in range(count):
            query.blocked[start + i] = wave.ints[rows.BLOCKED, i]


@device
def _blocked_directly(scene, query, wave, first, last):
    size = wave.floats.columns
    for start in range(first, last, size):
        count = min(size, last - start)
        _load(query, wave, start, count, rows.SHADOW_ORIGIN, rows.SHADOW_END)
        for i in range(count):
            wave.ints[rows.BLOCKED, i] = query.blocked[start + i]
        find_blocked_directly(scene, wave, count)
        for i in range(count):
            query.blocked[start + i] = wave.ints[rows.BLOCKED, i]


@kernel
def occluded_rays(scene_words, query_words, wave_words, first, last, coherent):
    """Whether rays first ≤ i < last meet anything before their limit; returns as closest_rays does."""
    scene, query, wave = open_scene(scene_words), open_query(query_words), open_wave(wave_words)
    fault = first_fault(query, first, last)
    if fault[0] != 0:
        return fault
    if scene.geometry.blocks.rows == 0:
        for i in range(first, last):
            query.blocked[i] = 0
    elif in_packets(scene.geometry, coherent):
        _blocked_in_packets(scene, query, wave, first, last)
    else:
        for i in range(first, last):
            origin, direction = _row(query.origins, i), _row(query.directions, i)
            query.blocked[i] = occluded(scene.geometry, origin, direction, query.limit[i], wave.scratch)
    if has_direct(scene):
        _blocked_directly(scene, query, wave, first, last)
    return fault


@kernel
def describe_hits(scene_words, query_words, scratch, normals):
    """Unit geometric normals, outward, of what was met, and texture coordinates of primitives into the query's own;
    rows of rays that met nothing keep what they hold."""
    scene, query = open_scene(scene_words), open_query(query_words)
    for i in range(query.slot.rows):
        slot, instance = np.int64(query.slot[i]), np.int64(query.instance[i])
        if slot == _NONE:
            continue
        hit = Hit(query.distance[i], _ZERO, _ZERO, slot, instance)
        if slot < 0:
            origin, direction = _row(query.origins, i), _row(query.directions, i)
            surface = surface_of(scene, origin, direction, hit, scratch)
            normal = surface.normal
            query.uv[i, 0], query.uv[i, 1] = surface.u, surface.v
        else:
            normal = true_normal(
                scene.geometry,
                scene.surfaces,
                hit,
                item_of(scene.surfaces, instance, triangle_number(scene.geometry, slot)),
            )
        normals[i, 0], normals[i, 1], normals[i, 2] = normal.x, normal.y, normal.z
