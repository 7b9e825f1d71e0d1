"""Rays through a grid of grids, in grid_layout.py's memory: from cell to cell, and into the grids that cells are.

A triangle stands in the blocks of every cell that it overlaps. The boxes of a list's blocks, which are around the parts
of triangles in that cell, are tested eight at a time before any triangle is. Lists of one block have no boxes; where
several cells have the same one, such as cells along a wall, a mailbox (Amanatides, Woo) sees to it that a ray tests it
once.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from isophote.kernels.accel.bvh import Slabs, enter_children, slabs
from isophote.kernels.accel.contract import (
    RAY_WORDS,
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
from isophote.kernels.accel.grid_layout import GRID, MAILED, MOST_LEVELS, ROW
from isophote.kernels.accel.grid_walk import Walk, Way, course_of, enter, hop, place_in, step, way_of
from isophote.kernels.accel.layout import LANES, WIDTH
from isophote.kernels.accel.things import closest_in_leaf, tested_in_leaf, things_of
from isophote.kernels.base.doubles import doubles_at
from isophote.kernels.base.entry import element_address, entry, floats_at, opener_at
from isophote.kernels.base.jit import device, exact_inline
from isophote.kernels.base.simd import load_float, load_int, lowest_bit, store_float, store_int
from isophote.kernels.forms.triangle import Shear, shear

__all__ = ["any_in_grid", "closest_in_grid", "things_in_grid"]

open_grid = opener_at(GRID)

# Scratch: where the ray is in the grids around: grid, cell, three distances to planes and where it leaves as doubles;
# then the walk of a far ray.
_PARENT, _PLACES = np.int64(10), np.int64(4)
_FAR = np.int64(STACK + 10 * (MOST_LEVELS + 1))
_FAR_WIDE = _FAR + np.int64(9)
_ROUND_UP = 1.0 + 2.0**-22
# The code of a cell in which the outermost grid would be.
_OUTERMOST, _NOWHERE = np.int64(1), 0.0
_ROOT, _ONE, _SEVEN = np.int64(0), np.int64(1), np.int64(7)
_LANES, _WIDTH, _ROW = np.int64(LANES), np.int64(WIDTH), np.int64(ROW)
# A hop costs as much as two or three steps.
_WORTH_A_HOP = np.int64(2)
# Which lists the ray has come by of those that several cells have, at the end of its words, as that of things is.
_BOXES = np.int64(16)
_MAILBOX, _MAILED, _NOTHING = np.int64(RAY_WORDS - 16), np.int64(MAILED), np.int32(-1)
_MOST_BLOCK_WORDS = np.int64(1) << np.int64(40)


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


class _Place(NamedTuple):
    """Where a ray comes to in a grid: whether it is far from that, its cell (−1 where it misses the grid), and the walk
    and the way where it is near. Where it is far, which is seldom, the walk is kept in the ray's words."""

    far: bool
    cell: int
    walk: Walk
    way: Way


@exact_inline
def _enter(frames, shapes, grid, course, limit, words):
    """At the first cell of a grid."""
    walk, leave, inside = enter(frames, shapes, grid, course, limit)
    cell, far = walk.cell if inside else -_ONE, is_far(frames, shapes, grid, course)
    if far:
        far_walk = begin_far(frames, shapes, grid, course, limit)
        cell = far_walk.cell
        # A walk that ends before it begins must not take the place of the one that it would leave.
        if cell >= 0:
            _keep_far(words, far_walk)
    return _Place(far, cell, walk, way_of(frames, shapes, grid, course, leave))


@device
def _push(words, grid, level, cell, walk, leave):
    """Keep where the ray is in a grid, to come back."""
    at = STACK + _PARENT * level
    store_int(words, at, np.int32(grid))
    store_int(words, at + 1, np.int32(cell))
    places = doubles_at(element_address(words, at + 2), _PLACES)
    places[0], places[1], places[2] = walk.next_x, walk.next_y, walk.next_z
    places[3] = leave


@exact_inline
def _pop(words, level, frames, shapes, course):
    """(grid, place): in the grid around, at the cell whose grid the ray has left."""
    at = STACK + _PARENT * level
    grid, cell = np.int64(load_int(words, at)), np.int64(load_int(words, at + 1))
    places = doubles_at(element_address(words, at + 2), _PLACES)
    walk, far = Walk(cell, places[0], places[1], places[2]), is_far(frames, shapes, grid, course)
    if far:
        x, y, z = place_in(shapes, grid, cell)
        _keep_far(words, resume_far(frames, shapes, grid, course, x, y, z))
    return grid, _Place(far, cell, walk, way_of(frames, shapes, grid, course, places[3]))


@exact_inline
def _to_next(cells, walk, way, shift, empty, limit):
    """(walk, steps, code): the next cell of a grid that is not empty, and what it holds; code −1 where the ray leaves
    the grid or comes to `limit` before. `empty` says how many cells are empty beyond this one."""
    steps, end = np.int64(0), min(way.leave, limit)
    while True:
        if empty >= _WORTH_A_HOP:
            t, hopped = hop(walk, way, empty)
            if not t < end:
                return walk, steps, -_ONE
            walk = hopped
        else:
            if not min(walk.next_x, min(walk.next_y, walk.next_z)) < end:
                return walk, steps, -_ONE
            walk = step(walk, way)
        steps += 1
        code = np.int64(cells[walk.cell])
        if code >= 0:
            return walk, steps, code
        empty = (code >> shift) & _SEVEN


@device
def _next_far(frames, shapes, grid, course, limit, words):
    """The next cell of a far ray's grid; −1 where the ray leaves it."""
    walk = next_far(frames, shapes, grid, course, _kept_far(words), limit)
    _keep_far(words, walk)
    return walk.cell


class _Test(NamedTuple):
    """The nearest triangle so far, and how many were tested."""

    nearest: Nearest
    tested: int


@exact_inline
def _test_rows(grid, first, row, count, blocks, ready, things, any_will_do, words, test):
    """Test the ray against the triangles of a list by blocks whose boxes it enters."""
    nearest, tested = test.nearest, test.tested
    for low in range(_ROOT, count, _LANES * _WIDTH):
        entered, _ = enter_children(grid.rows, row * _ROW, ready.box, nearest.t)
        while entered != 0:
            k = np.int64(lowest_bit(entered))
            entered &= entered - np.int32(1)
            own = min(count - low - _LANES * k, _LANES)
            nearest = closest_in_leaf(blocks, first + k, own, ready.sheared, things, nearest, words)
            tested += own
            if any_will_do and nearest.slot >= 0:
                return _Test(nearest, tested)
        first += _WIDTH
        row += _ONE
    return _Test(nearest, tested)


@exact_inline
def _test_list(grid, number, blocks, ready, things, any_will_do, words, test):
    """Test the ray against what is in a list, four at a time."""
    first, count = np.int64(grid.lists[number, 0]), np.int64(grid.lists[number, 1])
    if things is None:
        row = np.int64(grid.lists[number, 2])
        if row >= 0:
            return _test_rows(grid, first, row, count, blocks, ready, things, any_will_do, words, test)
        if row == _MAILED:
            box = _MAILBOX + (number & (_BOXES - 1))
            if load_int(words, box) == number:
                return test
            store_int(words, box, np.int32(number))
    nearest = closest_in_leaf(blocks, first, count, ready.sheared, things, test.nearest, words)
    return _Test(nearest, test.tested + tested_in_leaf(count, things))


class _Ready(NamedTuple):
    """The ray made ready for triangles, and for boxes of eight blocks."""

    sheared: Shear
    box: Slabs


@device
def _trace(grid, blocks, words, things, any_will_do):
    """The nearest triangle, or thing, or the first that is met where any will do."""
    origin, direction = ray_origin(words), ray_direction(words)
    ready, course = _Ready(shear(origin, direction), slabs(origin, direction, grid.reach)), course_of(origin, direction)
    cells, frames, shapes = grid.cells, grid.frames, grid.shapes
    test = _Test(nearest_of(words), np.int64(0))
    if things is None:
        for k in range(_BOXES):
            store_int(words, _MAILBOX + k, _NOTHING)
    visited, deepest, level, number = np.int64(0), np.int64(0), -_ONE, _ROOT
    # The ray comes to the outermost grid as to one in a cell.
    far, cell, code = False, -_ONE, _OUTERMOST
    walk = Walk(cell, _NOWHERE, _NOWHERE, _NOWHERE)
    way = Way(_ROOT, _ROOT, _ROOT, _NOWHERE, _NOWHERE, _NOWHERE, _NOWHERE, _NOWHERE, _NOWHERE, _NOWHERE)
    while True:
        empty = np.int64(0)
        if code < 0:
            empty = (code >> course.shift) & _SEVEN
        elif code & 1 == 0:
            test = _test_list(grid, code >> 1, blocks, ready, things, any_will_do, words, test)
            if any_will_do and test.nearest.slot >= 0:
                break
        else:
            inner = _enter(frames, shapes, code >> 1, course, np.float64(test.nearest.t), words)
            if inner.cell >= 0:
                if level >= 0:
                    _push(words, number, level, cell, walk, way.leave)
                number, level = code >> 1, level + 1
                far, cell, walk, way = inner
                code = np.int64(cells[cell])
                deepest = max(deepest, level)
                visited += 1
                continue
            if level < 0:
                break
        # On to the next cell, or to the next of the grids around.
        limit, going = np.float64(test.nearest.t), True
        while going:
            if far:
                cell = _next_far(frames, shapes, number, course, limit, words)
                visited += 1
                if cell >= 0:
                    code = np.int64(cells[cell])
                    break
            else:
                walk, steps, code = _to_next(cells, walk, way, course.shift, empty, limit)
                visited += steps
                if code >= 0:
                    cell = walk.cell
                    break
            going = level > 0
            if going:
                level -= 1
                number, place = _pop(words, level, frames, shapes, course)
                far, cell, walk, way = place
                empty = np.int64(0)
        if not going:
            break
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


@entry
def things_in_grid(tables, blocks, ray, test, subject, any_will_do):
    grid, words = open_grid(tables), ray_at(ray)
    things = things_of(ray, words, grid.reach, test, subject, any_will_do)
    return answer(words, _trace(grid, floats_at(blocks, _MOST_BLOCK_WORDS), words, things, any_will_do != 0))
