"""Rays through a bounding interval hierarchy by entries, which count what a ray visits and finish what it comes to.

Pictures go through bvh.py, as through any tree of eight children a node, and have parts finished by waiting.py. Rays
come by the same nodes in the same order here, whatever is finished before.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.bih_layout import BIH
from isophote.kernels.accel.bvh import slabs
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
from isophote.kernels.accel.layout import WIDTH
from isophote.kernels.accel.things import closest_in_leaf, enough, tested_in_leaf, things_of
from isophote.kernels.accel.tree_entry import push_children, triangles_in
from isophote.kernels.base.entry import call_entry, entry, opener_at
from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import load_float, load_int, store_int
from isophote.kernels.forms.triangle import shear

__all__ = ["any_in_bih", "closest_in_bih", "things_in_bih"]

open_bih = opener_at(BIH)

# A row of distances to children, then the stack (tree_entry.py).
_STACK, _ENTRY = np.int64(STACK + WIDTH), np.int64(3)
_BLOCKS, _ROOT = np.int64(7), np.int32(0)


@device
def _finished(tree, tables, node):
    """The code of what has a negative one: what becomes of a part, or the leaf that it is."""
    code = np.int64(-1) - np.int64(node)
    if code & _BLOCKS == 0:
        return call_entry(tree.finish, (tables, code >> 3))
    return np.int64(node)


@device
def _closest(tables, words, things):
    tree = open_bih(tables)
    origin, direction = ray_origin(words), ray_direction(words)
    box, sheared = slabs(origin, direction, tree.reach), shear(origin, direction)
    nearest = nearest_of(words)
    visited, tested, deepest, level = np.int64(0), np.int64(0), np.int64(0), np.int64(0)
    top = _STACK
    node = _ROOT
    while True:
        if node < 0:
            node = np.int32(_finished(tree, tables, node))
        visited += 1
        deepest = max(deepest, level)
        if node >= 0:
            top = push_children(tree.nodes, node, box, nearest.t, level + 1, words, top)
        else:
            code = np.int64(-1) - np.int64(node)
            first, last = code >> 3, (code >> 3) + (code & _BLOCKS)
            count = triangles_in(tree.blocks, first, last)
            tested += tested_in_leaf(count, things)
            nearest = closest_in_leaf(tree.blocks, first, count, sheared, things, nearest, words)
            if enough(things, nearest):
                top = _STACK
        while True:
            if top == _STACK:
                add_counts(words, visited, tested, deepest)
                return answer(words, nearest)
            top -= _ENTRY
            if load_float(words, top) < nearest.t:
                node, level = load_int(words, top + 1), np.int64(load_int(words, top + 2))
                break


@entry
def closest_in_bih(tables, blocks, ray):
    return _closest(tables, ray_at(ray), None)


@entry
def things_in_bih(tables, blocks, ray, test, subject, any_will_do):
    words, reach = ray_at(ray), open_bih(tables).reach
    return _closest(tables, words, things_of(ray, words, reach, test, subject, any_will_do))


@entry
def any_in_bih(tables, blocks, ray):
    tree, words = open_bih(tables), ray_at(ray)
    origin, direction = ray_origin(words), ray_direction(words)
    box, sheared = slabs(origin, direction, tree.reach), shear(origin, direction)
    limit = nearest_of(words).t
    visited, tested, deepest, met = np.int64(0), np.int64(0), np.int64(0), np.int64(0)
    store_int(words, _STACK + 1, _ROOT)
    store_int(words, _STACK + 2, np.int32(0))
    top = _STACK + _ENTRY
    while top > _STACK and met == 0:
        top -= _ENTRY
        node, level = load_int(words, top + 1), np.int64(load_int(words, top + 2))
        if node < 0:
            node = np.int32(_finished(tree, tables, node))
        visited += 1
        deepest = max(deepest, level)
        if node >= 0:
            top = push_children(tree.nodes, node, box, limit, level + 1, words, top)
        else:
            code = np.int64(-1) - np.int64(node)
            first, last = code >> 3, (code >> 3) + (code & _BLOCKS)
            count = triangles_in(tree.blocks, first, last)
            tested += count
            met = np.int64(any_in_blocks(tree.blocks, first, count, sheared, limit))
    add_counts(words, visited, tested, deepest)
    return met
