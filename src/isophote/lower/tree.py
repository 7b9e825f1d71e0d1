"""Trees of triangles and of boxes, built on all cores: what they are is told in kernels/accel/layout.py."""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.errors import GeometryError
from isophote.kernels.accel import build, build_wide
from isophote.kernels.accel.layout import BLOCK, LANES, MAX_BLOCKS, NODE

__all__ = ["Tree", "build_boxes", "build_triangles"]

FloatArray: TypeAlias = npt.NDArray[np.float32]
IntArray: TypeAlias = npt.NDArray[np.int32]


class Tree(NamedTuple):
    """A tree in kernels/accel/layout.py's memory.

    `nodes` is flat float32. `blocks` is flat float32 blocks of triangles, or, over boxes, int32 numbers of boxes:
    there a leaf's `first` and `count` say which of these numbers it holds. `bounds` is (2, 3) float32, the least and
    greatest corner; (+inf, -inf) where there is nothing.
    """

    nodes: FloatArray
    blocks: FloatArray | IntArray
    bounds: FloatArray


class _Kind(NamedTuple):
    """What differs between trees: items a block, items a binary leaf, items a leaf at most, and costs."""

    lanes: int
    smallest: int
    most: int
    leaf_cost: np.float32
    block_cost: np.float32


_TRIANGLES = _Kind(LANES, 4, 8, np.float32(0), np.float32(1))
_BOXES = _Kind(1, 1, MAX_BLOCKS, np.float32(0), np.float32(8))


def build_triangles(positions: npt.ArrayLike, triangles: npt.ArrayLike, threads: int | None = None) -> Tree:
    """The tree of `triangles`, (m, 3) int32 rows of `positions`, (n, 3) float32.

    The same bits come out for any number of `threads` (all cores if None). Raises `GeometryError` where a position
    is not finite or a triangle names a position that is not there.
    """
    points = np.require(positions, np.float32, ["C", "W"]).reshape(-1)
    corners = np.require(triangles, np.int32, ["C", "W"]).reshape(-1)
    count = len(corners) // 3
    if count == 0:
        return _nothing(np.empty(0, np.float32))
    if not np.isfinite(points).all():
        raise GeometryError("positions must be finite in single precision, within 3.4e38")
    if corners.min() < 0 or corners.max() >= len(points) // 3:
        raise GeometryError(f"triangles name positions outside 0 to {len(points) // 3 - 1}")
    records = np.empty(2 * count * build.RECORD, np.float32)
    found = np.empty((1, 16), np.float32)
    build.triangle_records(points, corners, records, 0, count, found[0])
    nodes, slots, bounds = _build(records, count, found, _TRIANGLES)
    del records
    blocks = np.empty(len(slots) // LANES * BLOCK, np.float32)
    build_wide.fill_blocks(points, corners, slots, blocks, 0, len(slots))
    return Tree(nodes, blocks, bounds)


def build_boxes(lower: npt.ArrayLike, upper: npt.ArrayLike) -> Tree:
    """The tree of the boxes from `lower` to `upper`, both (k, 3) float32."""
    least = np.asarray(lower, np.float32).reshape(-1, 3)
    greatest = np.asarray(upper, np.float32).reshape(-1, 3)
    count = len(least)
    if count == 0:
        return _nothing(np.empty(0, np.int32))
    if not (np.isfinite(least).all() and np.isfinite(greatest).all() and (least <= greatest).all()):
        raise GeometryError("boxes must be finite, and their lower corners not above their upper ones")
    records = np.zeros((2 * count, build.RECORD), np.float32)
    records[:count, 0:3] = least
    records[:count, 4:7] = -greatest
    records.view(np.int32)[:count, 3] = np.arange(count)
    found = np.zeros((1, 16), np.float32)
    found[0, 0:3] = least.min(axis=0)
    found[0, 4:7] = -greatest.max(axis=0)
    doubled = least + greatest
    found[0, 8:11] = doubled.min(axis=0)
    found[0, 12:15] = -doubled.max(axis=0)
    nodes, items, bounds = _build(records.reshape(-1), count, found, _BOXES)
    return Tree(nodes, items, bounds)


def _nothing(blocks: FloatArray | IntArray) -> Tree:
    """A root without children."""
    nodes = np.zeros(NODE, np.float32)
    nodes[:24], nodes[24:48] = np.inf, -np.inf
    bounds = np.array([[np.inf] * 3, [-np.inf] * 3], np.float32)
    return Tree(nodes, blocks, bounds)


def _build(records: FloatArray, count: int, found: FloatArray, kind: _Kind) -> tuple[FloatArray, IntArray, FloatArray]:
    """Nodes, slots and bounds."""
    whole = found.min(axis=0)
    binary = np.empty(2 * count * build.RECORD, np.float32)
    children = np.empty(2 * count, np.int32)
    order = np.empty(count, np.int32)
    costs = np.empty(2 * count * 8, np.float32)
    binary[:8] = whole[:8]
    binary.view(np.int32)[[3, 7]] = 0, count
    end = build.build_subtree(
        records, binary, children, order, count, 0, 1, 0, 0, kind.lanes, kind.smallest, whole[8:].copy()
    )
    choice = kind.lanes, kind.most, kind.leaf_cost, kind.block_cost
    build_wide.collapse_costs(binary, children, costs, 0, end, *choice)
    no_floats, no_ints, tasks = np.empty(0, np.float32), np.empty(0, np.int32), np.empty(0, np.int64)
    tree = binary, children, costs, order
    nodes_count, blocks_count, _ = build_wide.lay_out(*tree, no_floats, no_ints, tasks, 0, -1, 0, 0, -1, *choice)
    nodes = np.empty(nodes_count * NODE, np.float32)
    slots = np.empty(blocks_count * kind.lanes, np.int32)
    build_wide.lay_out(*tree, nodes, slots, tasks, 0, -1, 0, 0, -1, *choice)
    bounds = np.stack([whole[0:3], -whole[4:7]])
    return nodes, slots, bounds
