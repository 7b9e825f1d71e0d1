"""Sixteen rays through the tree together, one in each lane.

It pays for rays that go much the same way, such as a pixel's camera rays, and for all rays in scenes of few triangles:
nodes and triangles are loaded once for all, and nothing is guessed wrong ray by ray. The rays of a packet share the
axis that triangles are sheared along (forms/triangle.py), so the caller sorts them by their longest component.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.bvh import FAR_SLACK, ORIGIN_SLACK, TINY
from isophote.kernels.accel.layout import BLOCK, CHILD, LANES, NODE, NUMBER, PACKET, PACKET_STACK, UPPER, WIDTH
from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import (
    absolute,
    as_float,
    bits,
    exact_product_difference,
    largest,
    least,
    load16,
    load_float,
    load_int,
    maximum,
    minimum,
    select,
    splat16,
    store16,
    store_float,
    store_int,
)

__all__ = ["FOUND", "LIMIT", "ORIGINS", "any_packet", "closest_packet", "longest_axis"]

# Rows of a packet's scratch, PACKET words each.
ORIGINS, DIRECTIONS, LIMIT, FOUND = 0, 3, 6, 7

_ZERO, _ONE = np.float32(0), np.float32(1)
_FAR = np.float32(np.inf)
_NO_HIT = np.int32(-1)


@device
def longest_axis(d):
    """Number of the direction's longest component."""
    x, y, z = abs(d.x), abs(d.y), abs(d.z)
    if x >= y and x >= z:
        return 0
    return 1 if y >= z else 2


@device
def _row(scratch, row):
    return load16(scratch, row * PACKET)


@device
def _reciprocals(d):
    """1/d lane by lane, with tiny components made large enough for it (bvh.py)."""
    tiny = splat16(TINY)
    zero = splat16(_ZERO)
    safe = select(absolute(d) > tiny, d, select(d >= zero, tiny, zero - tiny))
    return splat16(_ONE) / safe


@device
def _slab(nodes, at, inverse, enter, leave):
    """Distances at which the rays enter and leave one axis of the box whose planes are at words `at`, `at` + UPPER."""
    low = splat16(load_float(nodes, at)) * inverse
    high = splat16(load_float(nodes, at + UPPER)) * inverse
    return minimum(low - enter, high - enter), maximum(low - leave, high - leave)


@device
def _push_children(nodes, base, scratch, top, box, limit):
    """Push the children that any ray enters, the nearest last. Returns the new top of the stack."""
    ix, iy, iz, ex, ey, ez, lx, ly, lz = box
    bottom = top
    for child in range(WIDTH):
        at = base + child
        if not load_float(nodes, at) <= load_float(nodes, at + UPPER):
            break
        x0, x1 = _slab(nodes, at, ix, ex, lx)
        y0, y1 = _slab(nodes, at + WIDTH, iy, ey, ly)
        z0, z1 = _slab(nodes, at + 2 * WIDTH, iz, ez, lz)
        near = maximum(maximum(x0, y0), maximum(z0, splat16(_ZERO)))
        far = minimum(minimum(x1, y1), minimum(z1, limit))
        entered = near <= far * splat16(FAR_SLACK)
        if bits(entered) == 0:
            continue
        distance = least(select(entered, near, splat16(_FAR)))
        place = top
        while place > bottom and load_float(scratch, place - 2) < distance:
            store_float(scratch, place, load_float(scratch, place - 2))
            store_int(scratch, place + 1, load_int(scratch, place - 1))
            place -= 2
        store_float(scratch, place, distance)
        store_int(scratch, place + 1, load_int(nodes, base + CHILD + child))
        top += 2
    return top


@device
def _corner(blocks, at, axis):
    return splat16(load_float(blocks, at + axis * LANES))


@device
def _hit_triangle(blocks, at, axes, shear, limit):
    """The rays that meet the triangle whose first word is `at` before their limit: (mask, t, weight 1, weight 2)."""
    kx, ky, kz = axes
    ox, oy, oz, sx, sy, sz = shear
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
    u = exact_product_difference(cx, by, cy, bx)
    v = exact_product_difference(ax, cy, ay, cx)
    w = exact_product_difference(bx, ay, by, ax)
    zero = splat16(_ZERO)
    inside = (minimum(u, minimum(v, w)) >= zero) | (maximum(u, maximum(v, w)) <= zero)
    scale = splat16(_ONE) / (u + v + w)
    t = (u * az + v * bz + w * cz) * sz * scale
    return inside & (t > zero) & (t < limit), t, v * scale, w * scale


@device
def _prepare(scratch, axis):
    """Axes, shear and box planes of the packet in `scratch`."""
    kz = axis
    kx = kz + 1 if kz < 2 else 0
    ky = kx + 1 if kx < 2 else 0
    sz = splat16(_ONE) / _row(scratch, DIRECTIONS + kz)
    shear = (
        _row(scratch, ORIGINS + kx),
        _row(scratch, ORIGINS + ky),
        _row(scratch, ORIGINS + kz),
        _row(scratch, DIRECTIONS + kx) * sz,
        _row(scratch, DIRECTIONS + ky) * sz,
        sz,
    )
    ix, iy, iz = (
        _reciprocals(_row(scratch, DIRECTIONS)),
        _reciprocals(_row(scratch, DIRECTIONS + 1)),
        _reciprocals(_row(scratch, DIRECTIONS + 2)),
    )
    x, y, z = _row(scratch, ORIGINS) * ix, _row(scratch, ORIGINS + 1) * iy, _row(scratch, ORIGINS + 2) * iz
    slack = splat16(ORIGIN_SLACK)
    ex, ey, ez = absolute(x) * slack, absolute(y) * slack, absolute(z) * slack
    return (kx, ky, kz), shear, (ix, iy, iz, x + ex, y + ey, z + ez, x - ex, y - ey, z - ez)


@device
def closest_packet(nodes, blocks, axis, scratch):
    """First hits of the PACKET rays in `scratch`, whose longest components are all along `axis`.

    Rows of origins, directions and limits are read; t, weights and slots (as int32) are written to rows from FOUND on,
    slot −1 where a ray meets nothing before its limit. A negative limit switches a lane off.
    """
    axes, shear, box = _prepare(scratch, axis)
    limit = _row(scratch, LIMIT)
    weight1 = weight2 = splat16(_ZERO)
    slots = splat16(as_float(_NO_HIT))
    bound = largest(limit)
    base = np.int64(PACKET_STACK)
    top = base
    node = np.int32(0)
    while True:
        if node >= 0:
            top = _push_children(nodes, np.int64(node) * NODE, scratch, top, box, limit)
        else:
            code = np.int64(-1) - np.int64(node)
            first = code >> 3
            for block in range(first, first + (code & 7)):
                for k in range(LANES):
                    at = block * BLOCK + k
                    if load_int(blocks, at + NUMBER) < 0:
                        break
                    met, t, w1, w2 = _hit_triangle(blocks, at, axes, shear, limit)
                    if bits(met) != 0:
                        limit = select(met, t, limit)
                        weight1 = select(met, w1, weight1)
                        weight2 = select(met, w2, weight2)
                        slots = select(met, splat16(as_float(np.int32(block * LANES + k))), slots)
            bound = largest(limit)
        while True:
            if top == base:
                store16(scratch, FOUND * PACKET, limit)
                store16(scratch, (FOUND + 1) * PACKET, weight1)
                store16(scratch, (FOUND + 2) * PACKET, weight2)
                store16(scratch, (FOUND + 3) * PACKET, slots)
                return
            top -= 2
            if load_float(scratch, top) < bound:
                node = load_int(scratch, top + 1)
                break


@device
def any_packet(nodes, blocks, axis, scratch):
    """Which of the packet's rays meet anything before their limit: bit k for lane k; see closest_packet."""
    axes, shear, box = _prepare(scratch, axis)
    limit = _row(scratch, LIMIT)
    off = splat16(-_ONE)
    blocked = np.int32(0)
    base = np.int64(PACKET_STACK)
    top = base
    node = np.int32(0)
    while True:
        if node >= 0:
            top = _push_children(nodes, np.int64(node) * NODE, scratch, top, box, limit)
        else:
            code = np.int64(-1) - np.int64(node)
            first = code >> 3
            for block in range(first, first + (code & 7)):
                for k in range(LANES):
                    at = block * BLOCK + k
                    if load_int(blocks, at + NUMBER) < 0:
                        break
                    met, _, _, _ = _hit_triangle(blocks, at, axes, shear, limit)
                    blocked |= bits(met)
                    limit = select(met, off, limit)
            if largest(limit) < _ZERO:
                return blocked
        if top == base:
            return blocked
        top -= 2
        node = load_int(scratch, top + 1)
