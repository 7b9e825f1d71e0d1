"""Lists of the triangles in a grid's cells: their order, the boxes of their blocks, and what cells share."""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.accel.crew import Run
from isophote.kernels.accel.grid_build import BOX_COST, TRIANGLE_COST
from isophote.kernels.accel.grid_layout import MAILED, NO_ROW, ROW, SIZE, SLACK
from isophote.kernels.accel.grid_order import order_lists
from isophote.kernels.accel.layout import LANES, WIDTH

__all__ = ["Geometry", "Lists", "boxes_of_lists", "order_all", "share_lists"]

FloatArray: TypeAlias = npt.NDArray[np.float32]
IntArray: TypeAlias = npt.NDArray[np.int32]
Doubles: TypeAlias = npt.NDArray[np.float64]
Longs: TypeAlias = npt.NDArray[np.int64]

# References that are worth a thread's while.
_SLAB = 1 << 15


class Geometry(NamedTuple):
    """Flat positions and triangles, whether these stand for boxes (kernels/accel/clip.py), and what runs jobs."""

    positions: FloatArray
    triangles: IntArray
    boxes: bool
    run: Run

    @property
    def item_cost(self) -> float:
        """What a triangle, or a box, costs a ray in a list."""
        return BOX_COST if self.boxes else TRIANGLE_COST


class Lists(NamedTuple):
    """References of all lists, one list after another, and how many each has."""

    references: IntArray
    sizes: IntArray


def boxes_of_lists(frames: Doubles, shapes: Longs, cells: IntArray) -> FloatArray:
    """The cells that are lists, (lists, 6), with the slack about them."""
    numbers = np.flatnonzero((cells >= 0) & (cells & 1 == 0))
    grid = np.searchsorted(shapes[:, 3], numbers, side="right") - 1
    frame, shape, rest = frames[grid], shapes[grid], numbers - shapes[grid, 3]
    place = np.stack([rest % shape[:, 0], rest // shape[:, 0] % shape[:, 1], rest // (shape[:, 0] * shape[:, 1])], 1)
    lower, slack = frame[:, :3] + place * frame[:, SIZE : SIZE + 3], frame[:, SLACK, None]
    upper = lower + frame[:, SIZE : SIZE + 3] + slack
    outward = np.array([-np.inf] * 3 + [np.inf] * 3, np.float32)
    return np.nextafter(np.concatenate([lower - slack, upper], axis=1).astype(np.float32), outward)


def order_all(geometry: Geometry, lists: Lists, cells: FloatArray) -> tuple[FloatArray, IntArray]:
    """Put references of `lists`, about `cells` (lists, 6), into the order of their blocks; the rows of the blocks'
    boxes, and the first row of each list, or NO_ROW for one that has none: of a single block, or of boxes."""
    references, sizes = lists
    own = np.where((sizes > LANES) & (not geometry.boxes), -(-sizes // (LANES * WIDTH)), 0)
    ends = np.cumsum(own)
    first_rows = np.where(own > 0, ends - own, NO_ROW).astype(np.int32)
    rows = np.empty(int(ends[-1]) * ROW, np.float32)
    starts = np.concatenate([np.zeros(1, np.int64), np.cumsum(sizes, dtype=np.int64)])
    given = geometry.positions, geometry.triangles, references, starts, first_rows, cells
    geometry.run(order_lists, [(*given, *piece, rows) for piece in _pieces_of_lists(starts)])
    return rows, first_rows


def _pieces_of_lists(starts: Longs) -> list[tuple[int, int]]:
    """Ranges of lists with enough references to be worth a thread's while."""
    ends = np.append(np.flatnonzero(np.diff(starts[1:] // _SLAB)) + 1, len(starts) - 1)
    return list(zip([0, *ends[:-1].tolist()], ends.tolist(), strict=True))


def share_lists(cells: IntArray, lists: Lists, first_rows: IntArray) -> tuple[IntArray, Lists, IntArray]:
    """Cells whose lists, of one block, are the same get one list, which is MAILED: a ray may come by it again. The
    codes of the cells, and the lists that are left with their first rows."""
    single = np.flatnonzero((lists.sizes <= LANES) & (first_rows == NO_ROW))
    starts = np.cumsum(lists.sizes, dtype=np.int64) - lists.sizes
    held = np.full((len(single), LANES), -1, np.int32)
    for lane in range(LANES):
        there = lists.sizes[single] > lane
        held[there, lane] = lists.references[starts[single[there]] + lane]
    _, first, same, count = np.unique(held, axis=0, return_index=True, return_inverse=True, return_counts=True)
    same = same.reshape(-1)
    marks = first_rows.copy()
    marks[single[first[count > 1]]] = MAILED
    keep = np.ones(len(lists.sizes), bool)
    keep[single] = False
    keep[single[first]] = True
    numbers = np.cumsum(keep) - 1
    numbers[single] = numbers[single[first[same]]]
    codes = cells.copy()
    listed = (cells >= 0) & (cells & 1 == 0)
    codes[listed] = 2 * numbers[cells[listed] >> 1]
    kept = Lists(lists.references[np.repeat(keep, lists.sizes)], lists.sizes[keep])
    return codes, kept, marks[keep]
