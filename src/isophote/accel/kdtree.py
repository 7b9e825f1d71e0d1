"""kd-trees of triangles, built on all cores: what they are is told in kernels/accel/kd_layout.py."""

from __future__ import annotations

import math
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.accel.accelerator import Accelerator, Built, blocks_of, padded_slots
from isophote.accel.crew import Run, crew, ranges
from isophote.accel.treelets import CHILDREN, MISSING, PLANES, treelets_of
from isophote.kernels.accel.kd_build import TASK, grow, triangle_events
from isophote.kernels.accel.kd_entry import any_in_kd, closest_in_kd, things_in_kd
from isophote.kernels.accel.kd_layout import ACROSS_Z, AXES, CODES, COMMON, KD, LEAF, NODE, PRESENT, TREELET
from isophote.kernels.accel.layout import LANES

__all__ = ["KDTREE"]

FloatArray: TypeAlias = npt.NDArray[np.float32]
IntArray: TypeAlias = npt.NDArray[np.int32]
Keys: TypeAlias = npt.NDArray[np.uint64]
Rows: TypeAlias = npt.NDArray[np.int64]

# Nodes of so many triangles or fewer are a subtree for one thread. Fixed: it must not depend on the number of threads.
_SUBTREE = 1 << 14
# References to triangles that leaves may hold, and nodes, for each triangle.
_MOST_REFERENCES = 8
_MOST_NODES = 8


class _Subtree(NamedTuple):
    """Nodes, of which the first is the root and the second none, areas of their boxes, and references of leaves; and
    what was left waiting: tasks, their boxes and events."""

    nodes: IntArray
    areas: FloatArray
    references: IntArray
    waiting: Rows
    boxes: FloatArray
    parked: Keys


def _build(positions: FloatArray, triangles: IntArray, threads: int | None) -> Built:
    count = len(triangles)
    corners = positions[triangles.reshape(-1)]
    bounds = np.stack([corners.min(axis=0, initial=np.inf), corners.max(axis=0, initial=-np.inf)]).astype(np.float32)
    if count == 0:
        table = _table(np.array([[0, LEAF]], np.int32), np.zeros(1, np.float32), np.zeros((2, 3), np.float32))
        return Built(table, np.empty(0, np.float32), bounds)
    flat = positions.reshape(-1), triangles.reshape(-1)
    with crew(threads, count) as run:
        events, counts = _events(run, flat, count)
        deepest = 8 + int(1.3 * math.log2(count))
        task = np.array([0, 0, *counts, count, 0, _MOST_REFERENCES * count + LANES], np.int64)
        top = _grow(flat, events, task, bounds.reshape(-1), _SUBTREE if count > _SUBTREE else 0, deepest)
        del events

        def subtree(number: int) -> _Subtree:
            task = top.waiting[number].copy()
            first, total = task[1], task[2:5].sum()
            task[:2] = 0
            return _grow(flat, top.parked[first : first + total], task, top.boxes[number], 0, deepest)

        parts = run(subtree, [(number,) for number in range(len(top.waiting))])
    nodes, areas, references = _joined(top, parts)
    slots = _into_blocks(nodes, references)
    return Built(_table(nodes, areas, bounds), blocks_of(positions, triangles, slots, threads), bounds)


def _table(nodes: IntArray, areas: FloatArray, bounds: FloatArray) -> Any:
    """The table of a tree of such nodes."""
    kinds = nodes[:, 1] & 3
    child = np.where(kinds == LEAF, MISSING, nodes[:, 1] >> 2).astype(np.int32)
    tree = treelets_of(child, areas, nodes[:, 0], nodes[:, 1] >> 2)
    there = tree.planes != MISSING
    words = np.zeros((len(tree.planes), TREELET), np.int32)
    words[:, :PLANES] = np.where(there, nodes[tree.planes, 0], np.float32(np.inf).view(np.int32))
    axes = np.where(there, kinds[tree.planes], 0)
    bit = 1 << np.arange(CHILDREN)
    words[:, AXES] = COMMON | ((axes == 1) @ bit[:PLANES]) | (((axes == 2) @ bit[:PLANES]) << ACROSS_Z)
    words[:, AXES] |= (tree.present @ bit) << PRESENT
    words[:, CODES:] = tree.codes
    return KD.pack(
        nodes=words.view(np.float32).reshape(-1),
        leaves=tree.leaves.reshape(-1),
        bounds=np.ascontiguousarray(bounds.reshape(-1)),
        reach=float(np.abs(bounds).max()),
    )


def _events(run: Run, flat: tuple[FloatArray, IntArray], count: int) -> tuple[Keys, list[int]]:
    """All triangles' events, those of each axis sorted, one axis after another; how many each axis has."""
    rows = np.empty(6 * count, np.uint64)
    pieces = list(ranges(0, count))
    found = np.zeros((len(pieces), 3), np.int64)
    run(triangle_events, [(*flat, rows, found[i], *piece) for i, piece in enumerate(pieces)])

    def gather(axis: int) -> Keys:
        own = rows[2 * count * axis : 2 * count * (axis + 1)]
        keys = np.concatenate([own[2 * p[0] : 2 * p[0] + n] for p, n in zip(pieces, found[:, axis], strict=True)])
        keys.sort()
        return keys

    keys = run(gather, [(axis,) for axis in range(3)])
    return np.concatenate(keys), [len(part) for part in keys]


def _grow(
    flat: tuple[FloatArray, IntArray], events: Keys, task: Rows, box: FloatArray, grain: int, deepest: int
) -> _Subtree:
    """The subtree of a task, whose events are all of `events`; with a grain, as far as nodes are larger than that."""
    count, budget = int(task[5]), int(task[7])
    arena = np.empty(max(6 * budget, len(events)), np.uint64)
    arena[: len(events)] = events
    tasks, boxes = np.zeros((deepest + 8, TASK), np.int64), np.zeros((deepest + 8, 6), np.float32)
    tasks[0], boxes[0] = task, box
    tasks[0, 0] = 0
    nodes = np.empty((_MOST_NODES * count + 16) * NODE, np.float32)
    nodes.view(np.int32)[: 2 * NODE] = [0, LEAF, 0, LEAF]
    areas = np.zeros(len(nodes) // NODE, np.float32)
    references = np.empty(budget, np.int32)
    used = np.array([2, 0, 0, 0], np.int64)
    most = budget if grain else 0
    parked = np.empty(6 * most, np.uint64)
    waiting, waiting_boxes = np.empty((most, TASK), np.int64), np.empty((most, 6), np.float32)
    grow(*flat, arena, tasks, boxes, nodes, areas, references, used, parked, waiting, waiting_boxes, grain, deepest)
    return _Subtree(
        nodes[: used[0] * NODE].view(np.int32).reshape(-1, NODE).copy(),
        areas[: used[0]].copy(),
        references[: used[1]].copy(),
        waiting[: used[3]].copy(),
        waiting_boxes[: used[3]].copy(),
        parked[: used[2]].copy(),
    )


def _joined(top: _Subtree, parts: list[_Subtree]) -> tuple[IntArray, FloatArray, IntArray]:
    """The whole tree's nodes, areas and references: those near the root, then every subtree's."""
    nodes, areas, references = [top.nodes], [top.areas], [top.references]
    node, reference = len(top.nodes), len(top.references)
    for root, part in zip(top.waiting[:, 0].tolist(), parts, strict=True):
        own = part.nodes
        leaf = (own[:, 1] & 3) == LEAF
        own[leaf, 0] += reference
        own[~leaf, 1] += 4 * (node - 2)
        top.nodes[root], top.areas[root] = own[0], part.areas[0]
        nodes.append(own[2:])
        areas.append(part.areas[2:])
        references.append(part.references)
        node += len(own) - 2
        reference += len(part.references)
    return np.concatenate(nodes), np.concatenate(areas), np.concatenate(references)


def _into_blocks(nodes: IntArray, references: IntArray) -> IntArray:
    """Slots of blocks that hold the references of each leaf; the leaves' first words become the numbers of their first
    blocks."""
    leaves = np.flatnonzero((nodes[:, 1] & 3) == LEAF)
    leaves = leaves[np.argsort(nodes[leaves, 0], kind="stable")]
    nodes[leaves, 0], slots = padded_slots(nodes[leaves, 1] >> 2, references)
    return slots


KDTREE = Accelerator("kdtree", _build, closest_in_kd, any_in_kd, things_in_kd)
