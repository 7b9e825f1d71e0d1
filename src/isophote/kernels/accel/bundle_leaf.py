"""Rays of a bundle (bundle.py) against the triangles of a leaf, sixteen rays to a triangle."""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.bundle_rays import (
    CORNERS,
    GROUP,
    LANES_OF_GROUP,
    NO_RAYS,
    ONE_RAY,
    ROW,
    SHEARS,
    sheared_ray,
)
from isophote.kernels.accel.layout import BLOCK, LANES
from isophote.kernels.base.bit_set import count_of, first_of
from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import (
    absolute,
    bits,
    load4,
    load16,
    load_float,
    lowest_bit,
    maximum,
    minimum,
    splat4,
    splat16,
    store4,
)
from isophote.kernels.base.simd_product import product_difference
from isophote.kernels.forms.triangle import meets_blocks

__all__ = ["blocked_in_leaf"]

# So few rays of a leaf go one by one.
_FEW_IN_LEAF = np.int64(12)
_ZERO, _ONE = np.float32(0), np.float32(1)


@device
def _corner_from(blocks, scratch, at, corner, bundle):
    """Leave a corner of a block's triangles, from the origin, in the scratch; how far along the normal it is, less
    what the cone reaches below."""
    cone, o = bundle.cone, bundle.origin
    step = corner * (3 * LANES)
    x = load4(blocks, at + step) - splat4(o.x)
    y = load4(blocks, at + step + LANES) - splat4(o.y)
    z = load4(blocks, at + step + 2 * LANES) - splat4(o.z)
    store4(scratch, CORNERS + step, x)
    store4(scratch, CORNERS + step + LANES, y)
    store4(scratch, CORNERS + step + 2 * LANES, z)
    up = splat4(cone.nx) * x + splat4(cone.ny) * y + splat4(cone.nz) * z
    return up + splat4(cone.below) * (absolute(x) + absolute(y) + absolute(z))


@device
def _reached_triangles(blocks, block, scratch, bundle):
    """Which triangles of a block the bundle may reach, as bits; their corners are left in the scratch."""
    at = block * BLOCK
    a = _corner_from(blocks, scratch, at, np.int64(0), bundle)
    b = _corner_from(blocks, scratch, at, np.int64(1), bundle)
    c = _corner_from(blocks, scratch, at, np.int64(2), bundle)
    # Places, and the sums above, are uncertain.
    return bits(maximum(a, maximum(b, c)) >= splat4(bundle.cone.place * np.float32(-3)))


@device
def _corner(scratch, corner, axis, lane):
    return splat16(load_float(scratch, CORNERS + corner * (3 * LANES) + axis * LANES + lane))


@device
def _meet_triangle(scratch, lane, kx, ky, kz, sx, sy, sz, limit):
    """Which of sixteen rays meet triangle `lane` of the block in the scratch, as bits; see forms/triangle.py."""
    az, bz, cz = _corner(scratch, 0, kz, lane), _corner(scratch, 1, kz, lane), _corner(scratch, 2, kz, lane)
    ax = _corner(scratch, 0, kx, lane) - sx * az
    bx = _corner(scratch, 1, kx, lane) - sx * bz
    cx = _corner(scratch, 2, kx, lane) - sx * cz
    ay = _corner(scratch, 0, ky, lane) - sy * az
    by = _corner(scratch, 1, ky, lane) - sy * bz
    cy = _corner(scratch, 2, ky, lane) - sy * cz
    u = product_difference(cx, by, cy, bx)
    v = product_difference(ax, cy, ay, cx)
    w = product_difference(bx, ay, by, ax)
    zero = splat16(_ZERO)
    inside = (minimum(u, minimum(v, w)) >= zero) | (maximum(u, maximum(v, w)) <= zero)
    scale = splat16(_ONE) / (u + v + w)
    t = (u * az + v * bz + w * cz) * sz * scale
    return bits(inside & (t > zero) & (t < limit))


@device
def _blocked_along(scratch, kz, limit, rays, reached):
    """Those of the rays, all with directions longest along axis `kz`, that meet triangles of the block in scratch."""
    kx = np.int64(kz + 1 if kz < 2 else 0)
    ky = np.int64(kx + 1 if kx < 2 else 0)
    blocked = NO_RAYS
    while rays != 0:
        column = first_of(rays) // GROUP * GROUP
        of_group = rays & (LANES_OF_GROUP << column)
        rays &= ~of_group
        sx, sy, sz = (
            load16(scratch, SHEARS + column),
            load16(scratch, SHEARS + ROW + column),
            load16(scratch, SHEARS + 2 * ROW + column),
        )
        left = reached
        met = np.int32(0)
        while left != 0:
            lane = np.int64(lowest_bit(left))
            left &= left - np.int32(1)
            met |= _meet_triangle(scratch, lane, kx, ky, kz, sx, sy, sz, splat16(limit))
        blocked |= (np.int64(met) << column) & of_group
    return blocked


@device
def blocked_in_leaf(blocks, first, count, bundle, rays, scratch):
    """Those of the rays that meet a triangle in blocks first ≤ b < first + count."""
    if count_of(rays) <= _FEW_IN_LEAF:
        return _blocked_alone(blocks, first, count, bundle, rays, scratch)
    blocked = NO_RAYS
    for block in range(first, first + count):
        left = rays & ~blocked
        reached = _reached_triangles(blocks, block, scratch, bundle)
        if reached == 0:
            continue
        blocked |= _blocked_along(scratch, np.int64(0), bundle.limit, left & bundle.along_x, reached)
        blocked |= _blocked_along(scratch, np.int64(1), bundle.limit, left & bundle.along_y, reached)
        blocked |= _blocked_along(scratch, np.int64(2), bundle.limit, left & bundle.along_z, reached)
    return blocked


@device
def _blocked_alone(blocks, first, count, bundle, rays, scratch):
    """`blocked_in_leaf`, ray by ray."""
    blocked = NO_RAYS
    while rays != 0:
        i = first_of(rays)
        rays &= rays - ONE_RAY
        if meets_blocks(blocks, first, first + count, sheared_ray(scratch, bundle, i), bundle.limit):
            blocked |= ONE_RAY << i
    return blocked
