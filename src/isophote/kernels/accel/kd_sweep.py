"""The best plane for a node of a kd-tree, and what lies on its sides.

Wald, Havran: "On building fast kd-trees for ray tracing, and on doing that in O(N log N)", RT 2006. A node has three
lists of events in order, one an axis; a sweep over them knows how many triangles lie on either side of every plane at
which that changes, so all planes are tried. A side's cost is its area times that of a leaf with its triangles.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from isophote.kernels.accel.kd_layout import END, PLANAR, START, event_kind, event_place, event_triangle
from isophote.kernels.accel.layout import LANES
from isophote.kernels.base.jit import device

__all__ = ["BOTH", "LOWER_SIDE", "UPPER_SIDE", "Split", "best_split", "box_area", "classify", "leaf_cost"]

# What a leaf costs, where a step through an inner node costs 1: entering it and testing a block of triangles. By
# measurement of rays, as all of these; docs/design/accelerators.md has the numbers.
LEAF_COST, BLOCK_COST = 0.5, 1.6
# Planes that cut off empty space are cheaper than they look: rays that miss leave early.
EMPTY_SHARE = 0.8

LOWER_SIDE, UPPER_SIDE, BOTH = np.uint8(1), np.uint8(2), np.uint8(3)
_LANES_SHIFT = np.int64(LANES.bit_length() - 1)


class Split(NamedTuple):
    """A plane: its cost (infinite if there is none), axis, place, whether triangles within it go to the lower side, and
    the triangles on both sides, those that are on both twice."""

    cost: float
    axis: int
    place: float
    planar_low: bool
    lower: int
    upper: int


@device
def leaf_cost(count):
    """What a leaf of `count` triangles costs."""
    if count == 0:
        return 0.0
    return LEAF_COST + BLOCK_COST * np.float64((count + (LANES - 1)) >> _LANES_SHIFT)


@device
def _cost(area_low, area_high, lower, upper, whole):
    cost = 1.0 + (area_low * leaf_cost(lower) + area_high * leaf_cost(upper)) / whole
    return cost * EMPTY_SHARE if lower == 0 or upper == 0 else cost


@device
def _extents(box):
    """The box's extents, flat ones widened a little: areas stay positive unless all is one point."""
    x = np.float64(box[3]) - np.float64(box[0])
    y = np.float64(box[4]) - np.float64(box[1])
    z = np.float64(box[5]) - np.float64(box[2])
    least = 1e-4 * max(x, max(y, z))
    return max(x, least), max(y, least), max(z, least)


@device
def box_area(box):
    """Half the surface of a box, flat ones widened a little."""
    x, y, z = _extents(box)
    return x * y + y * z + z * x


@device
def _sweep(events, begin, end, axis, count, box, across, around, whole, best):
    """The better of `best` and the best plane on one axis; `across` is the product of the other two extents, `around`
    their sum."""
    first, last = np.float64(box[axis]), np.float64(box[axis + 3])
    lower, upper = np.int64(0), np.int64(count)
    i = begin
    while i < end:
        place = event_place(events[i])
        ends, planars, starts = np.int64(0), np.int64(0), np.int64(0)
        while i < end and event_place(events[i]) == place:
            kind = event_kind(events[i])
            ends += kind == END
            planars += kind == PLANAR
            starts += kind == START
            i += 1
        upper -= planars + ends
        p = np.float64(place)
        if p > first and p < last:
            area_low, area_high = across + around * (p - first), across + around * (last - p)
            cost = _cost(area_low, area_high, lower + planars, upper, whole)
            if cost < best.cost:
                best = Split(cost, np.int64(axis), p, True, lower + planars, upper)
            if planars > 0:
                cost = _cost(area_low, area_high, lower, upper + planars, whole)
                if cost < best.cost:
                    best = Split(cost, np.int64(axis), p, False, lower, upper + planars)
        lower += starts + planars
    return best


@device
def best_split(events, begin, counts, triangles, box):
    """The `Split` of least cost of a node with so many triangles; its events lie from `begin` on, `counts` an axis."""
    best = Split(np.inf, np.int64(0), 0.0, True, np.int64(0), np.int64(0))
    x, y, z = _extents(box)
    whole = x * y + y * z + z * x
    # All in one point, or so large that areas are.
    if not (whole > 0.0 and whole < np.inf):
        return best
    at = begin
    for axis in range(3):
        across = y * z if axis == 0 else (z * x if axis == 1 else x * y)
        around = y + z if axis == 0 else (z + x if axis == 1 else x + y)
        best = _sweep(events, at, at + counts[axis], axis, triangles, box, across, around, whole, best)
        at += counts[axis]
    return best


@device
def classify(events, begin, counts, split, sides):
    """Write the side of each of a node's triangles to `sides`, at the triangle's number; return where the events on the
    split's axis begin."""
    at = begin
    for axis in range(split.axis):
        at += counts[axis]
    end = at + counts[split.axis]
    for i in range(at, end):
        sides[event_triangle(events[i])] = BOTH
    for i in range(at, end):
        place, kind = np.float64(event_place(events[i])), event_kind(events[i])
        triangle = event_triangle(events[i])
        if kind == END:
            if place <= split.place:
                sides[triangle] = LOWER_SIDE
        elif kind == START:
            if place >= split.place:
                sides[triangle] = UPPER_SIDE
        elif place < split.place or (place == split.place and split.planar_low):
            sides[triangle] = LOWER_SIDE
        else:
            sides[triangle] = UPPER_SIDE
    return at
