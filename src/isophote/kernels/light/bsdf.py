"""How surfaces scatter light: the kinds of material that are compiled into the tiles, and the table of all.

All other kinds are LINKED: tiles call them by address (brdf/contract.py), so that they do not grow with their number.

Directions are of the world: `out` leaves the surface towards where the path came from, `into` is where it goes on.
"""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.base.jit import device
from isophote.kernels.base.table import FLOAT_ROWS, FLOATS, INT, INT_ROWS, INTS, LONG_ROWS, Table
from isophote.kernels.base.vec import dot, orthonormal
from isophote.kernels.base.warp import INV_PI

__all__ = [
    "BLACK",
    "GLASS",
    "LINKED",
    "MATERIALS",
    "MATTE",
    "MIRROR",
    "fresnel_dielectric",
    "scatter_glass",
    "scatter_matte",
]

MATTE, MIRROR, GLASS, BLACK, LINKED = 0, 1, 2, 3, 4

_ZERO, _HALF, _ONE = np.float32(0), np.float32(0.5), np.float32(1)


# `kinds` (n,); `textures`, `emission_textures` (n,): what multiplies the colour and what is emitted, or −1; `values`
# (n, 8): colour, emitted radiance, index of refraction, 1 where both sides emit. `scatters` (n,): 1 where light from
# any direction is scattered to others, so that lights can be aimed at, 2 where some goes through the surface;
# `branches` (n,): the number of single directions that light is sent to.
#
# Of LINKED kinds: `prepare`, the entry of trace/prepare.py; `spans` (n, 6): root node, first slot, number of slots, 1
# where the tangent matters, which of the slots is the first of two whose sum is what ambient light is multiplied
# by, or 0 where none is, and 1 more than that which holds the normal that is seen, or 0 where it is the surface's;
# `nodes` (m, 8) as in brdf/contract.py; `slot_values` (k, 3) and `slot_codes` (k, 2): a parameter's value and the
# texture that multiplies it, or −1, with the channel that counts, or −1 for all three, or NORMAL_MAP where texels are
# turned into a normal of the world, or BUMP where heights are, by the entry `bump` of trace/bump.py; `data`: numbers of
# whatever kind, such as tables of measured reflectance.
#
# `cuts` (n,): the slot of a surface's opacity, which its cut-off follows, or −1 where it is whole; `opacity`,
# `pass_holes` and `shade_holes`: the entries of trace/hole_rays.py, or 0 where no material is cut out.
MATERIALS = Table(
    "Materials",
    kinds=INTS,
    textures=INTS,
    emission_textures=INTS,
    values=FLOAT_ROWS,
    scatters=INTS,
    branches=INTS,
    prepare=INT,
    spans=INT_ROWS,
    nodes=LONG_ROWS,
    slot_values=FLOAT_ROWS,
    slot_codes=INT_ROWS,
    data=FLOATS,
    cuts=INTS,
    opacity=INT,
    pass_holes=INT,
    shade_holes=INT,
    bump=INT,
)


@device
def fresnel_dielectric(cosine, ior):
    """(reflected share, cosine inside) at a smooth boundary, unpolarised; `ior` is that behind over that in front.

    r_par = (n cosθ − cosθ') / (n cosθ + cosθ'),  r_perp = (cosθ − n cosθ') / (cosθ + n cosθ'),
    R = ½ (r_par² + r_perp²);  R = 1 where sinθ > n (total internal reflection).
    """
    sine2 = (_ONE - cosine * cosine) / (ior * ior)
    if sine2 >= _ONE:
        return _ONE, _ZERO
    inside = math.sqrt(_ONE - sine2)
    parallel = (ior * cosine - inside) / (ior * cosine + inside)
    perpendicular = (cosine - ior * inside) / (cosine + ior * inside)
    return _HALF * (parallel * parallel + perpendicular * perpendicular), inside


@device
def scatter_matte(normal, x, y):
    """(direction, density) in proportion to the cosine, from a point (x, y) of the unit disk."""
    z = math.sqrt(max(_ZERO, _ONE - x * x - y * y))
    tangent, bitangent = orthonormal(normal)
    return tangent * x + bitangent * y + normal * z, z * INV_PI


@device
def scatter_glass(out, normal, ior, u):
    """(direction, factor on radiance) of the reflected or the refracted ray, picked by `u` in proportion to its share.

    Radiance is squeezed into a smaller cone behind the boundary: the refracted ray carries 1 / n² of it
    (Veach: thesis, 1997, section 5.2).
    """
    cosine = dot(out, normal)
    n = ior if cosine > _ZERO else _ONE / ior
    facing = normal if cosine > _ZERO else -normal
    cosine = abs(cosine)
    share, inside = fresnel_dielectric(cosine, n)
    if u < share:
        return facing * (cosine + cosine) - out, _ONE
    return facing * (cosine / n - inside) - out / n, _ONE / (n * n)
