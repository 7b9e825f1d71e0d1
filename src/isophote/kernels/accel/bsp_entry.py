"""Rays through a BSP tree, in bsp_layout.py's memory, by treelets (treelet.py).

At a plane in any direction, n · o and n · d take three multiplications and additions each, and there is a division. For
eight planes at once that is little more than what planes along axes take, so these are treated alike.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from isophote.kernels.accel.bsp_layout import BSP, CODES, PLACES, PRESENT, TREELET, WIDER
from isophote.kernels.accel.contract import (
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
from isophote.kernels.accel.treelet import (
    NOWHERE,
    Place,
    bottom_of,
    intervals,
    leaf_at,
    near_sides,
    next_waiting,
    step_down,
)
from isophote.kernels.base.entry import entry, floats_at, opener_at
from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import absolute, bits, load8, load_int, select, splat8
from isophote.kernels.base.vec import vec3
from isophote.kernels.forms.triangle import shear

__all__ = ["any_in_bsp", "closest_in_bsp", "things_in_bsp"]

open_bsp = opener_at(BSP)

_TREELET, _PRESENT, _PLACES, _CODES = np.int64(TREELET), np.int64(PRESENT), np.int64(PLACES), np.int64(CODES)
_ROW, _CHILDREN, _PLANES = np.int64(8), np.int64(255), np.int64(127)
_ROOT, _TOP_LEVEL = np.int64(0), np.int64(0)
_ZERO, _UNIT, _WIDER = np.float32(0), np.float32(1), np.float32(WIDER)
# Numbers from which on n · o and n · d might overflow, and then a slack that makes rays go to both sides.
_LARGE, _ENDLESS = np.float32(1e37), np.float32(np.inf)
_MOST_BLOCK_WORDS = np.int64(1) << np.int64(40)


class _Slant(NamedTuple):
    """A ray made ready for planes, eight times over: origin, direction, how far from it things count as on it, and the
    least size of n · d, with either sign."""

    ox: object
    oy: object
    oz: object
    dx: object
    dy: object
    dz: object
    slack: object
    least: object
    negative: object


@device
def _largest(v):
    return max(abs(v.x), max(abs(v.y), abs(v.z)))


@device
def _begin(tree, words, bottom, limit):
    """The ray made ready, and the root, with the ray's interval in all that the tree holds."""
    o, d = ray_origin(words), ray_direction(words)
    most, longest = max(tree.reach, _largest(o)), _largest(d)
    slack = _ENDLESS if max(most, longest) > _LARGE else most * PLACE_SLACK * _WIDER
    least = max(longest * LEAST_SHARE, TINY)
    slant = _Slant(
        splat8(o.x),
        splat8(o.y),
        splat8(o.z),
        splat8(d.x),
        splat8(d.y),
        splat8(d.z),
        splat8(slack),
        splat8(least),
        splat8(-least),
    )
    narrow = spread_of(o, d, tree.reach)
    s = narrow.slack
    spread = Spread(narrow.origin, narrow.inverse, vec3(s.x * _WIDER, s.y * _WIDER, s.z * _WIDER))
    enter, leave = box_interval(spread, tree.bounds, limit)
    return slant, Place(_ROOT if enter <= leave else NOWHERE, _TOP_LEVEL, enter, leave, bottom)


@device
def _enter(nodes, base, ray, place):
    """Children of the treelet at word `base` that the ray enters: (planes whose upper side it comes to first, what is
    near, children, where it enters, where it leaves); the first and third are bits."""
    x, y, z = load8(nodes, base), load8(nodes, base + _ROW), load8(nodes, base + 2 * _ROW)
    along = x * ray.dx + y * ray.dy + z * ray.dz
    below = along < splat8(_ZERO)
    along = select(absolute(along) < ray.least, select(below, ray.negative, ray.least), along)
    inverse = splat8(_UNIT) / along
    t = (load8(nodes, base + _PLACES) - (x * ray.ox + y * ray.oy + z * ray.oz)) * inverse
    slack = ray.slack * absolute(inverse)
    falling = np.int64(bits(below)) & _PLANES
    near = near_sides(falling)
    enter, leave = intervals(t - slack, t + slack, near, place)
    present = np.int64(load_int(nodes, base + _PRESENT)) & _CHILDREN
    return falling, near, np.int64(bits(enter <= leave)) & present, enter, leave


@device
def _closest(tree, blocks, words, bottom, things):
    triangles, nodes = floats_at(blocks, _MOST_BLOCK_WORDS), tree.nodes
    sheared = shear(ray_origin(words), ray_direction(words))
    nearest = nearest_of(words)
    ray, place = _begin(tree, words, bottom, nearest.t)
    visited, tested, deepest = np.int64(0), np.int64(0), np.int64(0)
    while place.code != NOWHERE:
        visited += 1
        deepest = max(deepest, place.level)
        if place.code >= 0:
            base = place.code * _TREELET
            falling, near, entered, enter, leave = _enter(nodes, base, ray, place)
            if entered != 0:
                place = step_down(nodes, base + _CODES, words, place, falling, near, entered, enter, leave)
                continue
        else:
            first, count = leaf_at(tree.leaves, place.code)
            tested += tested_in_leaf(count, things)
            nearest = closest_in_leaf(triangles, first, count, sheared, things, nearest, words)
            if enough(things, nearest):
                break
        place = next_waiting(nodes, _TREELET, _CODES, words, bottom, place.top, nearest.t)
    add_counts(words, visited, tested, deepest)
    return answer(words, nearest)


@entry
def closest_in_bsp(tables, blocks, ray):
    return _closest(open_bsp(tables), blocks, ray_at(ray), bottom_of(ray), None)


@entry
def things_in_bsp(tables, blocks, ray, test, subject, any_will_do):
    tree, words = open_bsp(tables), ray_at(ray)
    things = things_of(ray, words, tree.reach, test, subject, any_will_do)
    return _closest(tree, blocks, words, bottom_of(ray), things)


@entry
def any_in_bsp(tables, blocks, ray):
    tree, words = open_bsp(tables), ray_at(ray)
    triangles, nodes = floats_at(blocks, _MOST_BLOCK_WORDS), tree.nodes
    sheared = shear(ray_origin(words), ray_direction(words))
    bottom, limit = bottom_of(ray), nearest_of(words).t
    ready, place = _begin(tree, words, bottom, limit)
    visited, tested, deepest, met = np.int64(0), np.int64(0), np.int64(0), np.int64(0)
    while place.code != NOWHERE:
        visited += 1
        deepest = max(deepest, place.level)
        if place.code >= 0:
            base = place.code * _TREELET
            falling, near, entered, enter, leave = _enter(nodes, base, ready, place)
            if entered != 0:
                place = step_down(nodes, base + _CODES, words, place, falling, near, entered, enter, leave)
                continue
        else:
            first, count = leaf_at(tree.leaves, place.code)
            tested += count
            if any_in_blocks(triangles, first, count, sheared, limit):
                met = np.int64(1)
                break
        place = next_waiting(nodes, _TREELET, _CODES, words, bottom, place.top, limit)
    add_counts(words, visited, tested, deepest)
    return met
