"""The cells of a tree of planes in any direction, level by level: convex polyhedra, as the polygons around them."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.accel.accelerator import Built
from isophote.kernels.accel.bsp_layout import KINDS, LEAF, NODE, PLANE, SHIFT, SLANTED

__all__ = ["Cell", "bsp_levels"]

Points: TypeAlias = npt.NDArray[np.float64]
Cell: TypeAlias = list[Points]
"""Polygons (k, 3) around a convex polyhedron."""

# Corners nearer to each other than this, in parts of the cell's size, are one.
_SAME = 1e-9


def bsp_levels(built: Built, depth: int, most: int) -> list[list[Cell]]:
    """Cells of the nodes from the root, level 0, to level `depth`; none from a level with more than `most` on."""
    nodes = built.tables.arrays["nodes"].reshape(-1, NODE)
    codes, planes = nodes.view(np.int32), built.tables.arrays["planes"].reshape(-1, PLANE)
    numbers, cells = [0], [_box(built.bounds.astype(np.float64))]
    levels = [cells]
    while len(levels) <= depth:
        inner = [k for k, number in enumerate(numbers) if codes[number, 1] & KINDS != LEAF]
        if not 0 < 2 * len(inner) <= most:
            break
        following: list[int] = []
        parts: list[Cell] = []
        for k in inner:
            number = numbers[k]
            child = int(codes[number, 1]) >> SHIFT
            normal, place = _plane(nodes[number], planes)
            for side in (0, 1):
                sign = 1.0 - 2.0 * side
                following.append(child + side)
                parts.append(_below(cells[k], sign * normal, sign * place))
        numbers, cells = following, parts
        levels.append(cells)
    return levels


def _plane(node: npt.NDArray[np.float32], planes: npt.NDArray[np.float32]) -> tuple[Points, float]:
    """The plane n · x = place of an inner node."""
    first, code = node.view(np.int32)
    kind = int(code) & KINDS
    if kind == SLANTED:
        return planes[first, :3].astype(np.float64), float(planes[first, 3])
    return np.eye(3)[kind], float(node[0])


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
