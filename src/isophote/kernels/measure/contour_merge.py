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

from isophote.kernels.base.jit import device, exact_apart
from isophote.kernels.base.simd_double import load_doubles, splat_doubles, store_doubles
from isophote.kernels.measure.contour_cells import BLOCKED
from isophote.kernels.measure.contour_groups import MOST, label, lone_children_fit, take_edges, take_group
from isophote.kernels.measure.contour_tables import BRICK, MOMENTS
from isophote.kernels.measure.contour_vertices import VERTICES, load_error, place_found, square_error
from isophote.kernels.measure.morton import unpacked
from isophote.kernels.measure.qef import solve_qefs

__all__ = ["merge_components"]

_NONE = np.int32(-1)
_ZERO, _ONE, _MANY = np.int64(0), np.int64(1), np.int64(-1)
_NOTHING = np.float64(0)
_EDGES = np.int64(12)


@device
def _grade(level):
    """Where the marks of the cells of a level start, and how many cells there are along the brick."""
    along = np.int64(BRICK) >> level
    # Those of the levels before: 16³, 8³ and so on.
    before = (np.int64(BRICK * BRICK * BRICK) - 8 * along * along * along) // 7
    return before, along


@device
def _holds_unmerged(work, code, level):
    """Whether a cell of a level holds components that are not merged that far."""
    if 1 << level == BRICK:
        return False
    start, along = _grade(level)
    return work.unmerged[start + (unpacked(code >> 2) * along + unpacked(code >> 1)) * along + unpacked(code)] != 0


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
        at = start + (unpacked(code >> 2) * along + unpacked(code >> 1)) * along + unpacked(code)
        # Those above are marked with it.
        if work.unmerged[at] != 0:
            break
        work.unmerged[at] = 1
        level += 1


@device
def _make(grid, work, made, lane, parts, level):
    """Make a component of the members in a lane, and put its error function there."""
    low, high = splat_doubles(_NOTHING), splat_doubles(_NOTHING)
    mask = np.int32(0)
    for i in range(lane * MOST, lane * MOST + parts):
        part = np.int64(work.members[i])
        mask |= take_edges(grid, work, part, made)
        low = low + load_doubles(work.moments, MOMENTS * part)
        high = high + load_doubles(work.moments, MOMENTS * part + 8)
    store_doubles(work.moments, MOMENTS * made, low)
    store_doubles(work.moments, MOMENTS * made + 8, high)
    work.masks[made], work.parents[made], work.levels[made] = mask, _NONE, level
    work.codes[made] = work.codes[work.members[lane * MOST]] >> 3
    work.counts[lane] = np.int32(parts)
    load_error(work, lane, made, _ONE << level)


@device
def _fits(work, component, made, most):
    """Whether the place of `made` is near enough to every component of the smallest cells that is in `component`."""
    x, y, z = work.places[made, 0], work.places[made, 1], work.places[made, 2]
    each = np.int64(work.heads[component])
    while each >= 0:
        error, count = square_error(work, each, x, y, z)
        if not error <= most * count:
            return False
        each = np.int64(work.following[each])
    return True


@device
def _all_fit(work, made, lane, most):
    for i in range(lane * MOST, lane * MOST + work.counts[lane]):
        if not _fits(work, np.int64(work.members[i]), made, most):
            return False
    return True


@device
def _move(work, made, to):
    """Give a component another number."""
    for edge in range(_EDGES):
        work.crossed[to, edge] = work.crossed[made, edge]
    for column in range(0, MOMENTS, 8):
        store_doubles(work.moments, MOMENTS * to + column, load_doubles(work.moments, MOMENTS * made + column))
    for axis in range(3):
        work.places[to, axis] = work.places[made, axis]
    work.masks[to], work.parents[to], work.levels[to] = work.masks[made], work.parents[made], work.levels[made]
    work.codes[to] = work.codes[made]


@device
def _adopt(work, made, members, count):
    """Merge the members into `made`: their lists of smallest components become one."""
    for i in range(count):
        part = np.int64(work.members[members + i])
        work.parents[part] = np.int32(made)
        if i == 0:
            work.heads[made] = work.heads[part]
        else:
            work.following[work.tails[made]] = work.heads[part]
        work.tails[made] = work.tails[part]


@device
def _settle(grid, work, made, pending, kept):
    """Place the vertices of the components from `made` on, and merge those that fit; the next free number, and the
    length of the next list."""
    most = np.float64(grid.reach) * np.float64(grid.reach)
    solve_qefs(work.qefs)
    end = made
    for lane in range(pending):
        proposed = made + lane
        place_found(work, lane, proposed)
        if _all_fit(work, proposed, lane, most):
            if end != proposed:
                _move(work, proposed, end)
            _adopt(work, end, lane * MOST, np.int64(work.counts[lane]))
            work.next_list[kept] = np.int32(end)
            kept += 1
            end += 1
    return end, kept


@device
def _propose(grid, work, first, count, name, lane, one):
    """Put the group of that name into a lane's members; their number, or 0. All are one group if that is known."""
    if one != 1:
        return take_group(grid, work, first, count, name, lane * MOST)
    for i in range(count):
        work.members[lane * MOST + i] = work.list[first + i]
    return count


@device
def _groups(grid, work, first, count, parent, level):
    """How many groups to ask for, and 1 where all components of a parent are known to be one."""
    one = _MANY
    # Of smallest cells, those that must not be merged are not listed; of others, is_graded has asked.
    if level > 1 or not _holds_unmerged(work, parent, level):
        one = lone_children_fit(grid, work, first, count)
    if one == _MANY:
        label(grid, work, first, count)
        return count, one
    return one, one


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
        if count <= MOST and (level < 2 or _is_graded(work, np.int64(parent), level)):
            names, one = _groups(grid, work, first, count, np.int64(parent), level)
            for name in range(names):
                if one == _MANY and work.labels[name] != name:
                    continue
                parts = _propose(grid, work, first, count, name, pending, one)
                if parts == 0:
                    continue
                _make(grid, work, made + pending, pending, parts, level)
                pending += 1
                if pending == VERTICES:
                    made, kept = _settle(grid, work, made, pending, kept)
                    pending = _ZERO
        first = end
    made, kept = _settle(grid, work, made, pending, kept)
    for entry in range(entries):
        if work.parents[work.list[entry]] < 0:
            _mark_unmerged(work, np.int64(work.list[entry]), level)
    return made, kept


@exact_apart
def merge_components(grid, work, components):
    """Merge the components of a brick's smallest cells as far as it goes; how many numbers of components are taken."""
    for mark in range(work.unmerged.rows):
        work.unmerged[mark] = 0
    for component in range(components):
        work.heads[component] = work.tails[component] = np.int32(component)
        work.following[component] = _NONE
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
