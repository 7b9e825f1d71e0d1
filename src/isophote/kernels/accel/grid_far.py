"""Rays that begin so far from a grid that their rounding is more than the slack of its lists.

Such a ray goes from slice to slice of cells along its longest axis, and within a slice to every cell that it may come
within its rounding of.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from isophote.kernels.accel.grid_layout import NEAR, REACH, ROUNDING, SIZE
from isophote.kernels.base.jit import device

__all__ = ["FarWalk", "begin_far", "is_far", "next_far", "resume_far"]

_ONE, _ZERO = np.int64(1), np.int64(0)


class FarWalk(NamedTuple):
    """A place: the cell's number (−1 at the end), slice and place in it; the places of the slice that are near the ray;
    the axis across slices, and how near that is."""

    cell: int
    slice: int
    i: int
    j: int
    low_i: int
    high_i: int
    low_j: int
    high_j: int
    main: int
    wide: float


@device
def _of(x, y, z, axis):
    return x if axis == 0 else (y if axis == 1 else z)


@device
def _offset(frames, shapes, grid, axis, origin):
    """How far an origin lies from the frame's middle along an axis."""
    return abs(origin - frames[grid, axis] - 0.5 * shapes[grid, axis] * frames[grid, SIZE + axis])


@device
def _distance(frames, shapes, grid, course):
    x = _offset(frames, shapes, grid, 0, course.ox)
    y = _offset(frames, shapes, grid, 1, course.oy)
    return max(x, max(y, _offset(frames, shapes, grid, 2, course.oz)))


@device
def is_far(frames, shapes, grid, course):
    """Whether a ray begins far from a grid."""
    return _distance(frames, shapes, grid, course) > frames[grid, NEAR]


@device
def _range(frames, shapes, grid, axis, course, begin, end, wide):
    """First and last cell on an axis that the ray may be near at `begin` ≤ t ≤ `end`; the last before the first where
    there is none."""
    origin, direction = _of(course.ox, course.oy, course.oz, axis), _of(course.dx, course.dy, course.dz, axis)
    a, b = origin + begin * direction, origin + end * direction
    lower, size, count = frames[grid, axis], frames[grid, SIZE + axis], shapes[grid, axis]
    first, last = (min(a, b) - wide - lower) / size, (max(a, b) + wide - lower) / size
    if not (last >= 0.0 and first < count):
        return _ONE, _ZERO
    return np.int64(max(first, 0.0)), np.int64(min(last, np.float64(count - 1)))


@device
def _slice_from(frames, shapes, grid, course, main, wide, slice_, limit):
    """The first place in slice number `slice_` in the ray's order, or in the next that it comes near before `limit`."""
    count, lower, size = shapes[grid, main], frames[grid, main], frames[grid, SIZE + main]
    origin, inverse = _of(course.ox, course.oy, course.oz, main), _of(course.ix, course.iy, course.iz, main)
    slack, one, two = wide * abs(inverse), (main + 1) % 3, (main + 2) % 3
    while slice_ < count:
        k = slice_ if inverse > 0.0 else count - 1 - slice_
        a, b = (lower + k * size - origin) * inverse, (lower + (k + 1) * size - origin) * inverse
        begin, end = max(min(a, b) - slack, 0.0), max(a, b) + slack
        if begin > limit:
            break
        if end >= begin:
            low_i, high_i = _range(frames, shapes, grid, one, course, begin, end, wide)
            low_j, high_j = _range(frames, shapes, grid, two, course, begin, end, wide)
            if low_i <= high_i and low_j <= high_j:
                walk = FarWalk(_ZERO, slice_, low_i, low_j, low_i, high_i, low_j, high_j, main, wide)
                return _with_cell(shapes, grid, course, walk)
        slice_ += 1
    return FarWalk(-_ONE, slice_, _ZERO, _ZERO, _ZERO, -_ONE, _ZERO, -_ONE, main, wide)


@device
def _stride(shapes, grid, axis):
    return _ONE if axis == 0 else (shapes[grid, 0] if axis == 1 else shapes[grid, 0] * shapes[grid, 1])


@device
def _with_cell(shapes, grid, course, walk):
    main = walk.main
    inverse = _of(course.ix, course.iy, course.iz, main)
    k = walk.slice if inverse > 0.0 else shapes[grid, main] - 1 - walk.slice
    one, two = (main + 1) % 3, (main + 2) % 3
    cell = shapes[grid, 3] + k * _stride(shapes, grid, main)
    cell += walk.i * _stride(shapes, grid, one) + walk.j * _stride(shapes, grid, two)
    return FarWalk(cell, walk.slice, walk.i, walk.j, walk.low_i, walk.high_i, walk.low_j, walk.high_j, main, walk.wide)


@device
def begin_far(frames, shapes, grid, course, limit):
    """The ray's first place in a grid before `limit`."""
    x, y, z = abs(course.dx), abs(course.dy), abs(course.dz)
    main = _ZERO if (x >= y and x >= z) else (_ONE if y >= z else _ONE + _ONE)
    wide = ROUNDING * (_distance(frames, shapes, grid, course) + frames[grid, REACH])
    return _slice_from(frames, shapes, grid, course, main, wide, _ZERO, limit)


@device
def resume_far(frames, shapes, grid, course, x, y, z):
    """The place at cell x, y, z, to which the ray came before."""
    first = begin_far(frames, shapes, grid, course, np.inf)
    main = first.main
    k = _of(x, y, z, main)
    slice_ = k if _of(course.ix, course.iy, course.iz, main) > 0.0 else shapes[grid, main] - 1 - k
    here = _slice_from(frames, shapes, grid, course, main, first.wide, slice_, np.inf)
    i, j = _of(x, y, z, (main + 1) % 3), _of(x, y, z, (main + 2) % 3)
    walk = FarWalk(_ZERO, slice_, i, j, here.low_i, here.high_i, here.low_j, here.high_j, main, first.wide)
    return _with_cell(shapes, grid, course, walk)


@device
def next_far(frames, shapes, grid, course, walk, limit):
    """The next place in a grid before `limit`."""
    if walk.i < walk.high_i:
        i, j = walk.i + 1, walk.j
    elif walk.j < walk.high_j:
        i, j = walk.low_i, walk.j + 1
    else:
        return _slice_from(frames, shapes, grid, course, walk.main, walk.wide, walk.slice + 1, limit)
    moved = FarWalk(_ZERO, walk.slice, i, j, walk.low_i, walk.high_i, walk.low_j, walk.high_j, walk.main, walk.wide)
    return _with_cell(shapes, grid, course, moved)
