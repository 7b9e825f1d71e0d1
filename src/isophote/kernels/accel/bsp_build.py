"""A BSP tree from parts of triangles, depth first; parts on both sides of a plane are cut by it.

The parts of the node in hand lie at the top of `arena`, those of nodes that wait below them. Every part holds all that
lies in the node of its triangle, so leaves miss nothing, however cells are rounded (bsp_cell.py).
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.bsp_cell import CELL, CELL_WORK, cell_area, cut_cell, start_cell
from isophote.kernels.accel.bsp_layout import LEAF, PLANE, SHIFT, SLANTED, TOLERANCE
from isophote.kernels.accel.bsp_planes import MOST_DIRECTIONS, MOST_PICKED, PROFILE, best_plane, no_plane
from isophote.kernels.accel.bsp_polygon import MOST_CORNERS, cut_box, cut_polygon, extent_along, is_boxed
from isophote.kernels.accel.kd_sweep import leaf_cost
from isophote.kernels.base.jit import device, kernel
from isophote.kernels.base.simd import store_float, store_int

__all__ = ["PART", "TASK", "grow", "root_cell", "whole_parts"]

# Float64 words of a whole triangle as a part (bsp_planes.py).
PART = 11
# A node that waits: number, first word of its parts, words of them, parts, level, references that its leaves may hold.
TASK = 6
_NODE, _FIRST, _WORDS, _PARTS, _LEVEL, _BUDGET = 0, 1, 2, 3, 4, 5
_LOWER_SIDE, _UPPER_SIDE, _BOTH = 1, 2, 3


@kernel
def whole_parts(positions, triangles, parts, begin, end):
    """Triangles begin ≤ i < end as parts, PART words each."""
    for triangle in range(begin, end):
        at = PART * triangle
        parts[at], parts[at + 1] = triangle, 3
        for corner in range(3):
            vertex = 3 * np.int64(triangles[3 * triangle + corner])
            for k in range(3):
                parts[at + 2 + 3 * corner + k] = positions[vertex + k]


@kernel
def root_cell(cells, box):
    """Make the first cell a box."""
    start_cell(cells, 0, box)


@device
def _side(low, high, tolerance, planar_low):
    """On which sides of a plane a part from height `low` to `high` is."""
    if high <= tolerance:
        return _LOWER_SIDE if low < -tolerance or planar_low else _UPPER_SIDE
    return _UPPER_SIDE if low >= -tolerance else _BOTH


@device
def _parts_of_side(arena, first, count, choice, side, tolerance, target, to):
    """Write what is on one side of a plane to `target`, from word `to` on; returns how many parts these are, and the
    word after them."""
    at, kept = first, np.int64(0)
    sign = 1.0 if side == _LOWER_SIDE else -1.0
    for _ in range(count):
        corners = np.int64(arena[at + 1])
        low, high = extent_along(choice.plane, arena, at + 2, corners)
        on = _side(low, high, tolerance, choice.planar_low)
        if on & side != 0:
            left = np.int64(0)
            if on == _BOTH and not is_boxed(arena, at + 2, corners):
                left = cut_polygon(choice.plane, sign, arena, at + 2, corners, target, to + 2)
            elif on == _BOTH and choice.plane.kind < SLANTED:
                left = cut_box(choice.plane, sign, arena, at + 2, target, to + 2)
            # Too many corners, or a box cut askew: the part stays as it is, which is more than is needed.
            if left == 0 or left > MOST_CORNERS:
                left = corners
                for k in range(3 * corners):
                    target[to + 2 + k] = arena[at + 2 + k]
            target[to], target[to + 1] = arena[at], left
            to += 2 + 3 * left
            kept += 1
        at += 2 + 3 * corners
    return kept, to


@device
def _write_leaf(nodes, leaves, used, node, arena, first, count):
    """A leaf; returns the references used so far. Until all leaves are there, its first word is that of its first
    reference."""
    store_int(nodes, 2 * node, np.int32(used))
    store_int(nodes, 2 * node + 1, np.int32((count << SHIFT) + LEAF))
    at = first
    for i in range(count):
        leaves[used + i] = np.int32(arena[at])
        at += 2 + 3 * np.int64(arena[at + 1])
    return used + count


@device
def _write_inner(nodes, planes, used, node, plane):
    """An inner node, whose children are next; a slanted plane goes to `planes`."""
    store_int(nodes, 2 * node + 1, np.int32((used[0] << SHIFT) + plane.kind))
    used[0] += 2
    if plane.kind != SLANTED:
        store_float(nodes, 2 * node, np.float32(plane.place))
        return
    store_int(nodes, 2 * node, np.int32(used[2]))
    at = PLANE * used[2]
    planes[at], planes[at + 1], planes[at + 2] = np.float32(plane.x), np.float32(plane.y), np.float32(plane.z)
    planes[at + 3] = np.float32(plane.place)
    used[2] += 1


@device
def _share(budget, own, other):
    """A child's part of the references that are to spare."""
    spare = budget - own - other
    return own + np.int64(np.float64(spare) * (np.float64(own) / np.float64(max(own + other, 1))))


@device
def _push(tasks, k, node, first, words, parts, level, budget):
    tasks[k, _NODE], tasks[k, _FIRST], tasks[k, _WORDS] = node, first, words
    tasks[k, _PARTS], tasks[k, _LEVEL], tasks[k, _BUDGET] = parts, level, budget


@device
def _park(tasks, top, cells, arena, parked, waiting, waiting_cells, used):
    """Put a node, its cell and its parts aside."""
    row, first = used[4], tasks[top, _FIRST]
    for k in range(TASK):
        waiting[row, k] = tasks[top, k]
    waiting[row, _FIRST] = used[3]
    for k in range(CELL):
        waiting_cells[row, k] = cells[top * CELL + k]
    for k in range(tasks[top, _WORDS]):
        parked[used[3] + k] = arena[first + k]
    used[3] += tasks[top, _WORDS]
    used[4] += 1


@kernel
def grow(
    positions, triangles, reach, arena, tasks, cells, nodes, areas, planes, leaves, used,
    parked, waiting, waiting_cells, grain, deepest,
):  # fmt: skip
    """Grow the node that is tasks[0] with the cell at word 0 of `cells` until all below it is leaves.

    Its parts lie from word 0 of `arena` on. `nodes`, and the `areas` of their cells, are written from
    number used[0] on, references of leaves from used[1] on, `planes` from number used[2] on. Where
    `grain` > 0, nodes of at most so many parts are not split, but become rows of `waiting` and `waiting_cells`, their
    parts put to `parked`, while there is room. Leaves `used`: nodes, references, planes, words of parked parts, waiting
    nodes.
    """
    beside, cell, work = np.empty(arena.size, np.float64), np.empty(CELL, np.float64), np.empty(CELL_WORK, np.float64)
    scratch = (
        np.empty(MOST_PICKED, np.int64),
        np.empty((MOST_DIRECTIONS, 3), np.float64),
        np.empty(2 * MOST_PICKED, np.uint64),
        np.empty(PROFILE, np.float64),
        work,
        np.empty(1, np.float32),
    )
    tolerance = TOLERANCE * reach
    top = 1
    while top > 0:
        top -= 1
        node, first, words, count = tasks[top, _NODE], tasks[top, _FIRST], tasks[top, _WORDS], tasks[top, _PARTS]
        level, budget = tasks[top, _LEVEL], tasks[top, _BUDGET]
        if grain > 0 and count <= grain and used[3] + words <= parked.size and used[4] < waiting.shape[0]:
            _park(tasks, top, cells, arena, parked, waiting, waiting_cells, used)
            continue
        areas[node] = cell_area(cells, top * CELL)
        # Two sides have at most twice the words, and three more for each part that is cut, to either side.
        fits = first + 2 * words + 6 * count <= arena.size and 2 * (used[0] + 2) <= nodes.size
        split, upper, lower, middle, end = False, np.int64(0), np.int64(0), np.int64(0), np.int64(0)
        choice = no_plane()
        if level < deepest and fits and count > 0:
            choice = best_plane(positions, triangles, arena, first, count, cells, top * CELL, reach, scratch)
        if choice.cost < leaf_cost(count):
            # The upper side first: the lower one's parts come to lie above, and it is next.
            for side in (_UPPER_SIDE, _LOWER_SIDE):
                upper, middle = lower, end
                lower, end = _parts_of_side(arena, first, count, choice, side, tolerance, beside, middle)
            split = lower + upper <= budget
        if not split:
            used[1] = _write_leaf(nodes, leaves, used[1], node, arena, first, count)
            continue
        for k in range(end):
            arena[first + k] = beside[k]
        for k in range(CELL):
            cell[k] = cells[top * CELL + k]
        for half in range(2):
            cut_cell(cell, 0, choice.plane, 1.0 if half == 1 else -1.0, cells, (top + half) * CELL, work)
        child = used[0]
        _write_inner(nodes, planes, used, node, choice.plane)
        _push(tasks, top, child + 1, first, middle, upper, level + 1, _share(budget, upper, lower))
        _push(tasks, top + 1, child, first + middle, end - middle, lower, level + 1, _share(budget, lower, upper))
        top += 2
