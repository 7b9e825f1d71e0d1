"""Triangles into the parts of a bounding interval hierarchy: the cells of a grid, and of grids within full cells."""

from __future__ import annotations

from typing import Any, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.accel.crew import GRAIN, Run, ranges
from isophote.kernels.accel.bih_sort import SORT, cells_of, extent_of, order_by_cell
from isophote.kernels.accel.build import RECORD

__all__ = ["Parts", "no_parts", "sort_into_parts"]

FloatArray: TypeAlias = npt.NDArray[np.float32]
IntArray: TypeAlias = npt.NDArray[np.int32]
Doubles: TypeAlias = npt.NDArray[np.float64]
Longs: TypeAlias = npt.NDArray[np.int64]

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
    starts: Longs
    boxes: FloatArray


class _Mesh(NamedTuple):
    """Fields of SORT that are the triangles, and what runs jobs."""

    triangles: dict[str, npt.NDArray[Any]]
    run: Run


def no_parts() -> Parts:
    """Those of no triangles."""
    return Parts(np.empty(0, np.int32), np.zeros(1, np.int64), np.empty((0, RECORD), np.float32))


def sort_into_parts(positions: FloatArray, corners: IntArray, last_point: FloatArray, run: Run) -> Parts:
    """The parts of all triangles, of which there is one at least; `positions` and `corners` are flat, `last_point` (4,)
    is the last position and any number."""
    pieces = list(ranges(0, len(positions) // 3))
    found = np.empty((len(pieces), 6), np.float32)
    run(extent_of, [(positions, *piece, found[i]) for i, piece in enumerate(pieces)])
    extent = found.min(axis=0).astype(np.float64)
    mesh = _Mesh({"positions": positions, "corners": corners, "last_point": last_point}, run)
    return _sorted(mesh, np.empty(0, np.int32), len(corners) // 3, np.stack([extent[:3], -extent[3:]]), 1)


def _sorted(mesh: _Mesh, numbers: IntArray, count: int, region: Doubles, depth: int) -> Parts:
    """The parts of the triangles of these numbers, or of all where there are none, whose centres lie in a region."""
    grid = _grid(region, count)
    order, jobs = np.empty(count, np.int32), _jobs(count)
    counts = np.empty((len(jobs), int(grid.shape.prod())), np.int64)
    boxes, places = np.empty((*counts.shape, RECORD), np.float32), np.empty(counts.shape, np.int64)
    table = SORT.pack(
        **mesh.triangles,
        numbers=numbers,
        frame=grid.frame(),
        cells=np.empty(count, np.int32),
        counts=counts,
        boxes=boxes.reshape(-1),
        places=places,
        order=order,
    )
    mesh.run(cells_of, [(table.words, job, *piece) for job, piece in enumerate(jobs)])
    totals = counts.sum(axis=0)
    filled = _along_a_curve(np.flatnonzero(totals), grid)
    starts = np.concatenate([[0], np.cumsum(totals[filled])])
    places[:, filled] = starts[:-1] + np.cumsum(counts[:, filled], axis=0) - counts[:, filled]
    mesh.run(order_by_cell, [(table.words, job, *piece) for job, piece in enumerate(jobs)])
    parts = Parts(order, starts, boxes[:, filled].min(axis=0))
    if depth == _MOST_GRIDS or totals.max() <= _LARGEST:
        return parts
    return _with_grids_within(mesh, parts, _regions(filled, grid, parts.boxes), depth)


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


class _Grid(NamedTuple):
    """A grid of cubes: cells along each axis, (3,); its first corner; and a cell's side, 0 where all is one point."""

    shape: Longs
    corner: Doubles
    side: float

    def frame(self) -> FloatArray:
        """As kernels/accel/bih_sort.py has it."""
        scale = 0.5 / self.side if self.side > 0 else 0.0
        with np.errstate(over="ignore"):
            return np.array([*(2 * self.corner), 0, *[scale] * 4, *(self.shape - 1), 0], np.float32)


def _grid(region: Doubles, count: int) -> _Grid:
    """The grid over a region for so many triangles."""
    extent = region[1] - region[0]
    most = min(max(count / _TO_A_CELL, 1), _MOST_CELLS)
    low, high = 1, _MOST_CELLS + 1
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if _shape(extent, middle).prod() <= most else (low, middle)
    return _Grid(_shape(extent, low), region[0], float(extent.max()) / low)


def _along_a_curve(cells: Longs, grid: _Grid) -> Longs:
    """Cells in Morton's order: what is seen together is together in memory, and touches few large pages."""
    at = np.stack(np.unravel_index(cells, grid.shape), axis=1)
    code = np.zeros(len(cells), np.int64)
    for bit in range(_MOST_CELLS.bit_length()):
        code |= ((at >> bit & 1) << (3 * bit + np.arange(3))).sum(axis=1)
    return cells[np.argsort(code)]


def _shape(extent: Doubles, longest: int) -> Longs:
    """Cells along each axis where there are so many along the longest."""
    most = float(extent.max())
    if most == 0:
        return np.ones(3, np.int64)
    return np.clip(np.ceil(extent / most * longest), 1, longest).astype(np.int64)


def _regions(filled: Longs, grid: _Grid, boxes: FloatArray) -> Doubles:
    """(k, 2, 3): where the centres of what is in cells lie, by the cells and by the boxes of what they hold."""
    at = np.stack(np.unravel_index(filled, grid.shape), axis=1)
    # Outermost cells have what rounding brings beyond the grid; elsewhere it moves nothing by more than part of a cell.
    wide = boxes.astype(np.float64)
    low, high = (grid.corner + (at + k) * grid.side for k in (0, 1))
    return np.stack([np.maximum(low, wide[:, :3]), np.minimum(high, -wide[:, 4:7])], axis=1)


def _jobs(count: int) -> list[tuple[int, int]]:
    """Ranges of whole pieces, few enough for each to have counts of all cells."""
    length = max(GRAIN, -(-count // _JOBS))
    return [(begin, min(begin + length, count)) for begin in range(0, count, length)]
