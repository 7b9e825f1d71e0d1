"""Outlines of quadratic Bézier arcs as a tree: sixteen arcs in a leaf, sixteen boxes in a node.

Arcs are put in the order of a Hilbert curve through their middles, so that each sixteen lie together, and each sixteen
of those. Children follow from numbers: child k of node j is number 16 j + k of the level below.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from isophote.kernels.base.table import FLOAT, FLOATS, INT, INTS, Packed, Table

__all__ = ["ARC", "GROUP", "MOST_LEVELS", "NODE", "OUTLINE", "SIDE", "pack_outline"]

# A leaf: x0, y0, x1, y1, x2, y2 of B(t) = (1 − t)² p0 + 2 t (1 − t) p1 + t² p2 of sixteen arcs, then their sides. A
# node: least x and y, greatest x and y of sixteen children, which are empty boxes where there are fewer.
ARC, SIDE, GROUP, NODE = 16, 96, 112, 64
MOST_LEVELS = 8

# `starts`: number of the first node of each level of `nodes`, the lowest level first, whose children are leaves.
# `turned`: whether rays run along x instead of y, which is what fewer arcs lie along. `reach`: the largest coordinate.
OUTLINE = Table("Outline", arcs=FLOATS, nodes=FLOATS, starts=INTS, levels=INT, turned=INT, slope=FLOAT, reach=FLOAT)

_ORDER_BITS = 15


def pack_outline(segments: Any, sides: Any, slope: float) -> Packed:
    """The tree of arcs `segments` (n, 6) float32, each monotone in x and in y.

    `sides` (n,) tells where the inside lies: 1 left of an arc, −1 right of it, 0 where it is no boundary. Arcs with
    the side 0 count for the winding number only.
    """
    low, high = _boxes(segments)
    order = np.argsort(_hilbert((low + high) / 2), kind="stable")
    arcs = _padded(np.column_stack([segments, sides])[order].astype(np.float32), 0.0)
    groups = np.ascontiguousarray(arcs.reshape(-1, ARC, 7).transpose(0, 2, 1))
    boxes = np.column_stack([low, high])[order].astype(np.float32)
    levels = []
    while True:
        boxes = _united(boxes)
        levels.append(_nodes(boxes))
        if len(levels[-1]) == 1:
            break
    starts = np.cumsum([0] + [len(level) for level in levels])[:-1]
    extent = high.max(axis=0) - low.min(axis=0)
    return OUTLINE.pack(
        arcs=groups.reshape(-1),
        nodes=np.concatenate(levels).reshape(-1),
        starts=starts.astype(np.int32),
        levels=len(levels),
        turned=extent[1] > extent[0],
        slope=slope,
        reach=float(np.abs(segments).max()),
    )


def _boxes(segments: Any) -> tuple[Any, Any]:
    """Corners of the arcs' boxes, (n, 2) each: those of their ends."""
    ends = segments[:, (0, 4)], segments[:, (1, 5)]
    low = np.stack([end.min(axis=1) for end in ends], axis=1)
    return low, np.stack([end.max(axis=1) for end in ends], axis=1)


def _padded(rows: Any, filler: float) -> Any:
    """Rows, and more of them up to a multiple of sixteen."""
    return np.concatenate([rows, np.full((-len(rows) % ARC, rows.shape[1]), filler, rows.dtype)])


_NOWHERE = np.array([np.inf, np.inf, -np.inf, -np.inf], np.float32)


def _sixteens(boxes: Any) -> Any:
    """Boxes (n, 4) as (m, 16, 4), empty ones at the end."""
    missing = np.tile(_NOWHERE, (-len(boxes) % ARC, 1))
    return np.concatenate([boxes, missing]).reshape(-1, ARC, 4)


def _united(boxes: Any) -> Any:
    """The boxes around each sixteen."""
    groups = _sixteens(boxes)
    return np.concatenate([groups[..., :2].min(axis=1), groups[..., 2:].max(axis=1)], axis=1)


def _nodes(boxes: Any) -> Any:
    """Nodes (m, 64) over boxes (n, 4), those of children."""
    return np.ascontiguousarray(_sixteens(boxes).transpose(0, 2, 1)).reshape(-1, NODE)


def _hilbert(points: Any) -> Any:
    """Places of points (n, 2) along a Hilbert curve."""
    low = points.min(axis=0)
    size = max(float((points - low).max()), 1e-30)
    x, y = ((points - low) / size * (2**_ORDER_BITS - 1)).astype(np.int64).T
    place = np.zeros(len(points), np.int64)
    for bit in range(_ORDER_BITS - 1, -1, -1):
        side = 1 << bit
        right, upper = (x & side) > 0, (y & side) > 0
        place += side * side * ((3 * right) ^ upper)
        # Turn the quarter so that the curve within it begins where the one before ended.
        flipped = ~upper & right
        x, y = np.where(flipped, side - 1 - x, x), np.where(flipped, side - 1 - y, y)
        x, y = np.where(upper, x, y), np.where(upper, y, x)
    return place
