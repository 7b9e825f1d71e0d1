"""Trees of triangles and of boxes, built on all cores: what they are is told in kernels/accel/layout.py."""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.accel.checks import MOST_ITEMS, checked_points, checked_triangles
from isophote.accel.crew import GRAIN, Run, crew, ranges
from isophote.errors import GeometryError
from isophote.kernels.accel import build, build_wide
from isophote.kernels.accel.layout import (
    BLOCK,
    CHILD,
    LANES,
    LOWER,
    MAX_BLOCKS,
    MAX_DEPTH,
    NODE,
    REACH,
    UPPER,
    WIDTH,
)

__all__ = ["BOXES", "TRIANGLES", "Kind", "Tree", "build_boxes", "build_triangles"]

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


class Kind(NamedTuple):
    """What differs between trees: items a block (a power of two), items of a leaf of the binary tree, items of a leaf
    at most, and what entering a leaf and testing one of its blocks cost, where testing a node costs 1.
    """

    lanes: int
    smallest: int
    most: int
    leaf_cost: np.float32
    block_cost: np.float32

    @property
    def collapse(self) -> tuple[int, int, np.float32, np.float32]:
        """What decides between nodes and leaves."""
        return self.lanes, self.most, self.leaf_cost, self.block_cost


# Costs by measurement of rays; docs/design/tree.md has the numbers. A box stands for a whole tree of its own.
TRIANGLES = Kind(LANES, LANES, 16, np.float32(0.6), np.float32(0.2))
BOXES = Kind(1, 1, MAX_BLOCKS, np.float32(0), np.float32(8))


def build_triangles(positions: npt.ArrayLike, triangles: npt.ArrayLike, threads: int | None = None) -> Tree:
    """The tree of `triangles`, (m, 3) int32 rows of `positions`, (n, 3) float32.

    The same bits come out for any number of `threads` (all cores if None). While it builds, it holds about 120 bytes
    a triangle. Raises `GeometryError` where a position is not finite, a triangle names a position that is not there,
    or there are more than 2^28 triangles.
    """
    points = checked_points(positions, "positions").reshape(-1)
    corners = checked_triangles(triangles, len(points) // 3).reshape(-1)
    count = len(corners) // 3
    if count == 0:
        return _nothing(np.empty(0, np.float32))
    with crew(threads, count) as run:
        records = np.empty(2 * count * build.RECORD, np.float32)
        pieces = list(ranges(0, count))
        found = np.empty((len(pieces), 16), np.float32)
        run(build.triangle_records, [(points, corners, records, *p, found[i]) for i, p in enumerate(pieces)])
        whole = found.min(axis=0)
        skeleton = _grow(run, records, count, whole, TRIANGLES)
        del records
        nodes, slots = _lay_out(run, skeleton, TRIANGLES)
        del skeleton
        blocks = np.empty(len(slots) // LANES * BLOCK, np.float32)
        run(build_wide.fill_blocks, [(points, corners, slots, blocks, *p) for p in ranges(0, len(slots))])
    return Tree(_with_reach(nodes, whole), blocks, _bounds(whole))


def build_boxes(lower: npt.ArrayLike, upper: npt.ArrayLike, threads: int | None = None) -> Tree:
    """The tree of the boxes from `lower` to `upper`, both (k, 3) float32.

    Raises `GeometryError` where a box is not finite or its lower corner lies above its upper one, or there are more
    than 2^28.
    """
    least, greatest = checked_points(lower, "lower corners"), checked_points(upper, "upper corners")
    count = len(least)
    if len(greatest) != count or (least > greatest).any():
        raise GeometryError("every box must have a lower corner and an upper one, not below it")
    if count > MOST_ITEMS:
        raise GeometryError(f"a tree holds 2^28 boxes at most, not {count:,}")
    if count == 0:
        return _nothing(np.empty(0, np.int32))
    records = np.zeros((2 * count, build.RECORD), np.float32)
    records[:count, 0:3] = least
    records[:count, 4:7] = -greatest
    records.view(np.int32)[:count, 3] = np.arange(count)
    with np.errstate(over="ignore"):
        doubled = least + greatest
    whole = np.zeros(16, np.float32)
    for start, rows in ((0, least), (4, -greatest), (8, doubled), (12, -doubled)):
        whole[start : start + 3] = rows.min(axis=0)
    with crew(threads, count) as run:
        skeleton = _grow(run, records.reshape(-1), count, whole, BOXES)
        nodes, items = _lay_out(run, skeleton, BOXES)
    return Tree(_with_reach(nodes, whole), items, _bounds(whole))


def _nothing(blocks: FloatArray | IntArray) -> Tree:
    """A root without children."""
    nodes = np.zeros(NODE, np.float32)
    nodes[LOWER:UPPER], nodes[UPPER:CHILD] = np.inf, -np.inf
    return Tree(nodes, blocks, np.array([[np.inf] * 3, [-np.inf] * 3], np.float32))


def _with_reach(nodes: FloatArray, whole: FloatArray) -> FloatArray:
    nodes[REACH] = np.abs(_bounds(whole)).max()
    return nodes


def _bounds(whole: FloatArray) -> FloatArray:
    return np.stack([whole[0:3], -whole[4:7]])


class _Branch(NamedTuple):
    """A node near the root: its range of items, its level, and the bounds of its boxes and of their centres."""

    first: int
    items: int
    depth: int
    bounds: FloatArray


class _Skeleton(NamedTuple):
    """A binary tree: records of nodes, first children, the items in the leaves' order; and which nodes there are, by
    subtrees, those near the root last.
    """

    nodes: FloatArray
    children: IntArray
    order: IntArray
    spans: list[tuple[int, int]]


def _grow(run: Run, records: FloatArray, count: int, whole: FloatArray, kind: Kind) -> _Skeleton:
    """The binary tree over `count` records: large nodes split by all threads, the rest a subtree a thread."""
    branches, links = _split_large(run, records, count, whole, kind)
    size = len(branches) + 2 * count
    nodes, children, order = (
        np.empty(size * build.RECORD, np.float32),
        np.empty(size, np.int32),
        np.empty(count, np.int32),
    )
    children[: len(links)] = links
    rows = nodes.reshape(-1, build.RECORD)
    for node, branch in enumerate(branches):
        rows[node] = branch.bounds[:8]
        rows.view(np.int32)[node, [3, 7]] = branch.first, branch.items

    def subtree(node: int) -> tuple[int, int]:
        first, _, depth, bounds = branches[node]
        free = len(branches) + 2 * first
        return free, build.build_subtree(
            records, nodes, children, order, count, node, free, depth, kind.lanes, kind.smallest, bounds[8:]
        )

    small = [node for node, link in enumerate(links) if link == 0]
    small.sort(key=lambda node: -branches[node].items)
    spans = run(subtree, [(node,) for node in small])
    return _Skeleton(nodes, children, order, [*spans, (0, len(branches))])


def _split_large(
    run: Run, records: FloatArray, count: int, whole: FloatArray, kind: Kind
) -> tuple[list[_Branch], list[int]]:
    """Split nodes until none is larger than the grain, level by level: (nodes, first child of each or 0)."""
    branches, links = [_Branch(0, count, 0, whole)], [0]
    level = [0] if count > GRAIN else []
    while level:
        pieces = [list(ranges(*_range(branches[node], count))) for node in level]
        found = iter(_split_level(run, records, count, [branches[node] for node in level], pieces, kind))
        following = []
        for node in level:
            links[node] = len(branches)
            for branch in next(found):
                if branch.items > GRAIN:
                    following.append(len(branches))
                branches.append(branch)
                links.append(0)
        level = following
    return branches, links


def _range(branch: _Branch, count: int) -> tuple[int, int]:
    """Where a node's records lie: even levels in the first half."""
    start = branch.first + branch.depth % 2 * count
    return start, start + branch.items


def _split_level(
    run: Run,
    records: FloatArray,
    count: int,
    level: list[_Branch],
    pieces: list[list[tuple[int, int]]],
    kind: Kind,
) -> list[tuple[_Branch, _Branch]]:
    """The two children of each node of a level."""
    tables = [np.empty((len(parts), build.TABLE), np.float32) for parts in pieces]
    run(
        build.bin_range,
        [
            (records, *part, branch.bounds[8:], table[i])
            for branch, parts, table in zip(level, pieces, tables, strict=True)
            for i, part in enumerate(parts)
        ],
    )
    found = [np.empty((len(parts), 32), np.float32) for parts in pieces]
    jobs, left_counts = [], []
    for branch, parts, table, sides in zip(level, pieces, tables, found, strict=True):
        start, _ = _range(branch, count)
        counts = table.view(np.int32)[:, build.COUNTS : build.COUNTS + 3 * build.BINS].copy()
        axis, plane = build.choose_split(table.reshape(-1), len(parts), branch.depth, branch.items, kind.lanes)
        middle = 0
        if axis < 0:
            axis, plane, middle = 0, 0, start + branch.items // 2
            left = [max(min(b, middle) - a, 0) for a, b in parts]
        else:
            left = counts[:, axis * build.BINS : axis * build.BINS + plane].sum(axis=1).tolist()
        low = branch.first + (branch.depth + 1) % 2 * count
        high = low + branch.items
        for i, (a, b) in enumerate(parts):
            jobs.append((records, a, b, low, high, axis, plane, middle, branch.bounds[8:], sides[i]))
            low += left[i]
            high -= b - a - left[i]
        left_counts.append(sum(left))
    run(build.split_range, jobs)
    children = []
    for branch, sides, left_count in zip(level, found, left_counts, strict=True):
        boxes = sides.min(axis=0).reshape(4, 8)
        right_count = branch.items - left_count
        children.append(
            (
                _Branch(branch.first, left_count, branch.depth + 1, boxes[[0, 2]].reshape(-1)),
                _Branch(branch.first + left_count, right_count, branch.depth + 1, boxes[[1, 3]].reshape(-1)),
            )
        )
    return children


def _lay_out(run: Run, skeleton: _Skeleton, kind: Kind) -> tuple[FloatArray, IntArray]:
    """Nodes and slots: the wide nodes near the root, then every subtree below them by itself."""
    tree = skeleton.nodes, skeleton.children, np.empty(len(skeleton.children) * WIDTH, np.float32)
    *subtrees, near_root = [(*tree, *span, *kind.collapse) for span in skeleton.spans]
    run(build_wide.collapse_costs, subtrees)
    build_wide.collapse_costs(*near_root)
    nodes, slots = np.empty(0, np.float32), np.empty(0, np.int32)
    tasks = np.empty((8 * (MAX_DEPTH + 2) * (1 + len(skeleton.order) // GRAIN), 2), np.int64)

    def write(root: int, parent: int, number: int, block: int) -> tuple[int, int, int]:
        written: tuple[int, int, int] = build_wide.lay_out(
            *tree, skeleton.order, nodes, slots, tasks.reshape(-1), root, parent, number, block, GRAIN, *kind.collapse
        )
        return written

    number, _, task_count = write(0, -1, 0, 0)
    roots = tasks[:task_count].tolist()
    sizes = run(write, [(node, word, 0, 0) for node, word in roots])
    starts = np.cumsum([(number, 0), *((size[0], size[1]) for size in sizes)], axis=0).tolist()
    nodes = np.empty(starts[-1][0] * NODE, np.float32)
    slots = np.empty(starts[-1][1] * kind.lanes, np.int32)
    write(0, -1, 0, 0)
    run(write, [(*root, *start) for root, start in zip(roots, starts[:-1], strict=True)])
    return nodes, slots
