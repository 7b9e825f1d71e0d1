"""The entry that makes a tree of a part of a bounding interval hierarchy, when a ray comes to it (bih_layout.py).

A part's tree is a function of its triangles in their order, and each is made once, by the thread that claims it. So the
hierarchy is the same whoever comes first, and in whatever order.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from isophote.kernels.accel.bih_layout import (
    BEGIN,
    BIH,
    BLOCK_SHARE,
    BUSY,
    END,
    FINISHED,
    NODE_SHARE,
    UNTOUCHED,
    WORD,
)
from isophote.kernels.accel.build import RECORD, build_subtree, centre, write_node
from isophote.kernels.accel.build_wide import collapse_costs, lay_out
from isophote.kernels.accel.layout import BLOCK, CHILD, LANES, LOWER, NODE, NUMBER, UPPER, WIDTH
from isophote.kernels.accel.triangle_box import AHEAD, Triangles, box_of, expect_triangle
from isophote.kernels.base.atomic import claim, load_acquire, store_release
from isophote.kernels.base.entry import call_entry, entry, opener_at
from isophote.kernels.base.jit import device, kernel
from isophote.kernels.base.simd import (
    load8,
    load_float,
    load_int,
    minimum,
    splat4,
    splat8,
    store4,
    store8,
    store_float,
    store_int,
)

__all__ = ["finish_all", "finish_part"]

open_bih = opener_at(BIH)

_INFINITY, _MISSING, _NOBODY = np.float32(np.inf), np.float32(np.nan), np.int32(-1)
_ZERO_FLOAT = np.float32(0)
_AHEAD = np.int64(AHEAD)
_UNTOUCHED, _BUSY, _FINISHED = np.int32(UNTOUCHED), np.int32(BUSY), np.int32(FINISHED)
_BLOCKS, _ONE, _ZERO = np.int64(7), np.int64(1), np.int64(0)
# As TRIANGLES in accel/tree.py: items a block, which are those of a binary leaf; of a leaf at most; and costs.
_LANES, _MOST = np.int64(LANES), np.int64(16)
_LEAF_COST, _BLOCK_COST = np.float32(0.6), np.float32(0.2)
# Levels that the tree may have above a part, where build_subtree begins to count; and one where it halves. Even:
# records lie in the first half.
_ABOVE, _HALVING = np.int64(28), np.int64(58)
# Where the root's code goes while the part's tree is made: a node before it.
_ROOT_WORD = np.int64(CHILD)


class _Tree(NamedTuple):
    """A part's tree by itself: nodes from 1 on, triangles by slots, and how many there are of both."""

    nodes: object
    slots: object
    last_node: int
    blocks: int


@device
def _write_records(tree, begin, end, records, found):
    """Records of the part's triangles, and the bounds of all, into `found`: of boxes, then of centres."""
    box = centres = splat8(_INFINITY)
    triangles, order = Triangles(tree.positions, tree.corners, tree.last_point), tree.order
    for i in range(begin, end):
        expect_triangle(triangles, np.int64(order[min(i + _AHEAD, end - 1)]))
        low, high = box_of(triangles, np.int64(order[i]))
        at = (i - begin) * RECORD
        store4(records, at, low)
        store4(records, at + 4, splat4(_ZERO_FLOAT) - high)
        store_int(records, at + 3, order[i])
        store_int(records, at + 7, np.int32(0))
        record = load8(records, at)
        box = minimum(record, box)
        centres = minimum(centre(record), centres)
    store8(found, 0, box)
    store8(found, RECORD, centres)


@device
def _grow(tree, begin, end, level, smallest):
    """The tree of a part's triangles, whose binary leaves have `smallest` at most; from level _HALVING on by halves."""
    count = end - begin
    records = np.empty(2 * count * RECORD, np.float32)
    found = np.empty(2 * RECORD, np.float32)
    nodes, children = np.empty(2 * count * RECORD, np.float32), np.empty(2 * count, np.int32)
    order, costs = np.empty(count, np.int32), np.empty(2 * count * WIDTH, np.float32)
    _write_records(tree, begin, end, records, found)
    write_node(nodes, _ZERO, load8(found, 0), _ZERO, count)
    size = build_subtree(records, nodes, children, order, count, _ZERO, _ONE, level, _LANES, smallest, found[RECORD:])
    collapse_costs(nodes, children, costs, _ZERO, size, _LANES, _MOST, _LEAF_COST, _BLOCK_COST)
    none, no_slots, tasks = np.empty(0, np.float32), np.empty(0, np.int32), np.empty(2, np.int64)
    last, blocks, _ = lay_out(
        nodes, children, costs, order, none, no_slots, tasks, _ZERO, _ROOT_WORD, _ONE, _ZERO, _ZERO, _LANES, _MOST,
        _LEAF_COST, _BLOCK_COST,
    )  # fmt: skip
    wide, slots = np.empty(last * NODE, np.float32), np.empty(blocks * LANES, np.int32)
    lay_out(
        nodes, children, costs, order, wide, slots, tasks, _ZERO, _ROOT_WORD, _ONE, _ZERO, _ZERO, _LANES, _MOST,
        _LEAF_COST, _BLOCK_COST,
    )  # fmt: skip
    return _Tree(wide, slots, last, blocks)


@device
def _moved(code, node, block):
    """A child's code where the part's node 1 is node `node` of all, and its block 0 block `block`."""
    if code >= 0:
        return code + np.int32(node - 1)
    return code - np.int32(block * (_BLOCKS + 1))


@device
def _copy_nodes(tree, part, node, block):
    """The part's nodes where they belong."""
    for number in range(1, part.last_node):
        source, target = number * NODE, (node + number - 1) * NODE
        for k in range(0, CHILD, WIDTH):
            store8(tree.nodes, target + k, load8(part.nodes, source + k))
        for k in range(WIDTH):
            code = load_int(part.nodes, source + CHILD + k)
            there = load_float(part.nodes, source + LOWER + k) <= load_float(part.nodes, source + UPPER + k)
            store_int(tree.nodes, target + CHILD + k, _moved(code, node, block) if there else np.int32(0))


@device
def _fill_blocks(tree, part, first):
    """Corners and numbers of the part's triangles, in blocks from `first` on."""
    for slot in range(part.blocks * LANES):
        base = (first + slot // LANES) * BLOCK + slot % LANES
        number = part.slots[slot]
        there = number >= 0
        triangle = np.int64(number) if there else _ZERO
        store_int(tree.blocks, base + NUMBER, number if there else _NOBODY)
        for corner in range(3):
            vertex = 3 * np.int64(tree.corners[3 * triangle + corner])
            for axis in range(3):
                value = tree.positions[vertex + axis] if there else _MISSING
                store_float(tree.blocks, base + corner * 3 * LANES + axis * LANES, value)


@device
def _finish(tree, number):
    """Make the tree of a part that is this thread's alone."""
    begin, end = tree.parts[number, BEGIN], tree.parts[number, END]
    count = end - begin
    node = tree.first_node + number + begin // NODE_SHARE
    block = number + begin // BLOCK_SHARE
    part = _grow(tree, begin, end, _ABOVE, _LANES)
    if part.last_node - 1 > count // NODE_SHARE or part.blocks > 1 + count // BLOCK_SHARE:
        # Leaves of nine triangles or more, since a half of what has more than sixteen has as many.
        part = _grow(tree, begin, end, _HALVING, _MOST)
    _copy_nodes(tree, part, node, block)
    _fill_blocks(tree, part, block)
    code = _moved(load_int(part.nodes, _ROOT_WORD), node, block)
    store_release(tree.nodes, tree.parts[number, WORD], code)


@entry
def finish_part(tables, number):
    """See that a part is finished; its code. One thread does it, others wait for it."""
    tree = open_bih(tables)
    if claim(tree.states, number, _UNTOUCHED, _BUSY):
        _finish(tree, number)
        store_release(tree.states, number, _FINISHED)
    while load_acquire(tree.states, number) != _FINISHED:
        pass
    return np.int64(load_int(tree.nodes, tree.parts[number, WORD]))


@kernel
def finish_all(tables):
    """See that all parts of the hierarchy whose tables are at an address are finished."""
    tree = open_bih(tables)
    for part in range(tree.parts.rows):
        call_entry(tree.finish, (tables, part))
