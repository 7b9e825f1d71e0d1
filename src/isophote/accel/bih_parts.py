"""Triangles into the parts of a bounding interval hierarchy: the cells of a grid, and of grids within full cells."""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.accel.crew import GRAIN, Run, ranges
from isophote.kernels.accel.bih_sort import cells_of, extent_of, order_by_cell
from isophote.kernels.accel.build import RECORD

__all__ = ["Parts", "no_parts", "sort_into_parts"]

FloatArray: TypeAlias = npt.NDArray[np.float32]
IntArray: TypeAlias = npt.NDArray[np.int32]
Doubles: TypeAlias = npt.NDArray[np.float64]

# Triangles to a cell if all cells had some, as is never so; cells at most; and triangles of a part at most, but for
# those that many grids within each other do not part.
_TO_A_CELL = 128
_MOST_CELLS = 1 << 15
_LARGEST = 8192
_MOST_GRIDS = 5
# Jobs that a grid's triangles are sorted in. Fixed: it must not depend on the number of threads.
_JOBS = 8


class Parts(NamedTuple):
    """Parts of triangles: their numbers in the parts' order, where each part begins, and the end, and records
    (build.py) of the parts' boxes, (k, 8)."""

    order: IntArray
    starts: npt.NDArray[np.int64]
    boxes: FloatArray


class _Mesh(NamedTuple):
    """Flat positions and corners, and what runs jobs."""

    positions: FloatArray
    corners: IntArray
    run: Run


def no_parts() -> Parts:
    """Those of no triangles."""
    return Parts(np.empty(0, np.int32), np.zeros(1, np.int64), np.empty((0, RECORD), np.float32))


def sort_into_parts(positions: FloatArray, corners: IntArray, run: Run) -> Parts:
    """The parts of all triangles, of which there is one at least; `positions` and `corners` are flat."""
    pieces = list(ranges(0, len(positions) // 3))
    found = np.empty((len(pieces), 6), np.float32)
    run(extent_of, [(positions, *piece, found[i]) for i, piece in enumerate(pieces)])
    extent = found.min(axis=0).astype(np.float64)
    mesh = _Mesh(positions, corners, run)
    return _sorted(mesh, np.empty(0, np.int32), len(corners) // 3, np.stack([extent[:3], -extent[3:]]), 1)


def _sorted(mesh: _Mesh, numbers: IntArray, count: int, region: Doubles, depth: int) -> Parts:
    """The parts of the triangles of these numbers, or of all where there are none, whose centres lie in a region."""
    shape, frame = _grid(region, count)
    cells, order = np.empty(count, np.uint16), np.empty(count, np.int32)
    pieces = list(_jobs(count))
    counts = np.empty((len(pieces), int(shape.prod())), np.int64)
    boxes = np.empty((*counts.shape, RECORD), np.float32)
    grid = mesh.positions, mesh.corners, numbers, frame, shape
    mesh.run(cells_of, [(*grid, *p, cells, counts[i], boxes[i].reshape(-1)) for i, p in enumerate(pieces)])
    totals = counts.sum(axis=0)
    starts = np.concatenate([[0], np.cumsum(totals)])
    places = starts[:-1] + np.cumsum(counts, axis=0) - counts
    mesh.run(order_by_cell, [(cells, numbers, *p, places[i], order) for i, p in enumerate(pieces)])
    filled = np.flatnonzero(totals)
    parts = Parts(order, np.append(starts[filled], count), boxes[:, filled].min(axis=0))
    if depth == _MOST_GRIDS or totals.max() <= _LARGEST:
        return parts
    return _with_grids_within(mesh, parts, _regions(filled, shape, frame, parts.boxes), depth)


def _with_grids_within(mesh: _Mesh, parts: Parts, regions: Doubles, depth: int) -> Parts:
    """The same with the parts of those that are too large."""
    starts, boxes = [], []
    for part, (begin, end) in enumerate(zip(parts.starts[:-1].tolist(), parts.starts[1:].tolist(), strict=True)):
        if end - begin <= _LARGEST:
            starts.append(parts.starts[part : part + 1])
            boxes.append(parts.boxes[part : part + 1])
            continue
        within = _sorted(mesh, parts.order[begin:end], end - begin, regions[part], depth + 1)
        parts.order[begin:end] = within.order
        starts.append(begin + within.starts[:-1])
        boxes.append(within.boxes)
    return Parts(parts.order, np.concatenate([*starts, parts.starts[-1:]]), np.concatenate(boxes))


def _grid(region: Doubles, count: int) -> tuple[npt.NDArray[np.int64], Doubles]:
    """(3,) cells and the frame (kernels/accel/bih_sort.py) of the grid of cubes over a region for so many triangles."""
    extent = region[1] - region[0]
    most = min(max(count / _TO_A_CELL, 1), _MOST_CELLS)
    low, high = 0, _MOST_CELLS
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if _shape(extent, middle).prod() <= most else (low, middle)
    shape = _shape(extent, max(low, 1))
    longest = float(extent.max())
    return shape, np.array([*(2 * region[0]), max(low, 1) / (2 * longest) if longest > 0 else 0.0])


def _shape(extent: Doubles, longest: int) -> npt.NDArray[np.int64]:
    """Cells along each axis where there are so many along the longest."""
    most = float(extent.max())
    if most == 0:
        return np.ones(3, np.int64)
    return np.clip(np.ceil(extent / most * longest), 1, longest).astype(np.int64)


def _regions(filled: npt.NDArray[np.int64], shape: npt.NDArray[np.int64], frame: Doubles, boxes: FloatArray) -> Doubles:
    """(k, 2, 3): where the centres of what is in cells may lie, by the cells and by the boxes of what they hold."""
    at = np.stack(np.unravel_index(filled, shape), axis=1)
    # One cell more on either side would do for rounding, which moves nothing by more than a little of one.
    low, high = (frame[:3] + (at + k) / frame[3] for k in (0, 1))
    wide = boxes.astype(np.float64)
    return np.stack([np.maximum(low / 2, wide[:, :3]), np.minimum(high / 2, -wide[:, 4:7])], axis=1)


def _jobs(count: int) -> list[tuple[int, int]]:
    """Ranges of whole pieces, few enough for each to have counts of all cells."""
    length = max(GRAIN, -(-count // _JOBS))
    return [(begin, min(begin + length, count)) for begin in range(0, count, length)]
