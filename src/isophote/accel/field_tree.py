"""Trees of regions over a field's tape, built on all cores: what they are is told in kernels/accel/field_layout.py."""

from __future__ import annotations

import itertools
from concurrent.futures import ThreadPoolExecutor
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.kernels.accel.field_build import AMBIGUOUS, PARENT, open_cells, split_regions
from isophote.kernels.accel.field_layout import CHILDREN, EMPTY, FIRST_TAPE, NODE
from isophote.kernels.forms.opcodes import INPUTS, ROW
from isophote.kernels.forms.tape_interval import REGION_SLOT
from isophote.machine import processors

__all__ = ["FieldTree", "build_field_tree", "warm_field_trees"]

Ints: TypeAlias = npt.NDArray[np.int32]
Longs: TypeAlias = npt.NDArray[np.int64]
Floats: TypeAlias = npt.NDArray[np.float32]

# A region is split while its tape is longer than this and the tree is not deeper than so many levels of nodes.
_SHORT = 12
_LEVELS = 3
# Tapes that are still so long on the last level are split once more.
_LONG = 96
# Rows of tapes (32 bytes each) and nodes (512 bytes) that a tree may hold, and the rows that one job may write.
_MOST_ROWS = 1 << 22
_MOST_NODES = 1 << 17
_JOB_ROWS = 1 << 18
# Empty regions get tapes of their own, too, for rays that ask for values there, where these have no more rows than
# this; otherwise they keep their parent's.
_EVERY_ROWS = 1 << 21
# Regions that stay whole are looked at in cells where their tapes have no more rows than this together.
_FINE_ROWS = 1 << 19
# What is proven of a region holds this far beyond it, in parts of the largest coordinate: more than the rounding of
# positions and of the walk through the regions.
_MARGIN = 2.0**-19


class FieldTree(NamedTuple):
    """`root` code, `nodes` and `tapes` of one field, with `rows` (n, ROW); `tapes[0]` is the whole field's; `levels` of
    nodes. Node 0 is none; `finer[0]` is that of the root."""

    root: int
    nodes: Ints
    finer: Longs
    tapes: Ints
    rows: Ints
    levels: int


class _Level(NamedTuple):
    """Regions to be split: numbers of their tapes, and their places along the axes."""

    tapes: Ints
    places: Ints


class _Split(NamedTuple):
    """What a job found: states and tapes of children, with the tapes and their rows counted from 0."""

    states: Ints
    child_tapes: Ints
    rows: Ints
    tapes: Ints


class _Store:
    """Tapes as they are found, equal ones once."""

    def __init__(self, rows: Ints) -> None:
        self._chunks = [rows]
        self._tables = [np.array([[0, len(rows)]], np.int32)]
        self._known = {rows.tobytes(): 0}
        self.rows, self.tapes = len(rows), 1

    def add(self, rows: Ints, tapes: Ints) -> Ints:
        """Keep tapes whose rows are counted from 0; their numbers here."""
        numbers = np.empty(len(tapes), np.int32)
        for k, (first, count) in enumerate(tapes.tolist()):
            own = rows[first : first + count]
            number = self._known.setdefault(own.tobytes(), self.tapes)
            if number == self.tapes:
                self._chunks.append(own)
                self._tables.append(np.array([[self.rows, count]], np.int32))
                self.rows += count
                self.tapes += 1
            numbers[k] = number
        return numbers

    def all_rows(self) -> Ints:
        self._chunks = [np.concatenate(self._chunks)]
        return self._chunks[0]

    def all_tapes(self) -> Ints:
        self._tables = [np.concatenate(self._tables)]
        return self._tables[0]


def build_field_tree(rows: Ints, data: Longs, low: Floats, side: float, threads: int | None = None) -> FieldTree:
    """The tree over the cube from `low`, (3,) float32, of edge length `side`, for a tape's `rows` (n, ROW).

    The tape's Lipschitz constants must hold in the cube and a little beyond. `data` are the words of its tables. The
    same bits come out for any number of `threads`. It holds 2²² rows and 2¹⁷ nodes at most: where more would be needed,
    regions stay larger and tapes longer.
    """
    store = _Store(rows)
    reach = float(max(np.abs(low).max(), np.abs(low.astype(np.float64) + side).max()))
    margin = np.float32(_MARGIN * reach)
    level = _Level(np.zeros(1, np.int32), np.zeros((1, 3), np.int32))
    unused, first = np.zeros((1, NODE), np.int32), np.zeros((1, CHILDREN), np.int64)
    nodes, finer = [unused], [first]
    first_node, depth = 1, 0
    with ThreadPoolExecutor(threads or processors()) as executor:
        if len(rows) <= _SHORT:
            first[0, 0] = _open_cells(executor, store, data, level, (low, np.float32(side / 4), margin))[0]
            return FieldTree(FIRST_TAPE, unused.reshape(-1), first.reshape(-1), store.all_tapes(), rows, 0)
        above, at = first, np.array([0])
        while len(level.tapes):
            width = np.float32(side / 4 ** (depth + 1))
            every = CHILDREN * int(store.all_tapes()[level.tapes, 1].sum()) <= _EVERY_ROWS and depth < _LEVELS - 1
            codes, tapes = _split_level(executor, store, data, level, (low, width, margin, every))
            depth += 1
            first_node += len(level.tapes)
            chosen = _chosen(store, codes, tapes, depth, first_node)
            kept = _children(level, tapes, (codes == AMBIGUOUS) & ~chosen)
            cells = np.zeros((len(codes), CHILDREN), np.int64)
            cells[(codes == AMBIGUOUS) & ~chosen] = _open_cells(
                executor, store, data, kept, (low, np.float32(width / 4), margin)
            )
            above.reshape(-1)[at] = _bits(codes != EMPTY)
            above, at = cells, np.flatnonzero(chosen)
            following = _children(level, tapes, chosen)
            node_codes = np.where(codes == AMBIGUOUS, FIRST_TAPE - tapes, codes)
            node_codes[chosen] = first_node + np.arange(len(following.tapes))
            nodes.append(np.concatenate([node_codes, tapes], axis=1).astype(np.int32))
            finer.append(cells)
            level = following
    return FieldTree(
        1, np.concatenate(nodes).reshape(-1), np.concatenate(finer).reshape(-1), store.all_tapes(), store.all_rows(),
        depth
    )  # fmt: skip


def _bits(cells: npt.NDArray[np.bool_]) -> Longs:
    """(n, 64) truth values as bits of n numbers."""
    return np.packbits(cells, axis=1, bitorder="little").view("<i8").reshape(-1).astype(np.int64, copy=False)


def _open_cells(
    executor: ThreadPoolExecutor, store: _Store, data: Longs, regions: _Level, frame: tuple[Any, ...]
) -> Longs:
    """`finer` of regions that stay whole; `frame`: the tree's corner, the width of a cell, and the margin."""
    rows, tapes = store.all_rows().reshape(-1), np.ascontiguousarray(store.all_tapes()[regions.tapes])
    cells = np.full(len(tapes), -1, np.int64)
    if int(tapes[:, 1].sum()) > _FINE_ROWS:
        return cells
    longest = int(tapes[:, 1].max(initial=0))

    def look(job: tuple[int, int]) -> None:
        slots, choices = np.zeros((INPUTS + longest) * REGION_SLOT, np.float32), np.zeros(longest + 1, np.int32)
        open_cells(rows, data, tapes, regions.places, *frame, *job, cells, slots, choices)

    list(executor.map(look, _jobs(tapes[:, 1])))
    return cells


def warm_field_trees() -> None:
    """Compile what builds trees: no regions need no tape."""
    none, places = np.zeros((0, 2), np.int32), np.zeros((0, 3), np.int32)
    frame = (np.zeros(3, np.float32), np.float32(1), np.float32(0), False)
    _split(np.zeros(0, np.int32), np.zeros(3, np.int64), none, places, frame, 0, 0)


def _chosen(store: _Store, states: Ints, tapes: Ints, depth: int, nodes: int) -> npt.NDArray[np.bool_]:
    """Which children are split in their turn, where the tree has so many nodes already."""
    if depth > _LEVELS:
        return np.zeros(states.shape, bool)
    lengths = store.all_tapes()[tapes, 1]
    wanted = (states == AMBIGUOUS) & (lengths > (_SHORT if depth < _LEVELS else _LONG))
    chosen: npt.NDArray[np.bool_] = wanted & (nodes + np.cumsum(wanted).reshape(wanted.shape) <= _MOST_NODES)
    return chosen


def _children(level: _Level, tapes: Ints, chosen: npt.NDArray[np.bool_]) -> _Level:
    parent, child = np.nonzero(chosen)
    offset = np.stack([child & 3, (child >> 2) & 3, child >> 4], axis=1)
    return _Level(tapes[chosen], (level.places[parent] * 4 + offset).astype(np.int32))


def _split_level(
    executor: ThreadPoolExecutor, store: _Store, data: Longs, level: _Level, frame: tuple[Any, ...]
) -> tuple[Ints, Ints]:
    """States of all children of a level's regions, (n, 64), and the numbers of their tapes."""
    rows = store.all_rows().reshape(-1)
    tapes = np.ascontiguousarray(store.all_tapes()[level.tapes])

    def split(job: tuple[int, int]) -> _Split:
        return _split(rows, data, tapes, level.places, frame, *job)

    jobs, states, numbers = _jobs(tapes[:, 1]), [], []
    for (first, last), found in zip(jobs, executor.map(split, jobs), strict=True):
        own = np.broadcast_to(level.tapes[first:last, None], found.states.shape)
        states.append(found.states)
        if store.rows + len(found.rows) <= _MOST_ROWS:
            here = np.append(store.add(found.rows, found.tapes), np.int32(0))
            # PARENT is −1, the last of these.
            numbers.append(np.where(found.child_tapes == PARENT, own, here[found.child_tapes]))
        else:
            numbers.append(own)
    return np.concatenate(states), np.concatenate(numbers).astype(np.int32)


def _jobs(lengths: Ints) -> list[tuple[int, int]]:
    """Runs of regions whose children have about so many rows at most; it does not depend on the threads."""
    number = CHILDREN * np.cumsum(lengths, dtype=np.int64) // _JOB_ROWS
    ends = np.flatnonzero(np.diff(number)) + 1
    return list(itertools.pairwise([0, *ends.tolist(), len(lengths)]))


def _split(
    rows: Ints,
    data: Longs,
    tapes: Ints,
    places: Ints,
    frame: tuple[Any, ...],
    first: int,
    last: int,
) -> _Split:
    count, longest = last - first, int(tapes[first:last, 1].max(initial=0))
    states, child_tapes = np.empty((count, CHILDREN), np.int32), np.empty((count, CHILDREN), np.int32)
    out = np.empty(CHILDREN * int(tapes[first:last, 1].sum() + 1) * ROW, np.int32)
    out_tapes = np.empty((CHILDREN * count, 2), np.int32)
    slots = np.zeros((INPUTS + longest) * REGION_SLOT, np.float32)
    marks, choices = np.zeros(INPUTS + longest, np.int32), np.zeros(longest + 1, np.int32)
    written, found = split_regions(
        rows,
        data,
        tapes[first:last],
        places[first:last],
        *frame,
        0,
        count,
        states,
        child_tapes,
        out,
        out_tapes,
        slots,
        choices,
        marks,
    )
    return _Split(states, child_tapes, out[: written * ROW].reshape(-1, ROW).copy(), out_tapes[:found].copy())
