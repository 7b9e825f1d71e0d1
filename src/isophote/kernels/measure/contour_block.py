"""A block of 8³ cells: samples of a field, crossings of the grid's edges, and components of the cells."""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import device
from isophote.kernels.base.linked import call_linked
from isophote.kernels.base.simd import bits, load16, lowest_bit, splat16, store16
from isophote.kernels.forms.opcodes import INPUTS
from isophote.kernels.measure.contour_cases import AMBIGUOUS, COMPONENT_BITS, COUNT_SHIFT
from isophote.kernels.measure.contour_tables import BLOCK, BLOCK_SAMPLES, CROSSING, MOMENTS, POINTS, WIDTH

__all__ = ["BLOCKED", "CELL_EDGES", "find_crossed_edges", "gather_cells", "sample_block"]

# Beside the twelve bits of a component's crossed edges: it must not be merged.
BLOCKED = np.int32(1 << 12)
CELL_EDGES = 12

_SIDE = np.int64(BLOCK + 1)
_LAYER = _SIDE * _SIDE
_STRIDE = np.int64(16 * WIDTH)
_ALL = np.int32(0xFFFF)
_ZERO, _HALF_RANGE = np.float32(0), np.float32(511)
_NONE = np.int32(-1)
_X, _Y, _Z = np.int64(0), np.int64(1), np.int64(2)


@device
def _place_samples(grid, points, i, j, k):
    at = 0
    for z in range(_SIDE):
        for y in range(_SIDE):
            for x in range(_SIDE):
                points[at] = grid.xs[i + x]
                points[POINTS + at] = grid.ys[j + y]
                points[2 * POINTS + at] = grid.zs[k + z]
                at += 1
    for rest in range(at, POINTS):
        for axis in range(INPUTS):
            points[axis * POINTS + rest] = points[axis * POINTS + at - 1]


@device
def sample_block(grid, work, count, i, j, k):
    """The values at the samples of the block at cell (i, j, k), by the tape in `work.leaf`; False if one is NaN."""
    _place_samples(grid, work.points, i, j, k)
    result = (INPUTS - 1 + count) * _STRIDE
    for start in range(0, POINTS, 16 * WIDTH):
        for axis in range(INPUTS):
            for lane in range(0, 16 * WIDTH, 16):
                store16(work.slots, axis * _STRIDE + lane, load16(work.points, axis * POINTS + start + lane))
        call_linked(grid.run_values, work.leaf_run, np.int64(0), count, np.int64(WIDTH))
        for lane in range(0, 16 * WIDTH, 16):
            store16(work.values, start + lane, load16(work.slots, result + lane))
    numbers = _ALL
    for vector in range(POINTS // 16):
        v = load16(work.values, 16 * vector)
        work.signs[vector] = bits(v < splat16(_ZERO))
        numbers &= bits(v == v)
    for row in range(_LAYER):
        bit = row * _SIDE
        pair = work.signs[bit >> 4] | work.signs[(bit >> 4) + 1] << 16
        work.rows_of_signs[row] = pair >> np.int32(bit & 15) & np.int32((1 << _SIDE) - 1)
    return numbers == _ALL


@device
def _add_edges(work, crossed, axis, sample, count):
    """Number the edges along an axis that start at the samples of set bits."""
    while crossed != 0:
        start = axis * BLOCK_SAMPLES + sample + lowest_bit(np.int32(crossed))
        crossed &= crossed - 1
        work.starts[count] = np.int32(start)
        work.crossing_of[start] = np.int32(count)
        count += 1
    return count


@device
def find_crossed_edges(work):
    """List the edges of the block between samples of unlike signs, in `work.starts`: axis · BLOCK_SAMPLES + sample."""
    signs = work.rows_of_signs
    count = _X
    inner = np.int32((1 << BLOCK) - 1)
    for row in range(_LAYER):
        count = _add_edges(work, np.int64((signs[row] ^ signs[row] >> 1) & inner), _X, row * _SIDE, count)
    for z in range(_SIDE):
        for row in range(z * _SIDE, z * _SIDE + BLOCK):
            count = _add_edges(work, np.int64(signs[row] ^ signs[row + 1]), _Y, row * _SIDE, count)
    for row in range(BLOCK * _SIDE):
        count = _add_edges(work, np.int64(signs[row] ^ signs[row + _SIDE]), _Z, row * _SIDE, count)
    return count


@device
def _find_crossed_cells(work):
    """For each row of cells, bits of those with corners of unlike signs."""
    signs = work.rows_of_signs
    for z in range(BLOCK):
        for y in range(BLOCK):
            row = z * _SIDE + y
            a, b, c, d = signs[row], signs[row + 1], signs[row + _SIDE], signs[row + _SIDE + 1]
            some, each = a | b | c | d, a & b & c & d
            work.crossed_cells[z * BLOCK + y] = (some | some >> 1) & ~(each & each >> 1)


@device
def _signs_of_cell(signs, x, row):
    a, b = signs[row] >> x & 3, signs[row + 1] >> x & 3
    c, d = signs[row + _SIDE] >> x & 3, signs[row + _SIDE + 1] >> x & 3
    return a | b << 2 | c << 4 | d << 6


@device
def _add_crossing(moments, component, crossings, at):
    """Add one plane to a component's error function; False where the surface has no normal."""
    px, py, pz = np.float64(crossings[at]), np.float64(crossings[at + 1]), np.float64(crossings[at + 2])
    nx, ny, nz = np.float64(crossings[at + 3]), np.float64(crossings[at + 4]), np.float64(crossings[at + 5])
    d = nx * px + ny * py + nz * pz
    moments[component, 0] += nx * nx
    moments[component, 1] += nx * ny
    moments[component, 2] += nx * nz
    moments[component, 3] += ny * ny
    moments[component, 4] += ny * nz
    moments[component, 5] += nz * nz
    moments[component, 6] += nx * d
    moments[component, 7] += ny * d
    moments[component, 8] += nz * d
    moments[component, 9] += d * d
    moments[component, 10] += px
    moments[component, 11] += py
    moments[component, 12] += pz
    moments[component, 13] += 1.0
    return nx * nx + ny * ny + nz * nz > 0.5


@device
def _start_in(edge, side):
    """Number of the start of an edge of a cell, relative to the cell's, in a grid of side³ samples."""
    axis, u, v = edge >> 2, edge & 1, edge >> 1 & 1
    if axis == 0:
        return u * side + v * side * side
    if axis == 1:
        return u * side * side + v
    return u + v * side


@device
def _new_component(work, component, code, flags):
    for column in range(MOMENTS):
        work.moments[component, column] = 0.0
    for edge in range(CELL_EDGES):
        work.crossed[component, edge] = _NONE
    work.codes[component] = code
    work.masks[component] = flags
    work.parents[component] = _NONE
    work.levels[component] = 0
    work.heads[component] = component
    work.tails[component] = component
    work.following[component] = _NONE


@device
def _gather_cell(grid, work, code, signs, sample, place, side, first):
    """Make the components of a cell, from number `first` on; `place` is its number among the brick's side³ samples."""
    word = grid.cases[signs]
    flags = BLOCKED if word & AMBIGUOUS else np.int32(0)
    count = np.int64(word >> COUNT_SHIFT & 7)
    for component in range(first, first + count):
        _new_component(work, component, code, flags)
    crossed = grid.crossed[signs]
    while crossed != 0:
        edge = lowest_bit(crossed)
        crossed &= crossed - np.int32(1)
        component = first + (word >> COMPONENT_BITS * edge & 3)
        axis = edge >> 2
        start = axis * BLOCK_SAMPLES + sample + _start_in(edge, _SIDE)
        work.crossed[component, edge] = axis * side * side * side + place + _start_in(edge, side)
        work.masks[component] |= np.int32(1 << edge)
        if not _add_crossing(work.moments, component, work.crossings, work.crossing_of[start] * CROSSING):
            work.masks[component] |= BLOCKED
    return first + count


@device
def _packed_normal(crossings, at):
    """A unit vector in ten bits a coordinate."""
    packed = np.int32(0)
    for axis in range(3):
        packed |= np.int32(crossings[at + axis] * _HALF_RANGE + _HALF_RANGE) << np.int32(10 * axis)
    return packed


@device
def gather_cells(grid, work, output, block, x0, y0, z0, side, cell, component, base):
    """Put out the cells of a block that the surface crosses, in the order of their codes, and make their components.

    The block has its number in the brick and lies at (x0, y0, z0) in it; `cell` and `component` are the next free
    numbers, and `base` what the brick's component 0 is in the output. Returns the next free numbers.
    """
    signs = work.rows_of_signs
    _find_crossed_cells(work)
    for number in range(BLOCK * BLOCK * BLOCK):
        at = np.int64(grid.places[number])
        x, y, z = at & 15, at >> 4 & 15, at >> 8
        if work.crossed_cells[z * BLOCK + y] >> x & 1 == 0:
            continue
        row = z * _SIDE + y
        case = _signs_of_cell(signs, np.int32(x), row)
        code = np.int32(block * BLOCK * BLOCK * BLOCK + number)
        sample = row * _SIDE + x
        place = ((z0 + z) * side + y0 + y) * side + x0 + x
        output.codes[cell] = code
        output.cases[cell] = case
        output.firsts[cell] = np.int32(base + component)
        for axis in range(3):
            if case & 1 != case >> (1 << axis) & 1:
                crossing = work.crossing_of[axis * BLOCK_SAMPLES + sample] * CROSSING
                output.crossings[3 * cell + axis] = work.crossings[crossing + axis]
                output.normals[3 * cell + axis] = _packed_normal(work.crossings, crossing + 3)
        component = _gather_cell(grid, work, code, case, sample, place, side, component)
        cell += 1
    return cell, component
