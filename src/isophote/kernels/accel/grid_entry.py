"""Rays through a grid of grids, in grid_layout.py's memory: from cell to cell, and into the grids that cells are.

A ray keeps the numbers of the triangles that it was tested against last ("mailbox"), and passes by blocks of nothing
else: a triangle stands in the list of every cell that it overlaps.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from isophote.kernels.accel.contract import (
    STACK,
    Nearest,
    add_counts,
    answer,
    closest_in_blocks,
    nearest_of,
    ray_at,
    ray_direction,
    ray_origin,
)
from isophote.kernels.accel.grid_far import closest_from_afar, is_far
from isophote.kernels.accel.grid_layout import GRID, MOST_LEVELS
from isophote.kernels.accel.grid_walk import course_of, enter, place_in, step, walk_from
from isophote.kernels.accel.layout import BLOCK, LANES, NUMBER
from isophote.kernels.base.entry import entry, floats_at, opener_at
from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import load_int, store_int
from isophote.kernels.forms.triangle import shear

__all__ = ["any_in_grid", "closest_in_grid"]

open_grid = opener_at(GRID)

# Scratch: the cells that the ray is in of the grids around, four words each; then the mailbox.
_PARENT = np.int64(4)
_MAILBOX = np.int64(STACK + 4 * (MOST_LEVELS + 1))
_BOXES = np.int64(64)
_ROOT, _NOTHING = np.int64(0), np.int32(-1)
_MOST_BLOCK_WORDS = np.int64(1) << np.int64(40)


@device
def _clear_mailbox(words):
    for k in range(_BOXES):
        store_int(words, _MAILBOX + k, _NOTHING)


@device
def _all_known(triangles, block, words):
    """Whether the ray was tested against all of a block's triangles, which it is from now on."""
    known = True
    for k in range(LANES):
        number = load_int(triangles, block * BLOCK + NUMBER + k)
        if number >= 0:
            box = _MAILBOX + (np.int64(number) & (_BOXES - 1))
            known = known and load_int(words, box) == number
            store_int(words, box, number)
    return known


@device
def _push(words, level, grid, shapes, walk):
    x, y, z = place_in(shapes, grid, walk.cell)
    at = STACK + _PARENT * level
    store_int(words, at, np.int32(grid))
    store_int(words, at + 1, np.int32(x))
    store_int(words, at + 2, np.int32(y))
    store_int(words, at + 3, np.int32(z))


@device
def _pop(words, level, frames, shapes, course, slack):
    """The grid around, and the `Walk` and `Way` in it where the ray went into a cell's grid."""
    at = STACK + _PARENT * level
    grid = np.int64(load_int(words, at))
    x, y, z = np.int64(load_int(words, at + 1)), np.int64(load_int(words, at + 2)), np.int64(load_int(words, at + 3))
    _, way, _ = enter(frames, shapes, grid, course, slack, np.inf)
    return grid, walk_from(frames, shapes, grid, course, x, y, z), way


@device
def _to_next(cells, walk, way, limit):
    """(walk, steps): the next cell that is not empty, or one that the ray leaves at or behind `limit`."""
    steps = np.int64(0)
    while min(walk.next_x, min(walk.next_y, walk.next_z)) < limit:
        walk = step(walk, way)
        steps += 1
        if cells[walk.cell] != 0:
            return walk, steps, True
    return walk, steps, False


class _Test(NamedTuple):
    """The nearest triangle so far, and how many were tested."""

    nearest: Nearest
    tested: int


@device
def _test_list(lists, code, triangles, sheared, words, test):
    nearest, tested = test.nearest, test.tested
    first, count = np.int64(lists[2 * code]), np.int64(lists[2 * code + 1])
    for block in range(first, first + ((count + (LANES - 1)) >> 2)):
        if not _all_known(triangles, block, words):
            lanes = min(count - (block - first) * LANES, LANES)
            tested += lanes
            nearest = closest_in_blocks(triangles, block, lanes, sheared, nearest, words)
    return _Test(nearest, tested)


@device
def _trace(grid, triangles, words, any_will_do):
    """The nearest triangle, or the first that is met where any will do."""
    origin, direction = ray_origin(words), ray_direction(words)
    sheared = shear(origin, direction)
    if is_far(origin, grid.reach):
        nearest, tested, visited = closest_from_afar(
            grid, triangles, origin, direction, sheared, nearest_of(words), words
        )
        add_counts(words, visited, tested, 0)
        return nearest
    course, slack = course_of(origin, direction), np.float64(grid.slack)
    cells, lists, frames, shapes = grid.cells, grid.lists, grid.frames, grid.shapes
    test = _Test(nearest_of(words), np.int64(0))
    visited, deepest, level, number = np.int64(0), np.int64(0), np.int64(0), _ROOT
    _clear_mailbox(words)
    walk, way, going = enter(frames, shapes, _ROOT, course, slack, np.float64(test.nearest.t))
    visited += going
    while going:
        code = np.int64(cells[walk.cell])
        if code > 0:
            test = _test_list(lists, code, triangles, sheared, words, test)
            if any_will_do and test.nearest.slot >= 0:
                break
        elif code < 0:
            inner, inner_way, inside = enter(frames, shapes, -code, course, slack, np.float64(test.nearest.t))
            if inside:
                _push(words, level, number, shapes, walk)
                level += 1
                deepest = max(deepest, level)
                walk, way, number = inner, inner_way, -code
                visited += 1
                continue
        while True:
            walk, steps, found = _to_next(cells, walk, way, min(way.leave, np.float64(test.nearest.t)))
            visited += steps
            if found:
                break
            if level == 0 or way.leave >= np.float64(test.nearest.t):
                going = False
                break
            level -= 1
            number, walk, way = _pop(words, level, frames, shapes, course, slack)
    add_counts(words, visited, test.tested, deepest)
    return test.nearest


@entry
def closest_in_grid(tables, blocks, ray):
    grid, words = open_grid(tables), ray_at(ray)
    return answer(words, _trace(grid, floats_at(blocks, _MOST_BLOCK_WORDS), words, False))


@entry
def any_in_grid(tables, blocks, ray):
    grid, words = open_grid(tables), ray_at(ray)
    return np.int64(_trace(grid, floats_at(blocks, _MOST_BLOCK_WORDS), words, True).slot >= 0)
