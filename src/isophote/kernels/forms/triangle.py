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
from isophote.kernels.base.simd import bits, load4, maximum, minimum, splat4
from isophote.kernels.base.simd_product import product_difference

__all__ = ["Shear", "hit_block", "shear"]

_ZERO = np.float32(0)
_ONE = np.float32(1)


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
def shear(origin, direction):
    """The ray's `Shear`. Triangles are met from both sides, so it need not keep winding: a ray's x, y, z and those of
    sixteen in accel/packet.py are in one order, and so are their roundings."""
    ax, ay, az = abs(direction.x), abs(direction.y), abs(direction.z)
    kz = 0 if (ax >= ay and ax >= az) else (1 if ay >= az else 2)
    kx = kz + 1 if kz < 2 else 0
    ky = kx + 1 if kx < 2 else 0
    along = _component(direction, kz)
    sz = _ONE / along
    return Shear(
        np.int64(kx),
        np.int64(ky),
        np.int64(kz),
        splat4(_component(origin, kx)),
        splat4(_component(origin, ky)),
        splat4(_component(origin, kz)),
        splat4(_component(direction, kx) * sz),
        splat4(_component(direction, ky) * sz),
        splat4(sz),
    )


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
