"""From cell to cell of a grid along a ray.

Amanatides, Woo: "A Fast Voxel Traversal Algorithm for Ray Tracing", Eurographics 1987. It is done in double precision,
in which a ray of single precision is as good as exact; what the test of a triangle adds to that is in the cells' lists
(grid_layout.py). A grid's frame is two slacks wider than what it holds, and a ray leaves one slack before its rim, so
no rounding takes it to a cell that is not there. Where it does not move along an axis, the next plane is infinitely
far.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from isophote.kernels.accel.grid_layout import SLACK
from isophote.kernels.base.jit import device

__all__ = ["Course", "Walk", "Way", "course_of", "enter", "place_in", "step", "walk_from"]

_FAR = np.inf
_ONE, _ZERO = np.int64(1), np.int64(0)


class Course(NamedTuple):
    """A ray in double precision: origin, direction, 1/d (±inf where d is 0)."""

    ox: float
    oy: float
    oz: float
    dx: float
    dy: float
    dz: float
    ix: float
    iy: float
    iz: float


class Way(NamedTuple):
    """What stays the same within a grid: how the cell's number changes by a step along each axis, distances between
    planes, and where the ray leaves."""

    jump_x: int
    jump_y: int
    jump_z: int
    width_x: float
    width_y: float
    width_z: float
    leave: float


class Walk(NamedTuple):
    """A place: the cell's number, and distances to the next planes."""

    cell: int
    next_x: float
    next_y: float
    next_z: float


@device
def course_of(origin, direction):
    """The ray's `Course`."""
    dx, dy, dz = np.float64(direction.x), np.float64(direction.y), np.float64(direction.z)
    return Course(
        np.float64(origin.x), np.float64(origin.y), np.float64(origin.z), dx, dy, dz, 1.0 / dx, 1.0 / dy, 1.0 / dz
    )


@device
def _interval(lower, size, count, slack, origin, inverse):
    """Where the ray is between the outer planes of an axis, one slack within the frame."""
    low, high = lower + slack - origin, lower + size * count - slack - origin
    if abs(inverse) == _FAR:
        inside = low <= 0.0 and high >= 0.0
        return (-_FAR, _FAR) if inside else (_FAR, -_FAR)
    a, b = low * inverse, high * inverse
    return min(a, b), max(a, b)


@device
def _cell_at(place, lower, size, count):
    return np.int64(max(0.0, min((place - lower) / size, np.float64(count - 1))))


@device
def _next_plane(cell, lower, size, origin, inverse):
    """Distance along the ray to the plane at which it leaves the cell on this axis."""
    if abs(inverse) == _FAR:
        return _FAR
    return (lower + (cell + (_ONE if inverse > 0.0 else _ZERO)) * size - origin) * inverse


@device
def walk_from(frames, shapes, grid, course, x, y, z):
    """The `Walk` at a cell."""
    return Walk(
        shapes[grid, 3] + (z * shapes[grid, 1] + y) * shapes[grid, 0] + x,
        _next_plane(x, frames[grid, 0], frames[grid, 3], course.ox, course.ix),
        _next_plane(y, frames[grid, 1], frames[grid, 4], course.oy, course.iy),
        _next_plane(z, frames[grid, 2], frames[grid, 5], course.oz, course.iz),
    )


@device
def enter(frames, shapes, grid, course, limit):
    """The `Walk` at the ray's first cell of a grid, the `Way` there, and whether it comes there before `limit`."""
    slack = frames[grid, SLACK]
    nx, ny, nz = shapes[grid, 0], shapes[grid, 1], shapes[grid, 2]
    sx, sy, sz = frames[grid, 3], frames[grid, 4], frames[grid, 5]
    x0, x1 = _interval(frames[grid, 0], sx, nx, slack, course.ox, course.ix)
    y0, y1 = _interval(frames[grid, 1], sy, ny, slack, course.oy, course.iy)
    z0, z1 = _interval(frames[grid, 2], sz, nz, slack, course.oz, course.iz)
    begin, leave = max(max(x0, y0), max(z0, 0.0)), min(x1, min(y1, z1))
    way = Way(
        _ONE if course.ix > 0.0 else -_ONE,
        nx if course.iy > 0.0 else -nx,
        nx * ny if course.iz > 0.0 else -nx * ny,
        sx * abs(course.ix),
        sy * abs(course.iy),
        sz * abs(course.iz),
        leave,
    )
    if not begin <= min(leave, limit):
        return Walk(shapes[grid, 3], _FAR, _FAR, _FAR), way, False
    x = _cell_at(course.ox + begin * course.dx, frames[grid, 0], sx, nx)
    y = _cell_at(course.oy + begin * course.dy, frames[grid, 1], sy, ny)
    z = _cell_at(course.oz + begin * course.dz, frames[grid, 2], sz, nz)
    return walk_from(frames, shapes, grid, course, x, y, z), way, True


@device
def place_in(shapes, grid, cell):
    """The x, y, z of a grid's cell by its number."""
    rest = cell - shapes[grid, 3]
    nx, ny = shapes[grid, 0], shapes[grid, 1]
    return rest % nx, rest // nx % ny, rest // (nx * ny)


@device
def step(walk, way):
    """The `Walk` at the next cell. Which axis it is cannot be guessed, so there is no branch."""
    along_x = walk.next_x <= walk.next_y and walk.next_x <= walk.next_z
    along_y = not along_x and walk.next_y <= walk.next_z
    along_z = not (along_x or along_y)
    jump = way.jump_x if along_x else (way.jump_y if along_y else way.jump_z)
    return Walk(
        walk.cell + jump,
        walk.next_x + (way.width_x if along_x else 0.0),
        walk.next_y + (way.width_y if along_y else 0.0),
        walk.next_z + (way.width_z if along_z else 0.0),
    )
