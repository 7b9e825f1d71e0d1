"""The solid angle of the cones from a mesh's rim to infinity, as seen from a point: sums over edges, in eight lanes.

The rim is a chain of directed edges, cut into eight stretches of about the same number, one for each lane. `rim` is (4,
8 k): x, y, z of vertices, eight stretches side by side, and a link: 1 where an edge runs from the vertex before to this
one, -1 where none does. After the first vertices they come in groups of `RIM_GROUP`.
"""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.base.jit import device, exact_apart, exact_device
from isophote.kernels.base.predicates import orient2d
from isophote.kernels.base.simd_double import (
    absolute_doubles,
    any_negative,
    double_lane,
    load_doubles,
    root_doubles,
    splat_doubles,
    where_negative,
)
from isophote.kernels.base.simd_signs import count_bits, sign_bits
from isophote.kernels.measure.mesh_distance import RIM_GROUP, RIM_LANES

__all__ = ["moved_side", "rim_angle"]

_NOTHING = np.int64(0)
# An angle of hardly less than ±π keeps its sign by such an imaginary part.
_HARDLY = 2.0**-400
# Real and imaginary parts that leave the sign of the angle to rounding.
_LITTLE, _UNSURE = 2.0**-200, 2.0**-49


@exact_device
def moved_side(px, py, ax, ay, bx, by, side):
    """The side of the line from a to b on which (px + ε, py + ε²) lies, where (px, py) lies on `side` of it."""
    if side != 0:
        return side
    if ay != by:
        return np.int64(1) if ay > by else np.int64(-1)
    return np.int64(bx > ax) - np.int64(bx < ax)


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
def _about_one(x, y, z):
    """A vector times a power of two that makes it about 1, if it is not 0."""
    exponent = math.frexp(max(abs(x), abs(y), abs(z)))[1]
    return math.ldexp(x, -exponent), math.ldexp(y, -exponent), math.ldexp(z, -exponent)


@exact_device
def _half_angle_closely(ax, ay, az, bx, by, bz, x, y, up):
    """r and i (`rim_angle`) of the edge from a to b as seen from (x, y, 0), also where the angle may be ±π.

    There its sign is that of the side on which (x + ε, y + ε²) lies of the edge. A vertex on the ray is to the left.
    """
    px, py, pz = _about_one(ax - x, ay - y, az)
    qx, qy, qz = _about_one(bx - x, by - y, bz)
    a_on = px == 0.0 and py == 0.0 and pz * up >= 0.0
    b_on = qx == 0.0 and qy == 0.0 and qz * up >= 0.0
    if a_on and b_on:
        return 1.0, 0.0
    if a_on:
        real, imaginary = -qx, qy * up
    elif b_on:
        real, imaginary = -px, -py * up
    else:
        a, b = math.sqrt(px * px + py * py + pz * pz), math.sqrt(qx * qx + qy * qy + qz * qz)
        a_height = (px * px + py * py) / (a + pz * up) if pz * up > 0.0 else a - pz * up
        b_height = (qx * qx + qy * qy) / (b + qz * up) if qz * up > 0.0 else b - qz * up
        real, imaginary = a_height * b_height + (px * qx + py * qy), up * (py * qx - px * qy)
    if real <= 0.0:
        side = moved_side(x, y, ax, ay, bx, by, orient2d(x, y, ax, ay, bx, by))
        imaginary = math.copysign(max(abs(imaginary), _HARDLY), np.float64(-up * side))
    size = 1.0 / (abs(real) + abs(imaginary))
    return real * size, imaginary * size


@exact_apart
def _rim_closely(rim, x, y, z, up):
    """`rim_angle`, edge by edge."""
    real, imaginary, turns = 1.0, 0.0, 0.0
    columns = np.int64(rim.columns)
    for b in range(RIM_LANES, columns):
        if rim[3, b] > 0.0:
            a = b - RIM_LANES
            r, i = _half_angle_closely(
                rim[0, a], rim[1, a], rim[2, a] - z, rim[0, b], rim[1, b], rim[2, b] - z, x, y, up
            )  # fmt: skip
            real, imaginary, more = _turned(real, imaginary, r, i)
            turns += more
    return turns + math.atan2(imaginary, real) / (2.0 * math.pi)


@device
def _height(x, y, z):
    """(h, f) with h / f = |v| - z of eight vectors v: not by the difference where it would cancel."""
    square = x * x + y * y
    length = root_doubles(square + z * z)
    down = splat_doubles(0.0) - z
    return where_negative(down, square, length - z), where_negative(down, length + z, splat_doubles(1.0))


@device
def _is_sure(rim, group, x, y, z, sign):
    """Whether no edge of a group leaves the sign of its angle to rounding: r negative or nearly so, i nearly zero."""
    columns = np.int64(rim.columns)
    part, little, one = splat_doubles(_UNSURE), splat_doubles(_LITTLE), splat_doubles(1.0)
    for k in range(group, group + RIM_GROUP * RIM_LANES, RIM_LANES):
        a = k - RIM_LANES
        ax, ay = load_doubles(rim, a) - x, load_doubles(rim, columns + a) - y
        bx, by = load_doubles(rim, k) - x, load_doubles(rim, columns + k) - y
        a_height, a_factor = _height(ax, ay, load_doubles(rim, 2 * columns + a) * sign - z)
        b_height, b_factor = _height(bx, by, load_doubles(rim, 2 * columns + k) * sign - z)
        factor = a_factor * b_factor
        left, right = ay * bx, ax * by
        r = a_height * b_height + factor * (ax * bx + ay * by)
        error = part * (absolute_doubles(left) + absolute_doubles(right))
        margin = factor * (absolute_doubles(left - right) - error) - little
        doubt = where_negative(r - little * factor, margin, one)
        if any_negative(where_negative(load_doubles(rim, 3 * columns + k), one, doubt)):
            return False
    return True


@device
def rim_angle(rim, x, y, z, up):
    """The sum of Ω / 4π over the rim's edges, for the ray upward (`up` 1) or downward (-1).

    tan(Ω / 2) of the cone from -d over the edge from a to b is i / r, where, with d = (0, 0, 1),
    r = (|a| - a_z) (|b| - b_z) + a_x b_x + a_y b_y and i = a_y b_x - a_x b_y; with d = (0, 0, -1), z and i change
    signs. Where a_z > 0, |a| - a_z is taken as (a_x² + a_y²) / (|a| + a_z), and r and i are multiplied by the
    denominator. The angles are added by multiplying the numbers r + i √-1, in eight lanes, and counting how often the
    products go round: where a sum of two angles of one sign has the other.
    """
    columns = np.int64(rim.columns)
    zero, one, sign = splat_doubles(0.0), splat_doubles(1.0), splat_doubles(np.float64(up))
    little = splat_doubles(_LITTLE)
    x8, y8, z8 = splat_doubles(x), splat_doubles(y), splat_doubles(z * up)
    real, imaginary, turns, below = one, zero, _NOTHING, _NOTHING
    ax, ay = load_doubles(rim, _NOTHING) - x8, load_doubles(rim, columns) - y8
    a_height, a_factor = _height(ax, ay, load_doubles(rim, 2 * columns) * sign - z8)
    for group in range(RIM_LANES, columns, RIM_GROUP * RIM_LANES):
        doubt = one
        for k in range(group, group + RIM_GROUP * RIM_LANES, RIM_LANES):
            bx, by = load_doubles(rim, k) - x8, load_doubles(rim, columns + k) - y8
            b_height, b_factor = _height(bx, by, load_doubles(rim, 2 * columns + k) * sign - z8)
            link = load_doubles(rim, 3 * columns + k)
            factor = a_factor * b_factor
            r = where_negative(link, one, a_height * b_height + factor * (ax * bx + ay * by))
            i = where_negative(link, zero, factor * (ay * bx - ax * by))
            doubt = where_negative(r - little * factor, zero - one, doubt)
            real, imaginary = real * r - imaginary * i, real * i + imaginary * r
            before, added = below, sign_bits(i)
            below = sign_bits(imaginary)
            turns += count_bits(below & ~(before | added)) - count_bits(before & added & ~below)
            ax, ay, a_height, a_factor = bx, by, b_height, b_factor
        if any_negative(doubt) and not _is_sure(rim, group, x8, y8, z8, sign):
            return _rim_closely(rim, x, y, z, up)
        size = one / (absolute_doubles(real) + absolute_doubles(imaginary))
        real, imaginary = real * size, imaginary * size
    p, q = 1.0, 0.0
    for k in range(RIM_LANES):
        r, i = double_lane(real, np.int64(k)), double_lane(imaginary, np.int64(k))
        # The lanes are about 1 in size, so their product is not much smaller.
        product, other = p * r - q * i, p * i + q * r
        turns += np.int64((q >= 0.0) & (i >= 0.0) & (other < 0.0)) - np.int64((q < 0.0) & (i < 0.0) & (other >= 0.0))
        p, q = product, other
    # What is too small or too large for a group's product ends as NaN.
    if not p * p + q * q > 0.0:
        return _rim_closely(rim, x, y, z, up)
    return up * (turns + math.atan2(q, p) / (2.0 * math.pi))
