"""Rays through a kd-tree, in kd_layout.py's memory, by treelets (treelet.py)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from isophote.kernels.accel.contract import (
    add_counts,
    answer,
    any_in_blocks,
    nearest_of,
    ray_at,
    ray_direction,
    ray_origin,
)
from isophote.kernels.accel.kd_layout import ACROSS_Z, AXES, CODES, KD, PRESENT, TREELET
from isophote.kernels.accel.spread import LARGEST, box_interval, spread_of
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
from isophote.kernels.base.simd import bits, load8, load_int, select, splat8
from isophote.kernels.base.simd_sides import fused, lanes_of
from isophote.kernels.forms.triangle import shear

__all__ = ["any_in_kd", "closest_in_kd", "things_in_kd"]

open_kd = opener_at(KD)

_TREELET, _AXES, _CODES = np.int64(TREELET), np.int64(AXES), np.int64(CODES)
_ACROSS_Z, _PRESENT, _CHILDREN = np.int64(ACROSS_Z), np.int64(PRESENT), np.int64(255)
_SEVEN, _NO_PLANE = np.int64(127), np.int64(0)
_ROOT, _TOP_LEVEL = np.int64(0), np.int64(0)
_ZERO = np.float32(0)
_MOST_BLOCK_WORDS = np.int64(1) << np.int64(40)


class _Across(NamedTuple):
    """A ray made ready for planes, eight times over: 1/d, and −o/d moved by the slack either way, on each axis; bits of
    planes whose upper side it comes to first: of all across x, and how those across y and z differ."""

    ix: object
    iy: object
    iz: object
    bx: object
    by: object
    bz: object
    ex: object
    ey: object
    ez: object
    fall_x: int
    fall_y: int
    fall_z: int


@device
def _moved(origin, inverse):
    return -max(min(origin * inverse, LARGEST), -LARGEST)


@device
def _begin(tree, words, bottom, limit):
    """The ray made ready, and the root, with the ray's interval in all that the tree holds."""
    spread = spread_of(ray_origin(words), ray_direction(words), tree.reach)
    o, i, s = spread.origin, spread.inverse, spread.slack
    x, y, z = _moved(o.x, i.x), _moved(o.y, i.y), _moved(o.z, i.z)
    fall_x = _SEVEN if i.x < _ZERO else _NO_PLANE
    across = _Across(
        splat8(i.x),
        splat8(i.y),
        splat8(i.z),
        splat8(x - s.x),
        splat8(y - s.y),
        splat8(z - s.z),
        splat8(x + s.x),
        splat8(y + s.y),
        splat8(z + s.z),
        fall_x,
        fall_x ^ (_SEVEN if i.y < _ZERO else _NO_PLANE),
        fall_x ^ (_SEVEN if i.z < _ZERO else _NO_PLANE),
    )
    enter, leave = box_interval(spread, tree.bounds, limit)
    return across, Place(_ROOT if enter <= leave else NOWHERE, _TOP_LEVEL, enter, leave, bottom)


@device
def _enter(nodes, base, ray, place):
    """Children of the treelet at word `base` that the ray enters: (planes whose upper side it comes to first, what is
    near, children, where it enters, where it leaves); the first and third are bits."""
    axes = np.int64(load_int(nodes, base + _AXES))
    y, z = lanes_of(axes), lanes_of(axes >> _ACROSS_Z)
    falling = ray.fall_x ^ (ray.fall_y & axes) ^ (ray.fall_z & (axes >> _ACROSS_Z))
    near = near_sides(falling)
    planes = load8(nodes, base)
    inverse = select(z, ray.iz, select(y, ray.iy, ray.ix))
    soonest = fused(planes, inverse, select(z, ray.bz, select(y, ray.by, ray.bx)))
    latest = fused(planes, inverse, select(z, ray.ez, select(y, ray.ey, ray.ex)))
    enter, leave = intervals(soonest, latest, near, place)
    return falling, near, np.int64(bits(enter <= leave)) & (axes >> _PRESENT) & _CHILDREN, enter, leave


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
def closest_in_kd(tables, blocks, ray):
    return _closest(open_kd(tables), blocks, ray_at(ray), bottom_of(ray), None)


@entry
def things_in_kd(tables, blocks, ray, test, subject, any_will_do):
    tree, words = open_kd(tables), ray_at(ray)
    things = things_of(ray, words, tree.reach, test, subject, any_will_do)
    return _closest(tree, blocks, words, bottom_of(ray), things)


@entry
def any_in_kd(tables, blocks, ray):
    tree, words = open_kd(tables), ray_at(ray)
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
