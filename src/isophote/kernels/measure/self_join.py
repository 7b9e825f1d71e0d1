"""All pairs of triangles of a mesh that meet: each triangle's box through the tree over all of them."""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.layout import BLOCK, CHILD, LANES, NODE, NUMBER, STACK, UPPER, WIDTH
from isophote.kernels.base.jit import device, kernel
from isophote.kernels.base.simd import (
    bits,
    load4,
    load8,
    load_float,
    load_int,
    lowest_bit,
    maximum,
    minimum,
    splat4,
    splat8,
    store_int,
)
from isophote.kernels.measure.meeting import is_flat, triangles_meet

__all__ = ["find_flat", "join"]

_ROOT, _TOP = np.int32(0), np.int64(0)


@kernel
def find_flat(vertices, triangles, begin, end, flat):
    """Write to `flat` (m,) uint8 which triangles have no area."""
    for k in range(begin, end):
        flat[k] = 1 if is_flat(vertices, triangles[k, 0], triangles[k, 1], triangles[k, 2]) else 0


@device
def _range(blocks, slot, axis):
    """Least and greatest coordinate of the triangle in a slot."""
    at = slot // LANES * BLOCK + slot % LANES + axis * LANES
    a, b, c = load_float(blocks, at), load_float(blocks, at + 3 * LANES), load_float(blocks, at + 6 * LANES)
    return min(a, min(b, c)), max(a, max(b, c))


@device
def _overlapping(blocks, block, axis, low, high):
    """Which triangles of a block reach into a range of an axis."""
    at = block * BLOCK + axis * LANES
    a, b, c = load4(blocks, at), load4(blocks, at + 3 * LANES), load4(blocks, at + 6 * LANES)
    return (minimum(a, minimum(b, c)) <= splat4(high)) & (maximum(a, maximum(b, c)) >= splat4(low))


@device
def _triple(triangles, k):
    return np.int64(triangles[k, 0]), np.int64(triangles[k, 1]), np.int64(triangles[k, 2])


@kernel
def join(nodes, blocks, vertices, triangles, flat, begin, end, pairs, most):
    """Find the pairs whose first triangle is in slots `begin` to `end` of `blocks`; write what fits into `pairs`.

    `nodes`, `blocks`: the tree (accel/layout.py) over `triangles` (m, 3), rows of `vertices` (n, 3), in which one place
    has one row; rounding that keeps the order of coordinates may lie between the two. Returns how many pairs there are,
    or a number beyond `most` as soon as there are more.
    """
    stack = np.empty(STACK, np.float32)
    found = np.int64(0)
    for slot in range(begin, end):
        own = load_int(blocks, slot // LANES * BLOCK + NUMBER + slot % LANES)
        if own < 0:
            continue
        if found > most:
            break
        lx, hx = _range(blocks, slot, 0)
        ly, hy = _range(blocks, slot, 1)
        lz, hz = _range(blocks, slot, 2)
        t = _triple(triangles, own)
        top, node = _TOP, _ROOT
        while True:
            if node >= 0:
                base = np.int64(node) * NODE
                met = bits(
                    (load8(nodes, base) <= splat8(hx))
                    & (load8(nodes, base + UPPER) >= splat8(lx))
                    & (load8(nodes, base + WIDTH) <= splat8(hy))
                    & (load8(nodes, base + UPPER + WIDTH) >= splat8(ly))
                    & (load8(nodes, base + 2 * WIDTH) <= splat8(hz))
                    & (load8(nodes, base + UPPER + 2 * WIDTH) >= splat8(lz))
                )
                while met != 0:
                    store_int(stack, top, load_int(nodes, base + CHILD + np.int64(lowest_bit(met))))
                    met &= met - np.int32(1)
                    top += 1
            else:
                code = np.int64(-1) - np.int64(node)
                first = code >> 3
                for block in range(first, first + (code & 7)):
                    met = bits(
                        _overlapping(blocks, block, 0, lx, hx)
                        & _overlapping(blocks, block, 1, ly, hy)
                        & _overlapping(blocks, block, 2, lz, hz)
                    )
                    while met != 0:
                        other = load_int(blocks, block * BLOCK + NUMBER + np.int64(lowest_bit(met)))
                        met &= met - np.int32(1)
                        if other <= own:
                            continue
                        if triangles_meet(vertices, t, _triple(triangles, other), flat[own] != 0, flat[other] != 0):
                            if found < len(pairs):
                                pairs[found, 0], pairs[found, 1] = own, other
                            found += 1
            if top == 0:
                break
            top -= 1
            node = load_int(stack, top)
    return found
