"""A kd-tree from its triangles' events, depth first, with triangles cut to the nodes that they lie in.

The events of the node in hand lie at the top of `arena`, those of nodes that wait below them. A split sorts them to the
two sides in order, so nothing is sorted again but the events of triangles on both sides, which are cut to either side
("perfect splits") and merged in: Wald, Havran 2006, section 4.3.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.clip import CLIP_WORDS, clip_extent
from isophote.kernels.accel.kd_layout import (
    END,
    LEAF,
    PLANAR,
    START,
    event,
    event_kind,
    event_triangle,
)
from isophote.kernels.accel.kd_sweep import BOTH, LOWER_SIDE, UPPER_SIDE, best_split, classify, leaf_cost
from isophote.kernels.base.jit import device, kernel
from isophote.kernels.base.simd import store_float, store_int
from isophote.kernels.measure.sort_words import sort_words

__all__ = ["TASK", "grow", "triangle_events"]

# A node that waits: number, first event, events on x, y, z, triangles, level, references that its leaves may hold.
TASK = 8
_NODE, _FIRST, _COUNTS, _TRIANGLES, _LEVEL, _BUDGET = 0, 1, 2, 5, 6, 7


@kernel
def triangle_events(positions, triangles, events, counts, begin, end):
    """Events of whole triangles begin ≤ i < end: at most 2 · (end − begin) an axis in the three rows of `events`, from
    2 · `begin` on; how many go to `counts` (3,). `events` (3, 2 n) uint64."""
    word = np.empty(1, np.float32)
    for axis in range(3):
        at = 2 * begin
        for triangle in range(begin, end):
            a = positions[3 * np.int64(triangles[3 * triangle]) + axis]
            b = positions[3 * np.int64(triangles[3 * triangle + 1]) + axis]
            c = positions[3 * np.int64(triangles[3 * triangle + 2]) + axis]
            low, high = min(a, min(b, c)), max(a, max(b, c))
            at = _add_events(events[axis], at, low, high, triangle, word)
        counts[axis] = at - 2 * begin


@device
def _add_events(events, at, low, high, triangle, word):
    if low == high:
        events[at] = event(low, PLANAR, triangle, word)
        return at + 1
    events[at] = event(low, START, triangle, word)
    events[at + 1] = event(high, END, triangle, word)
    return at + 2


@device
def _write_leaf(nodes, leaves, used, node, events, begin, count_x, triangles):
    """A leaf of the triangles with events on x; returns the references used so far. Until all leaves are there, its
    first word is that of its first reference."""
    store_int(nodes, 2 * node, np.int32(used))
    store_int(nodes, 2 * node + 1, np.int32(triangles * 4 + LEAF))
    for i in range(begin, begin + count_x):
        if event_kind(events[i]) != END:
            leaves[used] = np.int32(event_triangle(events[i]))
            used += 1
    return used


@device
def _cut_events(positions, triangles, events, begin, count, sides, box, work, extent, word, cut, counts):
    """Events of the triangles on both sides that reach into a box, sorted, in the three rows of `cut`; returns how many
    triangles these are. `events` from `begin` on, `count` of them, name each such triangle once by START or PLANAR."""
    kept = 0
    counts[0] = counts[1] = counts[2] = 0
    for i in range(begin, begin + count):
        triangle = event_triangle(events[i])
        if sides[triangle] != BOTH or event_kind(events[i]) == END:
            continue
        if clip_extent(positions, triangles, triangle, box, work, extent):
            kept += 1
            for axis in range(3):
                counts[axis] = _add_events(cut[axis], counts[axis], extent[axis], extent[axis + 3], triangle, word)
    return kept


@device
def _merge_side(events, begin, end, sides, side, cut, cut_count, target, at):
    """Events of one side, and those of triangles cut to it, in order, to `target` from `at` on; returns their end."""
    k = 0
    for i in range(begin, end):
        key = events[i]
        if sides[event_triangle(key)] != side:
            continue
        while k < cut_count and cut[k] < key:
            target[at] = cut[k]
            at += 1
            k += 1
        target[at] = key
        at += 1
    while k < cut_count:
        target[at] = cut[k]
        at += 1
        k += 1
    return at


@device
def _one_side(
    positions, triangles, arena, task, split, sides, side, box, work, extent, word, cut, spare, counts, beside, at
):
    """The events of a node's child, written to `beside` from `at` on, `counts` an axis; the number of its triangles.

    `box` is the child's. Returns (triangles, end of the events).
    """
    begin = task[_FIRST]
    axis_begin = begin
    for axis in range(split.axis):
        axis_begin += task[_COUNTS + axis]
    straddling = _cut_events(
        positions, triangles, arena, axis_begin, task[_COUNTS + split.axis], sides, box, work, extent, word, cut, counts
    )
    alone = np.int64(0)
    for i in range(axis_begin, axis_begin + task[_COUNTS + split.axis]):
        alone += sides[event_triangle(arena[i])] == side and event_kind(arena[i]) != END
    for axis in range(3):
        sort_words(cut[axis], spare, counts[axis])
        end = begin + task[_COUNTS + axis]
        start = at
        at = _merge_side(arena, begin, end, sides, side, cut[axis], counts[axis], beside, at)
        counts[axis] = at - start
        begin = end
    return straddling + alone, at


@device
def _push(tasks, boxes, k, node, first, counts, triangles, level, budget, box):
    tasks[k, _NODE], tasks[k, _FIRST], tasks[k, _TRIANGLES] = node, first, triangles
    tasks[k, _LEVEL], tasks[k, _BUDGET] = level, budget
    for axis in range(3):
        tasks[k, _COUNTS + axis] = counts[axis]
    for word in range(6):
        boxes[k, word] = box[word]


@device
def _share(budget, own, other):
    """A child's part of the references that are to spare."""
    spare = budget - own - other
    return own + np.int64(np.float64(spare) * (np.float64(own) / np.float64(max(own + other, 1))))


@kernel
def grow(
    positions, triangles, arena, tasks, boxes, nodes, leaves, used, parked, waiting, waiting_boxes, grain, deepest
):
    """Grow the node that is tasks[0] with the box boxes[0] until all below it is leaves.

    Its events lie from word 0 of `arena` on. `nodes` are written from number used[0] on, references of leaves from
    used[1] on. Where `grain` > 0, nodes of at most so many triangles are not split, but become rows of `waiting` and
    `waiting_boxes`, their events put to `parked`. Leaves `used`: nodes, references, parked events, waiting nodes.
    """
    most = tasks[0, _BUDGET]
    sides = np.empty(triangles.size // 3, np.uint8)
    beside = np.empty(6 * most, np.uint64)
    cut, spare = np.empty((3, 2 * most), np.uint64), np.empty(2 * most, np.uint64)
    work, extent, word = np.empty(CLIP_WORDS, np.float64), np.empty(6, np.float32), np.empty(1, np.float32)
    task, box, low_box, high_box = (
        np.empty(TASK, np.int64),
        np.empty(6, np.float32),
        np.empty(6, np.float32),
        np.empty(6, np.float32),
    )
    low_counts, high_counts = np.empty(3, np.int64), np.empty(3, np.int64)
    top = 1
    while top > 0:
        top -= 1
        task[:] = tasks[top]
        box[:] = boxes[top]
        node, first, count = task[_NODE], task[_FIRST], task[_TRIANGLES]
        if grain > 0 and count <= grain:
            total = task[_COUNTS] + task[_COUNTS + 1] + task[_COUNTS + 2]
            waiting[used[3]] = task
            waiting[used[3], _FIRST] = used[2]
            waiting_boxes[used[3]] = box
            parked[used[2] : used[2] + total] = arena[first : first + total]
            used[2] += total
            used[3] += 1
            continue
        split = best_split(arena, first, task[_COUNTS : _COUNTS + 3], count, box)
        room = task[_LEVEL] < deepest and split.lower + split.upper <= task[_BUDGET] and 2 * (used[0] + 2) <= nodes.size
        if not (room and split.cost < leaf_cost(count)):
            used[1] = _write_leaf(nodes, leaves, used[1], node, arena, first, task[_COUNTS], count)
            continue
        classify(arena, first, task[_COUNTS : _COUNTS + 3], split, sides)
        low_box[:], high_box[:] = box, box
        low_box[split.axis + 3] = high_box[split.axis] = np.float32(split.place)
        upper, end = _one_side(
            positions, triangles, arena, task, split, sides, UPPER_SIDE, high_box, work, extent, word, cut, spare,
            high_counts, beside, 0,
        )  # fmt: skip
        lower, end = _one_side(
            positions, triangles, arena, task, split, sides, LOWER_SIDE, low_box, work, extent, word, cut, spare,
            low_counts, beside, end,
        )  # fmt: skip
        arena[first : first + end] = beside[:end]
        child = used[0]
        used[0] += 2
        store_float(nodes, 2 * node, np.float32(split.place))
        store_int(nodes, 2 * node + 1, np.int32(child * 4 + split.axis))
        level, budget = task[_LEVEL] + 1, task[_BUDGET]
        upper_events = high_counts[0] + high_counts[1] + high_counts[2]
        _push(tasks, boxes, top, child + 1, first, high_counts, upper, level, _share(budget, upper, lower), high_box)
        first += upper_events
        _push(tasks, boxes, top + 1, child, first, low_counts, lower, level, _share(budget, lower, upper), low_box)
        top += 2
