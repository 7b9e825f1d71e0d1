"""Points that lie best on many planes, within boxes: sixteen quadratic error functions at once.

A point x is sought for planes n_i · (x − p_i) = 0, near their middle m: A x = g, with A = Σ n_i n_iᵀ and
g = Σ n_i (n_i · (p_i − m)), x relative to m. A is taken apart into eigenvalues and eigenvectors by Jacobi's rotations;
what belongs to eigenvalues far below the largest is left out, so that x stays near m along a flat surface or a straight
edge (Lindstrom, "Out-of-core simplification of large polygonal models", 2000). A point outside its box comes back into
it along the edge that it lies on, or else as a point of the plane, or else as m. But an edge or a corner of a surface
may poke out of a cell, across a face or an edge of it, into one of which no corner is inside: so points a cell away
from the box are taken too, if they are clearly better.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import device, exact_apart
from isophote.kernels.base.simd import absolute, bits, load16, maximum, minimum, select, splat16, square_root, store16

__all__ = ["BOX_HIGH", "BOX_LOW", "MATRIX", "QEF_WORDS", "RIGHT", "SOLUTION", "solve_qefs"]

# Rows of sixteen floats: xx, xy, xz, yy, yz, zz of the matrix, the right side, the box, and the point found, all
# relative to the middle.
MATRIX, RIGHT, BOX_LOW, BOX_HIGH, SOLUTION = 0, 96, 144, 192, 240
QEF_WORDS = 288

# Eigenvalues below this part of the largest are left out: normals that differ by less than some five degrees.
_CUT = np.float32(2e-3)
# How far outside its box, in cells, a point may lie by rounding; and if that makes the mean square distance from the
# planes smaller by `_GAIN` square cells or more. Points that were brought there are that far out or, by `_ROUNDING`,
# farther.
_SLACK, _MARGIN, _GAIN = np.float32(1e-4), np.float32(1), np.float32(1e-4)
_ROUNDING = np.float32(1e-4)
# A little less than that, for the sum of the minors over the square of the trace.
_FLAT = np.float32(0.98) * _CUT
_ZERO, _HALF, _ONE = np.float32(0), np.float32(0.5), np.float32(1)
_ALL = np.int32(0xFFFF)
_SWEEPS = 4
# What is left beside the diagonal, as part of the trace, when there is nothing to turn.
_TINY = np.float32(1e-7)


@device
def _rotation(app, aqq, apq):
    """Tangent, cosine and sine of the rotation that makes apq vanish (Golub and Van Loan, section 8.5.2)."""
    zero, one = splat16(_ZERO), splat16(_ONE)
    theta = (aqq - app) * splat16(_HALF) / apq
    t = one / (absolute(theta) + square_root(theta * theta + one))
    t = select(theta < zero, zero - t, t)
    t = select(apq == zero, zero, t)
    c = one / square_root(t * t + one)
    return t, c, t * c


@device
def _order(l0, x0, y0, z0, c0, l1, x1, y1, z1, c1):
    """Two eigenpairs, the larger eigenvalue first."""
    keep = l0 >= l1
    return (
        select(keep, l0, l1), select(keep, x0, x1), select(keep, y0, y1), select(keep, z0, z1), select(keep, c0, c1),
        select(keep, l1, l0), select(keep, x1, x0), select(keep, y1, y0), select(keep, z1, z0), select(keep, c1, c0),
    )  # fmt: skip


@device
def _inside(work, x, y, z, slack):
    slack = splat16(slack)
    low = (x >= load16(work, BOX_LOW) - slack) & (y >= load16(work, BOX_LOW + 16) - slack)
    low = low & (z >= load16(work, BOX_LOW + 32) - slack)
    high = (x <= load16(work, BOX_HIGH) + slack) & (y <= load16(work, BOX_HIGH + 16) + slack)
    return low & high & (z <= load16(work, BOX_HIGH + 32) + slack)


@device
def _span(work, axis, x, slope, slack, first, last):
    """The part of a line's parameters from `first` to `last` where x + s slope lies within the box."""
    p = (load16(work, BOX_LOW + 16 * axis) - splat16(slack) - x) / slope
    q = (load16(work, BOX_HIGH + 16 * axis) + splat16(slack) - x) / slope
    return maximum(minimum(p, q), first), minimum(maximum(p, q), last)


@device
def _slide(work, x, y, z, u, v, w, slack):
    """A point brought into the box along (u, v, w), if that line meets it."""
    first, last = splat16(-np.float32(np.inf)), splat16(np.float32(np.inf))
    first, last = _span(work, np.int64(0), x, u, slack, first, last)
    first, last = _span(work, np.int64(1), y, v, slack, first, last)
    first, last = _span(work, np.int64(2), z, w, slack, first, last)
    s = maximum(minimum(splat16(_ZERO), last), first)
    return x + s * u, y + s * v, z + s * w


@device
def _error(work, x, y, z):
    """x A x − 2 g x: the sum of the square distances of the planes, less that at the middle."""
    xx, xy, xz = load16(work, 0), load16(work, 16), load16(work, 32)
    yy, yz, zz = load16(work, 48), load16(work, 64), load16(work, 80)
    p, q, r = load16(work, RIGHT), load16(work, RIGHT + 16), load16(work, RIGHT + 32)
    a, b, c = xx * x + xy * y + xz * z, xy * x + yy * y + yz * z, xz * x + yz * y + zz * z
    return x * (a - p - p) + y * (b - q - q) + z * (c - r - r)


@device
def _better(work, x, y, z, a, b, c):
    """The point (a, b, c) where it lies in its box, or near it and clearly better than (x, y, z); else the latter."""
    planes = load16(work, 0) + load16(work, 48) + load16(work, 80)
    clearly = _error(work, a, b, c) + planes * splat16(_GAIN) < _error(work, x, y, z)
    near, far = _inside(work, a, b, c, _SLACK + _ROUNDING), _inside(work, a, b, c, _MARGIN + _ROUNDING)
    take = near | (far & clearly)
    return select(take, a, x), select(take, b, y), select(take, c, z)


@device
def _times(work, x, y, z):
    """A x."""
    xx, xy, xz = load16(work, 0), load16(work, 16), load16(work, 32)
    yy, yz, zz = load16(work, 48), load16(work, 64), load16(work, 80)
    return xx * x + xy * y + xz * z, xy * x + yy * y + yz * z, xz * x + yz * y + zz * z


@device
def _solve_planes(work):
    """Write the points nearest on planes; whether all sixteen functions are those of one plane each.

    The two smaller eigenvalues together are about the sum of A's principal minors over the largest one. Where that is
    below the cut, A multiplied twice with a column of its own is the eigenvector in single precision.
    """
    xx, xy, xz = load16(work, 0), load16(work, 16), load16(work, 32)
    yy, yz, zz = load16(work, 48), load16(work, 64), load16(work, 80)
    trace = xx + yy + zz
    minors = (xx * yy - xy * xy) + (xx * zz - xz * xz) + (yy * zz - yz * yz)
    flat = minors <= splat16(_FLAT) * trace * trace
    if bits(flat) != _ALL:
        return False
    first = (xx >= yy) & (xx >= zz)
    second = yy >= zz
    x = select(first, xx, select(second, xy, xz))
    y = select(first, xy, select(second, yy, yz))
    z = select(first, xz, select(second, yz, zz))
    x, y, z = _times(work, x, y, z)
    x, y, z = _times(work, x, y, z)
    u, v, w = _times(work, x, y, z)
    p, q, r = load16(work, RIGHT), load16(work, RIGHT + 16), load16(work, RIGHT + 32)
    step = (x * p + y * q + z * r) / (x * u + y * v + z * w)
    x, y, z = step * x, step * y, step * z
    store16(work, SOLUTION, x)
    store16(work, SOLUTION + 16, y)
    store16(work, SOLUTION + 32, z)
    return bits(_inside(work, x, y, z, _SLACK)) == _ALL


@exact_apart
def solve_qefs(work):
    """Solve the sixteen functions in `work`, float32; boxes hold their middles. See the names of its rows above."""
    if _solve_planes(work):
        return
    zero, one = splat16(_ZERO), splat16(_ONE)
    a, b, c = load16(work, 0), load16(work, 16), load16(work, 32)
    d, e, f = load16(work, 48), load16(work, 64), load16(work, 80)
    # Columns of eigenvectors: (x0, y0, z0), ...
    x0, y0, z0, x1, y1, z1, x2, y2, z2 = one, zero, zero, zero, one, zero, zero, zero, one
    tiny = splat16(_TINY) * (a + d + f)
    for _ in range(_SWEEPS):
        # Each sweep squares what is left beside the diagonal.
        if bits(absolute(b) + absolute(c) + absolute(e) > tiny) == 0:
            break
        t, u, s = _rotation(a, d, b)
        a, d, b = a - t * b, d + t * b, zero
        c, e = u * c - s * e, s * c + u * e
        x0, x1 = u * x0 - s * x1, s * x0 + u * x1
        y0, y1 = u * y0 - s * y1, s * y0 + u * y1
        z0, z1 = u * z0 - s * z1, s * z0 + u * z1
        t, u, s = _rotation(a, f, c)
        a, f, c = a - t * c, f + t * c, zero
        b, e = u * b - s * e, s * b + u * e
        x0, x2 = u * x0 - s * x2, s * x0 + u * x2
        y0, y2 = u * y0 - s * y2, s * y0 + u * y2
        z0, z2 = u * z0 - s * z2, s * z0 + u * z2
        t, u, s = _rotation(d, f, e)
        d, f, e = d - t * e, f + t * e, zero
        b, c = u * b - s * c, s * b + u * c
        x1, x2 = u * x1 - s * x2, s * x1 + u * x2
        y1, y2 = u * y1 - s * y2, s * y1 + u * y2
        z1, z2 = u * z1 - s * z2, s * z1 + u * z2
    p, q, r = load16(work, RIGHT), load16(work, RIGHT + 16), load16(work, RIGHT + 32)
    c0, c1, c2 = x0 * p + y0 * q + z0 * r, x1 * p + y1 * q + z1 * r, x2 * p + y2 * q + z2 * r
    a, x0, y0, z0, c0, d, x1, y1, z1, c1 = _order(a, x0, y0, z0, c0, d, x1, y1, z1, c1)
    a, x0, y0, z0, c0, f, x2, y2, z2, c2 = _order(a, x0, y0, z0, c0, f, x2, y2, z2, c2)
    d, x1, y1, z1, c1, f, x2, y2, z2, c2 = _order(d, x1, y1, z1, c1, f, x2, y2, z2, c2)
    cut = a * splat16(_CUT)
    c0 = select(a > zero, c0 / a, zero)
    c1 = select(d > cut, c1 / d, zero)
    c2 = select(f > cut, c2 / f, zero)
    # On the plane, on the edge, at the corner.
    px, py, pz = c0 * x0, c0 * y0, c0 * z0
    ex, ey, ez = px + c1 * x1, py + c1 * y1, pz + c1 * z1
    vx, vy, vz = ex + c2 * x2, ey + c2 * y2, ez + c2 * z2
    plane = _inside(work, px, py, pz, _SLACK)
    x, y, z = select(plane, px, zero), select(plane, py, zero), select(plane, pz, zero)
    for slack in (_SLACK, _MARGIN):
        p, q, r = _slide(work, ex, ey, ez, x2, y2, z2, slack)
        x, y, z = _better(work, x, y, z, p, q, r)
    x, y, z = _better(work, x, y, z, vx, vy, vz)
    store16(work, SOLUTION, x)
    store16(work, SOLUTION + 16, y)
    store16(work, SOLUTION + 32, z)
