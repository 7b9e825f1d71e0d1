"""Bricks of 32³ cells: blocks sampled where the surface may be, cells merged, vertices placed."""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import device, kernel
from isophote.kernels.base.simd import lowest_bit
from isophote.kernels.forms.tape_prune import shorten
from isophote.kernels.measure.contour_block import find_crossed_edges, gather_cells, sample_block
from isophote.kernels.measure.contour_merge import load_qef, mean_place, merge_components, solution
from isophote.kernels.measure.contour_regions import child_place, children_undecided, shorten_for_region
from isophote.kernels.measure.contour_roots import find_roots
from isophote.kernels.measure.contour_tables import BLOCK, BRICK, CONTOUR, OUTPUT, WORK
from isophote.kernels.measure.qef import solve_qefs

__all__ = ["AT_BORDER", "DONE", "NOT_A_NUMBER", "NO_ROOM", "contour_bricks"]

# What a call ends with: all bricks done; no room for the next one; a NaN in it; the surface at the grid's border.
DONE, NO_ROOM, NOT_A_NUMBER, AT_BORDER = 0, 1, 2, 3

_SIDE = np.int64(BRICK + 1)
_BATCH = 16
_DONE, _NO_ROOM, _NOT_A_NUMBER, _AT_BORDER = np.int64(0), np.int64(1), np.int64(2), np.int64(3)
# Cells and components that a block may have.
_BLOCK_CELLS, _BLOCK_COMPONENTS = np.int64(BLOCK**3), np.int64(4 * BLOCK**3)

# Levels of cells within a brick, each of which has no more components than the one below.
_LEVELS = np.int64(6)

_open_contour, _open_work, _open_output = CONTOUR.open, WORK.open, OUTPUT.open


@device
def _crosses_border(grid, work, i, j, k):
    """Whether a block reaches the grid's border, and has a sample inside there."""
    signs = work.rows_of_signs
    first, last = np.int32(1), np.int32(1 << BLOCK)
    for z in range(BLOCK + 1):
        for y in range(BLOCK + 1):
            row = signs[z * (BLOCK + 1) + y]
            if (i == 0 and row & first != 0) or (i + BLOCK == grid.nx and row & last != 0):
                return True
            if row != 0 and (j + y == 0 or j + y == grid.ny or k + z == 0 or k + z == grid.nz):
                return True
    return False


@device
def _contour_block(grid, work, output, rows, child, i, j, k, cell, component, base):
    """Contour one block of a brick at (i, j, k): how it ended, and the next free numbers of cells and components."""
    x, y, z = child_place(child)
    x, y, z = x * BLOCK, y * BLOCK, z * BLOCK
    if not sample_block(grid, work, rows, i + x, j + y, k + z):
        return _NOT_A_NUMBER, cell, component
    if _crosses_border(grid, work, i + x, j + y, k + z):
        return _AT_BORDER, cell, component
    crossings = find_crossed_edges(work)
    if crossings == 0:
        return _DONE, cell, component
    if cell + _BLOCK_CELLS > output.codes.rows or component + _BLOCK_COMPONENTS > work.following.rows:
        return _NO_ROOM, cell, component
    if base + _LEVELS * (component + _BLOCK_COMPONENTS) > output.parents.rows:
        return _NO_ROOM, cell, component
    find_roots(grid, work, rows, crossings, x, y, z)
    cell, component = gather_cells(grid, work, output, np.int64(child), x, y, z, _SIDE, cell, component, base)
    return _DONE, cell, component


@device
def _contour_blocks(grid, work, output, i, j, k, cell, base):
    """Contour the blocks of a brick: how it ended, the next free cell, and the number of components."""
    component = np.int64(0)
    near = shorten_for_region(grid, work, i, j, k, np.int64(BRICK))
    if near == 0:
        return _DONE, cell, component
    for sixteen in range(4):
        held = children_undecided(grid, work, near, sixteen, i, j, k, np.int64(BLOCK))
        while held != 0:
            lane = np.int64(lowest_bit(held))
            held &= held - np.int32(1)
            rows = shorten(work.near, np.int64(0), near, work.choices, lane, work.leaf, np.int64(0), work.marks)
            child = 16 * sixteen + lane
            status, cell, component = _contour_block(grid, work, output, rows, child, i, j, k, cell, component, base)
            if status != _DONE:
                return status, cell, component
    return _DONE, cell, component


@device
def _place_smallest(grid, work, components):
    """Place the vertices of the smallest cells."""
    pending = _DONE
    for component in range(components):
        if grid.sharp == 0:
            for axis in range(3):
                work.places[component, axis] = mean_place(work.moments, component, axis)
            continue
        load_qef(work, pending, component, np.int64(1))
        work.labels[pending] = np.int32(component)
        pending += 1
        if pending == _BATCH:
            _solve(work, pending)
            pending = _DONE
    _solve(work, pending)


@device
def _solve(work, count):
    solve_qefs(work.qefs)
    for lane in range(count):
        solution(work, lane, np.int64(work.labels[lane]))


@device
def _put_out(work, output, made, base, i, j, k):
    """Put out a brick's components, but for those that came to nothing; the next free number."""
    node = base
    for component in range(made):
        if work.numbers[component] >= 0:
            work.numbers[component] = np.int32(node)
            node += 1
    end = node
    for component in range(made):
        if work.numbers[component] < 0:
            continue
        node = np.int64(work.numbers[component])
        parent = work.parents[component]
        output.parents[node] = work.numbers[parent] if parent >= 0 else np.int32(-1)
        output.levels[node] = work.levels[component]
        output.places[node, 0] = work.places[component, 0] + np.float64(i)
        output.places[node, 1] = work.places[component, 1] + np.float64(j)
        output.places[node, 2] = work.places[component, 2] + np.float64(k)
    return end


@device
def _owned_edges(cases, first, last):
    """How many edges that start at the low corners of cells are crossed."""
    count = 0
    for cell in range(first, last):
        case = cases[cell]
        for axis in range(3):
            count += (case ^ case >> (1 << axis)) & 1
    return count


@kernel
def contour_bricks(contour, scratch, out, bricks, first, last):
    """Contour `bricks[first:last]`, numbers of bricks; what comes of them goes to the output, a row of `ends` for each.

    Returns how it ended, and how many bricks are done.
    """
    grid, work, output = _open_contour(contour), _open_work(scratch), _open_output(out)
    across, along = (grid.nx + BRICK - 1) // BRICK, (grid.ny + BRICK - 1) // BRICK
    cell, base = np.int64(0), np.int64(0)
    for place in range(first, last):
        brick = bricks[place]
        i, j, k = brick % across * BRICK, brick // across % along * BRICK, brick // (across * along) * BRICK
        status, end, components = _contour_blocks(grid, work, output, i, j, k, cell, base)
        if status != _DONE:
            return status, place - first
        made = components
        for component in range(components):
            work.numbers[component] = np.int32(0)
        if grid.reach >= 0:
            made = merge_components(grid, work, components)
        _place_smallest(grid, work, components)
        base = _put_out(work, output, made, base, i, j, k)
        row = place - first
        output.ends[row, 0], output.ends[row, 1] = np.int32(end), np.int32(base)
        output.ends[row, 2] = np.int32(_owned_edges(output.cases, cell, end))
        cell = end
    return _DONE, np.int64(last - first)
