"""Generalised winding numbers of triangle meshes: the solid angle that a mesh fills as seen from a point, over 4π.

One ray from the point to infinity is followed, along +z or -z. A mesh without rim is met as often outward, less inward,
as it winds round the point, and that is all. Otherwise cones from the rim to infinity, away from the ray, make a closed
surface of it: they never meet the ray, so

    w(p) = signed crossings of the ray + sum over rim edges (a, b) of Ω(p; -d, a, b) / 4π,

where d is the ray's direction and Ω the solid angle of a spherical triangle. This is exact for every mesh, whatever its
holes, overlaps and intersections, up to the rounding of Ω. (Jacobson, Kavan, Sorkine-Hornung: "Robust Inside-Outside
Segmentation using Generalized Winding Numbers", 2013, section 4, close a mesh to the same end.)

Which triangles the ray meets is decided by exact signs. Where a sign is zero the point counts as moved by (ε, ε², ε³),
ε > 0 smaller than all numbers, so that neither a vertex nor an edge is met twice or missed, and a point on the
surface lies on one side of it.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.layout import BLOCK, CHILD, LANES, NODE, NUMBER, UPPER, WIDTH
from isophote.kernels.base.jit import device, exact_apart, exact_device, kernel
from isophote.kernels.base.predicates import ORIENT2D_BOUND, ORIENT3D_BOUND, orient2d, orient3d
from isophote.kernels.base.simd import (
    absolute,
    bits,
    load4,
    load8,
    load_int,
    lowest_bit,
    maximum,
    minimum,
    splat4,
    splat8,
    store_int,
)
from isophote.kernels.measure.mesh_distance import STACK_WORDS, open_mesh, to_single
from isophote.kernels.measure.rim import moved_side, rim_angle

__all__ = ["crossings", "winding_numbers", "winding_of"]

_ZERO = np.float32(0)
_ROOT = np.int32(0)
_TOP = np.int64(0)
_NOTHING = np.int64(0)
# Single-precision coordinates in the box are wrong by 2^-24, their differences by 2^-22 with rounding; a product of two
# by that times their sum. Twice as much is allowed for.
_PART, _LEAST = np.float32(2.0**-20), np.float32(2.0**-40)
# What underflow may add to the determinants of coordinates in the mesh's frame.
_UNDERFLOW = 2.0**-500

# --- which triangles the ray meets ----------------------------------------------------------------


@exact_device
def _side(px, py, c, slot, k, i, j):
    """The side, as `orient2d` has it, of a triangle's edge opposite corner k on which a point lies, by axes i and j."""
    first, second = 3 * ((k + 1) % 3), 3 * ((k + 2) % 3)
    return orient2d(px, py, c[slot, first + i], c[slot, first + j], c[slot, second + i], c[slot, second + j])


@exact_device
def _touches(place, c, slot):
    """Whether a point of the plane of a triangle lies on the triangle, which may have no area."""
    within = True
    for i in range(3):
        j = (i + 1) % 3
        low, high = np.int64(1), np.int64(-1)
        for k in range(3):
            side = _side(place[i], place[j], c, slot, k, i, j)
            low, high = min(low, side), max(high, side)
        if low != 0 or high != 0:
            return low >= 0 or high <= 0
        corners = c[slot, i], c[slot, 3 + i], c[slot, 6 + i]
        within &= min(corners) <= place[i] and place[i] <= max(corners)
    return within


@exact_device
def _moved_below(c, slot):
    """1 where (ε, ε², ε³) leads below the plane of a triangle, as `orient3d` has it, -1 above; 0 without area."""
    for axis in range(3):
        i, j = (axis + 1) % 3, (axis + 2) % 3
        side = _side(c[slot, i], c[slot, j], c, slot, 0, i, j)
        if side != 0:
            return -side
    return _NOTHING


@exact_apart
def _meet_closely(x, y, z, up, c, slot):
    """`_meet`, by exact signs."""
    below = orient3d(
        c[slot, 0], c[slot, 1], c[slot, 2], c[slot, 3], c[slot, 4], c[slot, 5], c[slot, 6], c[slot, 7], c[slot, 8],
        x, y, z,
    )  # fmt: skip
    on = _NOTHING
    if below == 0:
        on = np.int64(_touches((x, y, z), c, slot))
        below = _moved_below(c, slot)
    low, high = np.int64(1), np.int64(-1)
    for k in range(3):
        first, second = 3 * ((k + 1) % 3), 3 * ((k + 2) % 3)
        side = _side(x, y, c, slot, k, 0, 1)
        side = moved_side(x, y, c[slot, first], c[slot, first + 1], c[slot, second], c[slot, second + 1], side)
        low, high = min(low, side), max(high, side)
    return low * up if low == high and below * low == up else _NOTHING, on


@exact_device
def _meet(x, y, z, up, c, slot):
    """(crossing, on) of the ray from (x, y, z) along z, or against it if `up` is -1, with the triangle in `slot`.

    The crossing is 1 where the ray leaves through the triangle's front, -1 where it enters; `on` is 1 where the point
    lies on the triangle.
    """
    ax, ay, az = c[slot, 0] - x, c[slot, 1] - y, c[slot, 2] - z
    bx, by, bz = c[slot, 3] - x, c[slot, 4] - y, c[slot, 5] - z
    cx, cy, cz = c[slot, 6] - x, c[slot, 7] - y, c[slot, 8] - z
    p, q, r, s, t, w = bx * cy, by * cx, cx * ay, cy * ax, ax * by, ay * bx
    u, v, n = p - q, r - s, t - w
    a, b, m = abs(p) + abs(q), abs(r) + abs(s), abs(t) + abs(w)
    bound = ORIENT2D_BOUND * (a + b + m) + _UNDERFLOW
    low, high = min(u, v, n), max(u, v, n)
    if low < -bound and high > bound:
        return _NOTHING, _NOTHING
    below = az * u + bz * v + cz * n
    bound3 = ORIENT3D_BOUND * (abs(az) * a + abs(bz) * b + abs(cz) * m) + _UNDERFLOW
    if (low > bound or high < -bound) and abs(below) > bound3:
        front = np.int64(1) if low > 0.0 else np.int64(-1)
        towards = np.int64(1) if below > 0.0 else np.int64(-1)
        return front * up if front * towards == up else _NOTHING, _NOTHING
    return _meet_closely(x, y, z, up, c, slot)


# --- the ray --------------------------------------------------------------------------------------


@device
def _pierced(blocks, block, x, y, z, up):
    """The triangles of a block, as bits, that a ray along the z axis may meet."""
    at = block * BLOCK
    ax, ay = load4(blocks, at) - x, load4(blocks, at + 4) - y
    bx, by = load4(blocks, at + 12) - x, load4(blocks, at + 16) - y
    cx, cy = load4(blocks, at + 24) - x, load4(blocks, at + 28) - y
    az, bz, cz = load4(blocks, at + 8) * up, load4(blocks, at + 20) * up, load4(blocks, at + 32) * up
    u, v, w = bx * cy - by * cx, cx * ay - cy * ax, ax * by - ay * bx
    size = absolute(ax) + absolute(ay) + absolute(bx) + absolute(by) + absolute(cx) + absolute(cy)
    error = size * splat4(_PART) + splat4(_LEAST)
    one_side = (minimum(u, minimum(v, w)) >= splat4(_ZERO) - error) | (maximum(u, maximum(v, w)) <= error)
    return bits(one_side & (maximum(az, maximum(bz, cz)) >= z))


@device
def crossings(mesh, x, y, z, up, stack):
    """(signed crossings, 1 if the point lies on the mesh) of the ray from (x, y, z) of the mesh's frame along the z
    axis, upward if `up` is 1, downward if -1. `stack` is scratch of STACK_WORDS.
    """
    qx, qy, qz = to_single(x, mesh.frame[0, 0]), to_single(y, mesh.frame[0, 1]), to_single(z, mesh.frame[0, 2])
    sign = np.float32(up)
    x8, y8, z8, sign8 = splat8(qx), splat8(qy), splat8(qz * sign), splat8(sign)
    x4, y4, z4, sign4 = splat4(qx), splat4(qy), splat4(qz * sign), splat4(sign)
    far = np.int64(UPPER + 2 * WIDTH) if up > 0 else np.int64(2 * WIDTH)
    nodes = mesh.nodes
    total, on = _NOTHING, _NOTHING
    top, node = _TOP, _ROOT
    while True:
        if node >= 0:
            base = np.int64(node) * NODE
            entered = bits(
                (load8(nodes, base) <= x8)
                & (load8(nodes, base + UPPER) >= x8)
                & (load8(nodes, base + WIDTH) <= y8)
                & (load8(nodes, base + UPPER + WIDTH) >= y8)
                & (load8(nodes, base + far) * sign8 >= z8)
            )
            while entered != 0:
                store_int(stack, top, load_int(nodes, base + CHILD + np.int64(lowest_bit(entered))))
                entered &= entered - np.int32(1)
                top += 1
        else:
            code = np.int64(-1) - np.int64(node)
            first = code >> 3
            for block in range(first, first + (code & 7)):
                met = _pierced(mesh.blocks, block, x4, y4, z4, sign4)
                while met != 0:
                    k = np.int64(lowest_bit(met))
                    met &= met - np.int32(1)
                    if load_int(mesh.blocks, block * BLOCK + NUMBER + k) >= 0:
                        crossing, touching = _meet(x, y, z, up, mesh.corners, block * LANES + k)
                        total += crossing
                        on |= touching
        if top == 0:
            return total, on
        top -= 1
        node = load_int(stack, top)


@device
def winding_of(mesh, x, y, z, stack):
    """(winding number, 1 if the point lies on the mesh) of the point (x, y, z) of the mesh's frame."""
    up = 1 if z >= mesh.frame[0, 2] else -1
    count, on = crossings(mesh, x, y, z, up, stack)
    if mesh.closed != 0:
        return np.float64(count), on
    return np.float64(count) + rim_angle(mesh.rim, x, y, z, up), on


@kernel
def winding_numbers(words, points, begin, end, numbers, on):
    """Fill `numbers` (n,) with winding numbers, and `on` (n,) int32 with 1 for points on the mesh: a range of rows."""
    mesh = open_mesh(words)
    stack = np.empty(STACK_WORDS, np.float32)
    scale = mesh.frame[0, 3]
    for i in range(begin, end):
        number, touching = winding_of(mesh, points[i, 0] * scale, points[i, 1] * scale, points[i, 2] * scale, stack)
        numbers[i] = number
        on[i] = touching
