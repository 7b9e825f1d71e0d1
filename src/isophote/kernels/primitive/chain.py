"""Primitives as the kernels of rendering methods know them: entries that are called where a scene has any."""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.geometry import Hit
from isophote.kernels.accel.surface import Surface
from isophote.kernels.base.doubles import doubles_at
from isophote.kernels.base.entry import call_entry, element_address, table_address
from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import bits, load16, lowest_bit, store_int
from isophote.kernels.base.simd_double16 import load_doubles16, splat_doubles16
from isophote.kernels.base.simd_rows import store_widened
from isophote.kernels.base.vec import vec3
from isophote.kernels.primitive.lanes import BLOCK_DOUBLES, LANES, PART, T
from isophote.kernels.primitive.layout import RAYS_AT, SLOT, SURFACE

__all__ = [
    "closest_primitive",
    "closest_primitives",
    "find_occluding",
    "primitive_occludes",
    "surface_of_primitive",
]

_ZERO, _ONE = np.float32(0), np.float32(1)
_SLOT, _PART_BITS, _PART = np.int64(SLOT), np.int64(4), np.int64(15)
_FIRST, _LANES, _RAYS_AT = np.int64(0), np.int64(LANES), np.int64(RAYS_AT)
_OFF, _CLEAR = -1.0, 0.0


@device
def _load_ray(scratch, origin, direction, t_max):
    scratch[0], scratch[1], scratch[2] = origin.x, origin.y, origin.z
    scratch[3], scratch[4], scratch[5] = direction.x, direction.y, direction.z
    scratch[6] = t_max


@device
def closest_primitive(primitives, origin, direction, best, scratch):
    """`best`, or the nearer `Hit` on a primitive: its slot is SLOT − the part's number, its instance the primitive's
    number."""
    if primitives.numbers.rows == 0:
        return best
    _load_ray(scratch, origin, direction, best.t)
    scratch[7] = _ZERO
    met = call_entry(primitives.trace, (table_address(primitives), element_address(scratch, _FIRST)))
    if met < 0:
        return best
    return Hit(scratch[6], _ZERO, _ZERO, _SLOT - (met & _PART), met >> _PART_BITS)


@device
def primitive_occludes(primitives, origin, direction, t_max, scratch):
    """Whether any primitive lies at 0 < t < t_max."""
    if primitives.numbers.rows == 0:
        return False
    _load_ray(scratch, origin, direction, t_max)
    scratch[7] = _ONE
    return call_entry(primitives.trace, (table_address(primitives), element_address(scratch, _FIRST))) >= 0


@device
def _load_lanes(rays, floats, origin, limit, first, last):
    """Rays first ≤ i < last of a wave, whose first row of origins is `origin`, into the entry's block; lanes that are
    left over repeat the last ray, switched off by their limit."""
    if last - first == LANES:
        columns = floats.columns
        for row in range(6):
            store_widened(rays, _LANES * row, load16(floats, (origin + row) * columns + first))
        store_widened(rays, T, load16(floats, limit * columns + first))
        return
    for lane in range(_LANES):
        i = min(first + lane, last - 1)
        for row in range(6):
            rays[LANES * row + lane] = np.float64(floats[origin + row, i])
        rays[T + lane] = np.float64(floats[limit, i]) if first + lane < last else _OFF


@device
def _met(rays):
    """Which rays of a block met anything, as bits."""
    return bits(load_doubles16(rays, PART) >= splat_doubles16(_CLEAR))


@device
def closest_primitives(primitives, floats, longs, wave_rows, count, scratch):
    """Primitives that lie before what rays 0 ≤ i < count of a wave have met so far, as closest_primitive for each.

    `wave_rows`: the rows of origins, of t in `floats`, of slots and instances in `longs`.
    """
    origin, limit, slot, instance = wave_rows
    rays = doubles_at(element_address(scratch, _RAYS_AT), BLOCK_DOUBLES)
    for first in range(0, count, LANES):
        last = min(first + LANES, count)
        _load_lanes(rays, floats, origin, limit, first, last)
        call_entry(primitives.trace_lanes, (table_address(primitives), element_address(scratch, _FIRST)))
        left = _met(rays)
        while left != 0:
            lane = np.int64(lowest_bit(left))
            left &= left - np.int32(1)
            code = np.int64(rays[PART + lane])
            floats[limit, first + lane] = np.float32(rays[T + lane])
            longs[slot, first + lane], longs[instance, first + lane] = _SLOT - (code & _PART), code >> _PART_BITS


@device
def find_occluding(primitives, floats, ints, wave_rows, count, scratch):
    """Set the row of what is blocked to 1 for rays 0 ≤ i < count of a wave that meet a primitive before their end.

    `wave_rows`: the rows of origins, of ends in `floats`, of what is blocked in `ints`.
    """
    origin, limit, blocked = wave_rows
    rays = doubles_at(element_address(scratch, _RAYS_AT), BLOCK_DOUBLES)
    for first in range(0, count, LANES):
        last = min(first + LANES, count)
        _load_lanes(rays, floats, origin, limit, first, last)
        for i in range(first, last):
            if ints[blocked, i] != 0:
                rays[T + i - first] = _OFF
        call_entry(primitives.trace_lanes, (table_address(primitives), element_address(scratch, _FIRST)))
        left = _met(rays)
        while left != 0:
            ints[blocked, first + lowest_bit(left)] = 1
            left &= left - np.int32(1)


@device
def surface_of_primitive(primitives, origin, direction, hit, scratch):
    """The `Surface` of a `Hit` on a primitive."""
    _load_ray(scratch, origin, direction, hit.t)
    store_int(scratch, np.int64(7), np.int32(hit.instance))
    store_int(scratch, np.int64(8), np.int32(_SLOT - hit.slot))
    call_entry(primitives.surface, (table_address(primitives), element_address(scratch, _FIRST)))
    place, normal = vec3(scratch[0], scratch[1], scratch[2]), vec3(scratch[3], scratch[4], scratch[5])
    item = np.int64(primitives.numbers[hit.instance, SURFACE])
    return Surface(place, normal, normal, scratch[6], scratch[7], scratch[8], item, _SLOT - hit.slot)
