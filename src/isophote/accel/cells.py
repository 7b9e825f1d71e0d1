"""The boxes of an accelerator's nodes, or their cells, level by level, for pictures of it."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.accel.accelerator import Built
from isophote.accel.bih import finish
from isophote.accel.bsp_cells import bsp_levels
from isophote.accel.treelets import PLANES, ROOT, parted, plane_lanes
from isophote.errors import GeometryError
from isophote.kernels.accel.grid_layout import SIZE
from isophote.kernels.accel.kd_layout import ACROSS_Z, AXES, CODES, TREELET
from isophote.kernels.accel.layout import CHILD, LOWER, NODE, UPPER, WIDTH

__all__ = ["SHOWN", "Edges", "Level", "edges_of", "levels_of"]

Points: TypeAlias = npt.NDArray[np.float64]
Level: TypeAlias = Points
"""(n, 2, 3): least and greatest corners of the boxes of one level."""

# Ends of the twelve edges of a box, as numbers of corners whose bits tell of which corner each coordinate is.
_EDGES = [(a, a | 1 << axis) for axis in range(3) for a in range(8) if not a >> axis & 1]


class Edges(NamedTuple):
    """The cells of one level: how many, and the ends (n, 2, 3) of the edges of all."""

    cells: int
    ends: Points


# Levels with more boxes are not asked for: nobody could tell them apart.
MOST_BOXES = 8192


def levels_of(name: str, built: Built, depth: int) -> list[Level]:
    """Boxes of the nodes of the accelerator `name`, from the root, level 0, to level `depth`; levels with more than
    8,192 boxes, and those below, are left out. Raises `GeometryError` where there is nothing to show."""
    _check(built)
    return _LEVELS[name](built, depth)


def edges_of(name: str, built: Built, depth: int) -> list[Edges]:
    """Edges of the nodes' boxes, or of the polyhedra between planes in any direction, as `levels_of` tells levels."""
    if name != "bsp":
        return [Edges(len(level), _box_edges(level)) for level in levels_of(name, built, depth)]
    _check(built)
    return [
        Edges(len(cells), np.concatenate([_around(polygon) for cell in cells for polygon in cell]))
        for cells in bsp_levels(built, depth, MOST_BOXES)
    ]


def _check(built: Built) -> None:
    if not np.isfinite(built.bounds).all():
        raise GeometryError("show_tree: there are no triangles to show the tree of")


def _box_edges(boxes: Level) -> Points:
    corners = np.stack([np.stack([boxes[:, k >> axis & 1, axis] for axis in range(3)], axis=1) for k in range(8)], 1)
    return corners[:, np.array(_EDGES)].reshape(-1, 2, 3)


def _around(polygon: Points) -> Points:
    return np.stack([polygon, np.roll(polygon, -1, axis=0)], axis=1)


def _bvh_levels(built: Built, depth: int) -> list[Level]:
    rows = built.tables.arrays["nodes"].reshape(-1, NODE)
    lower = rows[:, LOWER:UPPER].reshape(-1, 3, WIDTH).transpose(0, 2, 1).astype(np.float64)
    upper = rows[:, UPPER:CHILD].reshape(-1, 3, WIDTH).transpose(0, 2, 1).astype(np.float64)
    codes = rows[:, CHILD : CHILD + WIDTH].copy().view(np.int32)
    levels, nodes = [built.bounds.astype(np.float64)[None]], np.zeros(1, np.int64)
    while len(levels) <= depth and len(nodes):
        present = np.isfinite(lower[nodes]).all(axis=2)
        boxes = np.stack([lower[nodes][present], upper[nodes][present]], axis=1)
        if not 0 < len(boxes) <= MOST_BOXES:
            break
        levels.append(boxes)
        children = codes[nodes][present]
        nodes = children[children >= 0].astype(np.int64)
    return levels


def _kd_levels(built: Built, depth: int) -> list[Level]:
    words = built.tables.arrays["nodes"].reshape(-1, TREELET)
    codes = words[:, CODES:].view(np.int32)
    axes = words[:, AXES].copy().view(np.int32)
    numbers, boxes = np.array([ROOT]), built.bounds.astype(np.float64)[None]
    levels = [boxes]
    while len(levels) <= depth:
        treelets, lanes = plane_lanes(numbers)
        inner = np.flatnonzero((lanes < PLANES) & np.isfinite(words[treelets, lanes]))
        if not 0 < 2 * len(inner) <= MOST_BOXES:
            break
        treelet, lane, row = treelets[inner], lanes[inner], np.arange(len(inner))
        axis = (axes[treelet] >> lane & 1) + 2 * (axes[treelet] >> (ACROSS_Z + lane) & 1)
        below, above = boxes[inner].copy(), boxes[inner].copy()
        below[row, 1, axis] = above[row, 0, axis] = words[treelet, lane]
        boxes = np.concatenate([below, above])
        numbers = np.concatenate(parted(numbers[inner], words[:, :CODES], codes))
        levels.append(boxes)
    return levels


def _grid_levels(built: Built, depth: int) -> list[Level]:
    """The frame, the cells of the grid that hold anything, the cells of the grids within, and so on."""
    arrays = built.tables.arrays
    frames, shapes, cells = arrays["frames"], arrays["shapes"], arrays["cells"]
    levels, grids = [built.bounds.astype(np.float64)[None]], [0]
    while len(levels) <= depth and grids:
        boxes, within = [], []
        for grid in grids:
            nx, ny, nz, first = (int(number) for number in shapes[grid])
            codes = cells[first : first + nx * ny * nz]
            filled = np.flatnonzero(codes >= 0)
            at = np.stack([filled % nx, filled // nx % ny, filled // (nx * ny)], axis=1)
            low = frames[grid, :3] + at * frames[grid, SIZE : SIZE + 3]
            boxes.append(np.stack([low, low + frames[grid, SIZE : SIZE + 3]], axis=1))
            within += (codes[filled][codes[filled] & 1 == 1] >> 1).tolist()
        level = np.concatenate(boxes)
        if not 0 < len(level) <= MOST_BOXES:
            break
        levels.append(level)
        grids = within
    return levels


def _bih_levels(built: Built, depth: int) -> list[Level]:
    """The boxes of a hierarchy all of whose parts are finished first."""
    finish(built)
    return _bvh_levels(built, depth)


_LEVELS: dict[str, Callable[[Built, int], list[Level]]] = {
    "bvh": _bvh_levels,
    "grid": _grid_levels,
    "kdtree": _kd_levels,
    "bih": _bih_levels,
}
SHOWN = (*_LEVELS, "bsp")
"""The accelerators whose boxes or cells can be told."""
