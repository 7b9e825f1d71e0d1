"""What an accelerator's entries are given, and how they answer: the contract between accelerators and rays.

An accelerator is two entries (kernels/base/entry.py) over tables of its own and leaf blocks of triangles (layout.py):

    closest(tables, blocks, ray)    slot of the nearest triangle at 0 < t < limit, counted from `blocks`, or −1
    any(tables, blocks, ray)        1 where there is any such triangle, else 0

All three are addresses: of the words of the accelerator's tables, of its object's first block, and of the ray's words
below, which are the ray's alone: threads never share them. The words from `STACK` on are free for stacks
and the like, and hold anything when a call begins. `closest` leaves t and the weights of corners 1 and 2 in LIMIT,
WEIGHT1 and WEIGHT2 where it meets something. Both add to the counts.

All accelerators test triangles by `closest_in_blocks` and `any_in_blocks`, so what they find has the same distance bit
for bit. Of triangles at exactly the same distance, the one that is met first is told, and which that is depends on the
accelerator.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from isophote.kernels.accel.layout import LANES
from isophote.kernels.base.entry import floats_at
from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import lane, load_float, load_int, lowest_bit, store4, store_float, store_int
from isophote.kernels.base.vec import vec3
from isophote.kernels.forms.triangle import hit_block

__all__ = [
    "DEPTH",
    "LIMIT",
    "NODES",
    "PRIMITIVES",
    "RAY_WORDS",
    "STACK",
    "STACK_WORDS",
    "WEIGHT1",
    "WEIGHT2",
    "Nearest",
    "add_counts",
    "answer",
    "any_in_blocks",
    "clear_counts",
    "closest_in_blocks",
    "nearest_of",
    "ray_at",
    "ray_direction",
    "ray_origin",
    "set_ray",
]

# Words of a ray: origin, direction, the limit of the search, what is found, and three int32 counts: nodes, cells or
# planes that the ray visited, triangles that it was tested against (again, where it was tested again), and the deepest
# level that it reached. Then a row for the test of a block, and room for the accelerator.
_ORIGIN, _DIRECTION = np.int64(0), np.int64(3)
LIMIT, WEIGHT1, WEIGHT2 = np.int64(6), np.int64(7), np.int64(8)
NODES, PRIMITIVES, DEPTH = np.int64(9), np.int64(10), np.int64(11)
_ROW, STACK = np.int64(12), np.int64(16)
# Enough for three words an entry of a stack of the deepest tree.
STACK_WORDS = 1520
RAY_WORDS = 16 + STACK_WORDS

_ZERO = np.float32(0)
_NONE, _SHIFT, _RAY_WORDS = np.int64(-1), np.int64(2), np.int64(RAY_WORDS)


class Nearest(NamedTuple):
    """The nearest triangle so far: distance in lengths of the direction (the limit, if there is none), weights of its
    corners 1 and 2, and its slot, or −1."""

    t: float
    weight1: float
    weight2: float
    slot: int


# --- the caller's side ----------------------------------------------------------------------------


@device
def set_ray(ray, origin, direction, limit):
    """Write a ray for an entry."""
    store_float(ray, _ORIGIN, origin.x)
    store_float(ray, _ORIGIN + 1, origin.y)
    store_float(ray, _ORIGIN + 2, origin.z)
    store_float(ray, _DIRECTION, direction.x)
    store_float(ray, _DIRECTION + 1, direction.y)
    store_float(ray, _DIRECTION + 2, direction.z)
    store_float(ray, LIMIT, limit)


@device
def clear_counts(ray):
    """Set a ray's counts to nothing; entries add to them."""
    for word in (NODES, PRIMITIVES, DEPTH):
        store_int(ray, word, np.int32(0))


# --- the accelerator's side -----------------------------------------------------------------------


@device
def ray_at(address):
    """The words of the ray at an address."""
    return floats_at(address, _RAY_WORDS)


@device
def ray_origin(ray):
    """The ray's origin."""
    return vec3(load_float(ray, _ORIGIN), load_float(ray, _ORIGIN + 1), load_float(ray, _ORIGIN + 2))


@device
def ray_direction(ray):
    """The ray's direction, of any length."""
    return vec3(load_float(ray, _DIRECTION), load_float(ray, _DIRECTION + 1), load_float(ray, _DIRECTION + 2))


@device
def nearest_of(ray):
    """Nothing yet, before the ray's limit."""
    return Nearest(load_float(ray, LIMIT), _ZERO, _ZERO, _NONE)


@device
def closest_in_blocks(blocks, first, count, sheared, nearest, ray):
    """`nearest`, or what is nearer among the `count` triangles in the blocks from number `first` on; `sheared` is the
    ray by forms/triangle.py."""
    t_max, w1, w2, slot = nearest.t, nearest.weight1, nearest.weight2, nearest.slot
    for block in range(first, first + ((count + (LANES - 1)) >> _SHIFT)):
        met, t, weight1, weight2 = hit_block(blocks, block, sheared, t_max)
        if met != 0:
            store4(ray, _ROW, t)
            while met != 0:
                k = lowest_bit(met)
                met &= met - np.int32(1)
                candidate = load_float(ray, _ROW + np.int64(k))
                if candidate < t_max:
                    t_max, slot = candidate, block * LANES + np.int64(k)
                    w1, w2 = lane(weight1, k), lane(weight2, k)
    return Nearest(t_max, w1, w2, slot)


@device
def any_in_blocks(blocks, first, count, sheared, limit):
    """Whether the ray meets any of the `count` triangles in the blocks from number `first` on before `limit`."""
    for block in range(first, first + ((count + (LANES - 1)) >> _SHIFT)):
        met, _, _, _ = hit_block(blocks, block, sheared, limit)
        if met != 0:
            return True
    return False


@device
def answer(ray, nearest):
    """Leave what was found in the ray's words; the slot, which `closest` returns."""
    store_float(ray, LIMIT, nearest.t)
    store_float(ray, WEIGHT1, nearest.weight1)
    store_float(ray, WEIGHT2, nearest.weight2)
    return nearest.slot


@device
def add_counts(ray, nodes, primitives, depth):
    """Add visited nodes and tested triangles to the ray's counts, and the deepest level reached."""
    store_int(ray, NODES, load_int(ray, NODES) + np.int32(nodes))
    store_int(ray, PRIMITIVES, load_int(ray, PRIMITIVES) + np.int32(primitives))
    store_int(ray, DEPTH, max(load_int(ray, DEPTH), np.int32(depth)))
