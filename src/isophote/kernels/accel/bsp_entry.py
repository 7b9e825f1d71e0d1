"""Rays through a BSP tree, in bsp_layout.py's memory.

As through a kd-tree (kd_entry.py): the nearer side of each plane first, while the other waits on a stack with the
interval of the ray that lies there. A plane along an axis costs what it costs there; at a slanted one, n · o and n · d
take three multiplications and additions each, and there is a division.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from isophote.kernels.accel.bsp_layout import BSP, KINDS, LEAF, PLANE, SHIFT, SLANTED, WIDER
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
from isophote.kernels.accel.spread import LEAST_SHARE, PLACE_SLACK, TINY, Spread, box_interval, spread_of
from isophote.kernels.accel.things import closest_in_leaf, enough, tested_in_leaf, things_of
from isophote.kernels.base.entry import entry, floats_at, opener_at
from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import load_float, load_int, store_float, store_int
from isophote.kernels.base.vec import vec3
from isophote.kernels.forms.triangle import shear

__all__ = ["any_in_bsp", "closest_in_bsp", "things_in_bsp"]

open_bsp = opener_at(BSP)

# Scratch: origin, 1/d, slack and sign by axis, then a stack of entries of four words: node, level, interval.
_ORIGIN, _INVERSE, _SLACK, _DOWN = np.int64(STACK), np.int64(STACK + 4), np.int64(STACK + 8), np.int64(STACK + 12)
_BOTTOM, _ENTRY = np.int64(STACK + 16), np.int64(4)
_LEAF, _SLANTED, _KINDS, _SHIFT, _PLANE = (
    np.int64(LEAF), np.int64(SLANTED), np.int64(KINDS), np.int64(SHIFT), np.int64(PLANE)
)  # fmt: skip
_ONE = np.int64(1)
_ZERO, _UNIT, _WIDER = np.float32(0), np.float32(1), np.float32(WIDER)
# Numbers from which on n · o and n · d might overflow, and then a slack that makes rays go to both sides.
_LARGE, _ENDLESS = np.float32(1e37), np.float32(np.inf)
_MOST_BLOCK_WORDS = np.int64(1) << np.int64(40)


class _Place(NamedTuple):
    """A node, its level, the ray's interval in it, and the top of the stack; `node` is −1 at the end."""

    node: int
    level: int
    enter: float
    leave: float
    top: int


class _Slant(NamedTuple):
    """A ray made ready for slanted planes: origin, direction, how far from it things count as on it, and the least size
    of n · d."""

    origin: object
    direction: object
    slack: float
    least: float


@device
def _largest(v):
    return max(abs(v.x), max(abs(v.y), abs(v.z)))


@device
def _slant_of(words, reach):
    origin, direction = ray_origin(words), ray_direction(words)
    most, longest = max(reach, _largest(origin)), _largest(direction)
    slack = _ENDLESS if max(most, longest) > _LARGE else most * PLACE_SLACK * _WIDER
    return _Slant(origin, direction, slack, max(longest * LEAST_SHARE, TINY))


@device
def _begin(tree, words, limit):
    """The root, with the ray's interval in all that the tree holds."""
    narrow = spread_of(ray_origin(words), ray_direction(words), tree.reach)
    s = narrow.slack
    spread = Spread(narrow.origin, narrow.inverse, vec3(s.x * _WIDER, s.y * _WIDER, s.z * _WIDER))
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
def _meet_slanted(planes, first, ray):
    """Where the ray meets a slanted plane, how uncertain that is, and 1 where it comes from above."""
    x, y, z = load_float(planes, first), load_float(planes, first + 1), load_float(planes, first + 2)
    o, d = ray.origin, ray.direction
    along = x * d.x + y * d.y + z * d.z
    down = np.int64(along < _ZERO)
    if abs(along) < ray.least:
        along = -ray.least if along < _ZERO else ray.least
    inverse = _UNIT / along
    t = (load_float(planes, first + 3) - (x * o.x + y * o.y + z * o.z)) * inverse
    return t, ray.slack * abs(inverse), down


@device
def _descend(tree, words, ray, place):
    """From a node to the leaf that the ray is in first; other sides wait on the stack where the ray comes there too."""
    nodes, planes = tree.nodes, tree.planes
    node, level, enter, leave, top = place.node, place.level, place.enter, place.leave, place.top
    while True:
        code = np.int64(load_int(nodes, 2 * node + 1))
        kind = code & _KINDS
        if kind < _LEAF:
            t = (load_float(nodes, 2 * node) - load_float(words, _ORIGIN + kind)) * load_float(words, _INVERSE + kind)
            slack, down = load_float(words, _SLACK + kind), np.int64(load_int(words, _DOWN + kind))
        elif kind == _SLANTED:
            t, slack, down = _meet_slanted(planes, np.int64(load_int(nodes, 2 * node)) * _PLANE, ray)
        else:
            return _Place(node, level, enter, leave, top)
        near = (code >> _SHIFT) + down
        level += 1
        node = near
        # Where t is not a number, no comparison holds, and both sides keep the whole interval.
        soonest, latest = t - slack, t + slack
        if soonest > leave:
            continue
        if latest < enter:
            node = near ^ _ONE
            continue
        store_int(words, top, np.int32(near ^ _ONE))
        store_int(words, top + 1, np.int32(level))
        store_float(words, top + 2, soonest if soonest > enter else enter)
        store_float(words, top + 3, leave)
        top += _ENTRY
        leave = latest if latest < leave else leave


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
    slant, nearest = _slant_of(words, tree.reach), nearest_of(words)
    place = _begin(tree, words, nearest.t)
    visited, tested, deepest = np.int64(0), np.int64(0), np.int64(0)
    while place.node >= 0:
        above = place.level
        place = _descend(tree, words, slant, place)
        visited += place.level - above + 1
        deepest = max(deepest, place.level)
        count = np.int64(load_int(nodes, 2 * place.node + 1)) >> _SHIFT
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
def closest_in_bsp(tables, blocks, ray):
    return _closest(open_bsp(tables), blocks, ray_at(ray), None)


@entry
def things_in_bsp(tables, blocks, ray, test, subject, any_will_do):
    tree, words = open_bsp(tables), ray_at(ray)
    return _closest(tree, blocks, words, things_of(ray, words, tree.reach, test, subject, any_will_do))


@entry
def any_in_bsp(tables, blocks, ray):
    tree, words = open_bsp(tables), ray_at(ray)
    triangles, nodes = floats_at(blocks, _MOST_BLOCK_WORDS), tree.nodes
    sheared = shear(ray_origin(words), ray_direction(words))
    slant, limit = _slant_of(words, tree.reach), nearest_of(words).t
    place = _begin(tree, words, limit)
    visited, tested, deepest, met = np.int64(0), np.int64(0), np.int64(0), np.int64(0)
    while place.node >= 0:
        above = place.level
        place = _descend(tree, words, slant, place)
        visited += place.level - above + 1
        deepest = max(deepest, place.level)
        count = np.int64(load_int(nodes, 2 * place.node + 1)) >> _SHIFT
        if count > 0:
            tested += count
            first = np.int64(load_int(nodes, 2 * place.node))
            if any_in_blocks(triangles, first, count, sheared, limit):
                met = np.int64(1)
                break
        place = _next_waiting(words, place.top, limit)
    add_counts(words, visited, tested, deepest)
    return met
