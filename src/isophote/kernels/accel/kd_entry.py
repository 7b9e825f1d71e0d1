"""Rays through a kd-tree, in kd_layout.py's memory.

From the root down, a ray goes to the side of each plane that it is on first, and the other side waits on a stack with
the interval of the ray that lies there (Wald: "Realtime Ray Tracing and Interactive Global Illumination", 2004, section
7.2). Intervals overlap by the ray's slack (spread.py), so nothing slips between two sides, and what is met before an
interval begins is nearer than all within it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

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
from isophote.kernels.accel.kd_layout import KD, LEAF
from isophote.kernels.accel.spread import box_interval, spread_of
from isophote.kernels.accel.things import closest_in_leaf, enough, tested_in_leaf, things_of
from isophote.kernels.base.entry import entry, floats_at, opener_at
from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import load_float, load_int, store_float, store_int
from isophote.kernels.forms.triangle import shear

__all__ = ["any_in_kd", "closest_in_kd", "things_in_kd"]

open_kd = opener_at(KD)

# Scratch: origin, 1/d, slack and sign by axis, then a stack of entries of four words: node, level, interval.
_ORIGIN, _INVERSE, _SLACK, _DOWN = np.int64(STACK), np.int64(STACK + 4), np.int64(STACK + 8), np.int64(STACK + 12)
_BOTTOM, _ENTRY = np.int64(STACK + 16), np.int64(4)
_LEAF, _ONE = np.int64(LEAF), np.int64(1)
_ZERO = np.float32(0)
_MOST_BLOCK_WORDS = np.int64(1) << np.int64(40)


class _Place(NamedTuple):
    """A node, its level, the ray's interval in it, and the top of the stack; `node` is −1 at the end."""

    node: int
    level: int
    enter: float
    leave: float
    top: int


@device
def _begin(tree, words, limit):
    """The root, with the ray's interval in all that the tree holds."""
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
    return _Place(np.int64(0) if enter <= leave else -_ONE, np.int64(0), enter, leave, _BOTTOM)


@device
def _descend(nodes, words, place):
    """From a node to the leaf that the ray is in first; other sides wait on the stack where the ray comes there too."""
    node, level, enter, leave, top = place.node, place.level, place.enter, place.leave, place.top
    while True:
        code = np.int64(load_int(nodes, 2 * node + 1))
        axis = code & _LEAF
        if axis == _LEAF:
            return _Place(node, level, enter, leave, top)
        # Children are a pair from an even number on: the nearer side is that of the ray's sign, the other its partner.
        near = (code >> 2) + np.int64(load_int(words, _DOWN + axis))
        t = (load_float(nodes, 2 * node) - load_float(words, _ORIGIN + axis)) * load_float(words, _INVERSE + axis)
        slack = load_float(words, _SLACK + axis)
        level += 1
        node = near
        if t - slack > leave:
            continue
        if t + slack < enter:
            node = near ^ _ONE
            continue
        store_int(words, top, np.int32(near ^ _ONE))
        store_int(words, top + 1, np.int32(level))
        store_float(words, top + 2, max(t - slack, enter))
        store_float(words, top + 3, leave)
        top += _ENTRY
        leave = min(t + slack, leave)


@device
def _next_waiting(words, top, limit):
    """The next node on the stack whose interval begins before `limit`."""
    while top > _BOTTOM:
        top -= _ENTRY
        enter = load_float(words, top + 2)
        if enter <= limit:
            node, level = np.int64(load_int(words, top)), np.int64(load_int(words, top + 1))
            return _Place(node, level, enter, load_float(words, top + 3), top)
    return _Place(-_ONE, np.int64(0), limit, limit, top)


@device
def _closest(tree, blocks, words, things):
    triangles, nodes = floats_at(blocks, _MOST_BLOCK_WORDS), tree.nodes
    sheared = shear(ray_origin(words), ray_direction(words))
    nearest = nearest_of(words)
    place = _begin(tree, words, nearest.t)
    visited, tested, deepest = np.int64(0), np.int64(0), np.int64(0)
    while place.node >= 0:
        above = place.level
        place = _descend(nodes, words, place)
        visited += place.level - above + 1
        deepest = max(deepest, place.level)
        count = np.int64(load_int(nodes, 2 * place.node + 1)) >> 2
        if count > 0:
            tested += tested_in_leaf(count, things)
            first = np.int64(load_int(nodes, 2 * place.node))
            nearest = closest_in_leaf(triangles, first, count, sheared, things, nearest, words)
            if enough(things, nearest):
                break
        place = _next_waiting(words, place.top, nearest.t)
    add_counts(words, visited, tested, deepest)
    return answer(words, nearest)


@entry
def closest_in_kd(tables, blocks, ray):
    return _closest(open_kd(tables), blocks, ray_at(ray), None)


@entry
def things_in_kd(tables, blocks, ray, test, subject, any_will_do):
    tree, words = open_kd(tables), ray_at(ray)
    return _closest(tree, blocks, words, things_of(ray, words, tree.reach, test, subject, any_will_do))


@entry
def any_in_kd(tables, blocks, ray):
    tree, words = open_kd(tables), ray_at(ray)
    triangles, nodes = floats_at(blocks, _MOST_BLOCK_WORDS), tree.nodes
    sheared = shear(ray_origin(words), ray_direction(words))
    limit = nearest_of(words).t
    place = _begin(tree, words, limit)
    visited, tested, deepest, met = np.int64(0), np.int64(0), np.int64(0), np.int64(0)
    while place.node >= 0:
        above = place.level
        place = _descend(nodes, words, place)
        visited += place.level - above + 1
        deepest = max(deepest, place.level)
        count = np.int64(load_int(nodes, 2 * place.node + 1)) >> 2
        if count > 0:
            tested += count
            first = np.int64(load_int(nodes, 2 * place.node))
            if any_in_blocks(triangles, first, count, sheared, limit):
                met = np.int64(1)
                break
        place = _next_waiting(words, place.top, limit)
    add_counts(words, visited, tested, deepest)
    return met
