"""Cones and parts of cones about y, between y = −1 and y = 1: of radius m + k y at height y, at most 1."""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.base.doubles import doubles_at
from isophote.kernels.base.entry import entry
from isophote.kernels.base.jit import device
from isophote.kernels.primitive import layout
from isophote.kernels.primitive.line import around, describe_lid, discriminant, roots, within_lids

__all__ = ["describe_cone", "meet_cone"]

_WORDS, _NO, _OWN = np.int64(layout.WORDS), np.int64(0), np.int64(2)
_FAR = math.inf
# Square of the radius of a ball about the middle that holds all.
_BALL2 = 2.0 + 1e-9


@device
def _within_side(line, m, k, nearest):
    """(enter, leave) of a line in the half of the double cone x² + z² ≤ (m + k y)² where m + k y ≥ 0, counted from its
    point `nearest`; (inf, −inf) where it passes by. Past the tip it may be the other half, where no lids are."""
    u, v, w = line[3], line[4], line[5]
    x, z = line[0] + nearest * u, line[2] + nearest * w
    g, rise = m + k * (line[1] + nearest * v), k * v
    a, b, c = u * u + w * w - rise * rise, x * u + z * w - g * rise, x * x + z * z - g * g
    d = discriminant(a, b, c)
    if d < 0.0:
        # Only lines that lean more than the side pass by; others go through the tip.
        if a > 0.0:
            return _FAR, -_FAR
        d = 0.0
    if a == 0.0 and b == 0.0:
        return (-_FAR, _FAR) if c <= 0.0 else (_FAR, -_FAR)
    near, far = roots(a, b, c, d)
    if a >= 0.0:
        return near, far
    return (far, _FAR) if rise > 0.0 else (-_FAR, near)


@entry
def meet_cone(own, line_address):
    """Crossings of the side (part 0) and the lids at y = 1 (part 1) and y = −1 (part 2)."""
    line, shape = doubles_at(line_address, _WORDS), doubles_at(own, _OWN)
    x, y, z, u, v, w = line[0], line[1], line[2], line[3], line[4], line[5]
    nearest = -(x * u + y * v + z * w) / (u * u + v * v + w * w)
    x, y, z = x + nearest * u, y + nearest * v, z + nearest * w
    if not x * x + y * y + z * z <= _BALL2:
        return _NO
    enter, leave = _within_side(line, shape[0], shape[1], nearest)
    if not enter <= leave:
        return _NO
    return within_lids(line, nearest + enter, nearest + leave)


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
