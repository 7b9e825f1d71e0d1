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

from isophote.accel.checks import checked_points, checked_triangles
from isophote.accel.crew import crew, ranges
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
    "padded_slots",
]

FloatArray: TypeAlias = npt.NDArray[np.float32]
IntArray: TypeAlias = npt.NDArray[np.int32]


class Built(NamedTuple):
    """An accelerator over the triangles of one object.

    `tables` are the accelerator's own, whose address its entries are given. `blocks`: flat float32 blocks of triangles
    (kernels/accel/layout.py), among which a triangle may stand several times; hits are told by their slots there.
    `bounds` is (2, 3) float32, the least and greatest corner; (+inf, -inf) where there is nothing. `seconds`: what
    building took, on the wall.
    """

    tables: Packed
    blocks: FloatArray
    bounds: FloatArray
    seconds: float = 0.0

    @property
    def bytes(self) -> int:
        """What tables and blocks take."""
        tables = (value.nbytes for value in self.tables.arrays.values() if isinstance(value, np.ndarray))
        return sum(tables) + self.blocks.nbytes


Build: TypeAlias = Callable[[FloatArray, IntArray, int | None], Built]


@attrs.frozen(eq=False)
class Accelerator:
    """A way to find what rays meet: its name, how it is built, and its entries (kernels/accel/contract.py).

    `build(positions, triangles, threads)` is given positions (n, 3) float32, all finite, and triangles (m, 3) int32,
    all naming positions that are there; there may be none. The same bits come out for any number of `threads`.
    """

    name: str
    build: Build
    closest: Entry
    any: Entry


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
