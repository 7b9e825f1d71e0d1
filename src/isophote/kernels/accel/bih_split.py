"""Nodes of a bounding interval hierarchy, split when somebody comes to them; memory as in bih_layout.py.

A node's split is a function of its row of `ranges` and of its triangles as they stand, and each node is split once, by
the thread that claims it. So the hierarchy is the same whoever comes first, and in whatever order.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.bih_layout import (
    BEGIN,
    BIH,
    BUSY,
    CELLS,
    END,
    LEAF,
    MOST_GRID_LEVELS,
    NODE,
    PLANES,
    RANGE,
    REGION,
    SLAB,
    SLAB_AXIS,
    WAITING,
)
from isophote.kernels.accel.build import RECORD, centre
from isophote.kernels.accel.layout import BLOCK, LANES, NUMBER
from isophote.kernels.base.atomic import claim, load_acquire, store_release
from isophote.kernels.base.entry import call_entry, entry, floats_at, opener_at
from isophote.kernels.base.jit import device, kernel
from isophote.kernels.base.long_words import highest_bit
from isophote.kernels.base.simd import load8, load_float, load_int, minimum, splat8, store8, store_float, store_int

__all__ = ["split_all", "split_node"]

open_bih = opener_at(BIH)

_INFINITY, _MISSING = np.float32(np.inf), np.float32(np.nan)
_WAITING, _BUSY, _LEAF = np.int32(WAITING), np.int32(BUSY), np.int64(LEAF)
_LANES, _LAST_CELL = np.int64(LANES), np.float64(CELLS - 1)
_MOST_BLOCK_WORDS = np.int64(1) << np.int64(40)
_NO_AXIS, _ONE = np.int64(-1), np.int64(1)
# Triangles beside a cut among which those are sought that go to its other side.
_WINDOW = np.int64(4096)


@device
def _place(records, i, axis):
    """Twice the centre of a triangle's box on an axis."""
    return load_float(records, i * RECORD + axis) - load_float(records, i * RECORD + 4 + axis)


@device
def _cell(place, origin, scale):
    """The cell of the grid that a place lies in."""
    return np.int64(min(max((np.float64(place) - origin) * scale, 0.0), _LAST_CELL))


@device
def _choose(tree, row):
    """(axis, cell): the range's longest axis on which its centres lie in several cells, and the first cell beyond the
    plane near the middle between them; the axis is −1 where there is none.

    Planes are those of grids over everything whose cells are 2ᵏ wide: of the one with at least four to the range."""
    ranges, scale = tree.ranges, tree.grid[0, 3]
    best, longest, plane = _NO_AXIS, np.float64(-1), np.int64(0)
    for axis in range(3):
        low, high = load_float(ranges, row + axis), -load_float(ranges, row + 4 + axis)
        extent = np.float64(high) - np.float64(low)
        first, last = _cell(low, tree.grid[0, axis], scale), _cell(high, tree.grid[0, axis], scale)
        if first < last and extent > longest:
            bit = highest_bit(max((last - first) >> 2, _ONE))
            middle = (first + last + 1 + (_ONE << bit)) >> 1
            best, longest, plane = np.int64(axis), extent, (middle >> bit) << bit
    return best, plane


@device
def _exchange(records, i, j):
    record = load8(records, i * RECORD)
    store8(records, i * RECORD, load8(records, j * RECORD))
    store8(records, j * RECORD, record)


@device
def _partition(tree, begin, end, axis, plane):
    """Bring the triangles whose cell lies before `plane` to the front; the place where the others begin."""
    records, origin, scale = tree.records, tree.grid[0, axis], tree.grid[0, 3]
    i, j = begin, end
    while i < j:
        if _cell(_place(records, i, axis), origin, scale) < plane:
            i += 1
        else:
            j -= 1
            _exchange(records, i, j)
    return i


@device
def _to_block(records, begin, end, cut, axis):
    """A place for the cut near `cut`, at a multiple of LANES within the range. Triangles that change sides are those
    nearest to the other one."""
    last = (end - 1) // _LANES * _LANES
    target = min(max((cut + _LANES // 2) // _LANES * _LANES, begin + _LANES), last)
    while cut < target:
        best = cut
        for i in range(cut + 1, min(cut + _WINDOW, end)):
            if _place(records, i, axis) < _place(records, best, axis):
                best = i
        _exchange(records, best, cut)
        cut += 1
    while cut > target:
        cut -= 1
        best = cut
        for i in range(max(cut - _WINDOW, begin), cut):
            if _place(records, i, axis) > _place(records, best, axis):
                best = i
        _exchange(records, best, cut)
    return target


@device
def _add_side(tree, parent, node, begin, end, axis, upper):
    """Make a child of a split on an axis: its row of `ranges` and its slab; the coordinate where it ends on that axis,
    or, if it is the upper one, begins."""
    records, ranges = tree.records, tree.ranges
    box = centres = splat8(_INFINITY)
    for i in range(begin, end):
        record = load8(records, i * RECORD)
        box = minimum(record, box)
        centres = minimum(centre(record), centres)
    row = node * RANGE
    store8(ranges, row, box)
    store8(ranges, row + REGION, load8(ranges, parent * RANGE + REGION))
    face = axis if upper else axis + 4
    plane = load_float(ranges, row + face)
    store_float(ranges, row + REGION + face, plane)
    _write_slab(tree, node, row)
    store8(ranges, row, centres)
    store_int(ranges, row + BEGIN, np.int32(begin))
    store_int(ranges, row + END, np.int32(end))
    return plane if upper else -plane


@device
def _write_slab(tree, node, row):
    """Choose the axis on which a node's region shrinks most to its box, which is in the first words of its row."""
    ranges, nodes = tree.ranges, tree.nodes
    best, most = np.int64(0), np.float32(-1)
    for axis in range(3):
        region = row + REGION + axis
        spare = (load_float(ranges, row + axis) - load_float(ranges, region)) + (
            load_float(ranges, row + 4 + axis) - load_float(ranges, region + 4)
        )
        if spare > most:
            best, most = np.int64(axis), spare
    low, high = load_float(ranges, row + best), load_float(ranges, row + 4 + best)
    store_float(ranges, row + REGION + best, low)
    store_float(ranges, row + REGION + 4 + best, high)
    store_float(nodes, node * NODE + SLAB, low)
    store_float(nodes, node * NODE + SLAB + 1, -high)
    store_int(nodes, node * NODE + SLAB_AXIS, np.int32(best))


@device
def _fill_block(tree, blocks, begin, end):
    """The block of a leaf's triangles."""
    block = begin // _LANES
    for lane in range(LANES):
        base = block * BLOCK + lane
        there = begin + lane < end
        triangle = np.int64(load_int(tree.records, (begin + lane) * RECORD + 3)) if there else np.int64(0)
        store_int(blocks, base + NUMBER, np.int32(triangle) if there else np.int32(-1))
        for corner in range(3):
            vertex = 3 * np.int64(tree.corners[3 * triangle + corner])
            for axis in range(3):
                value = tree.positions[vertex + axis] if there else _MISSING
                store_float(blocks, base + corner * 12 + axis * 4, value)
    return block


@device
def _split(tree, blocks, node, level):
    """Split a node that is this thread's alone; its code."""
    row = node * RANGE
    begin, end = np.int64(load_int(tree.ranges, row + BEGIN)), np.int64(load_int(tree.ranges, row + END))
    if end - begin <= LANES:
        return np.int32((_fill_block(tree, blocks, begin, end) + 1) * 4 + _LEAF)
    axis, plane = _choose(tree, row)
    if axis < 0 or level >= MOST_GRID_LEVELS:
        axis = np.int64(0)
        cut = ((begin + end) // 2 + _LANES // 2) // _LANES * _LANES
    else:
        cut = _to_block(tree.records, begin, end, _partition(tree, begin, end, axis, plane), axis)
    number = cut // _LANES
    lower_end = _add_side(tree, node, 2 * number, begin, cut, axis, False)
    upper_begin = _add_side(tree, node, 2 * number + 1, cut, end, axis, True)
    store_float(tree.nodes, node * NODE + PLANES, lower_end)
    store_float(tree.nodes, node * NODE + PLANES + 1, upper_begin)
    return np.int32((number + 1) * 4 + axis)


@entry
def split_node(tables, blocks, node, level):
    """See that a node at a level is split; its code. One thread splits, others wait for it."""
    tree = open_bih(tables)
    nodes, word = tree.nodes, node * NODE
    if claim(nodes, word, _WAITING, _BUSY):
        code = _split(tree, floats_at(blocks, _MOST_BLOCK_WORDS), node, level)
        store_release(nodes, word, code)
        return np.int64(code)
    code = load_acquire(nodes, word)
    while code == _BUSY:
        code = load_acquire(nodes, word)
    return np.int64(code)


@kernel
def split_all(tables, blocks, waiting):
    """Split the root and all below it. `tables` and `blocks` are addresses; `waiting` (k, 2) int64 takes the nodes that
    wait, with their levels: one for each level."""
    split = open_bih(tables).split
    waiting[0, 0], waiting[0, 1] = 0, 0
    top = 1
    while top > 0:
        top -= 1
        node, level = waiting[top, 0], waiting[top, 1]
        code = call_entry(split, (tables, blocks, node, level))
        if (code & _LEAF) != _LEAF:
            for side in range(2):
                waiting[top, 0], waiting[top, 1] = 2 * ((code >> 2) - 1) + side, level + 1
                top += 1
