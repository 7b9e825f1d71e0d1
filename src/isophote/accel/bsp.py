"""Trees of planes in any direction, built on all cores: what they are is told in kernels/accel/bsp_layout.py."""

from __future__ import annotations

import math
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.accel.accelerator import Accelerator, Built, blocks_of, padded_slots
from isophote.accel.crew import crew, ranges
from isophote.accel.treelets import CHILDREN, MISSING, PLANES, treelets_of
from isophote.kernels.accel.bsp_build import PART, TASK, grow, root_cell, whole_parts
from isophote.kernels.accel.bsp_cell import CELL
from isophote.kernels.accel.bsp_entry import any_in_bsp, closest_in_bsp, things_in_bsp
from isophote.kernels.accel.bsp_layout import (
    BSP,
    CODES,
    COMMON,
    KINDS,
    LEAF,
    NODE,
    PLANE,
    PRESENT,
    SHIFT,
    SLANTED,
    TREELET,
)
from isophote.kernels.accel.layout import LANES

__all__ = ["BSP_TREE"]

FloatArray: TypeAlias = npt.NDArray[np.float32]
IntArray: TypeAlias = npt.NDArray[np.int32]
Doubles: TypeAlias = npt.NDArray[np.float64]
Rows: TypeAlias = npt.NDArray[np.int64]

# Nodes of so many parts or fewer are a subtree for one thread. Fixed: it must not depend on the number of threads.
_SUBTREE = 1 << 12
# References to triangles that leaves may hold, and nodes, for each triangle.
_MOST_REFERENCES = 6
_MOST_NODES = 8
# Words of parts that nodes may hold at once, for each that there is at first.
_ROOM = 5
# A flat box is widened to this share of its largest extent: areas stay positive unless all is one point.
_LEAST_EXTENT = 1e-4


class _Subtree(NamedTuple):
    """Nodes, of which the first is the root and the second none, areas of their cells, planes and references of leaves;
    and what was left waiting: tasks, their cells and parts."""

    nodes: IntArray
    areas: FloatArray
    planes: FloatArray
    references: IntArray
    waiting: Rows
    cells: Doubles
    parked: Doubles


def _build(positions: FloatArray, triangles: IntArray, threads: int | None) -> Built:
    count = len(triangles)
    corners = positions[triangles.reshape(-1)]
    bounds = np.stack([corners.min(axis=0, initial=np.inf), corners.max(axis=0, initial=-np.inf)]).astype(np.float32)
    if count == 0:
        none = np.zeros((0, PLANE), np.float32)
        table = _table(np.array([[0, LEAF]], np.int32), np.zeros(1, np.float32), none, np.zeros((2, 3), np.float32))
        return Built(table, np.empty(0, np.float32), bounds)
    flat = positions.reshape(-1), triangles.reshape(-1), float(np.abs(bounds).max())
    with crew(threads, count) as run:
        parts = np.empty(PART * count)
        run(whole_parts, [(*flat[:2], parts, *piece) for piece in ranges(0, count)])
        deepest = 8 + int(1.3 * math.log2(count))
        task = np.array([0, 0, len(parts), count, 0, _MOST_REFERENCES * count + LANES], np.int64)
        top = _grow(flat, parts, task, _root(bounds), _SUBTREE if count > _SUBTREE else 0, deepest)
        del parts

        def subtree(number: int) -> _Subtree:
            task = top.waiting[number].copy()
            first, words = task[1:3]
            task[:2] = 0
            return _grow(flat, top.parked[first : first + words], task, top.cells[number], 0, deepest)

        below = run(subtree, [(number,) for number in range(len(top.waiting))])
    nodes, areas, planes, references = _joined(top, below)
    slots = _into_blocks(nodes, references)
    return Built(_table(nodes, areas, planes, bounds), blocks_of(positions, triangles, slots, threads), bounds)


def _table(nodes: IntArray, areas: FloatArray, planes: FloatArray, bounds: FloatArray) -> Any:
    """The table of a tree of such nodes and (n, PLANE) slanted planes."""
    kinds = nodes[:, 1] & KINDS
    child = np.where(kinds == LEAF, MISSING, nodes[:, 1] >> SHIFT).astype(np.int32)
    tree = treelets_of(child, areas, nodes[:, 0], nodes[:, 1] >> SHIFT)
    there, missing = tree.planes != MISSING, [0, 0, 0, np.inf]
    words = np.zeros((len(tree.planes), TREELET), np.float32)
    rows = np.where(there[..., None], _planes_of(nodes, planes)[tree.planes], missing)
    words[:, : 4 * CHILDREN].reshape(-1, 4, CHILDREN)[:, :, :PLANES] = rows.transpose(0, 2, 1)
    words.view(np.int32)[:, PRESENT] = COMMON | (tree.present @ (1 << np.arange(CHILDREN)))
    words.view(np.int32)[:, CODES:] = tree.codes
    return BSP.pack(
        nodes=words.reshape(-1),
        leaves=tree.leaves.reshape(-1),
        bounds=np.ascontiguousarray(bounds.reshape(-1)),
        reach=float(np.abs(bounds).max()),
    )


def _planes_of(nodes: IntArray, planes: FloatArray) -> FloatArray:
    """The planes (n, PLANE) of nodes; anything for leaves."""
    kinds = nodes[:, 1] & KINDS
    found = np.concatenate([np.eye(3, dtype=np.float32)[np.minimum(kinds, 2)], nodes[:, :1].view(np.float32)], axis=1)
    slanted = kinds == SLANTED
    found[slanted] = planes[nodes[slanted, 0]]
    return found


def _root(bounds: FloatArray) -> Doubles:
    """The cell that is the whole box."""
    box = bounds.astype(np.float64)
    extent = box[1] - box[0]
    missing = np.maximum(_LEAST_EXTENT * extent.max() - extent, 0.0)
    cell = np.zeros(CELL)
    root_cell(cell, (box + np.outer((-0.5, 0.5), missing)).reshape(-1))
    return cell


def _grow(
    flat: tuple[FloatArray, IntArray, float], parts: Doubles, task: Rows, cell: Doubles, grain: int, deepest: int
) -> _Subtree:
    """The subtree of a task, whose parts are all of `parts`; with a grain, as far as nodes are larger than that."""
    count, budget = int(task[3]), int(task[5])
    arena = np.empty(_ROOM * len(parts) + 64)
    arena[: len(parts)] = parts
    tasks, cells = np.zeros((deepest + 8, TASK), np.int64), np.empty((deepest + 8) * CELL)
    tasks[0], cells[:CELL] = task, cell
    most = _MOST_NODES * count + 16
    nodes, areas = np.empty(most * NODE, np.float32), np.zeros(most, np.float32)
    planes = np.empty(most // 2 * PLANE, np.float32)
    nodes.view(np.int32)[: 2 * NODE] = [0, LEAF, 0, LEAF]
    references = np.empty(budget, np.int32)
    used = np.array([2, 0, 0, 0, 0], np.int64)
    parked = np.empty(2 * len(arena) if grain else 0)
    waiting = np.empty((64 * (count // grain) + 64 if grain else 0, TASK), np.int64)
    waiting_cells = np.empty((len(waiting), CELL))
    grow(
        *flat,
        arena,
        tasks,
        cells,
        nodes,
        areas,
        planes,
        references,
        used,
        parked,
        waiting,
        waiting_cells,
        grain,
        deepest,
    )
    return _Subtree(
        nodes[: used[0] * NODE].view(np.int32).reshape(-1, NODE).copy(),
        areas[: used[0]].copy(),
        planes[: used[2] * PLANE].copy(),
        references[: used[1]].copy(),
        waiting[: used[4]].copy(),
        waiting_cells[: used[4]].copy(),
        parked[: used[3]].copy(),
    )


def _joined(top: _Subtree, below: list[_Subtree]) -> tuple[IntArray, FloatArray, FloatArray, IntArray]:
    """The whole tree's nodes, areas, planes and references: those near the root, then every subtree's."""
    nodes, areas, planes, references = [top.nodes], [top.areas], [top.planes], [top.references]
    node, plane, reference = len(top.nodes), len(top.planes) // PLANE, len(top.references)
    for root, part in zip(top.waiting[:, 0].tolist(), below, strict=True):
        own = part.nodes
        kinds = own[:, 1] & KINDS
        own[kinds == LEAF, 0] += reference
        own[kinds == SLANTED, 0] += plane
        own[kinds != LEAF, 1] += (node - 2) << SHIFT
        top.nodes[root], top.areas[root] = own[0], part.areas[0]
        nodes.append(own[2:])
        areas.append(part.areas[2:])
        planes.append(part.planes)
        references.append(part.references)
        node += len(own) - 2
        plane += len(part.planes) // PLANE
        reference += len(part.references)
    joined = np.concatenate(planes).reshape(-1, PLANE)
    return np.concatenate(nodes), np.concatenate(areas), joined, np.concatenate(references)


def _into_blocks(nodes: IntArray, references: IntArray) -> IntArray:
    """Slots of blocks that hold the references of each leaf; the leaves' first words become the numbers of their first
    blocks."""
    leaves = np.flatnonzero((nodes[:, 1] & KINDS) == LEAF)
    leaves = leaves[np.argsort(nodes[leaves, 0], kind="stable")]
    nodes[leaves, 0], slots = padded_slots(nodes[leaves, 1] >> SHIFT, references)
    return slots


BSP_TREE = Accelerator("bsp", _build, closest_in_bsp, any_in_bsp, things_in_bsp)
