"""From a binary tree to nodes of eight children in layout.py's memory, by the cheapest cut.

`costs[node]` holds in word j (1 to 7) the least cost of the items below a node when they hang on j children of a wide
node: the dynamic programme of Ylitie, Karras, Laine: "Efficient Incoherent Ray Traversal on GPUs Through Compressed
Wide BVHs", HPG 2017, section 3. It decides which binary nodes become wide ones, which vanish, and which become leaves.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.build import RECORD, half_area
from isophote.kernels.accel.layout import BLOCK, CHILD, LOWER, MAX_DEPTH, NODE, NUMBER, UPPER, WIDTH
from isophote.kernels.base.jit import device, kernel
from isophote.kernels.base.simd import load8, load_float, load_int, store_float, store_int

__all__ = ["collapse_costs", "fill_blocks", "lay_out"]

_INFINITY = np.float32(np.inf)
_MISSING = np.float32(np.nan)


@device
def _leaf_cost(nodes, node, lanes, most, leaf_cost, block_cost):
    """Cost of a node as one leaf; infinite where it has more than `most` items."""
    count = np.int64(load_int(nodes, node * RECORD + 7))
    if count > most:
        return _INFINITY
    blocks = np.float32((count + (lanes - 1)) // lanes)
    return half_area(load8(nodes, node * RECORD)) * (leaf_cost + block_cost * blocks)


@device
def _best_share(costs, left, slots):
    """(cost, children for the left side) of the best share of `slots` children between nodes `left`, `left` + 1."""
    least, best = _INFINITY, np.int64(1)
    for k in range(1, slots):
        cost = load_float(costs, left * WIDTH + k) + load_float(costs, (left + 1) * WIDTH + slots - k)
        if cost < least:
            least, best = cost, np.int64(k)
    return least, best


@kernel
def collapse_costs(nodes, children, costs, begin, end, lanes, most, leaf_cost, block_cost):
    """Costs of nodes `end` - 1 down to `begin`; those of their children must be there, or lie in the range."""
    for node in range(end - 1, begin - 1, -1):
        as_leaf = _leaf_cost(nodes, node, lanes, most, leaf_cost, block_cost)
        left = np.int64(children[node])
        cost = as_leaf
        if left != 0:
            below, _ = _best_share(costs, left, WIDTH)
            cost = min(as_leaf, half_area(load8(nodes, node * RECORD)) + below)
        for slots in range(1, WIDTH):
            if slots > 1 and left != 0:
                below, _ = _best_share(costs, left, slots)
                cost = min(cost, below)
            store_float(costs, node * WIDTH + slots, cost)


@device
def _is_leaf(nodes, children, costs, node, lanes, most, leaf_cost, block_cost):
    if children[node] == 0:
        return True
    as_leaf = _leaf_cost(nodes, node, lanes, most, leaf_cost, block_cost)
    return as_leaf < _INFINITY and as_leaf <= load_float(costs, node * WIDTH + 1)


@device
def _cut(children, costs, node, work, chosen):
    """Leave in `chosen` the binary nodes that become the children of wide node `node`; return their number."""
    if children[node] == 0:
        chosen[0] = node
        return np.int64(1)
    count, top = np.int64(0), 0
    work[0], work[1] = node, WIDTH
    while top >= 0:
        part, slots = work[2 * top], work[2 * top + 1]
        top -= 1
        left = np.int64(children[part])
        if left == 0:
            slots = 1
        if slots < WIDTH:
            while slots > 1 and load_float(costs, part * WIDTH + slots - 1) <= load_float(costs, part * WIDTH + slots):
                slots -= 1
        if slots == 1:
            chosen[count] = part
            count += 1
            continue
        _, share = _best_share(costs, left, slots)
        work[2 * top + 2], work[2 * top + 3] = left + 1, slots - share
        work[2 * top + 4], work[2 * top + 5] = left, share
        top += 2
    return count


@device
def _write_child(wide, base, k, nodes, node):
    for axis in range(3):
        store_float(wide, base + LOWER + axis * WIDTH + k, load_float(nodes, node * RECORD + axis))
        store_float(wide, base + UPPER + axis * WIDTH + k, -load_float(nodes, node * RECORD + 4 + axis))


@device
def _clear_node(wide, base):
    for k in range(UPPER):
        store_float(wide, base + LOWER + k, _INFINITY)
        store_float(wide, base + UPPER + k, -_INFINITY)
    for k in range(CHILD, NODE):
        store_int(wide, base + k, np.int32(0))


@device
def _write_leaf(nodes, node, order, slots, block, lanes):
    """Copy a leaf's item numbers to its slots, -1 into the last block's free ones; return its number of blocks."""
    first = np.int64(load_int(nodes, node * RECORD + 3))
    count = np.int64(load_int(nodes, node * RECORD + 7))
    blocks = (count + (lanes - 1)) // lanes
    if slots.size > 0:
        for k in range(blocks * lanes):
            slots[block * lanes + k] = order[first + k] if k < count else np.int32(-1)
    return blocks


@kernel
def lay_out(
    nodes, children, costs, order, wide, slots, tasks, root, parent, number, block, grain, lanes, most, leaf_cost,
    block_cost,
):  # fmt: skip
    """Write the wide tree of binary node `root`, depth first, from wide node `number` and block `block` on.

    The root's code goes to word `parent` of `wide`; without a parent (-1) the root becomes a wide node even if it is
    a leaf. Where the root has a parent, everything below is written. Otherwise children with `grain` items or
    fewer are not: `tasks` takes (node, word for its code) of each. With empty `wide` and `slots` everything is
    counted and nothing written. Returns (next wide node, next block, tasks).
    """
    writing = wide.size > 0
    pending = np.empty(2 * (WIDTH - 1) * (MAX_DEPTH + 4), np.int64)
    work = np.empty(4 * WIDTH, np.int64)
    chosen = np.empty(WIDTH, np.int64)
    task_count = 0
    pending[0], pending[1] = root, parent
    top = 2
    while top > 0:
        top -= 2
        node, word = pending[top], pending[top + 1]
        if word >= 0 and _is_leaf(nodes, children, costs, node, lanes, most, leaf_cost, block_cost):
            blocks = _write_leaf(nodes, node, order, slots, block, lanes)
            if writing:
                store_int(wide, word, np.int32(-1 - (block * 8 + blocks)))
            block += blocks
            continue
        base = number * NODE
        number += 1
        if writing:
            _clear_node(wide, base)
            if word >= 0:
                store_int(wide, word, np.int32(number - 1))
        count = _cut(children, costs, node, work, chosen)
        for k in range(count - 1, -1, -1):
            child = chosen[k]
            if writing:
                _write_child(wide, base, k, nodes, child)
            if parent < 0 and load_int(nodes, child * RECORD + 7) <= grain:
                tasks[2 * task_count], tasks[2 * task_count + 1] = child, base + CHILD + k
                task_count += 1
            else:
                pending[top], pending[top + 1] = child, base + CHILD + k
                top += 2
    return number, block, task_count


@kernel
def fill_blocks(positions, triangles, slots, blocks, begin, end):
    """Corners and numbers of the triangles in slots `begin` to `end`."""
    for slot in range(begin, end):
        base = (slot // 4) * BLOCK + slot % 4
        triangle = np.int64(slots[slot])
        store_int(blocks, base + NUMBER, slots[slot])
        for corner in range(3):
            vertex = 3 * np.int64(triangles[3 * max(triangle, 0) + corner])
            for axis in range(3):
                value = positions[vertex + axis] if triangle >= 0 else _MISSING
                store_float(blocks, base + corner * 12 + axis * 4, value)
