"""From cell to cell of a grid along a ray.

Amanatides, Woo: "A Fast Voxel Traversal Algorithm for Ray Tracing", Eurographics 1987. It is done in double precision,
in which a ray of single precision is as good as exact; what the test of a triangle adds to that is in the cells' lists
(grid_layout.py). A grid's frame is two slacks wider than what it holds, and a ray leaves one slack before its rim, so
no rounding takes it to a cell that is not there. Where it does not move along an axis, the next plane is as good as
infinitely far.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from isophote.kernels.accel.grid_layout import INVERSE, SIZE, SLACK
from isophote.kernels.base.jit import device, exact_inline

__all__ = ["Course", "Walk", "Way", "course_of", "enter", "hop", "place_in", "step", "walk_from", "way_of"]

# Farther than any ray's plane, and finite: no multiple of it is no number.
_FAR = 1e300
_ONE, _ZERO = np.int64(1), np.int64(0)


class Course(NamedTuple):
    """A ray in double precision: origin, direction, 1/d (±inf where d is 0); and by which bits of an empty cell it goes
    (grid_layout.py)."""

    ox: float
    oy: float
    oz: float
    dx: float
    dy: float
    dz: float
    ix: float
    iy: float
    iz: float
    shift: int


class Way(NamedTuple):
    """What stays the same within a grid: how the cell's number changes by a step along each axis, distances between
    planes, planes a distance, and where the ray leaves."""

    jump_x: int
    jump_y: int
    jump_z: int
    width_x: float
    width_y: float
    width_z: float
    rate_x: float
    rate_y: float
    rate_z: float
    leave: float


class Walk(NamedTuple):
    """A place: the cell's number, and distances to the next planes."""

    cell: int
    next_x: float
    next_y: float
    next_z: float


@exact_inline
def course_of(origin, direction):
    """The ray's `Course`."""
    dx, dy, dz = np.float64(direction.x), np.float64(direction.y), np.float64(direction.z)
    ix, iy, iz = 1.0 / dx, 1.0 / dy, 1.0 / dz
    octant = (_ZERO if ix > 0.0 else _ONE) + (_ZERO if iy > 0.0 else 2 * _ONE) + (_ZERO if iz > 0.0 else 4 * _ONE)
    ox, oy, oz = np.float64(origin.x), np.float64(origin.y), np.float64(origin.z)
    return Course(ox, oy, oz, dx, dy, dz, ix, iy, iz, 3 * octant)


@device
def _interval(lower, size, count, slack, origin, direction, inverse):
    """Where the ray is between the outer planes of an axis, one slack within the frame."""
    low, high = lower + slack - origin, lower + size * count - slack - origin
    if direction == 0.0:
        inside = low <= 0.0 and high >= 0.0
        return (-_FAR, _FAR) if inside else (_FAR, -_FAR)
    a, b = low * inverse, high * inverse
    return min(a, b), max(a, b)


@device
def _cell_at(place, lower, inverse_size, count):
    return np.int64(max(0.0, min((place - lower) * inverse_size, np.float64(count - 1))))


@device
def _next_plane(cell, lower, size, origin, direction, inverse):
    """Distance along the ray to the plane at which it leaves the cell on this axis."""
    if direction == 0.0:
        return _FAR
    return (lower + (cell + (_ONE if inverse > 0.0 else _ZERO)) * size - origin) * inverse


@exact_inline
def walk_from(frames, shapes, grid, course, x, y, z):
    """The `Walk` at a cell."""
    return Walk(
        shapes[grid, 3] + (z * shapes[grid, 1] + y) * shapes[grid, 0] + x,
        _next_plane(x, frames[grid, 0], frames[grid, 3], course.ox, course.dx, course.ix),
        _next_plane(y, frames[grid, 1], frames[grid, 4], course.oy, course.dy, course.iy),
        _next_plane(z, frames[grid, 2], frames[grid, 5], course.oz, course.dz, course.iz),
    )


@device
def _width(size, direction, inverse):
    return 0.0 if direction == 0.0 else size * abs(inverse)


@exact_inline
def way_of(frames, shapes, grid, course, leave):
    """The `Way` in a grid that the ray leaves there."""
    nx, ny = shapes[grid, 0], shapes[grid, 1]
    return Way(
        _ONE if course.ix > 0.0 else -_ONE,
        nx if course.iy > 0.0 else -nx,
        nx * ny if course.iz > 0.0 else -nx * ny,
        _width(frames[grid, SIZE], course.dx, course.ix),
        _width(frames[grid, SIZE + 1], course.dy, course.iy),
        _width(frames[grid, SIZE + 2], course.dz, course.iz),
        frames[grid, INVERSE] * abs(course.dx),
        frames[grid, INVERSE + 1] * abs(course.dy),
        frames[grid, INVERSE + 2] * abs(course.dz),
        leave,
    )


@exact_inline
def enter(frames, shapes, grid, course, limit):
    """The `Walk` at the ray's first cell of a grid, where it leaves, and whether it comes there before `limit`."""
    slack = frames[grid, SLACK]
    nx, ny, nz = shapes[grid, 0], shapes[grid, 1], shapes[grid, 2]
    sx, sy, sz = frames[grid, SIZE], frames[grid, SIZE + 1], frames[grid, SIZE + 2]
    x0, x1 = _interval(frames[grid, 0], sx, nx, slack, course.ox, course.dx, course.ix)
    y0, y1 = _interval(frames[grid, 1], sy, ny, slack, course.oy, course.dy, course.iy)
    z0, z1 = _interval(frames[grid, 2], sz, nz, slack, course.oz, course.dz, course.iz)
    begin, leave = max(max(x0, y0), max(z0, 0.0)), min(x1, min(y1, z1))
    if not begin <= min(leave, limit):
        return Walk(shapes[grid, 3], _FAR, _FAR, _FAR), leave, False
    x = _cell_at(course.ox + begin * course.dx, frames[grid, 0], frames[grid, INVERSE], nx)
    y = _cell_at(course.oy + begin * course.dy, frames[grid, 1], frames[grid, INVERSE + 1], ny)
    z = _cell_at(course.oz + begin * course.dz, frames[grid, 2], frames[grid, INVERSE + 2], nz)
    return walk_from(frames, shapes, grid, course, x, y, z), leave, True


@device
def place_in(shapes, grid, cell):
    """The x, y, z of a grid's cell by its number."""
    rest = cell - shapes[grid, 3]
    nx, ny = shapes[grid, 0], shapes[grid, 1]
    return rest % nx, rest // nx % ny, rest // (nx * ny)


@exact_inline
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


@device
def _planes_until(t, next_plane, rate):
    """How many planes of an axis the ray crosses until t."""
    return np.int64((t - next_plane) * rate + 1.0) if next_plane <= t else _ZERO


@exact_inline
def hop(walk, way, empty):
    """(t, walk): where the ray leaves the cube of `empty` more cells toward its octant, and the `Walk` there."""
    far = np.float64(empty)
    x, y, z = walk.next_x + far * way.width_x, walk.next_y + far * way.width_y, walk.next_z + far * way.width_z
    t = min(x, min(y, z))
    i = _planes_until(t, walk.next_x, way.rate_x)
    j = _planes_until(t, walk.next_y, way.rate_y)
    k = _planes_until(t, walk.next_z, way.rate_z)
    return t, Walk(
        walk.cell + i * way.jump_x + j * way.jump_y + k * way.jump_z,
        walk.next_x + i * way.width_x,
        walk.next_y + j * way.width_y,
        walk.next_z + k * way.width_z,
    )
