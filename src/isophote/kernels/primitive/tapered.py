"""Cones and parts of cones about y, between y = −1 and y = 1: of radius m + k y at height y, at most 1."""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.base.doubles import doubles_at
from isophote.kernels.base.entry import entry
from isophote.kernels.base.jit import exact_inline
from isophote.kernels.primitive import layout
from isophote.kernels.primitive.lanes import BLOCK_DOUBLES, U, V, W, X, Y, Z, keep_within_lids
from isophote.kernels.primitive.line import around, describe_lid, discriminant, roots, within_lids

__all__ = ["describe_cone", "meet_cone", "meet_cones"]

_WORDS, _NO, _OWN = np.int64(layout.WORDS), np.int64(0), np.int64(2)
_FAR = math.inf
# Square of the radius of a ball about the middle that holds all.
_BALL2 = 2.0 + 1e-9


@exact_inline
def _within_side(x, y, z, u, v, w, m, k):
    """(enter, leave) of a line in the half of the double cone x² + z² ≤ (m + k y)² where m + k y ≥ 0; (inf, −inf) where
    it passes by. Past the tip it may be the other half, where no lids are."""
    nearest = -(x * u + y * v + z * w) / (u * u + v * v + w * w)
    x, y, z = x + nearest * u, y + nearest * v, z + nearest * w
    g, rise = m + k * y, k * v
    a, b, c = u * u + w * w - rise * rise, x * u + z * w - g * rise, x * x + z * z - g * g
    d = discriminant(a, b, c)
    near, far = roots(a, b, c, max(d, 0.0))
    near, far = nearest + near, nearest + far
    # Only lines that lean more than the side pass by; others go through the tip. Along the side with a = b = 0 the line
    # is inside or outside all the way.
    by = (x * x + y * y + z * z > _BALL2) | ((d < 0.0) & (a > 0.0)) | ((a == 0.0) & (b == 0.0) & (c > 0.0))
    all_along = (a == 0.0) & (b == 0.0)
    enter = near if a >= 0.0 else (far if rise > 0.0 else -_FAR)
    leave = far if a >= 0.0 else (_FAR if rise > 0.0 else near)
    enter, leave = (-_FAR if all_along else enter), (_FAR if all_along else leave)
    return (_FAR if by else enter), (-_FAR if by else leave)


@entry
def meet_cone(own, line_address):
    """Crossings of the side (part 0) and the lids at y = 1 (part 1) and y = −1 (part 2)."""
    line, shape = doubles_at(line_address, _WORDS), doubles_at(own, _OWN)
    enter, leave = _within_side(line[0], line[1], line[2], line[3], line[4], line[5], shape[0], shape[1])
    if not enter <= leave:
        return _NO
    return within_lids(line, enter, leave)


@entry
def meet_cones(own, block_address, lanes):
    """The first crossings of sixteen rays."""
    block, shape = doubles_at(block_address, BLOCK_DOUBLES), doubles_at(own, _OWN)
    m, k = shape[0], shape[1]
    for i in range(lanes):
        x, y, z, u, v, w = block[X + i], block[Y + i], block[Z + i], block[U + i], block[V + i], block[W + i]
        enter, leave = _within_side(x, y, z, u, v, w, m, k)
        keep_within_lids(block, i, enter, leave)
    return _NO


@entry
def describe_cone(own, line_address):
    """Of the side, u: angle from +x, v: height, 0 to 1; of a lid as line.describe_lid."""
    line, shape = doubles_at(line_address, _WORDS), doubles_at(own, _OWN)
    m, k, part = shape[0], shape[1], line[layout.PART]
    if part > 0.0:
        describe_lid(line, m + k if part == 1.0 else m - k)
        return _NO
    most = max(1.0 - line[layout.SLACK], 0.5)
    x, y, z = line[layout.PLACE], min(max(line[layout.PLACE + 1], -most), most), line[layout.PLACE + 2]
    rho, radius = math.sqrt(x * x + z * z), m + k * y
    # At the tip all sides meet; any will do.
    x, z = (x / rho, z / rho) if rho > 0.0 else (1.0, 0.0)
    line[layout.PLACE], line[layout.PLACE + 1], line[layout.PLACE + 2] = x * radius, y, z * radius
    line[layout.NORMAL], line[layout.NORMAL + 1], line[layout.NORMAL + 2] = x, -k, z
    line[layout.UV], line[layout.UV + 1] = around(x, z), 0.5 + 0.5 * y
    return _NO
