"""What Fortune's sweep asks of circles: where one ends, where its middle is, and which of two parabolas is ahead.

Sums are first made in doubles. Where so much cancels that few places would be left, they are made again in pairs of
doubles, which leaves some 100 places less those that cancel.
"""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.base.exact import pair_add, pair_multiply, pair_subtract, two_difference
from isophote.kernels.base.jit import exact_apart, exact_device

__all__ = ["centre", "is_ahead", "top"]

# What may cancel before pairs are used; half of the places of a double.
_CANCELLED = 2.0**-26
# Below, what underflowed may count.
_SMALL = 2.0**-450
# Bound of the rounding of `is_ahead` in doubles: eight operations on each term.
_AHEAD_BOUND = 8 * 2.0**-53


@exact_device
def _cross_terms(ux, uy, vx, vy):
    """For the circle through 0, u, v: twice its middle times the area (x, y), and the area; and whether that is exact
    enough."""
    u, v = ux * ux + uy * uy, vx * vx + vy * vy
    p, q = ux * vy, uy * vx
    area = p - q
    vyu, uyv = vy * u, uy * v
    uxv, vxu = ux * v, vx * u
    x, y = vyu - uyv, uxv - vxu
    sure = abs(area) > _CANCELLED * (abs(p) + abs(q)) and abs(x) > _CANCELLED * (abs(vyu) + abs(uyv))
    sure = sure and abs(x) > _SMALL and abs(y) > _SMALL
    return x, y, area, sure and abs(y) > _CANCELLED * (abs(uxv) + abs(vxu))


@exact_device
def _exponent(a, b, c, d):
    """Of the power of two that the largest of four numbers reaches."""
    return math.frexp(max(max(abs(a), abs(b)), max(abs(c), abs(d))))[1]


@exact_device
def _scaled_difference(a, b, exponent):
    """(a - b) / 2^exponent, as a pair."""
    h, l = two_difference(a, b)
    return math.ldexp(h, -exponent), math.ldexp(l, -exponent)


@exact_apart
def _cross_terms_closely(ax, ay, bx, by, cx, cy):
    # Scaled to about 1, so that nothing underflows; x and y get the scale of their quotients with the area.
    e = _exponent(ax - bx, ay - by, cx - bx, cy - by)
    ux, uy = _scaled_difference(ax, bx, e), _scaled_difference(ay, by, e)
    vx, vy = _scaled_difference(cx, bx, e), _scaled_difference(cy, by, e)
    u = pair_add(pair_multiply(ux, ux), pair_multiply(uy, uy))
    v = pair_add(pair_multiply(vx, vx), pair_multiply(vy, vy))
    area = pair_subtract(pair_multiply(ux, vy), pair_multiply(uy, vx))
    x = pair_subtract(pair_multiply(vy, u), pair_multiply(uy, v))
    y = pair_subtract(pair_multiply(ux, v), pair_multiply(vx, u))
    return math.ldexp(x[0], e), math.ldexp(y[0], e), area[0]


@exact_device
def _from_b(ax, ay, bx, by, cx, cy):
    x, y, area, sure = _cross_terms(ax - bx, ay - by, cx - bx, cy - by)
    if not sure:
        x, y, area = _cross_terms_closely(ax, ay, bx, by, cx, cy)
    return x, y, area


@exact_device
def centre(ax, ay, bx, by, cx, cy):
    """The middle of the circle through a, b, c, which do not lie on a line."""
    x, y, area = _from_b(ax, ay, bx, by, cx, cy)
    return bx + x / (2 * area), by + y / (2 * area)


@exact_device
def top(ax, ay, bx, by, cx, cy):
    """The greatest y of the circle through a, b, c; infinity where that overflows."""
    x, y, area = _from_b(ax, ay, bx, by, cx, cy)
    reach = math.sqrt(x * x + y * y)
    above = (abs(y) + reach) / (2 * abs(area))
    if (y < 0) != (area < 0):
        # The middle lies below b: instead of the difference of reach and |y|, which nearly cancel, x² over their sum.
        above = abs(x) * (abs(x) / (reach + abs(y))) / (2 * abs(area))
    return by + above if above < np.inf else np.inf


@exact_apart
def _is_ahead_closely(ax, ay, bx, by, px, py):
    e = _exponent(ax - px, ay - py, bx - px, by - py)
    aex, aey = _scaled_difference(ax, px, e), _scaled_difference(ay, py, e)
    bex, bey = _scaled_difference(bx, px, e), _scaled_difference(by, py, e)
    a = pair_add(pair_multiply(aex, aex), pair_multiply(aey, aey))
    b = pair_add(pair_multiply(bex, bex), pair_multiply(bey, bey))
    return pair_subtract(pair_multiply(a, bey), pair_multiply(b, aey))[0] > 0


@exact_device
def is_ahead(ax, ay, bx, by, px, py):
    """Whether above p the parabola around a is ahead of the one around b, the sweep line going through p.

    The parabolas' heights differ by |b - p|² / (p.y - b.y) - |a - p|² / (p.y - a.y), over 2; neither of a and b lies
    higher than p.
    """
    aex, aey, bex, bey = ax - px, py - ay, bx - px, py - by
    left = (aex * aex + aey * aey) * bey
    right = (bex * bex + bey * bey) * aey
    difference = right - left
    if abs(difference) > _AHEAD_BOUND * (left + right) + _SMALL:
        return difference > 0
    if aey == 0 and bey == 0:
        return px - ax < bx - px
    return _is_ahead_closely(ax, ay, bx, by, px, py)
