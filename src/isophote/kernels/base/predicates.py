"""Signs of determinants that decide about points: orient2d, orient3d, incircle, insphere, as device functions.

Each gives -1, 0 or 1, and the right one for all finite doubles, however large, small or nearly degenerate:

1. a filter in doubles with Shewchuk's forward bounds ("Adaptive Precision Floating-Point Arithmetic and Fast Robust
   Geometric Predicates", 1997), which decides nearly always and is compiled into the caller;
2. the same determinant in pairs of doubles over exact differences, some 2^-100 of its largest terms. Where all
   coordinates are multiples of 2^k, as on a grid, the determinant is one of a power of it, so a small value is zero;
3. whole numbers (`determinant_sign`).

Underflow errs by an absolute amount, which the bounds of 1 and 2 include; overflow makes infinities or NaN, which pass
no bound. So 3 decides where doubles cannot.
"""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.base.exact import (
    determinant_sign,
    lowest_place,
    pair_add,
    pair_multiply,
    pair_subtract,
    two_difference,
)
from isophote.kernels.base.jit import exact_apart, exact_device

__all__ = [
    "INCIRCLE_BOUND",
    "INSPHERE_BOUND",
    "ORIENT2D_BOUND",
    "ORIENT3D_BOUND",
    "incircle",
    "insphere",
    "orient2d",
    "orient3d",
]

_EPSILON = 2.0**-53
ORIENT2D_BOUND = (3 + 16 * _EPSILON) * _EPSILON
ORIENT3D_BOUND = (7 + 56 * _EPSILON) * _EPSILON
INCIRCLE_BOUND = (10 + 96 * _EPSILON) * _EPSILON
INSPHERE_BOUND = (16 + 224 * _EPSILON) * _EPSILON

# In pairs: an operation errs by 8 * 2^-106 of its result at most; a determinant's terms pass through one, four, four
# and eight of them, and twice as many again are allowed for.
_PAIR_ORIENT2D_BOUND = 2.0**-101
_PAIR_ORIENT3D_BOUND = 2.0**-100
_PAIR_INCIRCLE_BOUND = 2.0**-99
_PAIR_INSPHERE_BOUND = 2.0**-98
# What underflow adds, for each unit of what the underflowing product is multiplied by afterwards. It adds far less, but
# processors take long over numbers too small to be normal, and this is the least that is.
_UNDERFLOW = 2.0**-1022

_TWO = np.int64(2)
_THREE = np.int64(3)
_LIFTED = np.bool_(True)
_FLAT = np.bool_(False)

_NONE = np.int64(0)
_MINUS = np.int64(-1)
_PLUS = np.int64(1)
# Not a sign: undecided.
_UNDECIDED = np.int64(2)


@exact_device
def _decide(value, bound, place):
    """The sign of a determinant that lies within `bound` of `value` and is a multiple of 2^place."""
    if value > bound:
        return _PLUS
    if -value > bound:
        return _MINUS
    if abs(value) + bound < math.ldexp(1.0, place):
        return _NONE
    return _UNDECIDED


@exact_device
def orient2d(ax, ay, bx, by, cx, cy):
    """1 where a, b, c turn to the left (counterclockwise), -1 to the right, 0 where they lie on a line."""
    left = (ax - cx) * (by - cy)
    right = (ay - cy) * (bx - cx)
    value = left - right
    bound = ORIENT2D_BOUND * (abs(left) + abs(right)) + _UNDERFLOW
    if value > bound:
        return _PLUS
    if -value > bound:
        return _MINUS
    return _orient2d_closely(ax, ay, bx, by, cx, cy)


@exact_apart
def _orient2d_closely(ax, ay, bx, by, cx, cy):
    adx, ady = two_difference(ax, cx), two_difference(ay, cy)
    bdx, bdy = two_difference(bx, cx), two_difference(by, cy)
    left, right = pair_multiply(adx, bdy), pair_multiply(ady, bdx)
    value = pair_subtract(left, right)[0]
    bound = _PAIR_ORIENT2D_BOUND * (abs(left[0]) + abs(right[0])) + _UNDERFLOW
    place = min(lowest_place(ax), lowest_place(bx), lowest_place(cx)) + min(
        lowest_place(ay), lowest_place(by), lowest_place(cy)
    )
    sign = _decide(value, bound, place)
    if sign != _UNDECIDED:
        return sign
    if adx[1] == 0 and ady[1] == 0 and bdx[1] == 0 and bdy[1] == 0:
        return determinant_sign((adx[0], ady[0], bdx[0], bdy[0]), _TWO, _FLAT)
    return determinant_sign((ax, ay, bx, by, cx, cy), _TWO, _FLAT)


@exact_device
def incircle(ax, ay, bx, by, cx, cy, dx, dy):
    """1 where d lies inside the circle through a, b, c, -1 outside, 0 on it, for a, b, c counterclockwise.

    For a, b, c clockwise the signs are exchanged.
    """
    adx, ady = ax - dx, ay - dy
    bdx, bdy = bx - dx, by - dy
    cdx, cdy = cx - dx, cy - dy
    bdxcdy, cdxbdy = bdx * cdy, cdx * bdy
    cdxady, adxcdy = cdx * ady, adx * cdy
    adxbdy, bdxady = adx * bdy, bdx * ady
    a, b, c = adx * adx + ady * ady, bdx * bdx + bdy * bdy, cdx * cdx + cdy * cdy
    value = a * (bdxcdy - cdxbdy) + b * (cdxady - adxcdy) + c * (adxbdy - bdxady)
    size = (abs(bdxcdy) + abs(cdxbdy)) * a + (abs(cdxady) + abs(adxcdy)) * b + (abs(adxbdy) + abs(bdxady)) * c
    bound = INCIRCLE_BOUND * size + _UNDERFLOW * (a + b + c + 1)
    if value > bound:
        return _PLUS
    if -value > bound:
        return _MINUS
    return _incircle_closely(ax, ay, bx, by, cx, cy, dx, dy)


@exact_device
def _pair_minor(a, b, c, d):
    """a d - b c of pairs, and |a d| + |b c|."""
    p, q = pair_multiply(a, d), pair_multiply(b, c)
    return pair_subtract(p, q), abs(p[0]) + abs(q[0])


@exact_device
def _pair_lift2(x, y):
    return pair_add(pair_multiply(x, x), pair_multiply(y, y))


@exact_apart
def _incircle_closely(ax, ay, bx, by, cx, cy, dx, dy):
    adx, ady = two_difference(ax, dx), two_difference(ay, dy)
    bdx, bdy = two_difference(bx, dx), two_difference(by, dy)
    cdx, cdy = two_difference(cx, dx), two_difference(cy, dy)
    a, b, c = _pair_lift2(adx, ady), _pair_lift2(bdx, bdy), _pair_lift2(cdx, cdy)
    bc, bc_size = _pair_minor(bdx, cdx, bdy, cdy)
    ca, ca_size = _pair_minor(cdx, adx, cdy, ady)
    ab, ab_size = _pair_minor(adx, bdx, ady, bdy)
    value = pair_add(pair_add(pair_multiply(a, bc), pair_multiply(b, ca)), pair_multiply(c, ab))[0]
    size = a[0] * bc_size + b[0] * ca_size + c[0] * ab_size
    bound = _PAIR_INCIRCLE_BOUND * size + _UNDERFLOW * (a[0] + b[0] + c[0] + 1)
    px = min(lowest_place(ax), lowest_place(bx), lowest_place(cx), lowest_place(dx))
    py = min(lowest_place(ay), lowest_place(by), lowest_place(cy), lowest_place(dy))
    sign = _decide(value, bound, px + py + 2 * min(px, py))
    if sign != _UNDECIDED:
        return sign
    if adx[1] == 0 and ady[1] == 0 and bdx[1] == 0 and bdy[1] == 0 and cdx[1] == 0 and cdy[1] == 0:
        return determinant_sign((adx[0], ady[0], bdx[0], bdy[0], cdx[0], cdy[0]), _TWO, _LIFTED)
    return determinant_sign((ax, ay, bx, by, cx, cy, dx, dy), _TWO, _LIFTED)


@exact_device
def orient3d(ax, ay, az, bx, by, bz, cx, cy, cz, dx, dy, dz):
    """1 where a, b, c are seen counterclockwise from the side of their plane away from d, -1 clockwise, 0 in a plane.

    The sign of det(a - d, b - d, c - d).
    """
    adx, bdx, cdx = ax - dx, bx - dx, cx - dx
    ady, bdy, cdy = ay - dy, by - dy, cy - dy
    adz, bdz, cdz = az - dz, bz - dz, cz - dz
    bdxcdy, cdxbdy = bdx * cdy, cdx * bdy
    cdxady, adxcdy = cdx * ady, adx * cdy
    adxbdy, bdxady = adx * bdy, bdx * ady
    value = adz * (bdxcdy - cdxbdy) + bdz * (cdxady - adxcdy) + cdz * (adxbdy - bdxady)
    a, b, c = abs(adz), abs(bdz), abs(cdz)
    size = (abs(bdxcdy) + abs(cdxbdy)) * a + (abs(cdxady) + abs(adxcdy)) * b + (abs(adxbdy) + abs(bdxady)) * c
    bound = ORIENT3D_BOUND * size + _UNDERFLOW * (a + b + c + 1)
    if value > bound:
        return _PLUS
    if -value > bound:
        return _MINUS
    return _orient3d_closely(ax, ay, az, bx, by, bz, cx, cy, cz, dx, dy, dz)


@exact_apart
def _orient3d_closely(ax, ay, az, bx, by, bz, cx, cy, cz, dx, dy, dz):
    adx, ady, adz = two_difference(ax, dx), two_difference(ay, dy), two_difference(az, dz)
    bdx, bdy, bdz = two_difference(bx, dx), two_difference(by, dy), two_difference(bz, dz)
    cdx, cdy, cdz = two_difference(cx, dx), two_difference(cy, dy), two_difference(cz, dz)
    bc, bc_size = _pair_minor(bdx, cdx, bdy, cdy)
    ca, ca_size = _pair_minor(cdx, adx, cdy, ady)
    ab, ab_size = _pair_minor(adx, bdx, ady, bdy)
    value = pair_add(pair_add(pair_multiply(adz, bc), pair_multiply(bdz, ca)), pair_multiply(cdz, ab))[0]
    a, b, c = abs(adz[0]), abs(bdz[0]), abs(cdz[0])
    bound = _PAIR_ORIENT3D_BOUND * (a * bc_size + b * ca_size + c * ab_size) + _UNDERFLOW * (a + b + c + 1)
    place = (
        min(lowest_place(ax), lowest_place(bx), lowest_place(cx), lowest_place(dx))
        + min(lowest_place(ay), lowest_place(by), lowest_place(cy), lowest_place(dy))
        + min(lowest_place(az), lowest_place(bz), lowest_place(cz), lowest_place(dz))
    )
    sign = _decide(value, bound, place)
    if sign != _UNDECIDED:
        return sign
    tails = abs(adx[1]) + abs(ady[1]) + abs(adz[1]) + abs(bdx[1]) + abs(bdy[1]) + abs(bdz[1])
    if tails + abs(cdx[1]) + abs(cdy[1]) + abs(cdz[1]) == 0:
        near = (adx[0], ady[0], adz[0], bdx[0], bdy[0], bdz[0], cdx[0], cdy[0], cdz[0])
        return determinant_sign(near, _THREE, _FLAT)
    return determinant_sign((ax, ay, az, bx, by, bz, cx, cy, cz, dx, dy, dz), _THREE, _FLAT)


@exact_device
def insphere(ax, ay, az, bx, by, bz, cx, cy, cz, dx, dy, dz, ex, ey, ez):
    """1 where e lies inside the sphere through a, b, c, d, -1 outside, 0 on it, for `orient3d` of a, b, c, d positive.

    For negative ones the signs are exchanged.
    """
    aex, bex, cex, dex = ax - ex, bx - ex, cx - ex, dx - ex
    aey, bey, cey, dey = ay - ey, by - ey, cy - ey, dy - ey
    aez, bez, cez, dez = az - ez, bz - ez, cz - ez, dz - ez
    aexbey, bexaey = aex * bey, bex * aey
    bexcey, cexbey = bex * cey, cex * bey
    cexdey, dexcey = cex * dey, dex * cey
    dexaey, aexdey = dex * aey, aex * dey
    aexcey, cexaey = aex * cey, cex * aey
    bexdey, dexbey = bex * dey, dex * bey
    ab, bc, cd = aexbey - bexaey, bexcey - cexbey, cexdey - dexcey
    da, ac, bd = dexaey - aexdey, aexcey - cexaey, bexdey - dexbey
    a = aex * aex + aey * aey + aez * aez
    b = bex * bex + bey * bey + bez * bez
    c = cex * cex + cey * cey + cez * cez
    d = dex * dex + dey * dey + dez * dez
    value = (d * (aez * bc - bez * ac + cez * ab) - c * (dez * ab + aez * bd + bez * da)) + (
        b * (cez * da + dez * ac + aez * cd) - a * (bez * cd - cez * bd + dez * bc)
    )
    ab_size, bc_size = abs(aexbey) + abs(bexaey), abs(bexcey) + abs(cexbey)
    cd_size, da_size = abs(cexdey) + abs(dexcey), abs(dexaey) + abs(aexdey)
    ac_size, bd_size = abs(aexcey) + abs(cexaey), abs(bexdey) + abs(dexbey)
    az_size, bz_size, cz_size, dz_size = abs(aez), abs(bez), abs(cez), abs(dez)
    size = (
        (cd_size * bz_size + bd_size * cz_size + bc_size * dz_size) * a
        + (da_size * cz_size + ac_size * dz_size + cd_size * az_size) * b
        + (ab_size * dz_size + bd_size * az_size + da_size * bz_size) * c
        + (bc_size * az_size + ac_size * bz_size + ab_size * cz_size) * d
    )
    reach = a + b + c + d + 1
    bound = INSPHERE_BOUND * size + _UNDERFLOW * (reach * reach)
    if value > bound:
        return _PLUS
    if -value > bound:
        return _MINUS
    return _insphere_closely(ax, ay, az, bx, by, bz, cx, cy, cz, dx, dy, dz, ex, ey, ez)


@exact_device
def _pair_lift3(x, y, z):
    return pair_add(_pair_lift2(x, y), pair_multiply(z, z))


@exact_device
def _pair_volume(az, bc, bc_size, bz, ca, ca_size, cz, ab, ab_size):
    """az bc + bz ca + cz ab of pairs, and the sum of the magnitudes of its terms."""
    value = pair_add(pair_add(pair_multiply(az, bc), pair_multiply(bz, ca)), pair_multiply(cz, ab))
    return value, abs(az[0]) * bc_size + abs(bz[0]) * ca_size + abs(cz[0]) * ab_size


@exact_device
def _negative(a):
    return -a[0], -a[1]


@exact_apart
def _insphere_closely(ax, ay, az, bx, by, bz, cx, cy, cz, dx, dy, dz, ex, ey, ez):
    aex, aey, aez = two_difference(ax, ex), two_difference(ay, ey), two_difference(az, ez)
    bex, bey, bez = two_difference(bx, ex), two_difference(by, ey), two_difference(bz, ez)
    cex, cey, cez = two_difference(cx, ex), two_difference(cy, ey), two_difference(cz, ez)
    dex, dey, dez = two_difference(dx, ex), two_difference(dy, ey), two_difference(dz, ez)
    ab, ab_size = _pair_minor(aex, bex, aey, bey)
    bc, bc_size = _pair_minor(bex, cex, bey, cey)
    cd, cd_size = _pair_minor(cex, dex, cey, dey)
    da, da_size = _pair_minor(dex, aex, dey, aey)
    ac, ac_size = _pair_minor(aex, cex, aey, cey)
    bd, bd_size = _pair_minor(bex, dex, bey, dey)
    bcd, bcd_size = _pair_volume(bez, cd, cd_size, cez, _negative(bd), bd_size, dez, bc, bc_size)
    cda, cda_size = _pair_volume(cez, da, da_size, dez, ac, ac_size, aez, cd, cd_size)
    dab, dab_size = _pair_volume(dez, ab, ab_size, aez, bd, bd_size, bez, da, da_size)
    abc, abc_size = _pair_volume(aez, bc, bc_size, bez, _negative(ac), ac_size, cez, ab, ab_size)
    a, b = _pair_lift3(aex, aey, aez), _pair_lift3(bex, bey, bez)
    c, d = _pair_lift3(cex, cey, cez), _pair_lift3(dex, dey, dez)
    first = pair_subtract(pair_multiply(d, abc), pair_multiply(c, dab))
    second = pair_subtract(pair_multiply(b, cda), pair_multiply(a, bcd))
    value = pair_add(first, second)[0]
    reach = a[0] + b[0] + c[0] + d[0] + 1
    size = a[0] * bcd_size + b[0] * cda_size + c[0] * dab_size + d[0] * abc_size
    px = min(lowest_place(ax), lowest_place(bx), lowest_place(cx), lowest_place(dx), lowest_place(ex))
    py = min(lowest_place(ay), lowest_place(by), lowest_place(cy), lowest_place(dy), lowest_place(ey))
    pz = min(lowest_place(az), lowest_place(bz), lowest_place(cz), lowest_place(dz), lowest_place(ez))
    place = px + py + pz + 2 * min(px, py, pz)
    sign = _decide(value, _PAIR_INSPHERE_BOUND * size + _UNDERFLOW * (reach * reach), place)
    if sign != _UNDECIDED:
        return sign
    tails = abs(aex[1]) + abs(bex[1]) + abs(cex[1]) + abs(dex[1]) + abs(aey[1]) + abs(bey[1]) + abs(cey[1])
    if tails + abs(dey[1]) + abs(aez[1]) + abs(bez[1]) + abs(cez[1]) + abs(dez[1]) == 0:
        near = (aex[0], aey[0], aez[0], bex[0], bey[0], bez[0], cex[0], cey[0], cez[0], dex[0], dey[0], dez[0])
        return determinant_sign(near, _THREE, _LIFTED)
    return determinant_sign((ax, ay, az, bx, by, bz, cx, cy, cz, dx, dy, dz, ex, ey, ez), _THREE, _LIFTED)
