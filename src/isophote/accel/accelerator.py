"""The contract of accelerators: how they are built, and what rays ask of them. See docs/design/accelerators.md.

Adding one takes a file with its entries in kernels/accel, a file here with an `Accelerator`, and a line in `_HOMES`.
"""

from __future__ import annotations

import importlib
import time
from collections.abc import Callable
from typing import Any, NamedTuple, TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.accel.checks import MOST_ITEMS, checked_points, checked_triangles
from isophote.accel.crew import crew, ranges
from isophote.errors import GeometryError
from isophote.kernels.accel.build_wide import fill_blocks
from isophote.kernels.accel.layout import BLOCK, LANES
from isophote.kernels.base.entry import Entry
from isophote.kernels.base.table import Packed

__all__ = [
    "ACCELERATORS",
    "REFERENCE",
    "Accelerator",
    "Build",
    "Built",
    "accelerator_of",
    "blocks_of",
    "build_accelerator",
    "build_things",
    "padded_slots",
]

FloatArray: TypeAlias = npt.NDArray[np.float32]
IntArray: TypeAlias = npt.NDArray[np.int32]


class Built(NamedTuple):
    """An accelerator over the triangles of one object, or over the boxes of other things.

    `tables` are the accelerator's own, whose address its entries are given. `blocks`: flat float32 blocks of triangles
    (kernels/accel/layout.py), among which a triangle may stand several times; hits are told by their slots there. Over
    boxes: whatever the entry for things wants (kernels/accel/things.py).
    `bounds` is (2, 3) float32, the least and greatest corner; (+inf, -inf) where there is nothing. `seconds`: what
    building took, on the wall.
    """

    tables: Packed
    blocks: FloatArray
    bounds: FloatArray
    seconds: float = 0.0

    @property
    def bytes(self) -> int:
        """What tables and blocks take; where rays build, as much as they may fill."""
        arrays = [value for value in self.tables.arrays.values() if isinstance(value, np.ndarray)]
        return sum(array.nbytes for array in arrays if array is not self.blocks) + self.blocks.nbytes


Build: TypeAlias = Callable[[FloatArray, IntArray, int | None], Built]
BuildBoxes: TypeAlias = Callable[[FloatArray, FloatArray, int | None], Built]


@attrs.frozen(eq=False)
class Accelerator:
    """A way to find what rays meet: its name, how it is built, and its entries (kernels/accel/contract.py, things.py).

    `build(positions, triangles, threads)` is given positions (n, 3) float32, all finite, and triangles (m, 3) int32,
    all naming positions that are there; there may be none. A triangle whose second and third corner are the same stands
    for the box between its corners (kernels/accel/clip.py). The same bits come out for any number of `threads`.
    `build_boxes(lower, upper, threads)` builds over boxes, where that is not done so.
    """

    name: str
    build: Build
    closest: Entry
    any: Entry
    things: Entry
    build_boxes: BuildBoxes | None = None


# Name → module in isophote.accel, and the Accelerator there. Each is loaded when it is first asked for.
_HOMES = {
    "bih": ("bih", "LAZY_BIH"),
    "brute": ("brute", "BRUTE_FORCE"),
    "bsp": ("bsp", "BSP_TREE"),
    "bvh": ("tree_accelerator", "BVH"),
    "grid": ("grid", "GRID_OF_GRIDS"),
    "kdtree": ("kdtree", "KDTREE"),
}
ACCELERATORS = ("bvh", "grid", "kdtree", "bih", "bsp")
REFERENCE = "brute"
"""Brute force, by which the others are tested."""


def accelerator_of(name: str) -> Accelerator:
    """The accelerator of a name, one of ACCELERATORS or REFERENCE."""
    module, constant = _HOMES[name]
    found: Accelerator = getattr(importlib.import_module(f"isophote.accel.{module}"), constant)
    return found


def build_accelerator(
    name: str, positions: npt.ArrayLike, triangles: npt.ArrayLike, threads: int | None = None
) -> Built:
    """The accelerator of a name over `triangles`, (m, 3) rows of `positions`, (n, 3).

    The same bits come out for any number of `threads` (all cores if None). Raises `GeometryError` where a position is
    not finite in single precision, a triangle names a position that is not there, or there are more than 2^28.
    """
    accelerator = accelerator_of(name)
    points = checked_points(positions, "positions")
    corners = checked_triangles(triangles, len(points))
    began = time.perf_counter()
    built = accelerator.build(points, corners, threads)
    return built._replace(seconds=time.perf_counter() - began)


def build_things(name: str, lower: npt.ArrayLike, upper: npt.ArrayLike, threads: int | None = None) -> Built:
    """The accelerator of a name over boxes from `lower` to `upper`, both (k, 3): of whatever has a test of its own.

    The same bits come out for any number of `threads` (all cores if None). Raises `GeometryError` where a box is not
    finite or its lower corner lies above its upper one, or there are more than 2^27.
    """
    least, greatest = checked_points(lower, "lower corners"), checked_points(upper, "upper corners")
    if len(greatest) != len(least) or (least > greatest).any():
        raise GeometryError("every box must have a lower corner and an upper one, not below it")
    if 2 * len(least) > MOST_ITEMS:
        raise GeometryError(f"an accelerator holds 2^27 boxes at most, not {len(least):,}")
    accelerator = accelerator_of(name)
    began = time.perf_counter()
    if accelerator.build_boxes is not None:
        built = accelerator.build_boxes(least, greatest, threads)
    else:
        corners = np.stack([least, greatest], axis=1).reshape(-1, 3)
        first = 2 * np.arange(len(least), dtype=np.int32)
        built = accelerator.build(corners, np.stack([first, first + 1, first + 1], axis=1), threads)
    return built._replace(seconds=time.perf_counter() - began)


def blocks_of(positions: FloatArray, triangles: IntArray, slots: IntArray, threads: int | None) -> FloatArray:
    """Blocks of triangles: in slot k stands triangle `slots[k]`, or none where that is −1; LANES slots make a block."""
    blocks = np.empty(len(slots) // LANES * BLOCK, np.float32)
    flat: tuple[Any, ...] = (positions.reshape(-1), triangles.reshape(-1), slots, blocks)
    with crew(threads, len(slots)) as run:
        run(fill_blocks, [(*flat, *piece) for piece in ranges(0, len(slots))])
    return blocks


def padded_slots(counts: IntArray, references: IntArray) -> tuple[IntArray, IntArray]:
    """Slots for lists of triangles, `counts` (k,) of the `references` each, every list beginning a block: the number of
    each list's first block, and the slots, with −1 in those that are left over."""
    ends = np.cumsum(-(-counts // LANES))
    starts = (ends - -(-counts // LANES)).astype(np.int32)
    slots = np.full(int(ends[-1]) * LANES if len(ends) else 0, -1, np.int32)
    within = np.arange(len(references)) - np.repeat(np.cumsum(counts) - counts, counts)
    slots[np.repeat(starts.astype(np.int64) * LANES, counts) + within] = references
    return starts, slots
