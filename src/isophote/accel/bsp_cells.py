"""The cells of a tree of planes in any direction, level by level: convex polyhedra, as the polygons around them."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.accel.accelerator import Built
from isophote.accel.treelets import CHILDREN, PLANES, ROOT, parted, plane_lanes
from isophote.kernels.accel.bsp_layout import CODES, PLACES, TREELET

__all__ = ["Cell", "bsp_levels"]

Points: TypeAlias = npt.NDArray[np.float64]
Cell: TypeAlias = list[Points]
"""Polygons (k, 3) around a convex polyhedron."""

# Corners nearer to each other than this, in parts of the cell's size, are one.
_SAME = 1e-9


def bsp_levels(built: Built, depth: int, most: int) -> list[list[Cell]]:
    """Cells of the nodes from the root, level 0, to level `depth`; none from a level with more than `most` on."""
    words = built.tables.arrays["nodes"].reshape(-1, TREELET)
    planes, codes = (
        words[:, : 4 * CHILDREN].reshape(-1, 4, CHILDREN).astype(np.float64),
        words[:, CODES:].view(np.int32),
    )
    numbers, cells = np.array([ROOT]), [_box(built.bounds.astype(np.float64))]
    levels = [cells]
    while len(levels) <= depth:
        treelets, lanes = plane_lanes(numbers)
        inner = np.flatnonzero((lanes < PLANES) & np.isfinite(words[treelets, PLACES + lanes]))
        if not 0 < 2 * len(inner) <= most:
            break
        parts: list[Cell] = []
        for k in inner:
            *normal, place = planes[treelets[k], :, lanes[k]]
            parts += [_below(cells[k], sign * np.array(normal), sign * place) for sign in (1.0, -1.0)]
        numbers, cells = np.stack(parted(numbers[inner], words[:, PLACES:CODES], codes), axis=1).reshape(-1), parts
        levels.append(cells)
    return levels


def _box(bounds: Points) -> Cell:
    """The six sides of a box."""
    sides = []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for end in bounds[:, axis]:
            side = np.empty((4, 3))
            side[:, axis], side[:, u], side[:, v] = end, bounds[[0, 1, 1, 0], u], bounds[[0, 0, 1, 1], v]
            sides.append(side)
    return sides


def _below(cell: Cell, normal: Points, place: float) -> Cell:
    """The part of a cell with normal · x ≤ place, closed by a polygon in the plane."""
    kept, rim = [], []
    for polygon in cell:
        part, cut = _clipped(polygon, polygon @ normal - place)
        rim += cut
        if len(part) >= 3:
            kept.append(part)
    return kept if len(rim) < 3 else [*kept, _around(np.array(rim), normal)]


def _clipped(polygon: Points, heights: Points) -> tuple[Points, list[Points]]:
    """The part of a polygon at heights that are not positive, and its corners at height 0."""
    part, cut = [], []
    for k, (corner, height) in enumerate(zip(polygon, heights, strict=True)):
        after = (k + 1) % len(polygon)
        if height <= 0:
            part.append(corner)
            if height == 0:
                cut.append(corner)
        if height * heights[after] < 0:
            share = height / (height - heights[after])
            place = corner + share * (polygon[after] - corner)
            part.append(place)
            cut.append(place)
    return np.array(part).reshape(-1, 3), cut


def _around(points: Points, normal: Points) -> Points:
    """Corners of a convex polygon in their order around it, each once."""
    axis = int(np.argmin(np.abs(normal)))
    u = np.cross(normal, np.eye(3)[axis])
    v = np.cross(normal, u)
    off = points - points.mean(axis=0)
    points = points[np.argsort(np.arctan2(off @ v, off @ u), kind="stable")]
    gaps = np.linalg.norm(points - np.roll(points, 1, axis=0), axis=1)
    distinct: Points = points[gaps > _SAME * np.abs(off).max()]
    return distinct
