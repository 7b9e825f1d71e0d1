"""All triangles of a scene as tables, and the two questions rays ask of them.

A scene is a list of instances of objects. An object is a tree, or another accelerator, over triangles in its own space;
one that is used once is stored in world space, all such together as one object. Where there is more than one instance,
a tree over their boxes, or the accelerator of the objects over these, finds the ones that a ray may meet.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from isophote.kernels.accel.bvh import any_triangle, closest_triangle, enter_children, slabs
from isophote.kernels.accel.contract import LIMIT, RAY_WORDS, WEIGHT1, WEIGHT2, set_ray
from isophote.kernels.accel.layout import BLOCK, CHILD, LANES, NODE, PACKET_SCRATCH, REACH, SCRATCH, STACK
from isophote.kernels.accel.things import BOXES, ask_boxes
from isophote.kernels.accel.waiting import Waiting
from isophote.kernels.base.entry import call_entry, element_address, floats_at, table_address
from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import load_float, load_int, lowest_bit, store8, store_float, store_int
from isophote.kernels.base.table import BYTES, FLOAT_ROWS, FLOATS, INT, INTS, LONGS, Table
from isophote.kernels.base.vec import vec3

__all__ = [
    "GEOMETRY",
    "RAY",
    "SCRATCH_WORDS",
    "SLOT_BITS",
    "Hit",
    "affine_point",
    "affine_vector",
    "closest_hit",
    "into_object",
    "occluded",
    "parts_of",
    "push_boxes",
]

# Two stacks for a single ray, the upper tree's behind the lower one's, or one packet; then, from word `RAY` on, the
# words of a ray for an accelerator's entries. A ray through an accelerator over instances is there, and the one through
# an instance's object where the stacks would be (instance_entry.py).
RAY = np.int64(max(2 * SCRATCH, PACKET_SCRATCH))
SCRATCH_WORDS = max(2 * SCRATCH, PACKET_SCRATCH) + RAY_WORDS
_NEAR = np.int64(SCRATCH + STACK)
_RAY_WORDS = np.int64(RAY_WORDS)

# What an accelerator over instances finds is told as instance · 2³⁶ + slot.
SLOT_BITS = np.int64(36)

_ZERO = np.float32(0)
_CLOSEST, _ANY = np.int64(0), np.int64(1)


# Trees and instances. `nodes`, `blocks`: every object's tree, one after another (layout.py). `roots` (instances,): the
# root node of each instance's object. `to_object`, `to_world` (instances, 12): rows of affine 3 × 4 matrices.
# `identity` (instances,): whether these are the identity. `top_nodes`, `top_items`: tree over the instances' boxes;
# empty where there is one instance, or another accelerator over them: that is `boxes`, with the test of what a ray
# meets first of an instance, and `blocking`, with that of whether it meets any of it. `closest`, `any`: the entries of
# the accelerator of all objects (contract.py), or 0 for trees, which are compiled into what asks; `objects`
# (instances,): addresses of its tables for each instance's object, and `first_blocks` (instances,): the object's first
# block. `finish`: the entry that finishes parts of trees that wait (waiting.py), which is given the object's tables, or
# 0 where none do.
GEOMETRY = Table(
    "Geometry",
    nodes=FLOATS,
    blocks=FLOATS,
    roots=INTS,
    to_object=FLOAT_ROWS,
    to_world=FLOAT_ROWS,
    identity=BYTES,
    top_nodes=FLOATS,
    top_items=INTS,
    boxes=BOXES,
    blocking=BOXES,
    closest=INT,
    any=INT,
    objects=LONGS,
    first_blocks=LONGS,
    finish=INT,
)


class Hit(NamedTuple):
    """Where a ray meets a triangle first: distance in lengths of the direction, weights of the triangle's corners 1
    and 2, slot of the triangle in `blocks` (-1: none), instance."""

    t: float
    weight1: float
    weight2: float
    slot: int
    instance: int


@device
def affine_point(matrices, k, p):
    """The point `p` by affine matrix number `k`."""
    return affine_vector(matrices, k, p) + vec3(matrices[k, 3], matrices[k, 7], matrices[k, 11])


@device
def affine_vector(matrices, k, d):
    """The vector `d` by the linear part of affine matrix number `k`."""
    return vec3(
        matrices[k, 0] * d.x + matrices[k, 1] * d.y + matrices[k, 2] * d.z,
        matrices[k, 4] * d.x + matrices[k, 5] * d.y + matrices[k, 6] * d.z,
        matrices[k, 8] * d.x + matrices[k, 9] * d.y + matrices[k, 10] * d.z,
    )


@device
def into_object(geometry, instance, origin, direction):
    """A ray's origin and direction in the space of an instance's object."""
    if geometry.identity[instance] != 0:
        return origin, direction
    matrices = geometry.to_object
    return affine_point(matrices, instance, origin), affine_vector(matrices, instance, direction)


@device
def _ask_entry(geometry, address, instance, origin, direction, limit, scratch):
    """What an entry of the accelerator answers to a ray in the space of an instance's object; the ray's words."""
    ray_address = element_address(scratch, RAY)
    ray = floats_at(ray_address, _RAY_WORDS)
    set_ray(ray, origin, direction, limit)
    blocks = element_address(geometry.blocks, geometry.first_blocks[instance] * BLOCK)
    return call_entry(address, (geometry.objects[instance], blocks, ray_address)), ray


@device
def _closest_by_entry(geometry, instance, origin, direction, best, scratch):
    """As _closest_in_instance, by the accelerator's entry."""
    slot, ray = _ask_entry(geometry, geometry.closest, instance, origin, direction, best.t, scratch)
    if slot < 0:
        return best
    slot += geometry.first_blocks[instance] * LANES
    return Hit(load_float(ray, LIMIT), load_float(ray, WEIGHT1), load_float(ray, WEIGHT2), slot, instance)


@device
def parts_of(geometry, instance):
    """Who finishes parts of the tree of an instance's object that wait."""
    return Waiting(geometry.finish, geometry.objects[instance])


@device
def _closest_in_instance(geometry, instance, origin, direction, best, scratch):
    """`best`, or the nearer hit of an instance."""
    o, d = into_object(geometry, instance, origin, direction)
    if geometry.closest != 0:
        return _closest_by_entry(geometry, instance, o, d, best, scratch)
    parts = parts_of(geometry, instance)
    root = geometry.roots[instance]
    t, w1, w2, slot = closest_triangle(geometry.nodes, geometry.blocks, root, o, d, best.t, scratch, parts)
    return Hit(t, w1, w2, slot, instance) if slot >= 0 else best


@device
def _any_in_instance(geometry, instance, origin, direction, t_max, scratch):
    o, d = into_object(geometry, instance, origin, direction)
    if geometry.any != 0:
        blocked, _ = _ask_entry(geometry, geometry.any, instance, o, d, t_max, scratch)
        return blocked != 0
    parts = parts_of(geometry, instance)
    return any_triangle(geometry.nodes, geometry.blocks, geometry.roots[instance], o, d, t_max, scratch, parts)


@device
def _closest_in_boxes(geometry, origin, direction, t_max, scratch):
    """As closest_hit, through the accelerator over the instances."""
    ray_address = element_address(scratch, RAY)
    t, code = ask_boxes(geometry.boxes, table_address(geometry), origin, direction, t_max, _CLOSEST, ray_address)
    if code < 0:
        return Hit(t_max, _ZERO, _ZERO, np.int64(-1), np.int64(0))
    ray, instance = floats_at(ray_address, _RAY_WORDS), code >> SLOT_BITS
    slot = code - (instance << SLOT_BITS)
    return Hit(t, load_float(ray, WEIGHT1), load_float(ray, WEIGHT2), slot, instance)


@device
def closest_hit(geometry, origin, direction, t_max, scratch):
    """The first triangle at 0 < t < t_max; `scratch` is float32 of SCRATCH_WORDS."""
    if geometry.boxes.things != 0:
        return _closest_in_boxes(geometry, origin, direction, t_max, scratch)
    best = Hit(t_max, _ZERO, _ZERO, np.int64(-1), np.int64(0))
    # The stack of the upper tree lies behind that of the lower one. Where there is one instance there is no upper tree:
    # code −2 is a leaf of the first one, and that is all.
    many = geometry.top_nodes.rows > 0
    base = np.int64(SCRATCH)
    top = base
    node = np.int32(0) if many else np.int32(-2)
    while True:
        if node >= 0:
            top = push_boxes(geometry.top_nodes, node, origin, direction, best.t, scratch, top, _NEAR)
        else:
            code = np.int64(-1) - np.int64(node)
            first = code >> 3
            for entry in range(first, first + (code & 7)):
                instance = np.int64(geometry.top_items[entry]) if many else np.int64(0)
                best = _closest_in_instance(geometry, instance, origin, direction, best, scratch)
        while True:
            if top == base:
                return best
            top -= 2
            if load_float(scratch, top) < best.t:
                node = load_int(scratch, top + 1)
                break


@device
def push_boxes(nodes, node, origin, direction, t_max, scratch, top, near_row):
    """Push the children of a node of a tree over boxes that the ray enters, the nearest last. Returns the new top.

    `near_row` is where the scratch has WIDTH words to spare.
    """
    entered, near = enter_children(
        nodes, np.int64(node) * NODE, slabs(origin, direction, load_float(nodes, REACH)), t_max
    )
    store8(scratch, near_row, near)
    bottom = top
    while entered != 0:
        k = np.int64(lowest_bit(entered))
        entered &= entered - np.int32(1)
        distance = load_float(scratch, near_row + k)
        at = top
        while at > bottom:
            above = load_float(scratch, at - 2)
            if above >= distance:
                break
            store_float(scratch, at, above)
            store_int(scratch, at + 1, load_int(scratch, at - 1))
            at -= 2
        store_float(scratch, at, distance)
        store_int(scratch, at + 1, load_int(nodes, np.int64(node) * NODE + CHILD + k))
        top += 2
    return top


@device
def occluded(geometry, origin, direction, t_max, scratch):
    """Whether any triangle lies at 0 < t < t_max."""
    if geometry.blocking.things != 0:
        ray = element_address(scratch, RAY)
        _, code = ask_boxes(geometry.blocking, table_address(geometry), origin, direction, t_max, _ANY, ray)
        return code >= 0
    many = geometry.top_nodes.rows > 0
    base = np.int64(SCRATCH)
    top = base
    node = np.int32(0) if many else np.int32(-2)
    while True:
        if node >= 0:
            top = push_boxes(geometry.top_nodes, node, origin, direction, t_max, scratch, top, _NEAR)
        else:
            code = np.int64(-1) - np.int64(node)
            first = code >> 3
            for entry in range(first, first + (code & 7)):
                instance = np.int64(geometry.top_items[entry]) if many else np.int64(0)
                if _any_in_instance(geometry, instance, origin, direction, t_max, scratch):
                    return True
        if top == base:
            return False
        top -= 2
        node = load_int(scratch, top + 1)
