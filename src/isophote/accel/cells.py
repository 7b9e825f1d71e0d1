"""The boxes of an accelerator's nodes, level by level, for pictures of it."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.accel.accelerator import Built
from isophote.errors import GeometryError
from isophote.kernels.accel.grid_layout import SIZE
from isophote.kernels.accel.kd_layout import LEAF
from isophote.kernels.accel.layout import CHILD, LOWER, NODE, UPPER, WIDTH

__all__ = ["SHOWN", "Level", "levels_of"]

Points: TypeAlias = npt.NDArray[np.float64]
Level: TypeAlias = Points
"""(n, 2, 3): least and greatest corners of the boxes of one level."""

# Levels with more boxes are not asked for: nobody could tell them apart.
MOST_BOXES = 8192


def levels_of(name: str, built: Built, depth: int) -> list[Level]:
    """Boxes of the nodes of the accelerator `name`, from the root, level 0, to level `depth`; levels with more than
    8,192 boxes, and those below, are left out. Raises `GeometryError` where there is nothing to show."""
    if not np.isfinite(built.bounds).all():
        raise GeometryError("show_tree: there are no triangles to show the tree of")
    return _LEVELS[name](built, depth)


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
    nodes = built.tables.arrays["nodes"].reshape(-1, 2)
    planes, codes = nodes[:, 0].astype(np.float64), nodes[:, 1].copy().view(np.int32)
    numbers, boxes = np.zeros(1, np.int64), built.bounds.astype(np.float64)[None]
    levels = [boxes]
    while len(levels) <= depth:
        inner = np.flatnonzero((codes[numbers] & 3) != LEAF)
        if not 0 < 2 * len(inner) <= MOST_BOXES:
            break
        code, plane = codes[numbers[inner]], planes[numbers[inner]]
        axis, row = code & 3, np.arange(len(inner))
        below, above = boxes[inner].copy(), boxes[inner].copy()
        below[row, 1, axis] = plane
        above[row, 0, axis] = plane
        boxes = np.concatenate([below, above])
        numbers = np.concatenate([code >> 2, (code >> 2) + 1]).astype(np.int64)
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
            filled = np.flatnonzero(codes)
            at = np.stack([filled % nx, filled // nx % ny, filled // (nx * ny)], axis=1)
            low = frames[grid, :3] + at * frames[grid, SIZE : SIZE + 3]
            boxes.append(np.stack([low, low + frames[grid, SIZE : SIZE + 3]], axis=1))
            within += (-codes[codes < 0]).tolist()
        level = np.concatenate(boxes)
        if not 0 < len(level) <= MOST_BOXES:
            break
        levels.append(level)
        grids = within
    return levels


_LEVELS: dict[str, Callable[[Built, int], list[Level]]] = {
    "bvh": _bvh_levels,
    "grid": _grid_levels,
    "kdtree": _kd_levels,
}
SHOWN = tuple(_LEVELS)
"""The accelerators whose boxes can be told."""
