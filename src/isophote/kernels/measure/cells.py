"""Cells of diagrams of points in the plane, cut out of a polygon by one line after another.

The cell of a site p with weight w is what lies within the lines to its partners q of weight v: all x with
|x - p|² - w <= |x - q|² - v. Polygons are rows (x, y, number of the partner along the edge that starts there, -1 for
the bounds), relative to p. A polygon that is not convex stays in one piece, of which parts may hang together by edges
that run there and back; its area and centroid are right none the less (Sutherland and Hodgman, "Reentrant Polygon
Clipping", 1974).
"""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.base.jit import device, kernel

__all__ = ["cell_polygon", "measure_cells", "power_partners"]

_OF_BOUNDS = -1.0
_SAFELY = 1 + 1e-9


@device
def _room(rows, count):
    """Rows for at least `count`, with what was there."""
    if count <= len(rows):
        return rows
    longer = np.empty((2 * count, 3))
    for i in range(len(rows)):
        for k in range(3):
            longer[i, k] = rows[i, k]
    return longer


@device
def _clip(rows, count, dx, dy, height, partner, out):
    """Cut off what has x dx + y dy > height; returns how many rows remain."""
    n = 0
    if count == 0:
        return n
    last = count - 1
    before = rows[last, 0] * dx + rows[last, 1] * dy - height
    for i in range(count):
        here = rows[i, 0] * dx + rows[i, 1] * dy - height
        if (before <= 0) != (here <= 0):
            t = before / (before - here)
            out[n, 0] = rows[last, 0] + t * (rows[i, 0] - rows[last, 0])
            out[n, 1] = rows[last, 1] + t * (rows[i, 1] - rows[last, 1])
            out[n, 2] = partner if before <= 0 else rows[last, 2]
            n += 1
        if here <= 0:
            out[n, 0], out[n, 1], out[n, 2] = rows[i, 0], rows[i, 1], rows[i, 2]
            n += 1
        before, last = here, i
    return n


@device
def _start(corners, px, py, rows):
    """Write a polygon relative to p."""
    for i in range(len(corners)):
        rows[i, 0], rows[i, 1], rows[i, 2] = corners[i, 0] - px, corners[i, 1] - py, _OF_BOUNDS
    return len(corners)


@device
def _clip_by(points, weights, i, j, rows, count, out):
    """Cut a cell of site i by the line to site j."""
    dx, dy = points[j, 0] - points[i, 0], points[j, 1] - points[i, 1]
    return _clip(rows, count, dx, dy, (dx * dx + dy * dy + weights[i] - weights[j]) / 2, float(j), out)


@device
def _reach(rows, count):
    """The greatest square of a distance to the site."""
    reach = 0.0
    for i in range(count):
        reach = max(reach, rows[i, 0] * rows[i, 0] + rows[i, 1] * rows[i, 1])
    return reach


@device
def _is_near(corners, px, py, reach):
    """Whether an edge of a polygon comes as near to p as the root of `reach`."""
    last = len(corners) - 1
    for i in range(len(corners)):
        x, y = corners[last, 0] - px, corners[last, 1] - py
        ux, uy = corners[i, 0] - corners[last, 0], corners[i, 1] - corners[last, 1]
        length = ux * ux + uy * uy
        t = 0.0 if length == 0 else min(max(-(x * ux + y * uy) / length, 0.0), 1.0)
        x, y = x + t * ux, y + t * uy
        if x * x + y * y <= reach:
            return True
        last = i
    return False


@device
def _is_within(corners, px, py):
    """Whether p lies inside a polygon, by crossings."""
    inside = False
    last = len(corners) - 1
    for i in range(len(corners)):
        if (corners[i, 1] > py) != (corners[last, 1] > py):
            t = (py - corners[i, 1]) / (corners[last, 1] - corners[i, 1])
            if px < corners[i, 0] + t * (corners[last, 0] - corners[i, 0]):
                inside = not inside
        last = i
    return inside


@device
def _cell(points, weights, i, partners, begin, end, bounds, around, a, b):
    """(rows, spare, count): the cell of a site, cut out of `around`, a convex polygon around the bounds.

    Where the bounds are not convex and come near, it is cut out of them once more.
    """
    corners = around
    while True:
        a = _room(a, len(corners))
        count = _start(corners, points[i, 0], points[i, 1], a)
        for k in range(begin, end):
            b = _room(b, 2 * count + 2)
            count = _clip_by(points, weights, i, partners[k], a, count, b)
            a, b = b, a
        if len(corners) == len(bounds) or count == 0:
            return a, b, count
        if not _is_near(bounds, points[i, 0], points[i, 1], _reach(a, count) * _SAFELY):
            return a, b, count if _is_within(bounds, points[i, 0] + a[0, 0], points[i, 1] + a[0, 1]) else 0
        corners = bounds


@kernel
def cell_polygon(points, weights, i, partners, begin, end, bounds, around, found):
    """Write the cell of site i as rows (x, y, partner), relative to the site; returns how many there are.

    `partners[begin:end]` are the sites that it may border on, `bounds` and `around` polygons (k, 2), counterclockwise.
    Rows that find no room in `found` are not written.
    """
    rows, _, count = _cell(
        points, weights, i, partners, begin, end, bounds, around, np.empty((32, 3)), np.empty((32, 3))
    )
    for m in range(min(count, len(found))):
        for k in range(3):
            found[m, k] = rows[m, k]
    return count


@kernel
def measure_cells(points, weights, starts, partners, bounds, around, begin, end, measures):
    """Write area and centroid of cells `begin` to `end` to `measures`, (n, 3); the site for cells without area.

    `partners[starts[i]:starts[i + 1]]` are those of site i.
    """
    a, b = np.empty((32, 3)), np.empty((32, 3))
    for i in range(begin, end):
        a, b, count = _cell(points, weights, i, partners, starts[i], starts[i + 1], bounds, around, a, b)
        area = x = y = 0.0
        last = count - 1
        for k in range(count):
            cross = a[last, 0] * a[k, 1] - a[k, 0] * a[last, 1]
            area += cross
            x += cross * (a[last, 0] + a[k, 0])
            y += cross * (a[last, 1] + a[k, 1])
            last = k
        measures[i, 0] = area / 2
        measures[i, 1], measures[i, 2] = points[i, 0], points[i, 1]
        if area > 0:
            measures[i, 1] += x / (3 * area)
            measures[i, 2] += y / (3 * area)


@kernel
def power_partners(points, weights, grid, first, following, side, width, bounds, begin, end, found):
    """Write the partners along the edges of cells `begin` to `end` to rows (site, partner) of `found`.

    `grid` (n, 2) int32 is the square of each site in a grid of `side` by `side` squares, `width` wide; `first` (side²,)
    and `following` (n,) are lists of the sites in each. Returns how many rows there are, of which those that find no
    room are not written.
    """
    a, b = np.empty((32, 3)), np.empty((32, 3))
    greatest = weights.max()
    rows = 0
    for i in range(begin, end):
        a = _room(a, len(bounds))
        count = _start(bounds, points[i, 0], points[i, 1], a)
        for ring in range(side):
            reach = _reach(a, count)
            beyond = math.sqrt(reach) + math.sqrt(max(reach - weights[i] + greatest, 0.0))
            if count == 0 or (ring - 1) * width > beyond:
                break
            x_low, x_high = grid[i, 0] - ring, grid[i, 0] + ring
            for y in range(max(grid[i, 1] - ring, 0), min(grid[i, 1] + ring, side - 1) + 1):
                step = 1 if y in (grid[i, 1] - ring, grid[i, 1] + ring) else max(2 * ring, 1)
                for x in range(x_low, x_high + 1, step):
                    j = first[y * side + x] if 0 <= x < side else -1
                    while j >= 0:
                        if j != i:
                            b = _room(b, 2 * count + 2)
                            count = _clip_by(points, weights, i, j, a, count, b)
                            a, b = b, a
                        j = following[j]
        for k in range(count):
            m = k + 1 if k + 1 < count else 0
            if a[k, 2] >= 0 and (a[k, 0] != a[m, 0] or a[k, 1] != a[m, 1]):
                if rows < len(found):
                    found[rows, 0], found[rows, 1] = i, a[k, 2]
                rows += 1
    return rows
