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

import math

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
from isophote.kernels.base.simd_double import (
    absolute_doubles,
    any_negative,
    double_lane,
    load_doubles,
    root_doubles,
    splat_doubles,
    where_negative,
)
from isophote.kernels.measure.mesh_distance import RIM_LANES, STACK_WORDS, open_mesh, to_single

__all__ = ["crossings", "rim_angle", "winding_numbers", "winding_of"]

_ZERO = np.float32(0)
_ROOT = np.int32(0)
_TOP = np.int64(0)
_NOTHING = np.int64(0)
# Single-precision coordinates in the box are wrong by 2^-24, their differences by 2^-22 with rounding; a product of two
# by that times their sum. Twice as much is allowed for.
_PART, _LEAST = np.float32(2.0**-20), np.float32(2.0**-40)
# What underflow may add to the determinants of coordinates in the mesh's frame.
_UNDERFLOW = 2.0**-500
# An angle of hardly less than ±π keeps its sign by such an imaginary part.
_HARDLY = 2.0**-400
# Real and imaginary parts that leave the sign of the angle to rounding.
_LITTLE, _UNSURE = 2.0**-300, 2.0**-49


# --- which triangles the ray meets ----------------------------------------------------------------


@exact_device
def _side(px, py, c, slot, k, i, j):
    """The side, as `orient2d` has it, of a triangle's edge opposite corner k on which a point lies, by axes i and j."""
    first, second = 3 * ((k + 1) % 3), 3 * ((k + 2) % 3)
    return orient2d(px, py, c[slot, first + i], c[slot, first + j], c[slot, second + i], c[slot, second + j])


@exact_device
def _moved_side(px, py, ax, ay, bx, by, side):
    """The side of the line from a to b on which (px + ε, py + ε²) lies, where (px, py) lies on `side` of it."""
    if side != 0:
        return side
    if ay != by:
        return np.int64(1) if ay > by else np.int64(-1)
    return np.int64(bx > ax) - np.int64(bx < ax)


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
        side = _moved_side(x, y, c[slot, first], c[slot, first + 1], c[slot, second], c[slot, second + 1], side)
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


# --- the rim --------------------------------------------------------------------------------------


@device
def _turned(real, imaginary, r, i):
    """(the product of two complex numbers, made about 1 in size, the turns that it went round beyond ±π)."""
    product, other = real * r - imaginary * i, real * i + imaginary * r
    turns = 0.0
    if imaginary >= 0.0 and i >= 0.0 and other < 0.0:
        turns = 1.0
    elif imaginary < 0.0 and i < 0.0 and other >= 0.0:
        turns = -1.0
    size = 1.0 / (abs(product) + abs(other))
    return product * size, other * size, turns


@exact_device
def _half_angle_closely(ax, ay, az, bx, by, bz, x, y, up):
    """r and i (`rim_angle`) of the edge from a to b as seen from (x, y, 0), also where the angle may be ±π.

    There its sign is that of the side on which (x + ε, y + ε²) lies of the edge. A vertex on the ray is to the left.
    """
    px, py, qx, qy = ax - x, ay - y, bx - x, by - y
    a_on = px == 0.0 and py == 0.0 and az * up >= 0.0
    b_on = qx == 0.0 and qy == 0.0 and bz * up >= 0.0
    if a_on and b_on:
        return 1.0, 0.0
    if a_on:
        real, imaginary = -qx, qy * up
    elif b_on:
        real, imaginary = -px, -py * up
    else:
        a, b = math.sqrt(px * px + py * py + az * az), math.sqrt(qx * qx + qy * qy + bz * bz)
        a_height = (px * px + py * py) / (a + az * up) if az * up > 0.0 else a - az * up
        b_height = (qx * qx + qy * qy) / (b + bz * up) if bz * up > 0.0 else b - bz * up
        real, imaginary = a_height * b_height + (px * qx + py * qy), up * (py * qx - px * qy)
    if real <= 0.0:
        side = _moved_side(x, y, ax, ay, bx, by, orient2d(x, y, ax, ay, bx, by))
        imaginary = math.copysign(max(abs(imaginary), _HARDLY), np.float64(-up * side))
    size = 1.0 / (abs(real) + abs(imaginary))
    return real * size, imaginary * size


@exact_apart
def _rim_closely(rim, x, y, z, up):
    """`rim_angle`, edge by edge."""
    real, imaginary, turns = 1.0, 0.0, 0.0
    for k in range(rim.columns):
        r, i = _half_angle_closely(
            rim[0, k], rim[1, k], rim[2, k] - z, rim[3, k], rim[4, k], rim[5, k] - z, x, y, up
        )  # fmt: skip
        real, imaginary, more = _turned(real, imaginary, r, i)
        turns += more
    return turns + math.atan2(imaginary, real) / (2.0 * math.pi)


@device
def _height(x, y, z, zero, one):
    """(h, f) with h / f = |v| - z of eight vectors v: not by the difference where it would cancel."""
    square = x * x + y * y
    length = root_doubles(square + z * z)
    down = zero - z
    return where_negative(down, square, length + down), where_negative(down, length + z, one)


@device
def rim_angle(mesh, x, y, z, up):
    """The sum of Ω / 4π over the rim's edges, for the ray upward (`up` 1) or downward (-1).

    tan(Ω / 2) of the cone from -d over the edge from a to b is i / r, where, with d = (0, 0, 1),
    r = (|a| - a_z) (|b| - b_z) + a_x b_x + a_y b_y and i = a_y b_x - a_x b_y. Where a_z > 0, |a| - a_z is taken as
    (a_x² + a_y²) / (|a| + a_z), and r and i are multiplied by the denominator. The angles are added by multiplying the
    numbers r + i √-1, in eight lanes, and counting how often the products go round.
    """
    rim = mesh.rim
    columns = rim.columns
    zero, one, sign = splat_doubles(0.0), splat_doubles(1.0), splat_doubles(np.float64(up))
    x8, y8, z8, part = splat_doubles(x), splat_doubles(y), splat_doubles(z), splat_doubles(_UNSURE)
    real, imaginary, turns = one, zero, zero
    for k in range(0, columns, RIM_LANES):
        ax, ay = load_doubles(rim, k) - x8, load_doubles(rim, columns + k) - y8
        bx, by = load_doubles(rim, 3 * columns + k) - x8, load_doubles(rim, 4 * columns + k) - y8
        a_height, a_factor = _height(ax, ay, (load_doubles(rim, 2 * columns + k) - z8) * sign, zero, one)
        b_height, b_factor = _height(bx, by, (load_doubles(rim, 5 * columns + k) - z8) * sign, zero, one)
        factor = a_factor * b_factor
        left, right = ay * bx, ax * by
        r = a_height * b_height + factor * (ax * bx + ay * by)
        i = sign * factor * (left - right)
        sure = absolute_doubles(i) - part * factor * (absolute_doubles(left) + absolute_doubles(right))
        # Nowhere may the sign of the angle be left to rounding: r is negative or nearly so, and i nearly zero.
        if any_negative(where_negative(r - splat_doubles(_LITTLE) * factor, sure - splat_doubles(_LITTLE), one)):
            return _rim_closely(rim, x, y, z, up)
        product, other = real * r - imaginary * i, real * i + imaginary * r
        round_up = where_negative(imaginary, zero, where_negative(i, zero, one))
        round_down = where_negative(imaginary, where_negative(i, one, zero), zero)
        turns = turns + where_negative(other, round_up, zero - round_down)
        size = one / (absolute_doubles(product) + absolute_doubles(other))
        real, imaginary = product * size, other * size
    all_turns, p, q = 0.0, 1.0, 0.0
    for k in range(RIM_LANES):
        p, q, more = _turned(p, q, double_lane(real, np.int64(k)), double_lane(imaginary, np.int64(k)))
        all_turns += more + double_lane(turns, np.int64(k))
    return all_turns + math.atan2(q, p) / (2.0 * math.pi)


@device
def winding_of(mesh, x, y, z, stack):
    """(winding number, 1 if the point lies on the mesh) of the point (x, y, z) of the mesh's frame."""
    up = 1 if z >= mesh.frame[0, 2] else -1
    count, on = crossings(mesh, x, y, z, up, stack)
    if mesh.closed != 0:
        return np.float64(count), on
    return np.float64(count) + rim_angle(mesh, x, y, z, up), on


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
