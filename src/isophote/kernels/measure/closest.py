"""The point of a triangle mesh that is closest to a given one.

The tree is walked nearest box first. Boxes and blocks of four triangles are measured in single precision, with room
for its rounding; triangles that may be the closest are measured in double precision.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from isophote.kernels.accel.layout import BLOCK, CHILD, LANES, NODE, NUMBER, STACK, UPPER, WIDTH
from isophote.kernels.base.jit import device, kernel
from isophote.kernels.base.simd import (
    bits,
    load4,
    load8,
    load_float,
    load_int,
    lowest_bit,
    maximum,
    minimum,
    select,
    splat4,
    splat8,
    store8,
    store_float,
    store_int,
)
from isophote.kernels.measure.mesh_distance import STACK_WORDS, open_mesh, to_single

__all__ = ["Nearest", "closest_points", "closest_slot", "nearest_on_slot"]

_ZERO, _ONE = np.float32(0), np.float32(1)
_FAR = np.float32(np.inf)
_NONE = np.int64(-1)
_TOP = np.int64(0)
_ROW = np.int64(STACK)

# What single precision may be wrong by, in parts of the coordinates and distances that go into a distance.
_ROUNDING = np.float64(2.0**-19)


class Nearest(NamedTuple):
    """A point of a triangle, in the mesh's frame: its square distance, place, and weights of corners 1 and 2."""

    square: float
    x: float
    y: float
    z: float
    weight1: float
    weight2: float


# --- one triangle in double precision -------------------------------------------------------------


@device
def _along(x, y, z, ex, ey, ez):
    """Where on the segment from 0 to e, in parts of it, lies the point closest to (x, y, z)."""
    square = ex * ex + ey * ey + ez * ez
    t = x * ex + y * ey + z * ez
    if not t > 0.0:
        return 0.0
    return t / square if t < square else 1.0


@device
def _place(corners, slot, x, y, z, w1, w2):
    """The point of weights w1, w2, and how far it is from (x, y, z)."""
    ax, ay, az = corners[slot, 0], corners[slot, 1], corners[slot, 2]
    fx = ax + w1 * (corners[slot, 3] - ax) + w2 * (corners[slot, 6] - ax)
    fy = ay + w1 * (corners[slot, 4] - ay) + w2 * (corners[slot, 7] - ay)
    fz = az + w1 * (corners[slot, 5] - az) + w2 * (corners[slot, 8] - az)
    dx, dy, dz = x - fx, y - fy, z - fz
    return Nearest(dx * dx + dy * dy + dz * dz, fx, fy, fz, w1, w2)


@device
def nearest_on_slot(corners, slot, x, y, z):
    """The point of the triangle in `slot` that is closest to (x, y, z), which may have any shape, also none."""
    ax, ay, az = corners[slot, 0], corners[slot, 1], corners[slot, 2]
    ux, uy, uz = corners[slot, 3] - ax, corners[slot, 4] - ay, corners[slot, 5] - az
    vx, vy, vz = corners[slot, 6] - ax, corners[slot, 7] - ay, corners[slot, 8] - az
    px, py, pz = x - ax, y - ay, z - az
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    # Weights of corners 1 and 2 at the foot of the perpendicular, times |n|².
    w1 = nx * (py * vz - pz * vy) + ny * (pz * vx - px * vz) + nz * (px * vy - py * vx)
    w2 = nx * (uy * pz - uz * py) + ny * (uz * px - ux * pz) + nz * (ux * py - uy * px)
    square = nx * nx + ny * ny + nz * nz
    if w1 > 0.0 and w2 > 0.0 and w1 + w2 < square:
        return _place(corners, slot, x, y, z, w1 / square, w2 / square)
    best = _place(corners, slot, x, y, z, _along(px, py, pz, ux, uy, uz), 0.0)
    other = _place(corners, slot, x, y, z, 0.0, _along(px, py, pz, vx, vy, vz))
    if other.square < best.square:
        best = other
    t = _along(px - ux, py - uy, pz - uz, vx - ux, vy - uy, vz - uz)
    other = _place(corners, slot, x, y, z, 1.0 - t, t)
    return other if other.square < best.square else best


# --- boxes and blocks in single precision ---------------------------------------------------------


@device
def _box_squares(nodes, base, x, y, z):
    """Square distances of eight boxes; infinite for missing ones."""
    zero = splat8(_ZERO)
    dx = maximum(maximum(load8(nodes, base) - x, x - load8(nodes, base + UPPER)), zero)
    dy = maximum(maximum(load8(nodes, base + WIDTH) - y, y - load8(nodes, base + UPPER + WIDTH)), zero)
    dz = maximum(maximum(load8(nodes, base + 2 * WIDTH) - z, z - load8(nodes, base + UPPER + 2 * WIDTH)), zero)
    return dx * dx + dy * dy + dz * dz


@device
def _segment_squares(px, py, pz, ex, ey, ez):
    """Square distances of the points p from the segments from 0 to e."""
    t = (px * ex + py * ey + pz * ez) / (ex * ex + ey * ey + ez * ez)
    t = maximum(minimum(t, splat4(_ONE)), splat4(_ZERO))
    dx, dy, dz = px - t * ex, py - t * ey, pz - t * ez
    return dx * dx + dy * dy + dz * dz


@device
def _triangle_squares(blocks, block, x, y, z):
    """Square distances of a block's triangles; NaN for missing ones.

    Where the shape of a triangle leaves its plane uncertain, what comes out is at most the distance.
    """
    at = block * BLOCK
    ax, ay, az = load4(blocks, at), load4(blocks, at + 4), load4(blocks, at + 8)
    ux, uy, uz = load4(blocks, at + 12) - ax, load4(blocks, at + 16) - ay, load4(blocks, at + 20) - az
    vx, vy, vz = load4(blocks, at + 24) - ax, load4(blocks, at + 28) - ay, load4(blocks, at + 32) - az
    px, py, pz = x - ax, y - ay, z - az
    rim = minimum(_segment_squares(px, py, pz, ux, uy, uz), _segment_squares(px, py, pz, vx, vy, vz))
    rim = minimum(rim, _segment_squares(px - ux, py - uy, pz - uz, vx - ux, vy - uy, vz - uz))
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    w1 = nx * (py * vz - pz * vy) + ny * (pz * vx - px * vz) + nz * (px * vy - py * vx)
    w2 = nx * (uy * pz - uz * py) + ny * (uz * px - ux * pz) + nz * (ux * py - uy * px)
    square = nx * nx + ny * ny + nz * nz
    height = nx * px + ny * py + nz * pz
    zero = splat4(_ZERO)
    inside = (w1 > zero) & (w2 > zero) & (w1 + w2 < square)
    return select(inside, minimum(height * height / square, rim), rim)


@device
def _limit(square, slack):
    """The square distance up to which single precision may stand for `square` or less."""
    d = np.sqrt(square) * (1.0 + _ROUNDING) + slack
    return np.float32(d * d)


@device
def _push_nearest_last(nodes, base, x, y, z, limit, stack, top):
    """Push the children within the square distance `limit`, the nearest last. Returns the new top."""
    squares = _box_squares(nodes, base, x, y, z)
    near = bits(squares <= splat8(limit))
    store8(stack, _ROW, squares)
    bottom = top
    while near != 0:
        k = np.int64(lowest_bit(near))
        near &= near - np.int32(1)
        square = load_float(stack, _ROW + k)
        if square == _FAR:
            continue
        at = top
        while at > bottom:
            above = load_float(stack, at - 2)
            if above >= square:
                break
            store_float(stack, at, above)
            store_int(stack, at + 1, load_int(stack, at - 1))
            at -= 2
        store_float(stack, at, square)
        store_int(stack, at + 1, load_int(nodes, base + CHILD + k))
        top += 2
    return top


@device
def closest_slot(mesh, x, y, z, reach, stack):
    """(square distance, slot) of the triangle closest to (x, y, z) of the mesh's frame, within square distance `reach`.

    The slot is -1, and the distance `reach`, where there is none. Of triangles at the same distance the one with the
    lowest number is taken. `stack` is float32 scratch of STACK_WORDS.
    """
    qx, qy, qz = to_single(x, mesh.frame[0, 0]), to_single(y, mesh.frame[0, 1]), to_single(z, mesh.frame[0, 2])
    slack = _ROUNDING * (1.0 + np.float64(abs(qx)) + np.float64(abs(qy)) + np.float64(abs(qz)))
    x8, y8, z8 = splat8(qx), splat8(qy), splat8(qz)
    x4, y4, z4 = splat4(qx), splat4(qy), splat4(qz)
    best, found, number = reach, _NONE, np.int32(0)
    limit = _limit(best, slack)
    top = _push_nearest_last(mesh.nodes, _TOP, x8, y8, z8, limit, stack, _TOP)
    while top > 0:
        top -= 2
        if load_float(stack, top) > limit:
            continue
        node = load_int(stack, top + 1)
        if node >= 0:
            top = _push_nearest_last(mesh.nodes, np.int64(node) * NODE, x8, y8, z8, limit, stack, top)
            continue
        code = np.int64(-1) - np.int64(node)
        first = code >> 3
        for block in range(first, first + (code & 7)):
            near = bits(_triangle_squares(mesh.blocks, block, x4, y4, z4) <= splat4(limit))
            while near != 0:
                k = np.int64(lowest_bit(near))
                near &= near - np.int32(1)
                slot = block * LANES + k
                square = nearest_on_slot(mesh.corners, slot, x, y, z).square
                if square > best:
                    continue
                own = load_int(mesh.blocks, block * BLOCK + NUMBER + k)
                if square < best or found < 0 or own < number:
                    best, found, number = square, slot, own
                    limit = _limit(best, slack)
    return best, found


@kernel
def closest_points(words, points, begin, end, places, distances, numbers, weights):
    """Closest points of the mesh to rows `begin` to `end` of `points` (n, 3).

    Fills `distances` (n,), and, unless they are empty, `places` (n, 3), `numbers` (n,) of triangles, and `weights`
    (n, 3) of their corners.
    """
    mesh = open_mesh(words)
    stack = np.empty(STACK_WORDS, np.float32)
    scale = mesh.frame[0, 3]
    for i in range(begin, end):
        x, y, z = points[i, 0] * scale, points[i, 1] * scale, points[i, 2] * scale
        square, slot = closest_slot(mesh, x, y, z, np.inf, stack)
        distances[i] = np.sqrt(square) / scale
        if numbers.size == 0:
            continue
        nearest = nearest_on_slot(mesh.corners, slot, x, y, z)
        places[i, 0], places[i, 1], places[i, 2] = nearest.x / scale, nearest.y / scale, nearest.z / scale
        numbers[i] = load_int(mesh.blocks, slot // LANES * BLOCK + NUMBER + slot % LANES)
        weights[i, 0] = max(0.0, 1.0 - nearest.weight1 - nearest.weight2)
        weights[i, 1], weights[i, 2] = nearest.weight1, nearest.weight2
