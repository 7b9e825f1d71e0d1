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
from isophote.kernels.accel.kd_sweep import BOTH, LOWER_SIDE, UPPER_SIDE, best_split, box_area, classify, leaf_cost
from isophote.kernels.base.jit import device, kernel
from isophote.kernels.base.simd import store_float, store_int

__all__ = ["TASK", "grow", "triangle_events"]

# A node that waits: number, first event, events on x, y, z, triangles, level, references that its leaves may hold.
TASK = 8
_NODE, _FIRST, _COUNTS, _TRIANGLES, _LEVEL, _BUDGET = 0, 1, 2, 5, 6, 7
# Runs of events up to this length are sorted by insertion.
_SHORT = 24


@kernel
def triangle_events(positions, triangles, events, counts, begin, end):
    """Events of whole triangles begin ≤ i < end: at most 2 · (end − begin) an axis in the three parts of `events`, from
    2 · `begin` on; how many go to `counts` (3,). `events` (6 n,) uint64."""
    word = np.empty(1, np.float32)
    part = events.size // 3
    for axis in range(3):
        first = axis * part + 2 * begin
        at = first
        for triangle in range(begin, end):
            a = positions[3 * np.int64(triangles[3 * triangle]) + axis]
            b = positions[3 * np.int64(triangles[3 * triangle + 1]) + axis]
            c = positions[3 * np.int64(triangles[3 * triangle + 2]) + axis]
            low, high = min(a, min(b, c)), max(a, max(b, c))
            at = _add_events(events, at, low, high, triangle, word)
        counts[axis] = at - first


@device
def _add_events(events, at, low, high, triangle, word):
    if low == high:
        events[at] = event(low, PLANAR, triangle, word)
        return at + 1
    events[at] = event(low, START, triangle, word)
    events[at + 1] = event(high, END, triangle, word)
    return at + 2


@device
def _sift(keys, begin, root, count):
    """Let the key at a heap's `root` sink to its place."""
    key = keys[begin + root]
    while 2 * root + 1 < count:
        child = 2 * root + 1
        if child + 1 < count and keys[begin + child] < keys[begin + child + 1]:
            child += 1
        if keys[begin + child] <= key:
            break
        keys[begin + root] = keys[begin + child]
        root = child
    keys[begin + root] = key


@device
def _sort(keys, begin, count):
    """Sort `count` keys from `begin` on: short runs, mostly."""
    if count <= _SHORT:
        for i in range(begin + 1, begin + count):
            key = keys[i]
            j = i
            while j > begin and keys[j - 1] > key:
                keys[j] = keys[j - 1]
                j -= 1
            keys[j] = key
        return
    for root in range(count // 2 - 1, -1, -1):
        _sift(keys, begin, root, count)
    for last in range(count - 1, 0, -1):
        keys[begin], keys[begin + last] = keys[begin + last], keys[begin]
        _sift(keys, begin, 0, last)


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
    """Events of the triangles on both sides that reach into a box, sorted, in the three parts of `cut`; returns how
    many triangles these are. `events` from `begin` on, `count` of them, name each such triangle once by START or
    PLANAR."""
    kept, part = np.int64(0), cut.size // 3
    ends = np.int64(0), np.int64(part), np.int64(2 * part)
    end_x, end_y, end_z = ends
    for i in range(begin, begin + count):
        triangle = event_triangle(events[i])
        if sides[triangle] != BOTH or event_kind(events[i]) == END:
            continue
        if clip_extent(positions, triangles, triangle, box, work, extent):
            kept += 1
            end_x = _add_events(cut, end_x, extent[0], extent[3], triangle, word)
            end_y = _add_events(cut, end_y, extent[1], extent[4], triangle, word)
            end_z = _add_events(cut, end_z, extent[2], extent[5], triangle, word)
    counts[0], counts[1], counts[2] = end_x, end_y - part, end_z - 2 * part
    for axis in range(3):
        _sort(cut, axis * part, counts[axis])
    return kept


@device
def _merge_side(events, begin, end, sides, side, cut, k, cut_end, target, at):
    """Events of one side, and those of triangles cut to it, k ≤ c < `cut_end`, in order, to `target` from `at` on;
    returns their end."""
    for i in range(begin, end):
        key = events[i]
        if sides[event_triangle(key)] != side:
            continue
        while k < cut_end and cut[k] < key:
            target[at] = cut[k]
            at += 1
            k += 1
        target[at] = key
        at += 1
    for i in range(k, cut_end):
        target[at] = cut[i]
        at += 1
    return at


@device
def _one_side(events, begin, given, axis, straddling, sides, side, cut, counts, target, at):
    """A child's events, from word `at` of `target` on, and how many on each axis in `counts`, which holds those that
    were cut; `given` are those of its parent. Returns the number of its triangles."""
    own, part = straddling, cut.size // 3
    for k in range(3):
        end = begin + given[k]
        if k == axis:
            for i in range(begin, end):
                own += sides[event_triangle(events[i])] == side and event_kind(events[i]) != END
        after = _merge_side(events, begin, end, sides, side, cut, k * part, k * part + counts[k], target, at)
        counts[k] = after - at
        at, begin = after, end
    return own


@device
def _share(budget, own, other):
    """A child's part of the references that are to spare."""
    spare = budget - own - other
    return own + np.int64(np.float64(spare) * (np.float64(own) / np.float64(max(own + other, 1))))


@device
def _push(tasks, boxes, k, node, first, counts, triangles, level, budget, box):
    tasks[k, _NODE], tasks[k, _FIRST], tasks[k, _TRIANGLES] = node, first, triangles
    tasks[k, _LEVEL], tasks[k, _BUDGET] = level, budget
    for axis in range(3):
        tasks[k, _COUNTS + axis] = counts[axis]
    for word in range(6):
        boxes[k, word] = box[word]


@device
def _park(tasks, boxes, top, arena, parked, waiting, waiting_boxes, used):
    """Put a node and its events aside."""
    row, first = used[3], tasks[top, _FIRST]
    total = tasks[top, _COUNTS] + tasks[top, _COUNTS + 1] + tasks[top, _COUNTS + 2]
    for k in range(TASK):
        waiting[row, k] = tasks[top, k]
    for k in range(6):
        waiting_boxes[row, k] = boxes[top, k]
    waiting[row, _FIRST] = used[2]
    for i in range(total):
        parked[used[2] + i] = arena[first + i]
    used[2] += total
    used[3] += 1


@kernel
def grow(
    positions,
    triangles,
    arena,
    tasks,
    boxes,
    nodes,
    areas,
    leaves,
    used,
    parked,
    waiting,
    waiting_boxes,
    grain,
    deepest,
):
    """Grow the node that is tasks[0] with the box boxes[0] until all below it is leaves.

    Its events lie from word 0 of `arena` on. `nodes`, and the `areas` of their boxes, are written from number
    used[0] on, references of leaves from used[1] on. Where `grain` > 0, nodes of at most so many triangles are not
    split, but become rows of `waiting` and `waiting_boxes`, their events put to `parked`. Leaves `used`: nodes,
    references, parked events, waiting nodes.
    """
    most = tasks[0, _BUDGET]
    sides = np.empty(triangles.size // 3, np.uint8)
    beside, cut = np.empty(6 * most, np.uint64), np.empty(6 * most, np.uint64)
    work, extent, word = np.empty(CLIP_WORDS, np.float64), np.empty(6, np.float32), np.empty(1, np.float32)
    box, given, counts = np.empty(6, np.float32), np.empty(3, np.int64), np.empty(3, np.int64)
    top = 1
    while top > 0:
        top -= 1
        count = tasks[top, _TRIANGLES]
        if grain > 0 and count <= grain:
            _park(tasks, boxes, top, arena, parked, waiting, waiting_boxes, used)
            continue
        node, first, level, budget = tasks[top, _NODE], tasks[top, _FIRST], tasks[top, _LEVEL], tasks[top, _BUDGET]
        for k in range(6):
            box[k] = boxes[top, k]
        for k in range(3):
            given[k] = tasks[top, _COUNTS + k]
        areas[node] = box_area(box)
        split = best_split(arena, first, given, count, box)
        fits = split.lower + split.upper <= budget and 2 * (used[0] + 2) <= nodes.size
        if level >= deepest or not fits or not split.cost < leaf_cost(count):
            used[1] = _write_leaf(nodes, leaves, used[1], node, arena, first, given[0], count)
            continue
        sweep = classify(arena, first, given, split, sides)
        child = used[0]
        used[0] += 2
        store_float(nodes, 2 * node, np.float32(split.place))
        store_int(nodes, 2 * node + 1, np.int32(child * 4 + split.axis))
        at = np.int64(0)
        # The upper side first: the lower one's events come to lie above, and it is next.
        for half in range(2):
            upper = half == 0
            side = UPPER_SIDE if upper else LOWER_SIDE
            face = split.axis + (0 if upper else 3)
            kept, box[face] = box[face], np.float32(split.place)
            straddling = _cut_events(
                positions, triangles, arena, sweep, given[split.axis], sides, box, work, extent, word, cut, counts
            )
            own = _one_side(arena, first, given, split.axis, straddling, sides, side, cut, counts, beside, at)
            number = child + (1 if upper else 0)
            _push(tasks, boxes, top, number, first + at, counts, own, level + 1, budget, box)
            box[face] = kept
            at += counts[0] + counts[1] + counts[2]
            top += 1
        for i in range(at):
            arena[first + i] = beside[i]
        lower, upper = tasks[top - 1, _TRIANGLES], tasks[top - 2, _TRIANGLES]
        tasks[top - 1, _BUDGET], tasks[top - 2, _BUDGET] = _share(budget, lower, upper), _share(budget, upper, lower)
