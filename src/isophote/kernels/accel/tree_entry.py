"""The tree of eight children a node (bvh.py) as an accelerator's entries, which count what a ray visits.

Pictures go through bvh.py, which is compiled into their kernels and counts nothing. Rays come by the same nodes in the
same order here.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.bvh import enter_children, slabs
from isophote.kernels.accel.contract import (
    STACK,
    add_counts,
    answer,
    any_in_blocks,
    closest_in_blocks,
    nearest_of,
    ray_at,
    ray_direction,
    ray_origin,
)
from isophote.kernels.accel.layout import BLOCK, CHILD, LANES, NODE, NUMBER, REACH
from isophote.kernels.accel.things import enough, test_thing, things_of
from isophote.kernels.base.entry import entry, floats_at, ints_at, opener_at
from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import load_float, load_int, lowest_bit, store8, store_float, store_int
from isophote.kernels.base.table import FLOATS, INT, Table
from isophote.kernels.forms.triangle import shear

__all__ = ["TREE", "any_in_tree", "closest_in_tree", "push_children", "things_in_tree", "triangles_in"]

# `nodes`, and the number of the `root` among them.
TREE = Table("Tree", nodes=FLOATS, root=INT)
open_tree = opener_at(TREE)

# A row of distances to children, then a stack of entries of three words: distance, node's code, level.
_NEAR, _STACK = np.int64(STACK), np.int64(STACK + 8)
_ENTRY = np.int64(3)
_MOST_BLOCK_WORDS = np.int64(1) << np.int64(40)


@device
def _reach_of(tree):
    return load_float(tree.nodes, tree.root * NODE + REACH)


@device
def triangles_in(blocks, first, last):
    """How many triangles blocks first ≤ b < last hold."""
    count = np.int64((last - first) * LANES)
    at = (last - 1) * BLOCK + NUMBER
    for k in range(LANES):
        if load_int(blocks, at + k) < 0:
            count -= 1
    return count


@device
def push_children(nodes, node, box, t_max, level, ray, top):
    """Push the children that the ray enters before `t_max`, the nearest last. Returns the new top."""
    base = np.int64(node) * NODE
    entered, near = enter_children(nodes, base, box, t_max)
    store8(ray, _NEAR, near)
    bottom = top
    while entered != 0:
        k = np.int64(lowest_bit(entered))
        entered &= entered - np.int32(1)
        distance = load_float(ray, _NEAR + k)
        at = top
        while at > bottom and load_float(ray, at - _ENTRY) < distance:
            for word in range(_ENTRY):
                store_int(ray, at + word, load_int(ray, at - _ENTRY + word))
            at -= _ENTRY
        store_float(ray, at, distance)
        store_int(ray, at + 1, load_int(nodes, base + CHILD + k))
        store_int(ray, at + 2, np.int32(level))
        top += _ENTRY
    return top


@entry
def closest_in_tree(tables, blocks, ray):
    tree, words = open_tree(tables), ray_at(ray)
    triangles = floats_at(blocks, _MOST_BLOCK_WORDS)
    origin, direction = ray_origin(words), ray_direction(words)
    box, sheared = slabs(origin, direction, _reach_of(tree)), shear(origin, direction)
    nearest = nearest_of(words)
    visited, tested, deepest, level = np.int64(0), np.int64(0), np.int64(0), np.int64(0)
    top = _STACK
    node = np.int32(tree.root)
    while True:
        visited += 1
        deepest = max(deepest, level)
        if node >= 0:
            top = push_children(tree.nodes, node, box, nearest.t, level + 1, words, top)
        else:
            code = np.int64(-1) - np.int64(node)
            first, last = code >> 3, (code >> 3) + (code & 7)
            count = triangles_in(triangles, first, last)
            tested += count
            nearest = closest_in_blocks(triangles, first, count, sheared, nearest, words)
        while True:
            if top == _STACK:
                add_counts(words, visited, tested, deepest)
                return answer(words, nearest)
            top -= _ENTRY
            if load_float(words, top) < nearest.t:
                node, level = load_int(words, top + 1), np.int64(load_int(words, top + 2))
                break


@entry
def any_in_tree(tables, blocks, ray):
    tree, words = open_tree(tables), ray_at(ray)
    triangles = floats_at(blocks, _MOST_BLOCK_WORDS)
    origin, direction = ray_origin(words), ray_direction(words)
    box, sheared = slabs(origin, direction, _reach_of(tree)), shear(origin, direction)
    limit = nearest_of(words).t
    visited, tested, deepest = np.int64(0), np.int64(0), np.int64(0)
    met = np.int64(0)
    store_int(words, _STACK + 1, np.int32(tree.root))
    store_int(words, _STACK + 2, np.int32(0))
    top = _STACK + _ENTRY
    while top > _STACK and met == 0:
        top -= _ENTRY
        node, level = load_int(words, top + 1), np.int64(load_int(words, top + 2))
        visited += 1
        deepest = max(deepest, level)
        if node >= 0:
            top = push_children(tree.nodes, node, box, limit, level + 1, words, top)
        else:
            code = np.int64(-1) - np.int64(node)
            first, last = code >> 3, (code >> 3) + (code & 7)
            count = triangles_in(triangles, first, last)
            tested += count
            met = np.int64(any_in_blocks(triangles, first, count, sheared, limit))
    add_counts(words, visited, tested, deepest)
    return met


@entry
def things_in_tree(tables, items, ray, test, subject, any_will_do):
    """Over boxes: `items` is the address of the numbers of things, int32, of which leaves name a range."""
    tree, words = open_tree(tables), ray_at(ray)
    numbers = ints_at(items, _MOST_BLOCK_WORDS)
    box = slabs(ray_origin(words), ray_direction(words), _reach_of(tree))
    things, nearest = things_of(ray, words, _reach_of(tree), test, subject, any_will_do), nearest_of(words)
    visited, deepest, level = np.int64(0), np.int64(0), np.int64(0)
    top = _STACK
    node = np.int32(tree.root)
    while True:
        visited += 1
        deepest = max(deepest, level)
        if node >= 0:
            top = push_children(tree.nodes, node, box, nearest.t, level + 1, words, top)
        else:
            code = np.int64(-1) - np.int64(node)
            first = code >> 3
            for at in range(first, first + (code & 7)):
                nearest = test_thing(numbers[at], things, nearest, words)
                if enough(things, nearest):
                    top = _STACK
                    break
        while True:
            if top == _STACK:
                add_counts(words, visited, np.int64(0), deepest)
                return answer(words, nearest)
            top -= _ENTRY
            if load_float(words, top) < nearest.t:
                node, level = load_int(words, top + 1), np.int64(load_int(words, top + 2))
                break
