"""Which components of the surface, in the eight children of a cell, become one there; see contour_merge.py.

A child's crossed edges lie on the edges of the whole, on its faces, or within it. Where each child holds one component,
its bits alone tell all of topology; else components are told apart by the crossings that they share.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import lowest_bit
from isophote.kernels.measure.contour_cases import SIMPLE
from isophote.kernels.measure.morton import bit_count

__all__ = ["MOST", "label", "lone_children_fit", "take_edges", "take_group"]

# Components that may be put together at once.
MOST = 32
_ZERO, _ONE, _SEVERAL = np.int64(0), np.int64(1), np.int64(-1)
_NO_BITS = np.int64(0)
_EDGES, _FACES, _BYTE = np.int64(4095), np.int64(63), np.int64(255)


@device
def _crossing(grid, work, component, edge):
    """Number of the crossing on an edge that a component crosses."""
    if work.levels[component] == 0:
        return work.spots[component] + grid.edge_numbers[edge]
    return work.crossed[component, edge]


@device
def _faces_of(grid, mask):
    return np.int64(grid.face_bits[mask & _EDGES])


@device
def _spread(reached, joined, axis):
    """Children reached from those reached already, over the faces across an axis."""
    across, step = joined >> 8 * axis & _BYTE, _ONE << axis
    return reached | (reached & across) << step | (reached >> step & across)


@device
def _is_connected(present, joined):
    """Whether faces join all children."""
    reached, before = present & -present, _NO_BITS
    while reached != before:
        before = reached
        for axis in range(3):
            reached = _spread(reached, joined, axis)
    return reached == present


@device
def lone_children_fit(grid, work, first, count):
    """Whether the components in `work.list` from `first` on, which are connected, are one in their parent: a disk that
    each face and edge of the parent meets once at most. -1 where a child has several, or they are not connected.

    For parents in which all components are listed. A closed region cut into disks by curves has the Euler
    characteristic disks − curves + points, of the curves and points within it; a point lies in four of the children.
    """
    present, outer, low, high = _NO_BITS, _NO_BITS, _NO_BITS, _NO_BITS
    four_points = _ZERO
    good = True
    for i in range(first, first + count):
        part = np.int64(work.list[i])
        child, mask = np.int64(work.codes[part] & 7), np.int64(work.masks[part])
        here = _ONE << child
        if present & here != 0:
            return _SEVERAL
        present |= here
        crossed = mask & grid.outer_edges[child]
        good = good and outer & crossed == 0
        outer |= crossed
        faces = 64 * child + (_faces_of(grid, mask) & _FACES)
        low |= grid.low_faces[faces]
        high |= grid.high_faces[faces]
        four_points += bit_count(mask & grid.inner_edges[child])
    if low != high or not _is_connected(present, low):
        return _SEVERAL
    if not good or 4 * (count - bit_count(low)) + four_points != 4:
        return _ZERO
    return _ZERO if _faces_of(grid, outer) & SIMPLE == 0 else _ONE


@device
def _share_curve(grid, work, p, q, axis):
    """Whether two components share the curve on the face between their cells, p's on the low side along the axis."""
    u, v = (axis + 1) % 3, (axis + 2) % 3
    for k in range(2):
        for edge, step in ((4 * u + k, 2), (4 * v + 2 * k, 1)):
            if work.masks[p] >> (edge + step) & work.masks[q] >> edge & 1 == 0:
                continue
            if _crossing(grid, work, p, edge + step) == _crossing(grid, work, q, edge):
                return True
    return False


@device
def _connected(grid, work, p, q):
    """Whether two components of children of one cell meet in a curve on the face between them."""
    a, b = work.codes[p] & 7, work.codes[q] & 7
    between = a ^ b
    if between != 1 and between != 2 and between != 4:
        return False
    axis = np.int64(between >> 1)
    return _share_curve(grid, work, p, q, axis) if a < b else _share_curve(grid, work, q, p, axis)


@device
def label(grid, work, first, count):
    """Name the list's entries from `first` on by what they are connected to, and count the curves that connect them.

    `labels[i]` is the least entry of i's group, `labels[MOST + i]` how many curves i shares with entries after it.
    """
    labels = work.labels
    for i in range(count):
        labels[i], labels[MOST + i] = np.int32(i), np.int32(0)
    for i in range(count):
        for j in range(i + 1, count):
            if not _connected(grid, work, np.int64(work.list[first + i]), np.int64(work.list[first + j])):
                continue
            labels[MOST + i] += np.int32(1)
            low, high = min(labels[i], labels[j]), max(labels[i], labels[j])
            if low != high:
                for k in range(count):
                    if labels[k] == high:
                        labels[k] = low


@device
def _curves_within(grid, mask, child):
    """Of the three faces of a child that lie within its parent, those that a component crosses."""
    faces = 64 * child + (_faces_of(grid, mask) & _FACES)
    return bit_count(np.int64(grid.low_faces[faces] | grid.high_faces[faces]))


@device
def take_group(grid, work, first, count, name, members):
    """Put the components labelled `name` into `work.members`, if they are one disk as `lone_children_fit` has it; their
    number, or 0."""
    parts, shared, twice_curves, four_points = _ZERO, _ZERO, _ZERO, _ZERO
    outer = _NO_BITS
    for i in range(count):
        if work.labels[i] != name:
            continue
        part = np.int64(work.list[first + i])
        child, mask = np.int64(work.codes[part] & 7), np.int64(work.masks[part])
        crossed = mask & grid.outer_edges[child]
        if outer & crossed != 0:
            return _ZERO
        outer |= crossed
        shared += work.labels[MOST + i]
        twice_curves += _curves_within(grid, mask, child)
        four_points += bit_count(mask & grid.inner_edges[child])
        work.members[members + parts] = np.int32(part)
        parts += 1
    if 2 * shared != twice_curves or 4 * parts - 2 * twice_curves + four_points != 4:
        return _ZERO
    return parts if _faces_of(grid, outer) & SIMPLE != 0 else _ZERO


@device
def take_edges(grid, work, part, made):
    """Hand on what a child crosses of its parent's edges; their bits."""
    outer = work.masks[part] & grid.outer_edges[work.codes[part] & 7]
    left = outer
    while left != 0:
        edge = np.int64(lowest_bit(left))
        left &= left - np.int32(1)
        work.crossed[made, edge] = _crossing(grid, work, part, edge)
    return outer
