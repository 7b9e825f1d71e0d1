"""The queries of rays.py where nothing but primitives is met: sixteen rays go straight from the arrays to the
primitives, and what they meet straight back."""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.surface import PUBLIC
from isophote.kernels.base.doubles import doubles_at
from isophote.kernels.base.entry import call_entry, element_address, table_address
from isophote.kernels.base.jit import device, kernel
from isophote.kernels.base.simd import bits, load16, lowest_bit, select, splat16, store16
from isophote.kernels.base.simd_double16 import chosen_doubles16, floor_doubles16, load_doubles16, splat_doubles16
from isophote.kernels.base.simd_rows import load_narrowed, load_triples, store_flags, store_whole, store_widened
from isophote.kernels.primitive.lanes import BLOCK_DOUBLES, LANES, PART, T, U, V, W, X, Y, Z
from isophote.kernels.primitive.layout import RAYS_AT, SLOT, SURFACE
from isophote.kernels.trace.rays import first_fault, open_query, open_scene, open_wave

__all__ = ["closest_primitive_rays", "occluded_primitive_rays"]

_LANES, _FIRST, _RAYS_AT = np.int64(LANES), np.int64(0), np.int64(RAYS_AT)
# A primitive's codes: so many, by the part that is met.
_CODES, _PART_BITS, _PART = 16.0, np.int64(4), np.int64(15)
_OFF, _NONE, _SLOT, _ZERO, _FAR = -1.0, -1.0, float(SLOT), np.float32(0), np.float32(np.inf)


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
def _write(scene, query, rays, first):
    """What sixteen rays met, from their codes."""
    code, none = load_doubles16(rays, PART), splat_doubles16(_NONE)
    met = code >= splat_doubles16(0.0)
    number = floor_doubles16(code * splat_doubles16(1 / _CODES))
    part = code - splat_doubles16(_CODES) * number
    store16(query.distance, first, select(met, load_narrowed(rays, T), splat16(_FAR)))
    store16(query.uv, 2 * first, splat16(_ZERO))
    store16(query.uv, 2 * first + LANES, splat16(_ZERO))
    store_whole(query.instance, first, number)
    store_whole(query.primitive, first, chosen_doubles16(met, part, none))
    store_whole(query.slot, first, chosen_doubles16(met, splat_doubles16(_SLOT) - part, none))
    numbers, item = scene.primitives.numbers, query.item
    if numbers.rows == 1:
        only = splat_doubles16(np.float64(_item_of(scene, _FIRST)))
        store_whole(item, first, chosen_doubles16(met, only, none))
        return
    store_whole(item, first, none)
    left = bits(met)
    while left != 0:
        i = first + lowest_bit(left)
        item[i] = _item_of(scene, query.instance[i])
        left &= left - np.int32(1)


@device
def _item_of(scene, number):
    return scene.surfaces.items[scene.primitives.numbers[number, SURFACE], PUBLIC]


@device
def _write_few(scene, query, rays, first, last):
    for i in range(first, last):
        code = np.int64(rays[PART + i - first])
        met = code >= 0
        number, part = code >> _PART_BITS, code & _PART
        query.distance[i] = np.float32(rays[T + i - first]) if met else _FAR
        query.uv[i, 0] = query.uv[i, 1] = _ZERO
        query.instance[i] = number
        query.primitive[i] = part if met else -1
        query.slot[i] = SLOT - part if met else -1
        query.item[i] = _item_of(scene, number) if met else -1


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
        if end - start == LANES:
            _write(scene, query, rays, start)
        else:
            _write_few(scene, query, rays, start, end)
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
        if end - start == LANES:
            store_flags(blocked, start, load_doubles16(rays, PART) >= splat_doubles16(0.0))
        else:
            for i in range(end - start):
                blocked[start + i] = rays[PART + i] >= 0.0
    return fault
