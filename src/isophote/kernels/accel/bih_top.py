"""The upper part of a bounding interval hierarchy: intervals over boxes, in build.py's binary nodes."""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.build import RECORD, centre, too_deep, write_node
from isophote.kernels.base.jit import device, kernel
from isophote.kernels.base.simd import load8, load_float, load_int, minimum, splat8, store8

__all__ = ["interval_nodes"]

_INFINITY, _TWO = np.float32(np.inf), np.float32(2)
# The levels that are left to parts, of those of a tree: where intervals would lead below the others, nodes are halved
# by number.
_BELOW = np.int64(30)
_MOST_LEVELS = 28
# Words of a stack entry: node, level.
_ENTRY = 2


@device
def _bounds(records, begin, end, found):
    """Box and bounds of the centres of records `begin` to `end`, into the first sixteen words of `found`."""
    box = centres = splat8(_INFINITY)
    for i in range(begin, end):
        record = load8(records, i * RECORD)
        box = minimum(record, box)
        centres = minimum(centre(record), centres)
    store8(found, 0, box)
    store8(found, RECORD, centres)


@device
def _place(records, i, axis):
    """Twice the centre of a record's box on an axis."""
    return load_float(records, i * RECORD + axis) - load_float(records, i * RECORD + 4 + axis)


@device
def _exchange(records, i, j):
    record = load8(records, i * RECORD)
    store8(records, i * RECORD, load8(records, j * RECORD))
    store8(records, j * RECORD, record)


@device
def _part(records, begin, end, found):
    """Bring what lies below the middle between centres, on their longest axis, to the front; where the rest begins."""
    axis, longest = 0, np.float32(-1)
    for k in range(3):
        extent = -load_float(found, RECORD + 4 + k) - load_float(found, RECORD + k)
        if extent > longest:
            axis, longest = k, extent
    plane = (load_float(found, RECORD + axis) - load_float(found, RECORD + 4 + axis)) / _TWO
    i, j = begin, end
    while i < j:
        if _place(records, i, axis) < plane:
            i += 1
        else:
            j -= 1
            _exchange(records, i, j)
    return i


@kernel
def interval_nodes(records, nodes, children, order):
    """Part `records` in intervals until each is alone: 2 k − 1 binary nodes in `nodes`, node 0 the root, children and
    order as build_subtree leaves them. Returns how many nodes there are."""
    count = len(records) // RECORD
    found = np.empty(2 * RECORD, np.float32)
    stack = np.empty(_ENTRY * (_MOST_LEVELS + 4), np.int64)
    _bounds(records, 0, count, found)
    write_node(nodes, 0, load8(found, 0), 0, count)
    stack[0], stack[1] = 0, 0
    top, free = _ENTRY, 1
    while top > 0:
        top -= _ENTRY
        node, level = stack[top], stack[top + 1]
        begin = np.int64(load_int(nodes, node * RECORD + 3))
        end = begin + np.int64(load_int(nodes, node * RECORD + 7))
        children[node] = 0
        if end - begin <= 1:
            order[begin] = load_int(records, begin * RECORD + 3)
            continue
        _bounds(records, begin, end, found)
        middle = begin if too_deep(level + _BELOW, end - begin) else _part(records, begin, end, found)
        if middle in (begin, end):
            middle = begin + (end - begin) // 2
        children[node] = free
        for first, last in ((begin, middle), (middle, end)):
            _bounds(records, first, last, found)
            write_node(nodes, free, load8(found, 0), first, last - first)
            stack[top], stack[top + 1] = free, level + 1
            top += _ENTRY
            free += 1
    return free
