"""The rays of a wave through the tree: one by one, or sixteen at a time where that pays."""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.field_chain import closest_field, field_occludes
from isophote.kernels.accel.geometry import Hit, closest_hit, occluded, parts_of
from isophote.kernels.accel.layout import BLOCK, PACKET
from isophote.kernels.accel.packet import (
    LIMIT,
    ORIGINS,
    SLOT,
    WEIGHT1,
    WEIGHT2,
    any_packet,
    closest_packet,
)
from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import (
    absolute,
    bits,
    load16,
    load_float,
    load_int,
    lowest_bit,
    splat16,
    store16,
    store_float,
)
from isophote.kernels.base.simd_lanes import count_bits, lane_numbers
from isophote.kernels.base.wide import load_lanes, load_wide, store_lanes
from isophote.kernels.light.emitter import closest_lamp, lamp_blocks
from isophote.kernels.primitive.chain import closest_primitives, find_occluding
from isophote.kernels.trace import wave as rows
from isophote.kernels.trace.holes import has_holes, pass_holes_of_rays, pass_holes_of_shadows, share_left
from isophote.kernels.trace.wave import add_radiance, row_vec3

__all__ = [
    "LAMP",
    "add_unblocked",
    "blocked_in_packets",
    "closest_direct_of_wave",
    "closest_in_packets",
    "find_blocked",
    "find_blocked_directly",
    "find_blocked_otherwise",
    "in_packets",
    "trace_rays",
]

# Slot of a hit that is a disk or sphere light, whose number stands in the place of the instance.
LAMP = np.int64(-2)

_ZERO, _ONE = np.float32(0), np.float32(1)
# Sixteen bits: all lanes.
_ALL = np.int32(0xFFFF)
# Rows that primitives are asked with.
_HIT_ROWS = tuple(np.int64(row) for row in (rows.ORIGIN, rows.HIT_T, rows.HIT_SLOT, rows.HIT_INSTANCE))
_SHADOW_ROWS = tuple(np.int64(row) for row in (rows.SHADOW_ORIGIN, rows.SHADOW_END, rows.BLOCKED))

# Packets go through the only instance's tree.
_ALONE = np.int64(0)
# Scenes of so few leaf blocks are traced in packets even where rays go every way.
_FEW_BLOCKS = 24


@device
def in_packets(geometry, coherent):
    """Whether rays go in packets: where they go much the same way, or nearly every ray comes by every triangle.
    Packets are for trees, and for one object."""
    if geometry.top_nodes.rows > 0 or geometry.closest != 0:
        return False
    return coherent or geometry.blocks.rows <= _FEW_BLOCKS * BLOCK


@device
def _axis_bits(floats, direction_row, i, count):
    """Bit by bit, which of the directions in columns i … i + 15, as far as they are before `count`, are longest along
    the first axis, and which along the second."""
    d, there = load_wide(floats, direction_row, i), lane_numbers() < splat16(np.float32(count - i))
    x, y, z = absolute(d.x), absolute(d.y), absolute(d.z)
    along_x = bits((x >= y) & (x >= z) & there)
    return along_x, bits((y >= z) & there) & ~along_x


@device
def _append_columns(order, place, i, chosen):
    """Write the columns i … i + 15 that are chosen bit by bit from `place` on. Returns the place after the last."""
    if chosen == _ALL:
        for lane in range(PACKET):
            order[place + lane] = i + lane
        return place + PACKET
    while chosen != 0:
        order[place] = i + lowest_bit(chosen)
        chosen &= chosen - np.int32(1)
        place += 1
    return place


@device
def _sort_by_axis(wave, direction_row, count):
    """Order of the wave's columns by the longest axis of their directions, those of one axis as they were; the counts
    of the first and the second axis."""
    floats, order = wave.floats, wave.longs[rows.ORDER]
    first, second = np.int64(0), np.int64(0)
    for i in range(0, count, PACKET):
        along_x, along_y = _axis_bits(floats, direction_row, i, count)
        first += count_bits(along_x)
        second += count_bits(along_y)
    next0, next1, next2 = np.int64(0), first, first + second
    for i in range(0, count, PACKET):
        along_x, along_y = _axis_bits(floats, direction_row, i, count)
        there = (np.int32(1) << np.int32(min(count - i, PACKET))) - np.int32(1)
        next0 = _append_columns(order, next0, i, along_x)
        next1 = _append_columns(order, next1, i, along_y)
        next2 = _append_columns(order, next2, i, np.int32(there & ~(along_x | along_y)))
    return first, second


@device
def _run(order, first, last):
    """The column of ray order[first] where all sixteen up to order[last − 1] stand side by side, or −1."""
    column = order[first]
    # Columns of one axis go up.
    return column if last - first == PACKET and order[last - 1] == column + (PACKET - 1) else np.int64(-1)


@device
def _load_packet(wave, first, last, origin_row, limit_row):
    """Copy rays order[first] … order[last − 1] into the packet's scratch, with direction rows after the origins'; lanes
    that are left over repeat the last ray, switched off."""
    floats, order, scratch = wave.floats, wave.longs[rows.ORDER], wave.scratch
    run = _run(order, first, last)
    if run >= 0:
        for k in range(6):
            store16(scratch, (ORIGINS + k) * PACKET, load_lanes(floats, origin_row + k, run))
        store16(scratch, LIMIT * PACKET, load_lanes(floats, limit_row, run))
        return
    for lane in range(PACKET):
        i = order[min(first + lane, last - 1)]
        for k in range(6):
            store_float(scratch, (ORIGINS + k) * PACKET + lane, floats[origin_row + k, i])
        store_float(scratch, LIMIT * PACKET + lane, floats[limit_row, i] if first + lane < last else -_ONE)


@device
def _store_hits(wave, first, last):
    floats, longs, scratch = wave.floats, wave.longs, wave.scratch
    order, slots, instances = longs[rows.ORDER], longs[rows.HIT_SLOT], longs[rows.HIT_INSTANCE]
    run = _run(order, first, last)
    if run >= 0:
        store_lanes(floats, rows.HIT_T, run, load16(scratch, LIMIT * PACKET))
        store_lanes(floats, rows.HIT_W1, run, load16(scratch, WEIGHT1 * PACKET))
        store_lanes(floats, rows.HIT_W2, run, load16(scratch, WEIGHT2 * PACKET))
        for lane in range(PACKET):
            slots[run + lane] = load_int(scratch, SLOT * PACKET + lane)
        for lane in range(PACKET):
            instances[run + lane] = 0
        return
    for lane in range(last - first):
        i = order[first + lane]
        floats[rows.HIT_T, i] = load_float(scratch, LIMIT * PACKET + lane)
        floats[rows.HIT_W1, i] = load_float(scratch, WEIGHT1 * PACKET + lane)
        floats[rows.HIT_W2, i] = load_float(scratch, WEIGHT2 * PACKET + lane)
        slots[i] = load_int(scratch, SLOT * PACKET + lane)
        instances[i] = 0


@device
def closest_in_packets(geometry, wave, count):
    """First triangle of every ray of the wave before the limit in its row HIT_T, sixteen rays at a time."""
    parts = parts_of(geometry, _ALONE)
    count0, count1 = _sort_by_axis(wave, rows.DIRECTION, count)
    start = np.int64(0)
    for axis in range(3):
        end = start + (count0 if axis == 0 else (count1 if axis == 1 else count - count0 - count1))
        for first in range(start, end, PACKET):
            last = min(first + PACKET, end)
            _load_packet(wave, first, last, rows.ORIGIN, rows.HIT_T)
            closest_packet(geometry.nodes, geometry.blocks, axis, wave.scratch, parts)
            _store_hits(wave, first, last)
        start = end


@device
def _closest_one_by_one(geometry, wave, count):
    floats, longs = wave.floats, wave.longs
    for i in range(count):
        origin, direction = row_vec3(floats, rows.ORIGIN, i), row_vec3(floats, rows.DIRECTION, i)
        hit = closest_hit(geometry, origin, direction, floats[rows.HIT_T, i], wave.scratch)
        floats[rows.HIT_T, i] = hit.t
        floats[rows.HIT_W1, i], floats[rows.HIT_W2, i] = hit.weight1, hit.weight2
        longs[rows.HIT_SLOT, i], longs[rows.HIT_INSTANCE, i] = hit.slot, hit.instance


@device
def closest_direct_of_wave(scene, wave, count):
    """Primitives and fields that lie before what the wave's rays have met so far."""
    if scene.primitives.numbers.rows > 0:
        closest_primitives(scene.primitives, wave.floats, wave.longs, _HIT_ROWS, count, wave.scratch)
    if scene.fields.numbers.rows == 0:
        return
    floats, longs = wave.floats, wave.longs
    for i in range(count):
        origin, direction = row_vec3(floats, rows.ORIGIN, i), row_vec3(floats, rows.DIRECTION, i)
        best = Hit(floats[rows.HIT_T, i], _ZERO, _ZERO, longs[rows.HIT_SLOT, i], longs[rows.HIT_INSTANCE, i])
        hit = closest_field(scene.fields, origin, direction, best, wave.scratch)
        floats[rows.HIT_T, i] = hit.t
        longs[rows.HIT_SLOT, i], longs[rows.HIT_INSTANCE, i] = hit.slot, hit.instance


@device
def trace_rays(scene, wave, count, coherent):
    """First hit of every path's ray, lamps included; beyond holes, where the scene has any (holes.py)."""
    _trace_to_surfaces(scene, wave, count, coherent)
    pass_holes_of_rays(scene, wave, count)


@device
def _trace_to_surfaces(scene, wave, count, coherent):
    if scene.geometry.blocks.rows == 0:
        for i in range(count):
            wave.longs[rows.HIT_SLOT, i] = -1
    elif in_packets(scene.geometry, coherent):
        closest_in_packets(scene.geometry, wave, count)
    else:
        _closest_one_by_one(scene.geometry, wave, count)
    closest_direct_of_wave(scene, wave, count)
    if scene.lights.lamps.rows == 0:
        return
    floats, longs = wave.floats, wave.longs
    for i in range(count):
        origin, direction = row_vec3(floats, rows.ORIGIN, i), row_vec3(floats, rows.DIRECTION, i)
        t, lamp = closest_lamp(scene.lights, origin, direction, floats[rows.HIT_T, i])
        if lamp >= 0:
            floats[rows.HIT_T, i] = t
            longs[rows.HIT_SLOT, i], longs[rows.HIT_INSTANCE, i] = LAMP, lamp


@device
def blocked_in_packets(geometry, wave, count):
    """Whether each shadow ray of the wave meets a triangle before its end, 0 or 1 in its row BLOCKED."""
    parts = parts_of(geometry, _ALONE)
    count0, count1 = _sort_by_axis(wave, rows.SHADOW_DIRECTION, count)
    order, scratch, found = wave.longs[rows.ORDER], wave.scratch, wave.ints[rows.BLOCKED]
    start = np.int64(0)
    for axis in range(3):
        end = start + (count0 if axis == 0 else (count1 if axis == 1 else count - count0 - count1))
        for first in range(start, end, PACKET):
            last = min(first + PACKET, end)
            _load_packet(wave, first, last, rows.SHADOW_ORIGIN, rows.SHADOW_END)
            blocked = any_packet(geometry.nodes, geometry.blocks, axis, scratch, parts)
            for lane in range(last - first):
                found[order[first + lane]] = (blocked >> lane) & 1
        start = end


@device
def _blocked_by_triangles(geometry, wave, count, coherent):
    floats, ints = wave.floats, wave.ints
    if geometry.blocks.rows == 0:
        for i in range(count):
            ints[rows.BLOCKED, i] = 0
    elif in_packets(geometry, coherent):
        blocked_in_packets(geometry, wave, count)
    else:
        for i in range(count):
            origin, direction = row_vec3(floats, rows.SHADOW_ORIGIN, i), row_vec3(floats, rows.SHADOW_DIRECTION, i)
            ints[rows.BLOCKED, i] = occluded(geometry, origin, direction, floats[rows.SHADOW_END, i], wave.scratch)


@device
def find_blocked_directly(scene, wave, count):
    """Set the row BLOCKED to 1 for shadow rays that meet a primitive or a field before their end."""
    floats, ints = wave.floats, wave.ints
    if scene.primitives.numbers.rows > 0:
        find_occluding(scene.primitives, floats, ints, _SHADOW_ROWS, count, wave.scratch)
    if scene.fields.numbers.rows == 0:
        return
    for i in range(count):
        if ints[rows.BLOCKED, i] == 0:
            origin, direction = row_vec3(floats, rows.SHADOW_ORIGIN, i), row_vec3(floats, rows.SHADOW_DIRECTION, i)
            end = floats[rows.SHADOW_END, i]
            ints[rows.BLOCKED, i] = field_occludes(scene.fields, origin, direction, end, wave.scratch)


@device
def find_blocked(scene, wave, count, coherent):
    """Whether each shadow ray of the wave meets anything before its end, 0 or 1 in its row BLOCKED; `share_left` says
    what is left of the light of others."""
    _blocked_by_triangles(scene.geometry, wave, count, coherent)
    find_blocked_otherwise(scene, wave, count)


@device
def find_blocked_otherwise(scene, wave, count):
    """`find_blocked` where the row BLOCKED tells already which rays meet triangles."""
    find_blocked_directly(scene, wave, count)
    if scene.lights.lamps.rows > 0:
        _blocked_by_lamps(scene.lights, wave, count)
    pass_holes_of_shadows(scene, wave, count)


@device
def _blocked_by_lamps(lights, wave, count):
    floats, ints = wave.floats, wave.ints
    for i in range(count):
        if ints[rows.BLOCKED, i] == 0:
            origin, direction = row_vec3(floats, rows.SHADOW_ORIGIN, i), row_vec3(floats, rows.SHADOW_DIRECTION, i)
            ints[rows.BLOCKED, i] = lamp_blocks(lights, origin, direction, floats[rows.SHADOW_END, i])


@device
def add_unblocked(scene, wave, count):
    """Add the light of every shadow ray that nothing blocks, as `find_blocked` has told."""
    for i in range(count):
        if wave.ints[rows.BLOCKED, i] == 0:
            light = row_vec3(wave.floats, rows.SHADOW_LIGHT, i)
            light = light * share_left(scene, wave, i) if has_holes(scene) else light
            add_radiance(wave, np.int64(wave.ints[rows.SHADOW_OWNER, i]), light)
