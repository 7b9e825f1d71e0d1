"""Polygons as sites of their medial axis: edges, and the vertices at which the inside is wider than a half-plane.

Site k < n is edge k, without its ends; site n + k is vertex k, where edge k starts. The inside lies to the left. A site
owns the points whose nearest point on it is not beyond its ends: for an edge a strip, for a vertex a wedge. Edges in
their order are the leaves of a tree of boxes, which lies in an array like a heap.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
from numba import types

from isophote.kernels.base.jit import device
from isophote.kernels.base.table import INTS, Packed, Table, ViewType

__all__ = ["POLYGON", "along", "contacts", "edge_distance", "height", "nearest_edge", "pack_polygon", "point_distance"]

_DOUBLES = ViewType(types.float64, 1)

# starts, directions  (n, 2): where edges start, and where they go, of unit length; lengths (n,)
# before, after       (n,) the edges before and after each on its ring
# reflex              (n,) 1 where the inside at the start of an edge is wider than a half-plane
# boxes               (2 size, 4) least x, least y, greatest x, greatest y; node i has the children 2 i and 2 i + 1
POLYGON = Table(
    "Polygon",
    starts=_DOUBLES,
    directions=_DOUBLES,
    lengths=_DOUBLES,
    before=INTS,
    after=INTS,
    reflex=INTS,
    boxes=_DOUBLES,
)


def pack_polygon(
    starts: npt.NDArray[np.float64],
    ends: npt.NDArray[np.float64],
    before: npt.NDArray[np.int32],
    after: npt.NDArray[np.int32],
    reflex: npt.NDArray[np.bool_],
) -> Packed:
    """The table of a polygon, from the ends (n, 2) of its edges."""
    count = len(starts)
    size = 1 << max(count - 1, 1).bit_length()
    boxes = np.empty((2 * size, 4))
    boxes[:, :2], boxes[:, 2:] = np.inf, -np.inf
    boxes[size : size + count, :2] = np.minimum(starts, ends)
    boxes[size : size + count, 2:] = np.maximum(starts, ends)
    level = size
    while level > 1:
        pairs = boxes[level : 2 * level].reshape(-1, 2, 4)
        level //= 2
        boxes[level : 2 * level, :2] = pairs[:, :, :2].min(axis=1)
        boxes[level : 2 * level, 2:] = pairs[:, :, 2:].max(axis=1)
    lengths = np.hypot(*(ends - starts).T)
    return POLYGON.pack(
        starts=np.ascontiguousarray(starts).reshape(-1),
        directions=np.ascontiguousarray((ends - starts) / lengths[:, None]).reshape(-1),
        lengths=lengths,
        before=before.astype(np.int32),
        after=after.astype(np.int32),
        reflex=reflex.astype(np.int32),
        boxes=boxes.reshape(-1),
    )


@device
def along(p, k, x, y):
    """Where the foot of (x, y) is on the line of edge k, from its start."""
    return (x - p.starts[2 * k]) * p.directions[2 * k] + (y - p.starts[2 * k + 1]) * p.directions[2 * k + 1]


@device
def height(p, k, x, y):
    """How far (x, y) lies to the left of the line of edge k."""
    return (y - p.starts[2 * k + 1]) * p.directions[2 * k] - (x - p.starts[2 * k]) * p.directions[2 * k + 1]


@device
def point_distance(p, k, x, y):
    """The distance to vertex k."""
    return math.hypot(x - p.starts[2 * k], y - p.starts[2 * k + 1])


@device
def edge_distance(p, k, x, y):
    """The distance to edge k with its ends."""
    t = along(p, k, x, y)
    if t <= 0:
        return point_distance(p, k, x, y)
    if t >= p.lengths[k]:
        return point_distance(p, np.int64(p.after[k]), x, y)
    return abs(height(p, k, x, y))


@device
def _box_distance(p, i, x, y):
    """The square of the distance to a box."""
    dx = max(max(p.boxes[4 * i] - x, x - p.boxes[4 * i + 2]), 0.0)
    dy = max(max(p.boxes[4 * i + 1] - y, y - p.boxes[4 * i + 3]), 0.0)
    return dx * dx + dy * dy


@device
def nearest_edge(p, x, y, limit, stack):
    """(edge, distance): the edge nearest to (x, y), of those nearer than `limit`; (-1, limit) where there is none."""
    size = p.boxes.rows >> 3
    best, least = np.int64(-1), limit
    stack[0] = 1
    count = 1
    while count > 0:
        count -= 1
        i = stack[count]
        if _box_distance(p, i, x, y) >= least * least:
            continue
        if i >= size:
            distance = edge_distance(p, i - size, x, y)
            if distance < least:
                best, least = i - size, distance
            continue
        near, far = 2 * i, 2 * i + 1
        if _box_distance(p, far, x, y) < _box_distance(p, near, x, y):
            near, far = far, near
        stack[count], stack[count + 1] = far, near
        count += 2
    return best, least


@device
def contacts(p, x, y, reach, stack, found):
    """Write the edges within `reach` of (x, y); returns how many, at most as many as there is room for."""
    size = p.boxes.rows >> 3
    number = 0
    stack[0] = 1
    count = 1
    while count > 0:
        count -= 1
        i = stack[count]
        if _box_distance(p, i, x, y) > reach * reach:
            continue
        if i >= size:
            if edge_distance(p, i - size, x, y) <= reach and number < len(found):
                found[number] = i - size
                number += 1
            continue
        stack[count], stack[count + 1] = 2 * i + 1, 2 * i
        count += 2
    return number
