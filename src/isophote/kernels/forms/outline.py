"""Exact signed distances to outlines of quadratic Bézier arcs, inside by the winding number.

A point asks sixteen arcs, or boxes of arcs, at a time. The nearest arc is found by the tree, nearest boxes first; the
winding number by a ray along x or y, which only arcs that reach over the point's y or x can meet. An arc holds its
lower end and not its upper one, so no end is met twice or missed.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from isophote.kernels.base.entry import entry, floats_at, opener_at
from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import (
    bits,
    lane,
    least,
    load16,
    load_float,
    load_int,
    lowest_bit,
    maximum,
    minimum,
    select,
    splat16,
    square_root,
    store16,
    store_float,
    store_int,
)
from isophote.kernels.base.simd_math import with_sign
from isophote.kernels.forms.field_data import DataTable
from isophote.kernels.forms.outline_tree import ARC, GROUP, MOST_LEVELS, NODE, OUTLINE, SIDE, pack_outline
from isophote.kernels.forms.table_slots import ANY, LANES, reach_of, store_around, store_gradient
from isophote.kernels.forms.tape_interval import REGION_MIDDLE

__all__ = ["outline_table"]

open_outline = opener_at(OUTLINE)

_ZERO, _ONE, _HALF, _TWO, _THREE = (np.float32(v) for v in (0, 1, 0.5, 2, 3))
_FAR = np.float32(np.inf)
_NONE = np.int64(-1)
_SCRATCH = MOST_LEVELS * ARC
# More than single precision needs; Newton's method would take ten.
_STEPS = 6
# Single precision's error of a distance, as a part of the coordinates that it is made of.
_ERROR = np.float32(2.0**-20)
_SLACK = np.float32(1e-5)


class Near(NamedTuple):
    """The arc nearest to a point: its square distance, its place among the leaves' arcs, the parameter on it."""

    square: float
    arc: int
    t: float


# --- arcs -----------------------------------------------------------------------------------------


@device
def _step(g0, g1, g2, g3, t, low, high):
    """A step towards the root of the cubic g, which rises between `low` and `high`: Halley's, or to the middle."""
    value = g0 + t * (g1 + t * (g2 + t * g3))
    below = value < splat16(_ZERO)
    low, high = select(below, t, low), select(below, high, t)
    slope = g1 + t * (splat16(_TWO) * g2 + t * splat16(_THREE) * g3)
    bend = g2 + splat16(_THREE) * g3 * t
    step = t - value * slope / (slope * slope - value * bend)
    return select((step >= low) & (step <= high), step, (low + high) * splat16(_HALF)), low, high


@device
def _rising_roots(g0, g1, g2, g3, first, last):
    """Where the cubic g rises through zero before `first`, and after `last`; an end where it does not."""
    low, high, end = splat16(_ZERO), first, splat16(_ONE)
    t, u = (low + high) * splat16(_HALF), (last + end) * splat16(_HALF)
    # Both at once, for each waits for its own division.
    for _ in range(_STEPS):
        t, low, high = _step(g0, g1, g2, g3, t, low, high)
        u, last, end = _step(g0, g1, g2, g3, u, last, end)
    return t, u


@device
def _group_near(arcs, at, x, y):
    """(square distances, parameters) of the nearest points of the arcs of a leaf.

    The square distance is least where g(t) = (B(t) − p) · B′(t) / 2, a cubic with a leading coefficient that is not
    negative, rises through 0: before the first of its extrema, or after the last.
    """
    zero, one = splat16(_ZERO), splat16(_ONE)
    x0, y0, x1, y1 = load16(arcs, at), load16(arcs, at + 16), load16(arcs, at + 32), load16(arcs, at + 48)
    x2, y2 = load16(arcs, at + 64), load16(arcs, at + 80)
    ex, ey, fx, fy = x0 - x, y0 - y, x1 - x0, y1 - y0
    hx, hy = (x2 - x1) - fx, (y2 - y1) - fy
    g0, g1 = ex * fx + ey * fy, splat16(_TWO) * (fx * fx + fy * fy) + ex * hx + ey * hy
    g2, g3 = splat16(_THREE) * (fx * hx + fy * hy), hx * hx + hy * hy
    turn = g2 * g2 - splat16(_THREE) * g3 * g1
    turns = turn > zero
    q = zero - (g2 + with_sign(square_root(maximum(turn, zero)), g2))
    r, s = q / (splat16(_THREE) * g3), g1 / q
    first = select(turns, minimum(one, maximum(zero, minimum(r, s))), one)
    last = select(turns, minimum(one, maximum(zero, maximum(r, s))), one)
    t, u = _rising_roots(g0, g1, g2, g3, first, last)
    px, py = ex + t * (splat16(_TWO) * fx + t * hx), ey + t * (splat16(_TWO) * fy + t * hy)
    best = px * px + py * py
    px, py = ex + u * (splat16(_TWO) * fx + u * hx), ey + u * (splat16(_TWO) * fy + u * hy)
    other = px * px + py * py
    t, best = select(other < best, u, t), minimum(best, other)
    start, dx, dy = ex * ex + ey * ey, x2 - x, y2 - y
    end = dx * dx + dy * dy
    # The ends themselves win ties, so that an end is known as one.
    t, best = select(start <= best, zero, t), minimum(start, best)
    t, best = select(end <= best, one, t), minimum(end, best)
    return select(load16(arcs, at + SIDE) == zero, splat16(_FAR), best), t


@device
def _count(mask):
    """How many bits are set."""
    count = np.int64(0)
    while mask != 0:
        mask &= mask - np.int32(1)
        count += 1
    return count


@device
def _group_winding(arcs, at, x, y, turned):
    """How often the arcs of a leaf cross the ray from (x, y) upward one way more than the other."""
    swap = np.int64(16) if turned else np.int64(0)
    u0, v0 = load16(arcs, at + swap), load16(arcs, at + 16 - swap)
    u1, v1 = load16(arcs, at + 32 + swap), load16(arcs, at + 48 - swap)
    u2, v2 = load16(arcs, at + 64 + swap), load16(arcs, at + 80 - swap)
    forward, back = (u0 <= x) & (u2 > x), (u2 <= x) & (u0 > x)
    crossing = forward | back
    if bits(crossing) == 0:
        return np.int64(0)
    zero = splat16(_ZERO)
    # From the lower end to the upper one: what runs along the same arc both ways must cross at the same place.
    u0, u2, v0, v2 = select(back, u2, u0), select(back, u0, u2), select(back, v2, v0), select(back, v0, v2)
    # u(t) = x: a t² + 2 b t + c = 0.
    a, b, c = (u2 - u1) - (u1 - u0), u1 - u0, u0 - x
    t = (zero - c) / (b + square_root(maximum(b * b - a * c, zero)))
    t = maximum(minimum(t, splat16(_ONE)), zero)
    s = splat16(_ONE) - t
    v = s * s * v0 + splat16(_TWO) * s * t * v1 + t * t * v2
    # An arc is monotone, so it stays between its ends.
    v = minimum(maximum(v, minimum(v0, v2)), maximum(v0, v2))
    above = v > y
    return _count(bits(forward & above)) - _count(bits(back & above))


# --- the tree -------------------------------------------------------------------------------------


@device
def _box_squares(nodes, at, x, y):
    zero = splat16(_ZERO)
    dx = maximum(maximum(load16(nodes, at) - x, x - load16(nodes, at + 32)), zero)
    dy = maximum(maximum(load16(nodes, at + 16) - y, y - load16(nodes, at + 48)), zero)
    return dx * dx + dy * dy


@device
def _nearest(outline, x, y, reach, scratch):
    """The nearest arc whose square distance is below `reach`; the arc is −1 where there is none."""
    vx, vy = splat16(x), splat16(y)
    best, arc, t = reach, _NONE, _ZERO
    level = outline.levels - 1
    store16(scratch, level * ARC, _box_squares(outline.nodes, np.int64(outline.starts[level]) * NODE, vx, vy))
    path = np.int64(0)
    while True:
        squares = load16(scratch, level * ARC)
        near = least(squares)
        if not near < best:
            level += 1
            if level == outline.levels:
                return Near(best, arc, t)
            path >>= 4
            continue
        k = np.int64(lowest_bit(bits(squares == splat16(near))))
        store_float(scratch, level * ARC + k, _FAR)
        child = (path << 4) + k
        if level > 0:
            level -= 1
            path = child
            at = (np.int64(outline.starts[level]) + child) * NODE
            store16(scratch, level * ARC, _box_squares(outline.nodes, at, vx, vy))
            continue
        found, places = _group_near(outline.arcs, child * GROUP, vx, vy)
        smallest = least(found)
        if smallest < best:
            chosen = lowest_bit(bits(found == splat16(smallest)))
            best, arc, t = smallest, child * ARC + np.int64(chosen), lane(places, chosen)


@device
def _winding(outline, x, y, scratch):
    """How often the outlines go round a point, up to the sign."""
    turned = outline.turned != 0
    if turned:
        x, y = y, x
    swap = np.int64(16) if turned else np.int64(0)
    vx, vy = splat16(x), splat16(y)
    total, path = np.int64(0), np.int64(0)
    level, entering = outline.levels - 1, True
    while True:
        if entering:
            at = (np.int64(outline.starts[level]) + path) * NODE
            low, high = load16(outline.nodes, at + swap), load16(outline.nodes, at + 32 + swap)
            met = bits((low <= vx) & (high >= vx) & (load16(outline.nodes, at + 48 - swap) > vy))
        else:
            met = load_int(scratch, level * ARC)
        if met == 0:
            level += 1
            if level == outline.levels:
                return total
            path >>= 4
            entering = False
            continue
        child = (path << 4) + np.int64(lowest_bit(met))
        store_int(scratch, level * ARC, met & (met - np.int32(1)))
        entering = level > 0
        if entering:
            level -= 1
            path = child
        else:
            total += _group_winding(outline.arcs, child * GROUP, vx, vy, turned)


@device
def _signed(outline, x, y, reach, scratch):
    """The signed distance of a point, and the nearest arc, where one is nearer than the square root of `reach`."""
    near = Near(_FAR, _NONE, _ZERO)
    for _ in range(2):
        near = _nearest(outline, x, y, reach, scratch)
        if near.arc >= 0:
            break
        # The bound was too low; or the point is not finite, and nothing is near it.
        reach = _FAR
    distance = np.float32(math.sqrt(near.square))
    return -distance if _winding(outline, x, y, scratch) != 0 else distance, near


@device
def _limit(distance, step, x, y):
    """A square that the square distance stays below after a step from a point at some distance."""
    far = (abs(distance) + step) * (_ONE + _SLACK) + _SLACK * (abs(x) + abs(y))
    return far * far + np.float32(1e-30)


@device
def _direction(outline, near, value, x, y):
    """The gradient: away from the nearest point of the boundary, inside toward it; within an arc the arc's normal."""
    if near.arc < 0:
        return _ZERO, _ZERO
    at, t = near.arc // ARC * GROUP + near.arc % ARC, near.t
    x0, y0, x1 = load_float(outline.arcs, at), load_float(outline.arcs, at + 16), load_float(outline.arcs, at + 32)
    y1, x2, y2 = load_float(outline.arcs, at + 48), load_float(outline.arcs, at + 64), load_float(outline.arcs, at + 80)
    side, s = load_float(outline.arcs, at + SIDE), _ONE - t
    tx, ty = s * (x1 - x0) + t * (x2 - x1), s * (y1 - y0) + t * (y2 - y1)
    dx, dy = side * ty, -side * tx
    at_end = t <= _ZERO or t >= _ONE
    if near.square > _ZERO and at_end:
        sign = -_ONE if value < _ZERO else _ONE
        dx, dy = sign * (x - (x0 if t == _ZERO else x2)), sign * (y - (y0 if t == _ZERO else y2))
    size = np.float32(math.sqrt(dx * dx + dy * dy))
    return (dx / size, dy / size) if size > _ZERO else (_ZERO, _ZERO)


# --- what interpreters call -----------------------------------------------------------------------


@entry
def outline_values(words, slots_at, out, a, b, c, width):
    """Values at `width` · 16 points."""
    outline, slots, scratch = open_outline(words), floats_at(slots_at, ANY), np.empty(_SCRATCH, np.float32)
    px, py, value, reach = _ZERO, _ZERO, _ZERO, _FAR
    for i in range(LANES * width):
        x, y = load_float(slots, a + i), load_float(slots, b + i)
        # The point before is mostly near, and its distance bounds this one's.
        if i > 0:
            reach = _limit(value, abs(x - px) + abs(y - py), x, y)
        value = _signed(outline, x, y, reach, scratch)[0]
        px, py = x, y
        store_float(slots, out + i, value)
    return 0


@entry
def outline_intervals(words, slots_at, out, a, b, c, width):
    """Bounds in sixteen regions."""
    outline, slots, scratch = open_outline(words), floats_at(slots_at, ANY), np.empty(_SCRATCH, np.float32)
    for i in range(LANES):
        x, y = load_float(slots, a + REGION_MIDDLE + i), load_float(slots, b + REGION_MIDDLE + i)
        value = _signed(outline, x, y, _FAR, scratch)[0]
        dx, dy = reach_of(slots, a, i), reach_of(slots, b, i)
        error = _ERROR * (abs(x) + abs(y) + outline.reach)
        store_around(slots, out, i, value, outline.slope * np.float32(math.sqrt(dx * dx + dy * dy)) + error)
    return 0


@entry
def outline_gradients(words, slots_at, out, a, b, c, width):
    """Values and gradients at sixteen points."""
    outline, slots, scratch = open_outline(words), floats_at(slots_at, ANY), np.empty(_SCRATCH, np.float32)
    for i in range(LANES):
        x, y = load_float(slots, a + i), load_float(slots, b + i)
        value, near = _signed(outline, x, y, _FAR, scratch)
        dx, dy = _direction(outline, near, value, x, y)
        store_gradient(slots, out, i, value, (a, b, c), (dx, dy, _ZERO))
    return 0


def outline_table(segments: Any, sides: Any, slope: float) -> DataTable:
    """Arcs, as `pack_outline` takes them, with the functions that interpreters call."""
    return DataTable(pack_outline(segments, sides, slope), (outline_values, outline_intervals, outline_gradients))
