"""The best plane for a node of a BSP tree.

Ize, Wald, Parker: "Ray Tracing with the BSP Tree", RT 2008; directions are few at a node, as in Kammaje, Mora: "A Study
of Restricted BSP Trees for Ray Tracing", RT 2007. Directions are the axes, normals of faces, and normals of planes
through edges and across their faces. For each a sweep over the ends of all parts of triangles knows how many are on
either side of every plane. The surfaces of the cell's two sides are interpolated between a few planes.

A part of a triangle is words of an arena: the triangle's number, the number of corners, the corners.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from isophote.kernels.accel.bsp_cell import areas_of_cut, cell_area, cell_extent
from isophote.kernels.accel.bsp_layout import SLANTED, TOLERANCE
from isophote.kernels.accel.bsp_polygon import Plane, extent_along
from isophote.kernels.accel.kd_layout import END, PLANAR, START, event, event_kind, event_place
from isophote.kernels.accel.kd_sweep import leaf_cost
from isophote.kernels.base.jit import device

__all__ = ["MOST_DIRECTIONS", "MOST_PICKED", "PROFILE", "Choice", "best_plane", "no_plane"]

# Parts that a sweep goes over, at most, spread evenly over a node that has more; triangles whose faces and edges give
# directions, and directions at most, three of which are the axes.
MOST_PICKED = 512
_GIVING, MOST_DIRECTIONS = 8, 7
# Planes for each direction at which surfaces are found.
_STEPS = 4
PROFILE = 2 * _STEPS
# Directions are the same where the cosine between them is as near to 1 as this.
_ALIKE = 1 - 1e-7
# What a step costs at planes along axes and at slanted ones, in the measure of leaf_cost; by measurement of rays, which
# fare better with fewer planes than cost in a kd-tree would give. Planes that cut off empty space are cheaper than they
# look, since rays that miss leave early.
_STEP_COST, _SLANTED_COST, _EMPTY_SHARE = 1.8, 2.0, 0.85
# Planes are within the cell by at least this share of its extent.
_INSET = 1e-6
# Sorted by insertion up to this length.
_SHORT = 24
# Largest coordinate at which n · o is finite in single precision, with room to spare.
_FARTHEST = 1e36


class Choice(NamedTuple):
    """A plane, its cost (infinite if there is none), and whether what lies within it goes to the lower side."""

    plane: object
    cost: float
    planar_low: bool


@device
def _pick(arena, first, count, picked):
    """Words of at most MOST_PICKED of the parts from word `first` on; returns how many."""
    step = (count + (MOST_PICKED - 1)) // MOST_PICKED
    at, found = first, np.int64(0)
    for i in range(count):
        if i % step == 0:
            picked[found] = at
            found += 1
        at += 2 + 3 * np.int64(arena[at + 1])
    return found


@device
def _add_direction(directions, found, x, y, z):
    """Add a direction, rounded to float32, unless there is one like it, or no room; returns how many there are."""
    length = math.sqrt(x * x + y * y + z * z)
    if not (length > 0.0 and length < np.inf) or found >= MOST_DIRECTIONS:
        return found
    x, y, z = x / length, y / length, z / length
    for i in range(found):
        if abs(x * directions[i, 0] + y * directions[i, 1] + z * directions[i, 2]) > _ALIKE:
            return found
    directions[found, 0], directions[found, 1], directions[found, 2] = np.float32(x), np.float32(y), np.float32(z)
    return found + 1


@device
def _corner(positions, triangles, triangle, k):
    at = 3 * np.int64(triangles[3 * triangle + k])
    return np.float64(positions[at]), np.float64(positions[at + 1]), np.float64(positions[at + 2])


@device
def _face_normal(a, b, c):
    ux, uy, uz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    vx, vy, vz = c[0] - a[0], c[1] - a[1], c[2] - a[2]
    x, y, z = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    length = math.sqrt(x * x + y * y + z * z)
    return (x / length, y / length, z / length) if length > 0.0 else (0.0, 0.0, 0.0)


@device
def _find_directions(positions, triangles, arena, picked, count, reach, directions):
    """The axes, normals of faces, then normals of planes through their edges."""
    for axis in range(3):
        for k in range(3):
            directions[axis, k] = 1.0 if k == axis else 0.0
    found = np.int64(3)
    if reach > _FARTHEST:
        return found
    giving = min(count, np.int64(_GIVING))
    for edges in range(2):
        for i in range(giving):
            triangle = np.int64(arena[picked[(i * count) // giving]])
            a, b = _corner(positions, triangles, triangle, 0), _corner(positions, triangles, triangle, 1)
            c = _corner(positions, triangles, triangle, 2)
            nx, ny, nz = _face_normal(a, b, c)
            if edges == 0:
                found = _add_direction(directions, found, nx, ny, nz)
                continue
            for _ in range(3):
                x, y, z = b[0] - a[0], b[1] - a[1], b[2] - a[2]
                found = _add_direction(directions, found, y * nz - z * ny, z * nx - x * nz, x * ny - y * nx)
                a, b, c = b, c, a
    return found


@device
def _sift(keys, root, count):
    """Let the key at a heap's `root` sink to its place."""
    key = keys[root]
    while 2 * root + 1 < count:
        child = 2 * root + 1
        if child + 1 < count and keys[child] < keys[child + 1]:
            child += 1
        if keys[child] <= key:
            break
        keys[root] = keys[child]
        root = child
    keys[root] = key


@device
def _sort(keys, count):
    if count <= _SHORT:
        for i in range(1, count):
            key = keys[i]
            j = i
            while j > 0 and keys[j - 1] > key:
                keys[j] = keys[j - 1]
                j -= 1
            keys[j] = key
        return
    for root in range(count // 2 - 1, -1, -1):
        _sift(keys, root, count)
    for last in range(count - 1, 0, -1):
        keys[0], keys[last] = keys[last], keys[0]
        _sift(keys, 0, last)


@device
def _events(arena, picked, count, plane, tolerance, events, word):
    """Sorted ends of parts along a direction, each drawn in by the tolerance; returns how many."""
    made = np.int64(0)
    for i in range(count):
        at = picked[i]
        low, high = extent_along(plane, arena, at + 2, np.int64(arena[at + 1]))
        if high - low <= 2 * tolerance:
            events[made] = event(0.5 * (low + high), PLANAR, 0, word)
            made += 1
        else:
            events[made] = event(low + tolerance, START, 0, word)
            events[made + 1] = event(high - tolerance, END, 0, word)
            made += 2
    _sort(events, made)
    return made


@device
def _between(profile, first, place):
    """A surface at a place that is counted in steps, from those in the middle of each step."""
    k = min(max(np.int64(place - 0.5), 0), _STEPS - 2)
    share = place - 0.5 - k
    return max(profile[first + k] + share * (profile[first + k + 1] - profile[first + k]), 0.0)


@device
def _sweep(events, made, count, scale, plane, low, high, profile, whole, best):
    """The better of `best` and the best plane of one direction between `low` and `high`; each part counts `scale`."""
    step = _STEP_COST if plane.kind < SLANTED else _SLANTED_COST
    inset = _INSET * (high - low)
    lower, upper = np.int64(0), count
    i = np.int64(0)
    while i < made:
        place = event_place(events[i])
        ends, planars, starts = np.int64(0), np.int64(0), np.int64(0)
        while i < made and event_place(events[i]) == place:
            kind = event_kind(events[i])
            ends += kind == END
            planars += kind == PLANAR
            starts += kind == START
            i += 1
        upper -= planars + ends
        p = np.float64(place)
        if p > low + inset and p < high - inset:
            at = (p - low) / (high - low) * _STEPS
            area_low, area_high = _between(profile, 0, at), _between(profile, _STEPS, at)
            for planar_low in range(2 if planars > 0 else 1):
                below = lower + (planars if planar_low == 1 else 0)
                above = upper + (planars if planar_low == 0 else 0)
                cost = step + (area_low * leaf_cost(below * scale) + area_high * leaf_cost(above * scale)) / whole
                cost *= _EMPTY_SHARE if below == 0 or above == 0 else 1.0
                if cost < best.cost:
                    best = Choice(Plane(plane.x, plane.y, plane.z, p, plane.kind), cost, planar_low == 1)
        lower += starts + planars
    return best


@device
def no_plane():
    """The choice of no plane at all."""
    return Choice(Plane(0.0, 0.0, 0.0, 0.0, np.int64(0)), np.inf, True)


@device
def best_plane(positions, triangles, arena, first, count, cells, cell, reach, scratch):
    """The `Choice` of least cost for the `count` parts from word `first` of `arena` on, in the cell at word `cell`.
    `scratch`: picked (MOST_PICKED) int64, directions (MOST_DIRECTIONS, 3), events (2 MOST_PICKED) uint64, a profile of
    PROFILE, work of CELL_WORK, and one float32."""
    picked, directions, events, profile, work, word = scratch
    best = no_plane()
    whole = cell_area(cells, cell)
    if not whole > 0.0:
        return best
    taken = _pick(arena, first, count, picked)
    scale = (count + taken // 2) // taken
    tolerance = 0.5 * TOLERANCE * reach
    for number in range(_find_directions(positions, triangles, arena, picked, taken, reach, directions)):
        x, y, z = directions[number, 0], directions[number, 1], directions[number, 2]
        kind = np.int64(number if number < 3 else SLANTED)
        plane = Plane(x, y, z, 0.0, kind)
        low, high = cell_extent(cells, cell, plane, work)
        if not high - low > 4 * tolerance:
            continue
        for k in range(_STEPS):
            place = low + (high - low) * (k + 0.5) / _STEPS
            below, above = areas_of_cut(cells, cell, Plane(x, y, z, place, kind), work)
            profile[k], profile[_STEPS + k] = below, above
        made = _events(arena, picked, taken, plane, tolerance, events, word)
        best = _sweep(events, made, taken, scale, plane, low, high, profile, whole, best)
    return best
