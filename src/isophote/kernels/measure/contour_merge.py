"""Cells of a brick merged, eight into one, where one vertex does for all of them.

A component of the surface in a cell is known by the edges of the cell that it crosses, and where. Components in the
eight children of a larger cell that share crossings become one there, if

- each edge of the larger cell is crossed at most once, and each face along one curve or none,
- the component is a disk, by its Euler characteristic,
- the new vertex is no farther than `reach` from the planes of every component of the smallest cells in it, as the root
  of the mean square over each of these.

- no cell half as large, in it or beside it in the brick, has components that were not merged that far: sizes of cells
  change step by step, or triangles between large cells and small ones would fold over.

The first two make the mesh of merged cells a closed manifold, as that of the smallest cells is: two components then
meet along one curve at most, and so two vertices share one edge at most (after Schaefer, Ju, Warren, "Manifold dual
contouring", 2007, whose conditions are the same in substance). Components of cells with ambiguous faces stay as they
are.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import device
from isophote.kernels.measure.contour_block import BLOCKED, CELL_EDGES
from isophote.kernels.measure.contour_tables import BRICK, MOMENTS
from isophote.kernels.measure.morton import bit_count, unpacked
from isophote.kernels.measure.qef import BOX_HIGH, BOX_LOW, MATRIX, RIGHT, SOLUTION, solve_qefs

__all__ = ["load_qef", "mean_place", "merge_components", "solution"]

_NONE = np.int32(-1)
_ZERO = np.int64(0)
_X, _Y, _Z = np.int64(0), np.int64(1), np.int64(2)
# Components that may be put together at once, and functions solved at once.
_MOST = 32
_BATCH = 16
_HALF = np.float64(0.5)


@device
def mean_place(moments, component, axis):
    """A coordinate of the middle of a component's crossings."""
    return moments[component, 10 + axis] / moments[component, 13]


@device
def load_qef(work, lane, component, size):
    """Put a component's error function into a lane, with the cell of `size` that its code names as its box."""
    moments, qefs = work.moments, work.qefs
    for k in range(6):
        qefs[MATRIX + 16 * k + lane] = np.float32(moments[component, k])
    x, y = mean_place(moments, component, _X), mean_place(moments, component, _Y)
    z = mean_place(moments, component, _Z)
    xx, xy, xz = moments[component, 0], moments[component, 1], moments[component, 2]
    yy, yz, zz = moments[component, 3], moments[component, 4], moments[component, 5]
    qefs[RIGHT + lane] = np.float32(moments[component, 6] - (xx * x + xy * y + xz * z))
    qefs[RIGHT + 16 + lane] = np.float32(moments[component, 7] - (xy * x + yy * y + yz * z))
    qefs[RIGHT + 32 + lane] = np.float32(moments[component, 8] - (xz * x + yz * y + zz * z))
    code = np.int64(work.codes[component])
    for axis in range(3):
        low = np.float64(unpacked(code >> axis) * size) - mean_place(moments, component, axis)
        qefs[BOX_LOW + 16 * axis + lane] = np.float32(low)
        qefs[BOX_HIGH + 16 * axis + lane] = np.float32(low + np.float64(size))


@device
def solution(work, lane, component):
    """Write what was found in a lane as the component's place in the brick."""
    for axis in range(3):
        found = np.float64(work.qefs[SOLUTION + 16 * axis + lane])
        work.places[component, axis] = mean_place(work.moments, component, axis) + found


@device
def _error(moments, component, x, y, z):
    """Mean square distance of a point to the planes of a component."""
    xx, xy, xz = moments[component, 0], moments[component, 1], moments[component, 2]
    yy, yz, zz = moments[component, 3], moments[component, 4], moments[component, 5]
    square = x * (xx * x + 2.0 * (xy * y + xz * z)) + y * (yy * y + 2.0 * yz * z) + zz * z * z
    linear = moments[component, 6] * x + moments[component, 7] * y + moments[component, 8] * z
    return (square - 2.0 * linear + moments[component, 9]) / moments[component, 13]


@device
def _share_curve(crossed, p, q, axis):
    """Whether two components share the curve on the face between their cells, p's on the low side along the axis."""
    u, v = (axis + 1) % 3, (axis + 2) % 3
    for k in range(2):
        across, along = 4 * u + k, 4 * v + 2 * k
        if crossed[p, across + 2] >= 0 and crossed[p, across + 2] == crossed[q, across]:
            return True
        if crossed[p, along + 1] >= 0 and crossed[p, along + 1] == crossed[q, along]:
            return True
    return False


@device
def _connected(work, p, q):
    """Whether two components of children of one cell meet in a curve on the face between them."""
    a, b = work.codes[p] & 7, work.codes[q] & 7
    between = a ^ b
    if between != 1 and between != 2 and between != 4:
        return False
    axis = np.int64(between >> 1)
    return _share_curve(work.crossed, p, q, axis) if a < b else _share_curve(work.crossed, q, p, axis)


@device
def _label(work, first, count):
    """Name the list's entries from `first` on by what they are connected to, and count the curves that connect them.

    `labels[i]` is the least entry of i's group, `labels[_MOST + i]` how many curves i shares with entries after it.
    """
    labels = work.labels
    for i in range(count):
        labels[i], labels[_MOST + i] = np.int32(i), np.int32(0)
    for i in range(count):
        for j in range(i + 1, count):
            if not _connected(work, work.list[first + i], work.list[first + j]):
                continue
            labels[_MOST + i] += np.int32(1)
            low, high = min(labels[i], labels[j]), max(labels[i], labels[j])
            if low != high:
                for k in range(count):
                    if labels[k] == high:
                        labels[k] = low


@device
def _curves_within(grid, mask, child):
    """Of the three faces of a child that lie within its parent, those that a component crosses."""
    count = 0
    for axis in range(3):
        # The face towards the middle: the high one of a child on the low side.
        if mask & grid.face_edges[2 * axis + (1 - (child >> axis & 1))] != 0:
            count += 1
    return count


@device
def _is_simple(grid, mask):
    """Whether each face is crossed along one curve at most."""
    for face in range(6):
        crossed = bit_count(np.int64(mask & grid.face_edges[face]))
        if crossed != 0 and crossed != 2:
            return False
    return True


@device
def _take_outer(grid, work, part, made):
    """Hand on what a child crosses of its parent's edges; False where one of them is crossed already."""
    outer = work.masks[part] & grid.outer_edges[work.codes[part] & 7]
    for edge in range(CELL_EDGES):
        if outer >> edge & 1 != 0:
            if work.crossed[made, edge] >= 0:
                return False
            work.crossed[made, edge] = work.crossed[part, edge]
            work.masks[made] |= np.int32(1 << edge)
    return True


@device
def _grade(level):
    """Where the marks of the cells of a level start, and how many cells there are along the brick."""
    along = np.int64(BRICK) >> level
    # Those of the levels before: 16³, 8³ and so on.
    before = (np.int64(BRICK * BRICK * BRICK) - 8 * along * along * along) // 7
    return before, along


@device
def _is_graded(work, code, level):
    """Whether all cells of the level below, in a cell or beside it, are merged."""
    start, along = _grade(level - 1)
    x, y, z = 2 * unpacked(code), 2 * unpacked(code >> 1), 2 * unpacked(code >> 2)
    for k in range(max(z - 1, _ZERO), min(z + 3, along)):
        for j in range(max(y - 1, _ZERO), min(y + 3, along)):
            for i in range(max(x - 1, _ZERO), min(x + 3, along)):
                if work.unmerged[start + (k * along + j) * along + i] != 0:
                    return False
    return True


@device
def _mark_unmerged(work, component, level):
    """Mark the cells of a level and of all above that hold a component of the level below, which was not merged."""
    code = np.int64(work.codes[component])
    while 1 << level < BRICK:
        code >>= 3
        start, along = _grade(level)
        work.unmerged[start + (unpacked(code >> 2) * along + unpacked(code >> 1)) * along + unpacked(code)] = 1
        level += 1


@device
def _propose(grid, work, first, count, label, made, pending):
    """Make component `made` of a group, if it may be; its parts into row `pending` of the members. Their number, or 0.

    A closed region cut into disks by curves has the Euler characteristic disks − curves + points, of the curves and
    points within it.
    """
    for edge in range(CELL_EDGES):
        work.crossed[made, edge] = _NONE
    for column in range(MOMENTS):
        work.moments[made, column] = 0.0
    work.masks[made], work.parents[made] = np.int32(0), _NONE
    parts, shared, twice_curves, points_four_times = _ZERO, _ZERO, _ZERO, _ZERO
    for i in range(count):
        if work.labels[i] != label:
            continue
        part = work.list[first + i]
        child = work.codes[part] & 7
        if not _take_outer(grid, work, part, made):
            return _ZERO
        mask = work.masks[part]
        shared += work.labels[_MOST + i]
        twice_curves += _curves_within(grid, mask, child)
        points_four_times += bit_count(np.int64(mask & grid.inner_edges[child]))
        for column in range(MOMENTS):
            work.moments[made, column] += work.moments[part, column]
        work.members[pending * _MOST + parts] = part
        parts += 1
    if 2 * shared != twice_curves or 4 * parts - 2 * twice_curves + points_four_times != 4:
        return _ZERO
    if not _is_simple(grid, work.masks[made]):
        return _ZERO
    work.codes[made] = work.codes[work.members[pending * _MOST]] >> 3
    return parts


@device
def _fits(work, component, made, most):
    """Whether the place of `made` is near enough to every component of the smallest cells that is in `component`."""
    x, y, z = work.places[made, 0], work.places[made, 1], work.places[made, 2]
    each = work.heads[component]
    while each >= 0:
        if not _error(work.moments, each, x, y, z) <= most:
            return False
        each = work.following[each]
    return True


@device
def _adopt(work, made, members, count):
    """Merge the members into `made`: their lists of smallest components become one."""
    for i in range(count):
        part = work.members[members + i]
        work.parents[part] = np.int32(made)
        if i == 0:
            work.heads[made] = work.heads[part]
        else:
            work.following[work.tails[made]] = work.heads[part]
        work.tails[made] = work.tails[part]


@device
def _settle(grid, work, first_made, pending, level, kept):
    """Place the vertices of the proposed components, and merge those that fit; the length of the next list."""
    most = np.float64(grid.reach) * np.float64(grid.reach)
    solve_qefs(work.qefs)
    for lane in range(pending):
        made = first_made + lane
        solution(work, lane, made)
        count = work.numbers[made]
        fits = True
        for i in range(count):
            fits = fits and _fits(work, work.members[lane * _MOST + i], made, most)
        if fits:
            _adopt(work, made, lane * _MOST, count)
            work.levels[made] = level
            work.next_list[kept] = np.int32(made)
            kept += 1
        else:
            work.numbers[made] = _NONE
    return kept


@device
def _merge_level(grid, work, made, entries, level):
    """Merge the components in `work.list` into cells of a level: the next free number, the length of the next list."""
    kept, pending, first = _ZERO, _ZERO, _ZERO
    while first < entries:
        parent = work.codes[work.list[first]] >> 3
        end = first + 1
        while end < entries and work.codes[work.list[end]] >> 3 == parent:
            end += 1
        count = end - first
        if count <= _MOST and (level < 2 or _is_graded(work, np.int64(parent), level)):
            _label(work, first, count)
            for label in range(count):
                if work.labels[label] != label:
                    continue
                parts = _propose(grid, work, first, count, label, made + pending, pending)
                if parts == 0:
                    continue
                work.numbers[made + pending] = np.int32(parts)
                load_qef(work, pending, made + pending, np.int64(1) << level)
                pending += 1
                if pending == _BATCH:
                    kept = _settle(grid, work, made, pending, level, kept)
                    made += pending
                    pending = 0
        first = end
    kept = _settle(grid, work, made, pending, level, kept)
    for entry in range(entries):
        if work.parents[work.list[entry]] < 0:
            _mark_unmerged(work, np.int64(work.list[entry]), level)
    return made + pending, kept


@device
def merge_components(grid, work, components):
    """Merge the components of a brick's smallest cells as far as it goes; how many numbers of components are taken.

    `numbers` is -1 for those that came to nothing.
    """
    for mark in range(work.unmerged.rows):
        work.unmerged[mark] = 0
    entries = _ZERO
    for component in range(components):
        if work.masks[component] & BLOCKED == 0:
            work.list[entries] = np.int32(component)
            entries += 1
        else:
            _mark_unmerged(work, component, np.int64(1))
    made, level = np.int64(components), np.int64(1)
    while entries > 0 and 1 << level <= BRICK:
        made, entries = _merge_level(grid, work, made, entries, level)
        for i in range(entries):
            work.list[i] = work.next_list[i]
        level += 1
    return made
