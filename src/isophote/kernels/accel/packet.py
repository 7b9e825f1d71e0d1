"""Sixteen rays through the tree together, one in each lane.

It pays for rays that go much the same way, such as a pixel's camera rays, and for all rays in scenes of few triangles:
nodes and triangles are loaded once for all, and nothing is guessed wrong ray by ray. The rays of a packet share the
axis that triangles are sheared along (forms/triangle.py), so the caller sorts them by their longest component.

Where the rays also agree in the signs of their directions, a node's eight boxes are first tested at once against the
interval of all sixteen rays, and only what that leaves is tested ray by ray (Boulos, Wald, Shirley: "Geometric and
Arithmetic Culling Methods for Entire Ray Packets", 2006).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from isophote.kernels.accel.bvh import FAR_SLACK
from isophote.kernels.accel.layout import (
    BLOCK,
    CHILD,
    LANES,
    NODE,
    NUMBER,
    PACKET,
    PACKET_NEAR,
    PACKET_NOTED,
    PACKET_STACK,
    REACH,
    UPPER,
    WIDTH,
)
from isophote.kernels.accel.spread import LARGEST, LEAST_SHARE, PLACE_SLACK, TINY
from isophote.kernels.accel.waiting import finish_noted, note_none, note_part, waits
from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import (
    absolute,
    as_float,
    bits,
    largest,
    least,
    load8,
    load16,
    load_float,
    load_int,
    lowest_bit,
    maximum,
    minimum,
    select,
    splat8,
    splat16,
    store8,
    store16,
    store_float,
    store_int,
)
from isophote.kernels.base.simd_product import product_difference

__all__ = [
    "DIRECTIONS",
    "LIMIT",
    "ORIGINS",
    "SLOT",
    "WEIGHT1",
    "WEIGHT2",
    "any_packet",
    "closest_packet",
]

# Rows of a packet's scratch, PACKET words each. What is found so far stands in LIMIT (t), WEIGHT1, WEIGHT2 and SLOT.
# NumPy integers: Numba would compile what takes a plain constant anew for each of its values.
ORIGINS, DIRECTIONS, LIMIT, WEIGHT1, WEIGHT2, SLOT, _SHEARS = (np.int64(row) for row in (0, 3, 6, 7, 8, 9, 10))


_ZERO, _ONE = np.float32(0), np.float32(1)
_FAR = np.float32(np.inf)
_NO_HIT = np.int32(-1)
_NOTED = np.int64(PACKET_NOTED)


@device
def _row(scratch, row):
    return load16(scratch, row * PACKET)


@device
def _reciprocals(d, smallest):
    """1/d lane by lane, with smaller components made large enough for it (spread.py)."""
    zero = splat16(_ZERO)
    safe = select(absolute(d) > smallest, d, select(d >= zero, smallest, zero - smallest))
    return splat16(_ONE) / safe


@device
def _largest_of(scratch, row):
    """The largest size of three rows, lane by lane."""
    return maximum(
        absolute(_row(scratch, row)), maximum(absolute(_row(scratch, row + 1)), absolute(_row(scratch, row + 2)))
    )


@device
def _finite(x):
    widest = splat16(LARGEST)
    return maximum(minimum(x, widest), splat16(_ZERO) - widest)


class _Packet(NamedTuple):
    """Planes as the rays see them: 1/d, and o/d moved outward, for each axis."""

    ix: object
    iy: object
    iz: object
    enter_x: object
    enter_y: object
    enter_z: object
    leave_x: object
    leave_y: object
    leave_z: object


class _Interval(NamedTuple):
    """All rays of a packet as one: for each axis the word offset of the near planes, the origins that count for near
    and for far planes, and the least and largest 1/d. `agree` is 0 where directions differ in sign."""

    agree: int
    near_x: int
    near_y: int
    near_z: int
    on_x: object
    on_y: object
    on_z: object
    of_x: object
    of_y: object
    of_z: object
    low_x: object
    low_y: object
    low_z: object
    high_x: object
    high_y: object
    high_z: object


@device
def _axis_interval(origin, inverse, offset, place):
    """(signs agree, near offset, near origin, far origin, least and largest 1/d) of one axis; `place`: how uncertain
    places are."""
    low, high = least(inverse), largest(inverse)
    first, last = least(origin) - place, largest(origin) + place
    up = low > _ZERO
    agree = 1 if (up or high < _ZERO) else 0
    near = np.int64(offset) if up else np.int64(offset + UPPER)
    return agree, near, splat8(last if up else first), splat8(first if up else last), splat8(low), splat8(high)


@device
def _interval(scratch, ix, iy, iz, place):
    ax, nx, onx, ofx, lx, hx = _axis_interval(_row(scratch, ORIGINS), ix, np.int64(0), place)
    ay, ny, ony, ofy, ly, hy = _axis_interval(_row(scratch, ORIGINS + 1), iy, np.int64(WIDTH), place)
    az, nz, onz, ofz, lz, hz = _axis_interval(_row(scratch, ORIGINS + 2), iz, np.int64(2 * WIDTH), place)
    return _Interval(ax & ay & az, nx, ny, nz, onx, ony, onz, ofx, ofy, ofz, lx, ly, lz, hx, hy, hz)


@device
def _near_far(nodes, base, near, mirror, on, of, low, high):
    """Bounds, over all rays, on the distances at which they enter and leave one axis of eight boxes."""
    a = load8(nodes, base + near) - on
    b = load8(nodes, base + (mirror - near)) - of
    return minimum(a * low, a * high), maximum(b * low, b * high)


@device
def _survivors(nodes, base, v, bound):
    """Children that some ray may enter: (bits, least distances)."""
    if v.agree == 0:
        # All that are there: missing ones have their bounds the wrong way round, and ray by ray would look endless.
        return bits(load8(nodes, base) <= load8(nodes, base + UPPER)), splat8(_ZERO)
    x0, x1 = _near_far(nodes, base, v.near_x, UPPER, v.on_x, v.of_x, v.low_x, v.high_x)
    y0, y1 = _near_far(nodes, base, v.near_y, UPPER + 2 * WIDTH, v.on_y, v.of_y, v.low_y, v.high_y)
    z0, z1 = _near_far(nodes, base, v.near_z, UPPER + 4 * WIDTH, v.on_z, v.of_z, v.low_z, v.high_z)
    near = maximum(maximum(x0, y0), maximum(z0, splat8(_ZERO)))
    far = minimum(minimum(x1, y1), minimum(z1, splat8(bound)))
    return bits(near <= far * splat8(FAR_SLACK)), near


@device
def _slab(nodes, at, inverse, enter, leave):
    """Distances at which the rays enter and leave one axis of the box whose planes are at words `at`, `at` + UPPER."""
    low = splat16(load_float(nodes, at)) * inverse
    high = splat16(load_float(nodes, at + UPPER)) * inverse
    return minimum(low - enter, high - enter), maximum(low - leave, high - leave)


@device
def _enter_child(nodes, at, p, limit):
    """The rays that enter the child whose planes begin at word `at`: (mask, distances)."""
    x0, x1 = _slab(nodes, at, p.ix, p.enter_x, p.leave_x)
    y0, y1 = _slab(nodes, at + WIDTH, p.iy, p.enter_y, p.leave_y)
    z0, z1 = _slab(nodes, at + 2 * WIDTH, p.iz, p.enter_z, p.leave_z)
    near = maximum(maximum(x0, y0), maximum(z0, splat16(_ZERO)))
    far = minimum(minimum(x1, y1), minimum(z1, limit))
    return near <= far * splat16(FAR_SLACK), near


@device
def _push(scratch, bottom, top, distance, child):
    """Put a child on the stack, below those of its node that are nearer."""
    place = top
    while place > bottom and load_float(scratch, place - 2) < distance:
        store_float(scratch, place, load_float(scratch, place - 2))
        store_int(scratch, place + 1, load_int(scratch, place - 1))
        place -= 2
    store_float(scratch, place, distance)
    store_int(scratch, place + 1, child)


@device
def _push_children(nodes, base, scratch, top, packet, interval, bound):
    """Push the children that any ray enters, the nearest last. Returns the new top of the stack.

    Where rays agree, inner nodes that the interval enters are pushed at once: what they hold is culled soon enough.
    """
    left, nearest = _survivors(nodes, base, interval, bound)
    store8(scratch, PACKET_NEAR, nearest)
    limit = _row(scratch, LIMIT)
    bottom = top
    while left != 0:
        child = np.int64(lowest_bit(left))
        left &= left - np.int32(1)
        code = load_int(nodes, base + CHILD + child)
        if code >= 0 and interval.agree != 0:
            _push(scratch, bottom, top, load_float(scratch, PACKET_NEAR + child), code)
            top += 2
            continue
        entered, near = _enter_child(nodes, base + child, packet, limit)
        if bits(entered) != 0:
            _push(scratch, bottom, top, least(select(entered, near, splat16(_FAR))), code)
            top += 2
    return top


@device
def _corner(blocks, at, axis):
    return splat16(load_float(blocks, at + axis * LANES))


@device
def _hit_triangle(blocks, at, kx, ky, kz, scratch):
    """The rays that meet the triangle whose first word is `at` before their limit: (mask, t, weight 1, weight 2)."""
    ox, oy, oz = _row(scratch, ORIGINS + kx), _row(scratch, ORIGINS + ky), _row(scratch, ORIGINS + kz)
    sx, sy, sz = _row(scratch, _SHEARS), _row(scratch, _SHEARS + 1), _row(scratch, _SHEARS + 2)
    step = 3 * LANES
    az = _corner(blocks, at, kz) - oz
    bz = _corner(blocks, at + step, kz) - oz
    cz = _corner(blocks, at + 2 * step, kz) - oz
    ax = (_corner(blocks, at, kx) - ox) - sx * az
    bx = (_corner(blocks, at + step, kx) - ox) - sx * bz
    cx = (_corner(blocks, at + 2 * step, kx) - ox) - sx * cz
    ay = (_corner(blocks, at, ky) - oy) - sy * az
    by = (_corner(blocks, at + step, ky) - oy) - sy * bz
    cy = (_corner(blocks, at + 2 * step, ky) - oy) - sy * cz
    u = product_difference(cx, by, cy, bx)
    v = product_difference(ax, cy, ay, cx)
    w = product_difference(bx, ay, by, ax)
    zero = splat16(_ZERO)
    inside = (minimum(u, minimum(v, w)) >= zero) | (maximum(u, maximum(v, w)) <= zero)
    # Most triangles are missed by all rays, which is guessed right.
    if bits(inside) == 0:
        return inside, zero, zero, zero
    scale = splat16(_ONE) / (u + v + w)
    t = (u * az + v * bz + w * cz) * sz * scale
    return inside & (t > zero) & (t < _row(scratch, LIMIT)), t, v * scale, w * scale


@device
def _keep(scratch, met, t, w1, w2, slot):
    """Note a triangle as the nearest so far for the rays that met it."""
    store16(scratch, LIMIT * PACKET, select(met, t, _row(scratch, LIMIT)))
    store16(scratch, WEIGHT1 * PACKET, select(met, w1, _row(scratch, WEIGHT1)))
    store16(scratch, WEIGHT2 * PACKET, select(met, w2, _row(scratch, WEIGHT2)))
    store16(scratch, SLOT * PACKET, select(met, splat16(as_float(np.int32(slot))), _row(scratch, SLOT)))


@device
def _hit_leaf(blocks, first, count, axes, scratch):
    """All rays against each triangle of a leaf."""
    kx, ky, kz = axes
    for block in range(first, first + count):
        for k in range(LANES):
            at = block * BLOCK + k
            if load_int(blocks, at + NUMBER) < 0:
                return
            met, t, w1, w2 = _hit_triangle(blocks, at, kx, ky, kz, scratch)
            if bits(met) != 0:
                _keep(scratch, met, t, w1, w2, block * LANES + k)


@device
def _prepare(scratch, axis, reach):
    """Shear rows in scratch; axes, planes and interval of the packet among boxes of coordinates up to `reach`."""
    kz = np.int64(axis)
    kx = kz + 1 if kz < 2 else np.int64(0)
    ky = kx + 1 if kx < 2 else np.int64(0)
    sz = splat16(_ONE) / _row(scratch, DIRECTIONS + kz)
    store16(scratch, _SHEARS * PACKET, _row(scratch, DIRECTIONS + kx) * sz)
    store16(scratch, (_SHEARS + 1) * PACKET, _row(scratch, DIRECTIONS + ky) * sz)
    store16(scratch, (_SHEARS + 2) * PACKET, sz)
    smallest = maximum(_largest_of(scratch, DIRECTIONS) * splat16(LEAST_SHARE), splat16(TINY))
    ix = _reciprocals(_row(scratch, DIRECTIONS), smallest)
    iy = _reciprocals(_row(scratch, DIRECTIONS + 1), smallest)
    iz = _reciprocals(_row(scratch, DIRECTIONS + 2), smallest)
    x = _finite(_row(scratch, ORIGINS) * ix)
    y = _finite(_row(scratch, ORIGINS + 1) * iy)
    z = _finite(_row(scratch, ORIGINS + 2) * iz)
    place = _finite(maximum(_largest_of(scratch, ORIGINS), splat16(reach)) * splat16(PLACE_SLACK))
    ex, ey, ez = _finite(place * absolute(ix)), _finite(place * absolute(iy)), _finite(place * absolute(iz))
    packet = _Packet(ix, iy, iz, x + ex, y + ey, z + ez, x - ex, y - ey, z - ez)
    return (kx, ky, kz), packet, _interval(scratch, ix, iy, iz, largest(place))


@device
def closest_packet(nodes, blocks, axis, scratch, parts):
    """First hits of the PACKET rays in `scratch`, whose longest components are all along `axis`.

    Rows of origins, directions and limits are read; t, weights and slots (int32) are left in the rows LIMIT, WEIGHT1,
    WEIGHT2 and SLOT; slot −1 where a ray meets nothing before its limit. A negative limit switches a lane off.
    `parts`: who finishes parts of the tree that wait (waiting.py).
    """
    axes, packet, interval = _prepare(scratch, axis, load_float(nodes, REACH))
    store16(scratch, SLOT * PACKET, splat16(as_float(_NO_HIT)))
    bound = largest(_row(scratch, LIMIT))
    base = np.int64(PACKET_STACK)
    top = base
    node = np.int32(0)
    note_none(parts, scratch, _NOTED)
    while True:
        if node >= 0:
            top = _push_children(nodes, np.int64(node) * NODE, scratch, top, packet, interval, bound)
        else:
            code = np.int64(-1) - np.int64(node)
            if waits(parts, code):
                note_part(code, scratch, _NOTED)
            _hit_leaf(blocks, code >> 3, code & 7, axes, scratch)
            bound = largest(_row(scratch, LIMIT))
        while True:
            if top == base:
                if finish_noted(parts, scratch, _NOTED):
                    node = np.int32(0)
                    break
                return
            top -= 2
            if load_float(scratch, top) < bound:
                node = load_int(scratch, top + 1)
                break


@device
def any_packet(nodes, blocks, axis, scratch, parts):
    """Which of the packet's rays meet anything before their limit: bit k for lane k; see closest_packet."""
    axes, packet, interval = _prepare(scratch, axis, load_float(nodes, REACH))
    kx, ky, kz = axes
    blocked = np.int32(0)
    bound = largest(_row(scratch, LIMIT))
    base = np.int64(PACKET_STACK)
    top = base
    node = np.int32(0)
    note_none(parts, scratch, _NOTED)
    while True:
        if node >= 0:
            top = _push_children(nodes, np.int64(node) * NODE, scratch, top, packet, interval, bound)
        else:
            code = np.int64(-1) - np.int64(node)
            if waits(parts, code):
                note_part(code, scratch, _NOTED)
            first = code >> 3
            for block in range(first, first + (code & 7)):
                for k in range(LANES):
                    at = block * BLOCK + k
                    if load_int(blocks, at + NUMBER) < 0:
                        break
                    met, _, _, _ = _hit_triangle(blocks, at, kx, ky, kz, scratch)
                    if bits(met) != 0:
                        blocked |= bits(met)
                        store16(scratch, LIMIT * PACKET, select(met, splat16(-_ONE), _row(scratch, LIMIT)))
            bound = largest(_row(scratch, LIMIT))
            if bound < _ZERO:
                return blocked
        if top > base:
            top -= 2
            node = load_int(scratch, top + 1)
        elif finish_noted(parts, scratch, _NOTED):
            node = np.int32(0)
        else:
            return blocked
