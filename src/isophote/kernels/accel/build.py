"""Binary trees over boxes by the surface area heuristic, in bins.

Wald: "On fast Construction of SAH-based Bounding Volume Hierarchies", RT 2007. What is sorted are records of eight
words, (lower x, y, z, number, -upper x, y, z, unused): one `minimum` unites two boxes, and lower - (-upper) is twice
the centre. A node of the binary tree is such a record too, with the first of its items in the place of the number
and their count in the last word; its children lie side by side, at `children[node]` (0: a leaf) and the next.

A split moves the node's records from one half of `records` to the other (even levels lie in the first half), those
of the left child upward from the start of the node's range, those of the right child downward from its end. So the
result does not depend on how the range is cut into pieces for threads.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.layout import MAX_DEPTH
from isophote.kernels.base.jit import device, kernel
from isophote.kernels.base.simd import (
    lane,
    load8,
    load_float,
    load_int,
    lowest_bit,
    minimum,
    select,
    splat8,
    store8,
    store_float,
    store_int,
    swap_triples,
    triples,
)

__all__ = [
    "BINS",
    "COUNTS",
    "RECORD",
    "TABLE",
    "bin_range",
    "build_subtree",
    "choose_split",
    "split_range",
    "triangle_records",
]

RECORD = 8
BINS = 16
# Nodes of few items take fewer bins: no worse, and a tenth of the time of a tree of a million.
_FEW_BINS = 8
_FEW = 12
# A table of bins: three axes of BINS boxes, then as many counts, then one row of areas.
COUNTS = 3 * BINS * RECORD
_AREAS = COUNTS + 3 * BINS
TABLE = _AREAS + BINS
# Deepest level of the binary tree. Where a surface area split could lead below it, nodes are halved by number.
_DEEPEST = MAX_DEPTH - 2

_INFINITY = np.float32(np.inf)
_ZERO = np.float32(0)
_X, _Y, _Z = np.int32(0), np.int32(1), np.int32(2)
# Words of a stack entry: node, level, six unused, then the bounds of the centres.
_ENTRY = 16


@device
def half_area(box):
    """Half the surface of a record's box; NaN or infinite where there is none."""
    extent = triples(box) + swap_triples(box)
    x, y, z = lane(extent, _X), lane(extent, _Y), lane(extent, _Z)
    return x * y + y * z + z * x


@device
def centre(record):
    """(c, -c) with c twice the centre of a record's box."""
    return triples(record) - swap_triples(record)


@device
def bin_scale(centres, bins):
    """Bins a unit of length on each axis: zero where all centres are one, from the bounds of (c, -c)."""
    extent = splat8(_ZERO) - (centres + swap_triples(centres))
    return select(extent > splat8(_ZERO), splat8(np.float32(bins)) / extent, splat8(_ZERO))


@device
def clear_bins(table, bins):
    """Empty boxes and no counts."""
    for axis in range(3):
        for k in range(axis * BINS, axis * BINS + bins):
            store8(table, k * RECORD, splat8(_INFINITY))
            store_int(table, COUNTS + k, np.int32(0))


@device
def _into_bin(table, k, record):
    store8(table, k * RECORD, minimum(load8(table, k * RECORD), record))
    store_int(table, COUNTS + k, load_int(table, COUNTS + k) + np.int32(1))


@device
def _bin_record(records, i, centres, scale, last, table):
    record = load8(records, i * RECORD)
    # The order of the operands turns a NaN, from an infinite extent, into the last bin.
    place = minimum((centre(record) - centres) * scale, splat8(last))
    _into_bin(table, np.int64(lane(place, _X)), record)
    _into_bin(table, BINS + np.int64(lane(place, _Y)), record)
    _into_bin(table, 2 * BINS + np.int64(lane(place, _Z)), record)


@device
def fill_bins(records, begin, end, centres, table, bins):
    """Unite the boxes of records `begin` to `end` into the bins of their centres.

    Neighbours in a mesh fall into the same bins, where each would wait for the one before; so two runs take turns.
    """
    scale = bin_scale(centres, bins)
    last = np.float32(bins - 1)
    half = (end - begin) // 2
    for i in range(begin, begin + half):
        _bin_record(records, i, centres, scale, last, table)
        _bin_record(records, i + half, centres, scale, last, table)
    if begin + 2 * half < end:
        _bin_record(records, end - 1, centres, scale, last, table)


@device
def _shift(lanes):
    return np.int64(lowest_bit(np.int32(lanes)))


@device
def best_split(table, bins, shift):
    """(axis, bins left of the plane) of least cost: areas times blocks of 2^`shift` items; (-1, 0) if none."""
    rounding = (np.int64(1) << shift) - 1
    least, best_axis, best_plane = _INFINITY, -1, 0
    for axis in range(3):
        row = axis * BINS
        box = splat8(_INFINITY)
        count = np.int64(0)
        for plane in range(bins - 1, 0, -1):
            box = minimum(box, load8(table, (row + plane) * RECORD))
            count += np.int64(load_int(table, COUNTS + row + plane))
            blocks = (count + rounding) >> shift
            store_float(table, _AREAS + plane, half_area(box) * np.float32(blocks))
        box = splat8(_INFINITY)
        count = np.int64(0)
        for plane in range(1, bins):
            box = minimum(box, load8(table, (row + plane - 1) * RECORD))
            count += np.int64(load_int(table, COUNTS + row + plane - 1))
            blocks = (count + rounding) >> shift
            # An empty side costs infinity times zero, which is not less than anything.
            cost = half_area(box) * np.float32(blocks) + load_float(table, _AREAS + plane)
            if cost < least:
                least, best_axis, best_plane = cost, axis, plane
    return best_axis, best_plane


@device
def too_deep(depth, count):
    """Whether a node must be halved, so that no leaf lies below the deepest level."""
    room = _DEEPEST - 1 - depth
    return room < 40 and count > (np.int64(1) << max(room, 0))


@device
def move_records(records, begin, end, target_left, target_right, axis, plane, middle, centres_scratch, bins, found):
    """Move records `begin` to `end` to their sides; leave the boxes and centre bounds of both sides in `found`.

    Left go those whose bin on `axis` is below `plane` and those before `middle`; they are written upward from
    `target_left`, the others downward from `target_right` - 1. `found` takes four vectors: left box, right box,
    left centres, right centres. Returns the ends of what was written.
    """
    centres = load8(centres_scratch, 0)
    scale = bin_scale(centres, bins)
    last = np.float32(bins - 1)
    store8(found, 0, scale)
    unit = load_float(found, axis)
    origin = load_float(centres_scratch, axis)
    bound = np.float32(plane)
    nothing = splat8(_INFINITY)
    limit = splat8(bound)
    left_box = right_box = left_centres = right_centres = nothing
    for i in range(begin, end):
        record = load8(records, i * RECORD)
        both = centre(record)
        place = (load_float(records, i * RECORD + axis) - load_float(records, i * RECORD + 4 + axis) - origin) * unit
        place = place if place < last else last
        if i < middle:
            place = np.float32(-1)
        goes_left = place < bound
        mask = splat8(place) < limit
        left_box = minimum(select(mask, record, nothing), left_box)
        right_box = minimum(select(mask, nothing, record), right_box)
        left_centres = minimum(select(mask, both, nothing), left_centres)
        right_centres = minimum(select(mask, nothing, both), right_centres)
        one = np.int64(goes_left)
        target_right -= 1 - one
        store8(records, (target_left if goes_left else target_right) * RECORD, record)
        target_left += one
    store8(found, 0, left_box)
    store8(found, 8, right_box)
    store8(found, 16, left_centres)
    store8(found, 24, right_centres)
    return target_left, target_right


@device
def write_node(nodes, node, box, first, count):
    """A node of the binary tree: its box and its range of items."""
    store8(nodes, node * RECORD, box)
    store_int(nodes, node * RECORD + 3, np.int32(first))
    store_int(nodes, node * RECORD + 7, np.int32(count))


@kernel
def triangle_records(positions, triangles, records, begin, end, found):
    """Records of triangles `begin` to `end`; leave their box and the bounds of their centres in `found`."""
    box = centres = splat8(_INFINITY)
    for i in range(begin, end):
        at = i * RECORD
        a, b, c = 3 * triangles[3 * i], 3 * triangles[3 * i + 1], 3 * triangles[3 * i + 2]
        for k in range(3):
            x, y, z = positions[a + k], positions[b + k], positions[c + k]
            store_float(records, at + k, min(x, min(y, z)))
            store_float(records, at + 4 + k, -max(x, max(y, z)))
        store_int(records, at + 3, np.int32(i))
        store_int(records, at + 7, np.int32(0))
        record = load8(records, at)
        box = minimum(record, box)
        centres = minimum(centre(record), centres)
    store8(found, 0, box)
    store8(found, 8, centres)


@kernel
def bin_range(records, begin, end, centres, table):
    """Bins of records `begin` to `end`, for a part of a large node."""
    clear_bins(table, BINS)
    fill_bins(records, begin, end, load8(centres, 0), table, BINS)


@kernel
def choose_split(tables, parts, depth, node_count, lanes):
    """Unite `parts` tables of bins into the first; the best split (axis, plane) of a node, (-1, 0): halve it."""
    for part in range(1, parts):
        start = part * TABLE
        for k in range(3 * BINS):
            at = k * RECORD
            store8(tables, at, minimum(load8(tables, at), load8(tables, start + at)))
            count = load_int(tables, COUNTS + k) + load_int(tables, start + COUNTS + k)
            store_int(tables, COUNTS + k, count)
    if too_deep(depth, node_count):
        return -1, 0
    return best_split(tables, BINS, _shift(lanes))


@kernel
def split_range(records, begin, end, target_left, target_right, axis, plane, middle, centres, found):
    """`move_records` for a part of a large node."""
    return move_records(records, begin, end, target_left, target_right, axis, plane, middle, centres, BINS, found)


@kernel
def build_subtree(records, nodes, children, order, item_count, root, free, depth, lanes, largest, centres):
    """Build the binary tree below node `root`, whose box and range are there, into nodes from `free` on.

    `records` holds two halves of `item_count` records; a block holds `lanes` items, a power of two. Leaves have
    `largest` items at most, and `order` takes the numbers of all items. Returns the number after the last node.
    """
    stack = np.empty(_ENTRY * (_DEEPEST + 4), np.float32)
    table = np.empty(TABLE, np.float32)
    found = np.empty(32, np.float32)
    store_int(stack, 0, np.int32(root))
    store_int(stack, 1, np.int32(depth))
    store8(stack, 8, load8(centres, 0))
    shift = _shift(lanes)
    top = _ENTRY
    while top > 0:
        top -= _ENTRY
        node = np.int64(load_int(stack, top))
        level = np.int64(load_int(stack, top + 1))
        first = np.int64(load_int(nodes, node * RECORD + 3))
        count = np.int64(load_int(nodes, node * RECORD + 7))
        start = first + (level & 1) * item_count
        if count <= largest:
            children[node] = 0
            for i in range(count):
                order[first + i] = load_int(records, (start + i) * RECORD + 3)
            continue
        bounds = load8(stack, top + 8)
        store8(found, 0, bounds)
        bins = _FEW_BINS if count <= _FEW else BINS
        axis, plane, middle = -1, 0, np.int64(0)
        if not too_deep(level, count):
            clear_bins(table, bins)
            fill_bins(records, start, start + count, bounds, table, bins)
            axis, plane = best_split(table, bins, shift)
        if axis < 0:
            axis, plane, middle = 0, 0, start + count // 2
        target = first + (1 - (level & 1)) * item_count
        store8(table, 0, bounds)
        end, _ = move_records(
            records, start, start + count, target, target + count, axis, plane, middle, table, bins, found
        )
        left_count = end - target
        write_node(nodes, free, load8(found, 0), first, left_count)
        write_node(nodes, free + 1, load8(found, 8), first + left_count, count - left_count)
        children[node] = free
        for child in (1, 0):
            store_int(stack, top, np.int32(free + child))
            store_int(stack, top + 1, np.int32(level + 1))
            store8(stack, top + 8, load8(found, 16 + 8 * child))
            top += _ENTRY
        free += 2
    return free
