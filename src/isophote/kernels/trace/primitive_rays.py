"""The queries of rays.py where nothing but primitives is met: sixteen rays go straight from the arrays to the
primitives, and what they meet straight back."""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.surface import PUBLIC
from isophote.kernels.base.doubles import doubles_at
from isophote.kernels.base.entry import call_entry, element_address, table_address
from isophote.kernels.base.jit import device, kernel
from isophote.kernels.base.simd import load16
from isophote.kernels.base.simd_rows import load_triples, store_widened
from isophote.kernels.primitive.lanes import BLOCK_DOUBLES, LANES, PART, T, U, V, W, X, Y, Z
from isophote.kernels.primitive.layout import RAYS_AT, SLOT, SURFACE
from isophote.kernels.trace.rays import first_fault, open_query, open_scene, open_wave

__all__ = ["closest_primitive_rays", "occluded_primitive_rays"]

_LANES, _FIRST, _RAYS_AT = np.int64(LANES), np.int64(0), np.int64(RAYS_AT)
_SLOT, _PART_BITS, _PART = np.int32(SLOT), np.int32(4), np.int32(15)
_OFF, _NOWHERE, _NOTHING, _ZERO = -1.0, np.int32(-1), np.int32(0), np.float32(0)
_FAR = np.float32(np.inf)


@device
def _load(query, rays, first):
    o, d, limit = query.origins, query.directions, query.limit
    x, y, z = load_triples(o, first)
    u, v, w = load_triples(d, first)
    store_widened(rays, X, x)
    store_widened(rays, Y, y)
    store_widened(rays, Z, z)
    store_widened(rays, U, u)
    store_widened(rays, V, v)
    store_widened(rays, W, w)
    store_widened(rays, T, load16(limit, first))


@device
def _load_few(query, rays, first, last):
    """Lanes that are left over repeat the last ray, switched off."""
    for lane in range(_LANES):
        i = min(first + lane, last - 1)
        for k in range(3):
            rays[LANES * k + lane] = query.origins[i, k]
            rays[LANES * (k + 3) + lane] = query.directions[i, k]
        rays[T + lane] = query.limit[i] if first + lane < last else _OFF


@device
def _trace(scene, query, scratch, rays, first, last):
    if last - first == _LANES:
        _load(query, rays, first)
    else:
        _load_few(query, rays, first, last)
    primitives = scene.primitives
    call_entry(primitives.trace_lanes, (table_address(primitives), element_address(scratch, _FIRST)))


@device
def _write(scene, query, rays, first, count):
    """What each ray met, from its code; loops without branches, each over few arrays, become vector instructions."""
    numbers, items = scene.primitives.numbers, scene.surfaces.items
    distance, uv, item = query.distance, query.uv, query.item
    part, slot, instance = query.primitive, query.slot, query.instance
    for i in range(count):
        distance[first + i] = np.float32(rays[T + i]) if rays[PART + i] >= 0.0 else _FAR
    for i in range(count):
        uv[first + i, 0] = uv[first + i, 1] = _ZERO
    for i in range(count):
        instance[first + i] = np.int32(rays[PART + i]) >> _PART_BITS
    for i in range(count):
        code = np.int32(rays[PART + i])
        part[first + i] = (code & _PART) if code >= _NOTHING else _NOWHERE
    for i in range(count):
        code = np.int32(rays[PART + i])
        slot[first + i] = _SLOT - (code & _PART) if code >= _NOTHING else _NOWHERE
    for i in range(count):
        code = np.int32(rays[PART + i])
        row = numbers[max(code, _NOTHING) >> _PART_BITS, SURFACE]
        item[first + i] = items[row, PUBLIC] if code >= _NOTHING else _NOWHERE


@kernel
def closest_primitive_rays(scene_words, query_words, wave_words, first, last, coherent):
    """As rays.closest_rays, in a scene that has primitives and nothing else."""
    scene, query, wave = open_scene(scene_words), open_query(query_words), open_wave(wave_words)
    fault = first_fault(query, first, last)
    if fault[0] != 0:
        return fault
    scratch = wave.scratch
    rays = doubles_at(element_address(scratch, _RAYS_AT), BLOCK_DOUBLES)
    for start in range(first, last, LANES):
        end = min(start + _LANES, last)
        _trace(scene, query, scratch, rays, start, end)
        _write(scene, query, rays, start, end - start)
    return fault


@kernel
def occluded_primitive_rays(scene_words, query_words, wave_words, first, last, coherent):
    """As rays.occluded_rays, in a scene that has primitives and nothing else."""
    scene, query, wave = open_scene(scene_words), open_query(query_words), open_wave(wave_words)
    fault = first_fault(query, first, last)
    if fault[0] != 0:
        return fault
    scratch, blocked = wave.scratch, query.blocked
    rays = doubles_at(element_address(scratch, _RAYS_AT), BLOCK_DOUBLES)
    for start in range(first, last, LANES):
        end = min(start + _LANES, last)
        _trace(scene, query, scratch, rays, start, end)
        for i in range(end - start):
            blocked[start + i] = rays[PART + i] >= 0.0
    return fault
