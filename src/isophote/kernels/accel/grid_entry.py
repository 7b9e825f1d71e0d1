"""Rays through a grid of grids, in grid_layout.py's memory: from cell to cell, and into the grids that cells are.

A triangle stands in the blocks of every cell that it overlaps, and a ray that comes by several of them is tested
against it in each. To remember what it was tested against ("mailbox", Amanatides and Woo) costs more than the tests,
of which four are made at once.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from isophote.kernels.accel.contract import (
    STACK,
    Nearest,
    add_counts,
    answer,
    nearest_of,
    ray_at,
    ray_direction,
    ray_origin,
)
from isophote.kernels.accel.grid_far import FarWalk, begin_far, is_far, next_far, resume_far
from isophote.kernels.accel.grid_layout import GRID, MOST_LEVELS, SIZE
from isophote.kernels.accel.grid_walk import Walk, Way, course_of, enter, place_in, step, walk_from
from isophote.kernels.accel.things import closest_in_leaf, tested_in_leaf, things_of
from isophote.kernels.base.entry import entry, floats_at, opener_at
from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import load_float, load_int, store_float, store_int
from isophote.kernels.forms.triangle import shear

__all__ = ["any_in_grid", "closest_in_grid", "things_in_grid"]

open_grid = opener_at(GRID)

# Scratch: the cells that the ray is in of the grids around, four words each; then the walk of a far ray.
_PARENT = np.int64(4)
_FAR = np.int64(STACK + 4 * (MOST_LEVELS + 1))
_FAR_WIDE = _FAR + np.int64(9)
_ROUND_UP = 1.0 + 2.0**-22
_ROOT, _ONE = np.int64(0), np.int64(1)
_MOST_BLOCK_WORDS = np.int64(1) << np.int64(40)


class _State(NamedTuple):
    """Where a ray is: the grid, how deep it lies, the cell (−1 at the end), and the walk where the ray is near.

    Where it is far, which is seldom, the walk is kept in the ray's words."""

    grid: int
    level: int
    cell: int
    far: bool
    walk: Walk
    way: Way


@device
def _keep_far(words, walk):
    store_int(words, _FAR, np.int32(walk.cell))
    store_int(words, _FAR + 1, np.int32(walk.slice))
    store_int(words, _FAR + 2, np.int32(walk.i))
    store_int(words, _FAR + 3, np.int32(walk.j))
    store_int(words, _FAR + 4, np.int32(walk.low_i))
    store_int(words, _FAR + 5, np.int32(walk.high_i))
    store_int(words, _FAR + 6, np.int32(walk.low_j))
    store_int(words, _FAR + 7, np.int32(walk.high_j))
    store_int(words, _FAR + 8, np.int32(walk.main))
    store_float(words, _FAR_WIDE, np.float32(walk.wide * _ROUND_UP))


@device
def _kept_far(words):
    at = _FAR
    return FarWalk(
        np.int64(load_int(words, at)),
        np.int64(load_int(words, at + 1)),
        np.int64(load_int(words, at + 2)),
        np.int64(load_int(words, at + 3)),
        np.int64(load_int(words, at + 4)),
        np.int64(load_int(words, at + 5)),
        np.int64(load_int(words, at + 6)),
        np.int64(load_int(words, at + 7)),
        np.int64(load_int(words, at + 8)),
        np.float64(load_float(words, _FAR_WIDE)),
    )


@device
def _enter(frames, shapes, grid, level, course, limit, words):
    """At the first cell of a grid."""
    walk, way, inside = enter(frames, shapes, grid, course, limit)
    cell, far = walk.cell if inside else -_ONE, is_far(frames, shapes, grid, course)
    if far:
        far_walk = begin_far(frames, shapes, grid, course, limit)
        cell = far_walk.cell
        # A walk that ends before it begins must not take the place of the one that it would leave.
        if cell >= 0:
            _keep_far(words, far_walk)
    return _State(grid, level, cell, far, walk, way)


@device
def _push(words, shapes, grid, level, cell):
    x, y, z = place_in(shapes, grid, cell)
    at = STACK + _PARENT * level
    store_int(words, at, np.int32(grid))
    store_int(words, at + 1, np.int32(x))
    store_int(words, at + 2, np.int32(y))
    store_int(words, at + 3, np.int32(z))


@device
def _pop(words, level, frames, shapes, course):
    """In the grid around, at the cell whose grid the ray has left."""
    at = STACK + _PARENT * level
    grid = np.int64(load_int(words, at))
    x, y, z = np.int64(load_int(words, at + 1)), np.int64(load_int(words, at + 2)), np.int64(load_int(words, at + 3))
    _, way, _ = enter(frames, shapes, grid, course, np.inf)
    walk, far = walk_from(frames, shapes, grid, course, x, y, z), is_far(frames, shapes, grid, course)
    if far:
        _keep_far(words, resume_far(frames, shapes, grid, course, x, y, z))
    return _State(grid, level, walk.cell, far, walk, way)


@device
def _to_next(cells, walk, way, limit):
    """(walk, steps, found): the next cell of a grid that is not empty, unless the ray leaves the grid or comes to
    `limit` before."""
    steps, end = np.int64(0), min(way.leave, limit)
    while min(walk.next_x, min(walk.next_y, walk.next_z)) < end:
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
def _test_list(grid, code, blocks, sheared, things, words, test):
    """Test the ray against what is in a list, four at a time."""
    first, count = np.int64(grid.lists[code, 0]), np.int64(grid.lists[code, 1])
    nearest = closest_in_leaf(blocks, first, count, sheared, things, test.nearest, words)
    return _Test(nearest, test.tested + tested_in_leaf(count, things))


@device
def _onward(grid, words, course, state, limit):
    """(state, steps): the next cell of a far ray's grid, or the next that is not empty of the grids around."""
    cells, frames, shapes = grid.cells, grid.frames, grid.shapes
    visited, left = np.int64(0), not state.far
    while True:
        if state.far:
            far_walk = next_far(frames, shapes, state.grid, course, _kept_far(words), limit)
            _keep_far(words, far_walk)
            visited += 1
            if far_walk.cell >= 0:
                return _State(state.grid, state.level, far_walk.cell, True, state.walk, state.way), visited
        elif not left:
            walk, steps, found = _to_next(cells, state.walk, state.way, limit)
            visited += steps
            if found:
                return _State(state.grid, state.level, walk.cell, False, walk, state.way), visited
        if state.level == 0:
            return _State(state.grid, state.level, -_ONE, False, state.walk, state.way), visited
        state, left = _pop(words, state.level - 1, frames, shapes, course), False


@device
def _trace(grid, blocks, words, things, any_will_do):
    """The nearest triangle, or thing, or the first that is met where any will do."""
    origin, direction = ray_origin(words), ray_direction(words)
    sheared, course = shear(origin, direction), course_of(origin, direction)
    cells, frames, shapes = grid.cells, grid.frames, grid.shapes
    test = _Test(nearest_of(words), np.int64(0))
    visited, deepest = np.int64(0), np.int64(0)
    state = _enter(frames, shapes, _ROOT, np.int64(0), course, np.float64(test.nearest.t), words)
    walk, way, cell = state.walk, state.way, state.cell
    visited += cell >= 0
    while cell >= 0:
        code = np.int64(cells[cell])
        if code > 0:
            test = _test_list(grid, code, blocks, sheared, things, words, test)
            if any_will_do and test.nearest.slot >= 0:
                break
        elif code < 0:
            inner = _enter(frames, shapes, -code, state.level + 1, course, np.float64(test.nearest.t), words)
            if inner.cell >= 0:
                _push(words, shapes, state.grid, state.level, cell)
                state = inner
                walk, way, cell = state.walk, state.way, state.cell
                deepest = max(deepest, state.level)
                visited += 1
                continue
        # What happens in nearly every cell stays in a few registers.
        if not state.far:
            walk, steps, found = _to_next(cells, walk, way, np.float64(test.nearest.t))
            cell = walk.cell
            visited += steps
            if found:
                continue
        state, steps = _onward(grid, words, course, state, np.float64(test.nearest.t))
        walk, way, cell = state.walk, state.way, state.cell
        visited += steps
    add_counts(words, visited, test.tested, deepest)
    return test.nearest


@entry
def closest_in_grid(tables, blocks, ray):
    grid, words = open_grid(tables), ray_at(ray)
    return answer(words, _trace(grid, floats_at(blocks, _MOST_BLOCK_WORDS), words, None, False))


@entry
def any_in_grid(tables, blocks, ray):
    grid, words = open_grid(tables), ray_at(ray)
    return np.int64(_trace(grid, floats_at(blocks, _MOST_BLOCK_WORDS), words, None, True).slot >= 0)


@device
def _reach(frames, shapes):
    """The largest size of a coordinate in the outermost grid."""
    reach = 0.0
    for axis in range(3):
        low = frames[_ROOT, axis]
        reach = max(reach, max(abs(low), abs(low + shapes[_ROOT, axis] * frames[_ROOT, SIZE + axis])))
    return np.float32(reach)


@entry
def things_in_grid(tables, blocks, ray, test, subject, any_will_do):
    grid, words = open_grid(tables), ray_at(ray)
    things = things_of(ray, words, _reach(grid.frames, grid.shapes), test, subject, any_will_do)
    return answer(words, _trace(grid, floats_at(blocks, _MOST_BLOCK_WORDS), words, things, any_will_do != 0))
