"""Whether anything could stand between two flat nodes: the shaft around them, and what of the scene reaches into it.

A shaft is what planes enclose that have both nodes on one side: six of a box around both, the two of the nodes, and
those through an edge of one and a corner of the other. What lies outside one plane blocks nothing
(Haines, Wallace: "Shaft Culling for Efficient Ray-Cast Radiosity", Eurographics Workshop on Rendering 1991).
"""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.base.double3 import Double3, cross3, difference, dot3, norm, row3, scaled, total
from isophote.kernels.base.jit import device
from isophote.kernels.base.table import DOUBLE_BOXES, LONGS, Packed, Table
from isophote.kernels.light.form_factor import corner3

__all__ = ["SHAFT", "new_shaft", "sees_all"]

# `planes` (n, 4): outward normal and height; `corners` (8, 3): those of both nodes; `stack`: nodes that wait.
SHAFT = Table("Shaft", planes=DOUBLE_BOXES, corners=DOUBLE_BOXES, stack=LONGS)

_BOX_PLANES, _MOST_PLANES, _STACK = 8, 40, 512
_ZERO, _ONE = np.float64(0), np.float64(1)


def new_shaft() -> Packed:
    """Scratch for one thread."""
    return SHAFT.pack(
        planes=np.zeros((_MOST_PLANES, 4)), corners=np.zeros((_BOX_PLANES, 3)), stack=np.zeros(_STACK, np.int64)
    )


@device
def _set_plane(shaft, k, normal, height):
    planes = shaft.planes
    planes[k, 0], planes[k, 1], planes[k, 2], planes[k, 3] = normal.x, normal.y, normal.z, height


@device
def _set_corners(patches, shaft, node, at):
    """Corners of a flat node from row `at` on; how many rows there are then. Of clusters those of the rectangle."""
    count = np.int64(patches.sides[node])
    if count == 0:
        count = np.int64(4)
        centre, axes = row3(patches.centres, node), patches.axes
        along = Double3(axes[node, 0], axes[node, 1], axes[node, 2])
        across = Double3(axes[node, 3], axes[node, 4], axes[node, 5])
    for c in range(count):
        if patches.sides[node] != 0:
            corner = corner3(patches.corners, node, c)
        else:
            first = _ONE if c == 1 or c == 2 else -_ONE
            second = _ONE if c >= 2 else -_ONE
            corner = total(centre, total(scaled(along, first), scaled(across, second)))
        shaft.corners[at + c, 0], shaft.corners[at + c, 1], shaft.corners[at + c, 2] = corner.x, corner.y, corner.z
    return at + count


@device
def _set_box(patches, shaft, p, q, count):
    """The planes of a box around all corners, and those of the two nodes."""
    for axis in range(3):
        low, high = math.inf, -math.inf
        for c in range(count):
            low, high = min(low, shaft.corners[c, axis]), max(high, shaft.corners[c, axis])
        unit = Double3(_ONE if axis == 0 else _ZERO, _ONE if axis == 1 else _ZERO, _ONE if axis == 2 else _ZERO)
        _set_plane(shaft, 2 * axis, unit, high)
        _set_plane(shaft, 2 * axis + 1, scaled(unit, -_ONE), -low)
    for k in range(2):
        node = p if k == 0 else q
        normal = scaled(row3(patches.normals, node), -_ONE)
        _set_plane(shaft, 6 + k, normal, dot3(normal, row3(patches.centres, node)))


@device
def _add_planes(shaft, first, last, other, end, made, room):
    """Planes through an edge of corners first ≤ i < last and a corner other ≤ j < end that have all corners on one
    side; how many planes there are then. What reaches over a plane by `room` is on it."""
    corners = shaft.corners
    for i in range(first, last):
        a, b = row3(corners, i), row3(corners, i + 1 if i + 1 < last else first)
        edge = difference(b, a)
        for j in range(other, end):
            normal = cross3(edge, difference(row3(corners, j), a))
            size = norm(normal)
            if size <= room * norm(edge):
                continue
            normal = scaled(normal, _ONE / size)
            height = dot3(normal, a)
            low, high = math.inf, -math.inf
            for c in range(max(last, end)):
                above = dot3(normal, row3(corners, c)) - height
                low, high = min(low, above), max(high, above)
            if made < _MOST_PLANES and high <= room:
                _set_plane(shaft, made, normal, height)
                made += 1
            elif made < _MOST_PLANES and low >= -room:
                _set_plane(shaft, made, scaled(normal, -_ONE), -height)
                made += 1
    return made


@device
def _lowest(patches, node, normal):
    """How far node reaches against a direction: the least of x · n."""
    if patches.sides[node] != 0:
        low = math.inf
        for c in range(patches.sides[node]):
            low = min(low, dot3(corner3(patches.corners, node, c), normal))
        return low
    if patches.flat[node] != 0:
        axes = patches.axes
        along = Double3(axes[node, 0], axes[node, 1], axes[node, 2])
        across = Double3(axes[node, 3], axes[node, 4], axes[node, 5])
        return dot3(row3(patches.centres, node), normal) - abs(dot3(along, normal)) - abs(dot3(across, normal))
    low, high = row3(patches.boxes, 2 * node), row3(patches.boxes, 2 * node + 1)
    x = (low.x if normal.x > _ZERO else high.x) * normal.x
    y = (low.y if normal.y > _ZERO else high.y) * normal.y
    return x + y + (low.z if normal.z > _ZERO else high.z) * normal.z


@device
def _reaches_in(patches, shaft, node, planes, count, room):
    """Whether a node could be within the shaft, by its first planes and by the node's own."""
    for k in range(planes):
        normal = row3(shaft.planes, k)
        if _lowest(patches, node, normal) >= shaft.planes[k, 3] - room:
            return False
    if patches.flat[node] == 0:
        return True
    normal = row3(patches.normals, node)
    height = dot3(normal, row3(patches.centres, node))
    low, high = math.inf, -math.inf
    for c in range(count):
        above = dot3(normal, row3(shaft.corners, c)) - height
        low, high = min(low, above), max(high, above)
    return low < -room and high > room


@device
def _is_empty(patches, shaft, roots, planes, count, room):
    """Whether no face could be within the shaft."""
    stack = shaft.stack
    for root in range(roots.rows):
        top = np.int64(1)
        stack[0] = roots[root]
        while top > 0:
            top -= 1
            node = stack[top]
            if not _reaches_in(patches, shaft, node, planes, count, room):
                continue
            if patches.sides[node] != 0 or top + patches.children[node] > _STACK:
                return False
            first = np.int64(patches.first_child[node])
            for k in range(patches.children[node]):
                stack[top] = first + k
                top += 1
    return True


@device
def sees_all(patches, shaft, p, q):
    """Whether nothing can stand between two flat nodes; False where that is not sure."""
    room = np.float64(patches.bias)
    first = _set_corners(patches, shaft, p, np.int64(0))
    count = _set_corners(patches, shaft, q, first)
    _set_box(patches, shaft, p, q, count)
    if _is_empty(patches, shaft, patches.roots, np.int64(_BOX_PLANES), count, room):
        return True
    made = _add_planes(shaft, np.int64(0), first, first, count, np.int64(_BOX_PLANES), room)
    made = _add_planes(shaft, first, count, np.int64(0), first, made, room)
    return _is_empty(patches, shaft, patches.roots, made, count, room)
