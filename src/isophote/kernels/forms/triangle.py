"""Rays against triangles, several at once, without leaks between neighbours.

Woop, Benthin, Wald: "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013. The ray is sheared onto its longest
axis; the three edge functions of the sheared corners say whether it passes inside. Two triangles that share an
edge compute the same sheared corners and edge functions of opposite sign, so that a ray cannot pass between them: an
edge function has the sign that exact arithmetic on these corners gives, and is zero only where that is. Where rounding
could make it zero, a ray would meet triangles far from it that it only sees edge-on.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from isophote.kernels.accel.layout import BLOCK, LANES
from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import bits, load4, maximum, minimum, splat4, splat8
from isophote.kernels.base.simd_pairs import joined
from isophote.kernels.base.simd_product import product_difference

__all__ = ["Shear", "hit_block", "meets_blocks", "shear", "shear_for_pairs"]

_ZERO = np.float32(0)
_ONE = np.float32(1)
_A, _B, _C = np.int64(0), np.int64(1), np.int64(2)


class Shear(NamedTuple):
    """A ray made ready for triangles: permuted axes and the shear that turns it into +z."""

    kx: int
    ky: int
    kz: int
    ox: float
    oy: float
    oz: float
    sx: float
    sy: float
    sz: float


@device
def _component(v, k):
    return v.x if k == 0 else (v.y if k == 1 else v.z)


@device
def _splits(origin, direction):
    """What `Shear` holds, as single numbers."""
    ax, ay, az = abs(direction.x), abs(direction.y), abs(direction.z)
    kz = 0 if (ax >= ay and ax >= az) else (1 if ay >= az else 2)
    kx = kz + 1 if kz < 2 else 0
    ky = kx + 1 if kx < 2 else 0
    sz = _ONE / _component(direction, kz)
    sx, sy = _component(direction, kx) * sz, _component(direction, ky) * sz
    ox, oy, oz = _component(origin, kx), _component(origin, ky), _component(origin, kz)
    return np.int64(kx), np.int64(ky), np.int64(kz), ox, oy, oz, sx, sy, sz


@device
def shear(origin, direction):
    """The ray's `Shear`. Triangles are met from both sides, so it need not keep winding: a ray's x, y, z and those of
    sixteen in accel/packet.py are in one order, and so are their roundings."""
    kx, ky, kz, ox, oy, oz, sx, sy, sz = _splits(origin, direction)
    return Shear(kx, ky, kz, splat4(ox), splat4(oy), splat4(oz), splat4(sx), splat4(sy), splat4(sz))


@device
def shear_for_pairs(origin, direction):
    """The ray's `Shear` for `meets_blocks`."""
    kx, ky, kz, ox, oy, oz, sx, sy, sz = _splits(origin, direction)
    return Shear(kx, ky, kz, splat8(ox), splat8(oy), splat8(oz), splat8(sx), splat8(sy), splat8(sz))


@device
def hit_block(blocks, block, ray, t_max):
    """Which of a block's triangles the ray meets before `t_max`: (bits, t, weight of corner 1, of corner 2)."""
    x = block * BLOCK + ray.kx * LANES
    y = block * BLOCK + ray.ky * LANES
    z = block * BLOCK + ray.kz * LANES
    step = 3 * LANES
    az = load4(blocks, z) - ray.oz
    bz = load4(blocks, z + step) - ray.oz
    cz = load4(blocks, z + 2 * step) - ray.oz
    ax = (load4(blocks, x) - ray.ox) - ray.sx * az
    bx = (load4(blocks, x + step) - ray.ox) - ray.sx * bz
    cx = (load4(blocks, x + 2 * step) - ray.ox) - ray.sx * cz
    ay = (load4(blocks, y) - ray.oy) - ray.sy * az
    by = (load4(blocks, y + step) - ray.oy) - ray.sy * bz
    cy = (load4(blocks, y + 2 * step) - ray.oy) - ray.sy * cz
    u = product_difference(cx, by, cy, bx)
    v = product_difference(ax, cy, ay, cx)
    w = product_difference(bx, ay, by, ax)
    zero = splat4(_ZERO)
    inside = (minimum(u, minimum(v, w)) >= zero) | (maximum(u, maximum(v, w)) <= zero)
    det = u + v + w
    scale = splat4(_ONE) / det
    t = (u * az + v * bz + w * cz) * ray.sz * scale
    met = inside & (t > zero) & (t < splat4(t_max))
    return bits(met), t, v * scale, w * scale


@device
def _pair(blocks, at, corner, axis):
    """A coordinate of a corner of the triangles of two blocks, which begin at two words."""
    step = corner * (3 * LANES) + axis * LANES
    return joined(load4(blocks, at[0] + step), load4(blocks, at[1] + step))


@device
def _meets_pair(blocks, block, other, ray, t_max):
    """Whether the ray meets any triangle of two blocks before `t_max`; bit for bit as `hit_block` has it."""
    at = block * BLOCK, other * BLOCK
    az = _pair(blocks, at, _A, ray.kz) - ray.oz
    bz = _pair(blocks, at, _B, ray.kz) - ray.oz
    cz = _pair(blocks, at, _C, ray.kz) - ray.oz
    ax = (_pair(blocks, at, _A, ray.kx) - ray.ox) - ray.sx * az
    bx = (_pair(blocks, at, _B, ray.kx) - ray.ox) - ray.sx * bz
    cx = (_pair(blocks, at, _C, ray.kx) - ray.ox) - ray.sx * cz
    ay = (_pair(blocks, at, _A, ray.ky) - ray.oy) - ray.sy * az
    by = (_pair(blocks, at, _B, ray.ky) - ray.oy) - ray.sy * bz
    cy = (_pair(blocks, at, _C, ray.ky) - ray.oy) - ray.sy * cz
    u = product_difference(cx, by, cy, bx)
    v = product_difference(ax, cy, ay, cx)
    w = product_difference(bx, ay, by, ax)
    zero = splat8(_ZERO)
    inside = (minimum(u, minimum(v, w)) >= zero) | (maximum(u, maximum(v, w)) <= zero)
    scale = splat8(_ONE) / (u + v + w)
    t = (u * az + v * bz + w * cz) * ray.sz * scale
    return bits(inside & (t > zero) & (t < splat8(t_max))) != 0


@device
def meets_blocks(blocks, first, last, ray, t_max):
    """Whether the ray meets any triangle of blocks first ≤ b < last before `t_max`."""
    block, met = first, False
    while block < last and not met:
        met = _meets_pair(blocks, block, min(block + 1, last - 1), ray, t_max)
        block += 2
    return met
