"""Orientation of five points of four-dimensional space, exact like the other predicates."""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.exact import determinant_sign
from isophote.kernels.base.jit import exact_apart, exact_device
from isophote.kernels.base.predicates import INSPHERE_BOUND

__all__ = ["orient4d"]

# As in `predicates`.
_UNDERFLOW = 2.0**-1022
_FOUR = np.int64(4)
_FLAT = np.bool_(False)


@exact_device
def _volume(a, b, c):
    """det(a, b, c) of three triples, and the same with all terms positive."""
    yz, zy = b[1] * c[2], b[2] * c[1]
    zx, xz = b[2] * c[0], b[0] * c[2]
    xy, yx = b[0] * c[1], b[1] * c[0]
    value = a[0] * (yz - zy) + a[1] * (zx - xz) + a[2] * (xy - yx)
    size = abs(a[0]) * (abs(yz) + abs(zy)) + abs(a[1]) * (abs(zx) + abs(xz)) + abs(a[2]) * (abs(xy) + abs(yx))
    return value, size


@exact_apart
def orient4d(a, b, c, d, e):
    """The sign of det(a - e, b - e, c - e, d - e) for points as quadruples; right for all finite doubles.

    The filter's bound is that of `insphere`, whose determinant is this one with a column that has more rounding.
    """
    p = a[0] - e[0], a[1] - e[1], a[2] - e[2], a[3] - e[3]
    q = b[0] - e[0], b[1] - e[1], b[2] - e[2], b[3] - e[3]
    r = c[0] - e[0], c[1] - e[1], c[2] - e[2], c[3] - e[3]
    s = d[0] - e[0], d[1] - e[1], d[2] - e[2], d[3] - e[3]
    pqr, pqr_size = _volume(p, q, r)
    pqs, pqs_size = _volume(p, q, s)
    prs, prs_size = _volume(p, r, s)
    qrs, qrs_size = _volume(q, r, s)
    value = s[3] * pqr - r[3] * pqs + q[3] * prs - p[3] * qrs
    size = abs(s[3]) * pqr_size + abs(r[3]) * pqs_size + abs(q[3]) * prs_size + abs(p[3]) * qrs_size
    reach = 1.0
    for k in range(4):
        reach += abs(p[k]) + abs(q[k]) + abs(r[k]) + abs(s[k])
    bound = INSPHERE_BOUND * size + _UNDERFLOW * (reach * reach * reach)
    if value > bound:
        return np.int64(1)
    if -value > bound:
        return np.int64(-1)
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    cx, cy, cz, cw = c
    dx, dy, dz, dw = d
    ex, ey, ez, ew = e
    points = (ax, ay, az, aw, bx, by, bz, bw, cx, cy, cz, cw, dx, dy, dz, dw, ex, ey, ez, ew)
    return determinant_sign(points, _FOUR, _FLAT)
