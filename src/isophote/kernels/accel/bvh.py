"""Rays through a tree of eight children a node, in layout.py's memory.

The test of a node is one set of vector instructions over its eight boxes. It is conservative: distances to planes
are widened by more than their rounding error (Ize: "Robust BVH Ray Traversal", JCGT 2(2), 2013) and that of the test of
triangles (spread.py), so a box is never missed whose triangle the watertight test in forms/triangle.py would hit.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from isophote.kernels.accel.layout import CHILD, LANES, NODE, NOTED, REACH, STACK, UPPER
from isophote.kernels.accel.spread import LARGEST, spread_of
from isophote.kernels.accel.waiting import finish_noted, note_none, note_part, waits
from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import (
    bits,
    lane,
    load8,
    load_float,
    load_int,
    lowest_bit,
    maximum,
    minimum,
    splat8,
    store4,
    store8,
    store_float,
    store_int,
)
from isophote.kernels.forms.triangle import hit_block, meets_blocks, shear, shear_for_pairs

__all__ = ["FAR_SLACK", "Slabs", "any_below", "any_triangle", "closest_triangle", "enter_children", "slabs"]

_ZERO = np.float32(0)
# Rounding of a whole distance is a few 2^-24 of it, given room to spare.
FAR_SLACK = np.float32(1 + 2.0**-20)
_NO_HIT = np.int64(-1)
_BOTTOM = np.int64(0)
_NOTED = np.int64(NOTED)


class Slabs(NamedTuple):
    """A ray made ready for boxes: word offsets of its near and far planes, 1/d, and o/d moved outward."""

    near_x: int
    near_y: int
    near_z: int
    inv_x: float
    inv_y: float
    inv_z: float
    enter_x: float
    enter_y: float
    enter_z: float
    leave_x: float
    leave_y: float
    leave_z: float


@device
def _finite(x):
    return max(min(x, LARGEST), -LARGEST)


@device
def slabs(origin, direction, reach):
    """The ray's `Slabs` among boxes whose coordinates do not exceed `reach`."""
    spread = spread_of(origin, direction, reach)
    ix, iy, iz = spread.inverse.x, spread.inverse.y, spread.inverse.z
    x, y, z = _finite(origin.x * ix), _finite(origin.y * iy), _finite(origin.z * iz)
    ex, ey, ez = spread.slack.x, spread.slack.y, spread.slack.z
    return Slabs(
        np.int64(0 if ix >= _ZERO else UPPER),
        np.int64(8 if iy >= _ZERO else UPPER + 8),
        np.int64(16 if iz >= _ZERO else UPPER + 16),
        splat8(ix),
        splat8(iy),
        splat8(iz),
        splat8(x + ex),
        splat8(y + ey),
        splat8(z + ez),
        splat8(x - ex),
        splat8(y - ey),
        splat8(z - ez),
    )


@device
def enter_children(nodes, base, ray, t_max):
    """Children of the node at word `base` that the ray enters before `t_max`: (bits, distances)."""
    near = maximum(
        maximum(
            load8(nodes, base + ray.near_x) * ray.inv_x - ray.enter_x,
            load8(nodes, base + ray.near_y) * ray.inv_y - ray.enter_y,
        ),
        maximum(load8(nodes, base + ray.near_z) * ray.inv_z - ray.enter_z, splat8(_ZERO)),
    )
    far = minimum(
        minimum(
            load8(nodes, base + (UPPER - ray.near_x)) * ray.inv_x - ray.leave_x,
            load8(nodes, base + (UPPER + 16 - ray.near_y)) * ray.inv_y - ray.leave_y,
        ),
        minimum(load8(nodes, base + (UPPER + 32 - ray.near_z)) * ray.inv_z - ray.leave_z, splat8(t_max)),
    )
    return bits(near <= far * splat8(FAR_SLACK)), near


@device
def closest_triangle(nodes, blocks, root, origin, direction, t_max, stack, parts=None):
    """The nearest triangle that the ray meets at 0 < t < `t_max`.

    Returns (t, weight of corner 1, weight of corner 2, slot), where slot = block * LANES + lane, or -1 for none
    (t is `t_max` then). `stack` is float32 scratch of layout.SCRATCH words. `parts`: who finishes parts of the tree
    that wait (waiting.py), if there may be any.
    """
    box = slabs(origin, direction, load_float(nodes, np.int64(root) * NODE + REACH))
    ray = shear(origin, direction)
    slot, weight1, weight2 = _NO_HIT, _ZERO, _ZERO
    top = np.int64(0)
    row = np.int64(STACK)
    node = np.int32(root)
    note_none(parts, stack, _NOTED)
    while True:
        if node >= 0:
            base = np.int64(node) * NODE
            entered, near = enter_children(nodes, base, box, t_max)
            if entered != 0:
                k = np.int64(lowest_bit(entered))
                entered &= entered - np.int32(1)
                nearest = load_int(nodes, base + CHILD + k)
                if entered == 0:
                    node = nearest
                    continue
                # Several: the nearest goes on, the others onto the stack, the farthest first.
                store8(stack, row, near)
                distance = load_float(stack, row + k)
                bottom = top
                while entered != 0:
                    k = np.int64(lowest_bit(entered))
                    entered &= entered - np.int32(1)
                    other = load_int(nodes, base + CHILD + k)
                    other_distance = load_float(stack, row + k)
                    if other_distance < distance:
                        other, nearest = nearest, other
                        other_distance, distance = distance, other_distance
                    at = top
                    while at > bottom:
                        above = load_float(stack, at - 2)
                        if above >= other_distance:
                            break
                        store_float(stack, at, above)
                        store_int(stack, at + 1, load_int(stack, at - 1))
                        at -= 2
                    store_float(stack, at, other_distance)
                    store_int(stack, at + 1, other)
                    top += 2
                node = nearest
                continue
        else:
            code = np.int64(-1) - np.int64(node)
            if waits(parts, code):
                note_part(code, stack, _NOTED)
            first = code >> 3
            for block in range(first, first + (code & 7)):
                met, t, w1, w2 = hit_block(blocks, block, ray, t_max)
                if met != 0:
                    store4(stack, row, t)
                    while met != 0:
                        k = lowest_bit(met)
                        met &= met - np.int32(1)
                        candidate = load_float(stack, row + np.int64(k))
                        if candidate < t_max:
                            t_max = candidate
                            slot = block * LANES + np.int64(k)
                            weight1, weight2 = lane(w1, k), lane(w2, k)
        while True:
            if top == 0:
                if finish_noted(parts, stack, _NOTED):
                    node = np.int32(root)
                    break
                return t_max, weight1, weight2, slot
            top -= 2
            if load_float(stack, top) < t_max:
                node = load_int(stack, top + 1)
                break


@device
def any_triangle(nodes, blocks, root, origin, direction, t_max, stack, parts=None):
    """Whether the ray meets a triangle at 0 < t < `t_max`; see closest_triangle."""
    box = slabs(origin, direction, load_float(nodes, np.int64(root) * NODE + REACH))
    ray = shear_for_pairs(origin, direction)
    return any_below(nodes, blocks, np.int32(root), box, ray, t_max, stack, _BOTTOM, parts)


@device
def any_below(nodes, blocks, root, box, ray, t_max, stack, bottom, parts=None):
    """Whether the ray meets a triangle below a node or in a leaf, given by its code, at 0 < t < `t_max`. The stack
    begins at word `bottom`."""
    node, top = np.int32(root), np.int64(bottom)
    note_none(parts, stack, _NOTED)
    while True:
        if node >= 0:
            base = np.int64(node) * NODE
            entered, _ = enter_children(nodes, base, box, t_max)
            if entered != 0:
                node = load_int(nodes, base + CHILD + np.int64(lowest_bit(entered)))
                entered &= entered - np.int32(1)
                while entered != 0:
                    store_int(stack, top, load_int(nodes, base + CHILD + np.int64(lowest_bit(entered))))
                    entered &= entered - np.int32(1)
                    top += 1
                continue
        else:
            code = np.int64(-1) - np.int64(node)
            first = code >> 3
            if waits(parts, code):
                note_part(code, stack, _NOTED)
            elif meets_blocks(blocks, first, first + (code & 7), ray, t_max):
                return True
        if top > bottom:
            top -= 1
            node = load_int(stack, top)
        elif finish_noted(parts, stack, _NOTED):
            node = np.int32(root)
        else:
            return False
