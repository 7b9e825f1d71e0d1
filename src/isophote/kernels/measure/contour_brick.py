"""Bricks of 32³ cells: blocks sampled where the surface may be, cells merged, vertices placed."""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import device, kernel
from isophote.kernels.base.simd import lowest_bit
from isophote.kernels.forms.tape_prune import shorten
from isophote.kernels.measure.contour_block import find_crossed_edges, sample_block
from isophote.kernels.measure.contour_cells import gather_cells
from isophote.kernels.measure.contour_merge import merge_components
from isophote.kernels.measure.contour_regions import child_place, children_undecided, shorten_for_region
from isophote.kernels.measure.contour_roots import find_roots
from isophote.kernels.measure.contour_tables import BLOCK, BRICK, CONTOUR, OUTPUT, WORK
from isophote.kernels.measure.contour_vertices import VERTICES, load_error, place_at_mean, place_found
from isophote.kernels.measure.qef import solve_qefs

__all__ = ["AT_BORDER", "DONE", "NOT_A_NUMBER", "NO_ROOM", "contour_bricks"]

# What a call ends with: all bricks done; no room for the next one; a NaN in it; the surface at the grid's border.
DONE, NO_ROOM, NOT_A_NUMBER, AT_BORDER = 0, 1, 2, 3

_SIDE = np.int64(BRICK + 1)
_DONE, _NO_ROOM, _NOT_A_NUMBER, _AT_BORDER = np.int64(0), np.int64(1), np.int64(2), np.int64(3)
_NONE = np.int64(0)
# Cells, edges and components that a block may have.
_BLOCK_CELLS, _BLOCK_EDGES, _BLOCK_COMPONENTS = np.int64(BLOCK**3), np.int64(3 * BLOCK**3), np.int64(4 * BLOCK**3)

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
def _has_room(work, output, cell, edge, component, base):
    """Whether there is room for what one more block may hold, and for all that a brick's components are merged into."""
    if cell + _BLOCK_CELLS > output.codes.rows or edge + _BLOCK_EDGES > output.edges.rows:
        return False
    components = component + _BLOCK_COMPONENTS
    return components <= work.following.rows and base + _LEVELS * components <= output.parents.rows


@device
def _contour_block(grid, work, output, rows, child, i, j, k, cell, edge, component, base, first_edge):
    """Contour one block of a brick at (i, j, k): how it ended, the next free numbers of cells, edges and components,
    and how many cells are ambiguous."""
    x, y, z = child_place(child)
    x, y, z = x * BLOCK, y * BLOCK, z * BLOCK
    if not sample_block(grid, work, rows, i + x, j + y, k + z):
        return _NOT_A_NUMBER, cell, edge, component, _NONE
    if _crosses_border(grid, work, i + x, j + y, k + z):
        return _AT_BORDER, cell, edge, component, _NONE
    crossings = find_crossed_edges(work)
    if crossings == 0:
        return _DONE, cell, edge, component, _NONE
    if not _has_room(work, output, cell, edge, component, base):
        return _NO_ROOM, cell, edge, component, _NONE
    some_unknown = find_roots(grid, work, rows, crossings, x, y, z)
    corner = (z * _SIDE + y) * _SIDE + x
    cell, edge, component, ambiguous = gather_cells(
        grid, work, output, np.int64(child), corner, _SIDE, some_unknown, cell, edge, component, first_edge
    )
    return _DONE, cell, edge, component, ambiguous


@device
def _contour_blocks(grid, work, output, i, j, k, cell, edge, base):
    """Contour the blocks of a brick: how it ended, the next free numbers of cells and edges, the number of components,
    and of ambiguous cells."""
    component, ambiguous, first_edge = _NONE, _NONE, edge
    near = shorten_for_region(grid, work, i, j, k, np.int64(BRICK))
    if near == 0:
        return _DONE, cell, edge, component, ambiguous
    for sixteen in range(4):
        held = children_undecided(grid, work, near, sixteen, i, j, k, np.int64(BLOCK))
        while held != 0:
            lane = np.int64(lowest_bit(held))
            held &= held - np.int32(1)
            rows = shorten(work.near, np.int64(0), near, work.choices, lane, work.leaf, np.int64(0), work.marks)
            status, cell, edge, component, more = _contour_block(
                grid, work, output, rows, 16 * sixteen + lane, i, j, k, cell, edge, component, base, first_edge
            )
            ambiguous += more
            if status != _DONE:
                return status, cell, edge, component, ambiguous
    return _DONE, cell, edge, component, ambiguous


@device
def _solve(work, count):
    solve_qefs(work.qefs)
    for lane in range(count):
        place_found(work, lane, np.int64(work.list[lane]))


@device
def _place_smallest(grid, work, components):
    """Place the vertices of the smallest cells that are not merged."""
    if grid.sharp == 0:
        for component in range(components):
            place_at_mean(work, component)
        return
    pending = _NONE
    for component in range(components):
        if work.parents[component] >= 0:
            continue
        load_error(work, pending, component, np.int64(1))
        work.list[pending] = np.int32(component)
        pending += 1
        if pending == VERTICES:
            _solve(work, pending)
            pending = _NONE
    _solve(work, pending)


@device
def _put_out(work, output, made, base, i, j, k):
    """Put out a brick's components; the next free number."""
    x, y, z = np.float64(i), np.float64(j), np.float64(k)
    for component in range(made):
        output.parents[base + component] = work.parents[component]
    for component in range(made):
        output.levels[base + component] = work.levels[component]
    for component in range(made):
        if work.parents[component] < 0 or work.levels[component] > 0:
            place, out = work.places[component], output.places[base + component]
            out[0], out[1], out[2] = place[0] + x, place[1] + y, place[2] + z
    # What components are merged into comes after them.
    for component in range(made - 1, -1, -1):
        parent = np.int64(work.parents[component])
        root = parent - component + output.roots[base + parent] if parent >= 0 else _NONE
        output.roots[base + component] = np.int32(root)
    return base + made


@kernel
def contour_bricks(contour, scratch, out, bricks, first, last, done):
    """Contour `bricks[first:last]`, numbers of bricks; what comes of them goes to the output, after the `done` bricks
    that are there already, a row of `ends` for each.

    Returns how it ended, and how many bricks are in the output then.
    """
    grid, work, output = _open_contour(contour), _open_work(scratch), _open_output(out)
    across, along = (grid.nx + BRICK - 1) // BRICK, (grid.ny + BRICK - 1) // BRICK
    cell, edge, base = _NONE, _NONE, _NONE
    if done > 0:
        before = output.ends[done - 1]
        cell, edge, base = np.int64(before[0]), np.int64(before[1]), np.int64(before[2])
    for place in range(first, last):
        brick = bricks[place]
        i, j, k = brick % across * BRICK, brick // across % along * BRICK, brick // (across * along) * BRICK
        status, next_cell, next_edge, components, ambiguous = _contour_blocks(
            grid, work, output, i, j, k, cell, edge, base
        )
        if status != _DONE:
            return status, done
        cell, edge, made = next_cell, next_edge, components
        for component in range(components):
            work.parents[component], work.levels[component] = np.int32(-1), 0
        if grid.reach >= 0:
            made = merge_components(grid, work, components)
        _place_smallest(grid, work, components)
        base = _put_out(work, output, made, base, i, j, k)
        row = output.ends[done]
        done += 1
        row[0], row[1], row[2], row[3] = np.int32(cell), np.int32(edge), np.int32(base), np.int32(ambiguous)
    return _DONE, done
