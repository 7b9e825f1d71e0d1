"""Rays through a bounding interval hierarchy, in bih_layout.py's memory, which they build where they come.

From the root down, a ray is cut to each node's slab and goes to the side that it meets first; the other one waits on a
stack with the interval of the ray that lies there. Intervals are wider than slabs and sides by the ray's slack
(spread.py). Any of them may be empty.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from isophote.kernels.accel.bih_layout import BIH, LEAF, NODE, PLANES, SLAB, SLAB_AXIS
from isophote.kernels.accel.contract import (
    STACK,
    add_counts,
    answer,
    any_in_blocks,
    nearest_of,
    ray_at,
    ray_direction,
    ray_origin,
)
from isophote.kernels.accel.layout import LANES
from isophote.kernels.accel.spread import box_interval, spread_of
from isophote.kernels.accel.things import closest_in_leaf, enough, tested_in_leaf, things_of
from isophote.kernels.base.atomic import load_acquire
from isophote.kernels.base.entry import call_entry, entry, floats_at, opener_at
from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import load_float, load_int, store_float, store_int
from isophote.kernels.forms.triangle import shear

__all__ = ["any_in_bih", "closest_in_bih", "things_in_bih"]

open_bih = opener_at(BIH)

# Scratch: origin, 1/d, slack and sign by axis, then a stack of entries of four words: node, level, interval.
_ORIGIN, _INVERSE, _SLACK, _DOWN = np.int64(STACK), np.int64(STACK + 4), np.int64(STACK + 8), np.int64(STACK + 12)
_BOTTOM, _ENTRY = np.int64(STACK + 16), np.int64(4)
_LEAF, _LANES, _ONE = np.int64(LEAF), np.int64(LANES), np.int64(1)
_ZERO = np.float32(0)
_UNSPLIT = np.int64(-2)
_MOST_BLOCK_WORDS = np.int64(1) << np.int64(40)


class _Place(NamedTuple):
    """A node, its level, the ray's interval in it, the top of the stack, and the leaf's block, or −1, or _UNSPLIT;
    `node` is −1 at the end."""

    node: int
    level: int
    enter: float
    leave: float
    top: int
    block: int


@device
def _begin(tree, words, limit):
    """The root, with the ray's interval in all that the hierarchy holds."""
    spread = spread_of(ray_origin(words), ray_direction(words), tree.reach)
    for row, v in ((_ORIGIN, spread.origin), (_INVERSE, spread.inverse), (_SLACK, spread.slack)):
        store_float(words, row, v.x)
        store_float(words, row + 1, v.y)
        store_float(words, row + 2, v.z)
    inverse = spread.inverse
    store_int(words, _DOWN, np.int32(inverse.x < _ZERO))
    store_int(words, _DOWN + 1, np.int32(inverse.y < _ZERO))
    store_int(words, _DOWN + 2, np.int32(inverse.z < _ZERO))
    enter, leave = box_interval(spread, tree.bounds, limit)
    met = tree.count > 0 and enter <= leave
    return _Place(np.int64(0) if met else -_ONE, np.int64(0), enter, leave, _BOTTOM, -_ONE)


@device
def _descend(tree, words, place):
    """From a node to the leaf that the ray is in first, or to a node in which it meets nothing, or that is to be split;
    other sides wait on the stack where the ray comes there too."""
    nodes = tree.nodes
    node, level, enter, leave, top = place.node, place.level, place.enter, place.leave, place.top
    while True:
        axis = np.int64(load_int(nodes, node * NODE + SLAB_AXIS))
        origin, inverse = load_float(words, _ORIGIN + axis), load_float(words, _INVERSE + axis)
        slack = load_float(words, _SLACK + axis)
        low = (load_float(nodes, node * NODE + SLAB) - origin) * inverse
        high = (load_float(nodes, node * NODE + SLAB + 1) - origin) * inverse
        enter, leave = max(min(low, high) - slack, enter), min(max(low, high) + slack, leave)
        if enter > leave:
            return _Place(node, level, enter, leave, top, -_ONE)
        code = np.int64(load_acquire(nodes, node * NODE))
        if code <= 0:
            return _Place(node, level, enter, leave, top, _UNSPLIT)
        axis, number = code & _LEAF, (code >> 2) - _ONE
        if axis == _LEAF:
            return _Place(node, level, enter, leave, top, number)
        down = np.int64(load_int(words, _DOWN + axis))
        origin, inverse = load_float(words, _ORIGIN + axis), load_float(words, _INVERSE + axis)
        slack = load_float(words, _SLACK + axis)
        # The nearer side's plane is where it ends, the other one's where that begins, as the ray goes.
        near_leave = min((load_float(nodes, node * NODE + PLANES + down) - origin) * inverse + slack, leave)
        far_enter = max((load_float(nodes, node * NODE + PLANES + 1 - down) - origin) * inverse - slack, enter)
        near = 2 * number + down
        if enter <= near_leave:
            if far_enter <= leave:
                store_int(words, top, np.int32(near ^ _ONE))
                store_int(words, top + 1, np.int32(level + 1))
                store_float(words, top + 2, far_enter)
                store_float(words, top + 3, leave)
                top += _ENTRY
            node, leave = near, near_leave
        elif far_enter <= leave:
            node, enter = near ^ _ONE, far_enter
        else:
            return _Place(node, level, enter, leave, top, -_ONE)
        level += 1


@device
def _next_waiting(words, top, limit):
    """The next node on the stack whose interval begins before `limit`."""
    while top > _BOTTOM:
        top -= _ENTRY
        enter = load_float(words, top + 2)
        if enter <= limit:
            node, level = np.int64(load_int(words, top)), np.int64(load_int(words, top + 1))
            return _Place(node, level, enter, load_float(words, top + 3), top, -_ONE)
    return _Place(-_ONE, np.int64(0), limit, limit, top, -_ONE)


@device
def _closest(tables, blocks, words, things):
    tree = open_bih(tables)
    triangles = floats_at(blocks, _MOST_BLOCK_WORDS)
    sheared = shear(ray_origin(words), ray_direction(words))
    nearest = nearest_of(words)
    place = _begin(tree, words, nearest.t)
    visited, tested, deepest = np.int64(0), np.int64(0), np.int64(0)
    while place.node >= 0:
        above = place.level
        place = _descend(tree, words, place)
        visited += place.level - above
        if place.block == _UNSPLIT:
            call_entry(tree.split, (tables, blocks, place.node, place.level))
            continue
        visited += 1
        deepest = max(deepest, place.level)
        if place.block >= 0:
            count = min(_LANES, tree.count - place.block * _LANES)
            tested += tested_in_leaf(count, things)
            nearest = closest_in_leaf(triangles, place.block, count, sheared, things, nearest, words)
            if enough(things, nearest):
                break
        place = _next_waiting(words, place.top, nearest.t)
    add_counts(words, visited, tested, deepest)
    return answer(words, nearest)


@entry
def closest_in_bih(tables, blocks, ray):
    return _closest(tables, blocks, ray_at(ray), None)


@entry
def things_in_bih(tables, blocks, ray, test, subject, any_will_do):
    words, reach = ray_at(ray), open_bih(tables).reach
    return _closest(tables, blocks, words, things_of(ray, words, reach, test, subject, any_will_do))


@entry
def any_in_bih(tables, blocks, ray):
    tree, words = open_bih(tables), ray_at(ray)
    triangles = floats_at(blocks, _MOST_BLOCK_WORDS)
    sheared = shear(ray_origin(words), ray_direction(words))
    limit = nearest_of(words).t
    place = _begin(tree, words, limit)
    visited, tested, deepest, met = np.int64(0), np.int64(0), np.int64(0), np.int64(0)
    while place.node >= 0:
        above = place.level
        place = _descend(tree, words, place)
        visited += place.level - above
        if place.block == _UNSPLIT:
            call_entry(tree.split, (tables, blocks, place.node, place.level))
            continue
        visited += 1
        deepest = max(deepest, place.level)
        if place.block >= 0:
            count = min(_LANES, tree.count - place.block * _LANES)
            tested += count
            if any_in_blocks(triangles, place.block, count, sheared, limit):
                met = np.int64(1)
                break
        place = _next_waiting(words, place.top, limit)
    add_counts(words, visited, tested, deepest)
    return met
