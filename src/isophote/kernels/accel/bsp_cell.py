"""Cells of a BSP tree: convex polyhedra, cut by planes, and their surfaces on either side of a plane.

A cell fills CELL float64 words: the number of faces, then for each its number of corners, its normal, its area, and its
corners. Cells say what planes cost, and nothing else: what is rounded, or left out where a cell has more faces than
there is room for, makes trees a little worse and no answer wrong.
"""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.accel.bsp_polygon import MOST_CORNERS, cut_polygon, extent_along, height
from isophote.kernels.base.jit import device

__all__ = ["CELL", "CELL_WORK", "areas_of_cut", "cell_area", "cell_extent", "cut_cell", "start_cell"]

_MOST_FACES = 18
_NORMAL, _AREA, _CORNERS = 1, 4, 5
_FACE = _CORNERS + 3 * (MOST_CORNERS + 2)
CELL = 1 + _MOST_FACES * _FACE
# Float64 words of work: a polygon, the cut's corners with their angles, and heights of faces.
_CUT = 3 * (MOST_CORNERS + 2)
_EXTENTS = _CUT + 4 * (MOST_CORNERS + 2)
CELL_WORK = _EXTENTS + 2 * _MOST_FACES
# Corners nearer to each other than this share of their size are one.
_SAME = 1e-9


@device
def start_cell(cells, at, box):
    """Make the cell at word `at` a box, whose least and greatest corner are given by six numbers."""
    cells[at] = 6
    for face in range(6):
        axis, upper = face // 2, face % 2
        first = at + 1 + _FACE * face
        cells[first] = 4
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for k in range(3):
            cells[first + _NORMAL + k] = 0.0
        cells[first + _NORMAL + axis] = 1.0 if upper == 1 else -1.0
        cells[first + _AREA] = (box[3 + u] - box[u]) * (box[3 + v] - box[v])
        for corner in range(4):
            word = first + _CORNERS + 3 * corner
            cells[word + axis] = box[axis + 3 * upper]
            cells[word + u] = box[u + (3 if corner in (1, 2) else 0)]
            cells[word + v] = box[v + (3 if corner >= 2 else 0)]


@device
def cell_area(cells, at):
    """The surface of a cell."""
    area = 0.0
    for face in range(np.int64(cells[at])):
        area += cells[at + 1 + _FACE * face + _AREA]
    return area


@device
def cell_extent(cells, at, plane, work):
    """The least and the greatest height of a cell above a plane; those of each of its faces go to `work`."""
    low, high = np.inf, -np.inf
    for face in range(np.int64(cells[at])):
        first = at + 1 + _FACE * face
        below, above = extent_along(plane, cells, first + _CORNERS, np.int64(cells[first]))
        work[_EXTENTS + 2 * face], work[_EXTENTS + 2 * face + 1] = below, above
        low, high = min(low, below), max(high, above)
    return low, high


@device
def _polygon_area(words, at, corners, normal, normal_at):
    """The area of a polygon with the normal at word `normal_at` of `normal`."""
    nx, ny, nz = normal[normal_at], normal[normal_at + 1], normal[normal_at + 2]
    twice = 0.0
    for i in range(1, corners - 1):
        b, c = at + 3 * i, at + 3 * i + 3
        bx, by, bz = words[b] - words[at], words[b + 1] - words[at + 1], words[b + 2] - words[at + 2]
        cx, cy, cz = words[c] - words[at], words[c + 1] - words[at + 1], words[c + 2] - words[at + 2]
        twice += nx * (by * cz - bz * cy) + ny * (bz * cx - bx * cz) + nz * (bx * cy - by * cx)
    return 0.5 * abs(twice)


@device
def areas_of_cut(cells, at, plane, work):
    """The surfaces of the parts of a cell below and above a plane, the cut counted for both.

    `work` is as `cell_extent` left it for the same direction and place 0. Faces of a closed surface, as vectors, add up
    to nothing: those below the plane give the cut's own area.
    """
    below, above, facing = 0.0, 0.0, 0.0
    for face in range(np.int64(cells[at])):
        first = at + 1 + _FACE * face
        corners, whole = np.int64(cells[first]), cells[first + _AREA]
        part = 0.0
        if work[_EXTENTS + 2 * face + 1] <= plane.place:
            part = whole
        elif work[_EXTENTS + 2 * face] < plane.place:
            kept = cut_polygon(plane, 1.0, cells, first + _CORNERS, corners, work, 0)
            part = min(_polygon_area(work, 0, kept, cells, first + _NORMAL), whole)
        below += part
        above += whole - part
        n = first + _NORMAL
        facing += part * (plane.x * cells[n] + plane.y * cells[n + 1] + plane.z * cells[n + 2])
    return below + abs(facing), above + abs(facing)


@device
def _collect(work, found, source, at, least):
    """Add a corner to those of the cut, of which there are `found`, unless it is there already."""
    for i in range(found):
        k = _CUT + 4 * i
        apart = abs(work[k] - source[at]) + abs(work[k + 1] - source[at + 1]) + abs(work[k + 2] - source[at + 2])
        if apart <= least:
            return found
    if found < MOST_CORNERS + 2:
        for k in range(3):
            work[_CUT + 4 * found + k] = source[at + k]
    return found + 1


@device
def _around(work, found, plane):
    """Sort the corners of the cut by their angles about their middle."""
    mx, my, mz = 0.0, 0.0, 0.0
    for i in range(found):
        k = _CUT + 4 * i
        mx, my, mz = mx + work[k] / found, my + work[k + 1] / found, mz + work[k + 2] / found
    ux, uy, uz = work[_CUT] - mx, work[_CUT + 1] - my, work[_CUT + 2] - mz
    vx, vy, vz = plane.y * uz - plane.z * uy, plane.z * ux - plane.x * uz, plane.x * uy - plane.y * ux
    for i in range(found):
        k = _CUT + 4 * i
        x, y, z = work[k] - mx, work[k + 1] - my, work[k + 2] - mz
        angle = math.atan2(vx * x + vy * y + vz * z, ux * x + uy * y + uz * z)
        while k > _CUT and work[k - 1] > angle:
            for word in range(4):
                work[k + word] = work[k - 4 + word]
            k -= 4
        work[k], work[k + 1], work[k + 2], work[k + 3] = x + mx, y + my, z + mz, angle


@device
def _add_cut(cells, to, faces, plane, side, work, found):
    """Add the cut as a face, where it is one and there is room."""
    if found < 3 or found > MOST_CORNERS or faces >= _MOST_FACES:
        return faces
    _around(work, found, plane)
    first = to + 1 + _FACE * faces
    cells[first] = found
    cells[first + _NORMAL] = side * plane.x
    cells[first + _NORMAL + 1] = side * plane.y
    cells[first + _NORMAL + 2] = side * plane.z
    for i in range(found):
        for k in range(3):
            cells[first + _CORNERS + 3 * i + k] = work[_CUT + 4 * i + k]
    cells[first + _AREA] = _polygon_area(cells, first + _CORNERS, found, cells, first + _NORMAL)
    return faces + 1


@device
def cut_cell(source, at, plane, side, cells, to, work):
    """Write the part of a cell that has side · height ≤ 0 to word `to` of `cells`."""
    low, high = cell_extent(source, at, plane, work)
    least = _SAME * (high - low)
    faces, found = np.int64(0), np.int64(0)
    for face in range(np.int64(source[at])):
        first, target = at + 1 + _FACE * face, to + 1 + _FACE * faces
        kept = cut_polygon(plane, side, source, first + _CORNERS, np.int64(source[first]), cells, target + _CORNERS)
        if kept > MOST_CORNERS:
            kept = MOST_CORNERS
        for i in range(kept):
            corner = target + _CORNERS + 3 * i
            if abs(height(plane, cells, corner)) <= least:
                found = _collect(work, found, cells, corner, least)
        if kept >= 3:
            cells[target] = kept
            for k in range(_NORMAL, _AREA):
                cells[target + k] = source[first + k]
            cells[target + _AREA] = _polygon_area(cells, target + _CORNERS, kept, source, first + _NORMAL)
            faces += 1
    cells[to] = _add_cut(cells, to, faces, plane, side, work, found)
