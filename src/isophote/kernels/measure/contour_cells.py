"""The cells of a block that the surface crosses: their components, and the edges that start at their low corners."""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import device, exact_apart
from isophote.kernels.base.simd import load4, lowest_bit, store4
from isophote.kernels.base.simd_double import double_lane, load_doubles, splat_doubles, store_doubles
from isophote.kernels.base.simd_planes import later_products, leading_products
from isophote.kernels.measure.contour_cases import AMBIGUOUS, COUNT_SHIFT
from isophote.kernels.measure.contour_tables import (
    AXIS_BIT,
    BLOCK,
    BLOCK_SAMPLES,
    CODE_BIT,
    CROSSING,
    MOMENTS,
    PLANE,
)
from isophote.kernels.measure.morton import bit_count

__all__ = ["BLOCKED", "gather_cells"]

# Beside the twelve bits of a component's crossed edges: it must not be merged.
BLOCKED = np.int32(1 << 12)

_SIDE = np.int64(BLOCK + 1)
_HALF_BLOCK = np.int64(BLOCK // 2)
_NOTHING, _HALF = np.float64(0), np.float64(0.5)
_XX, _YY, _ZZ = np.int64(0), np.int64(3), np.int64(5)


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
def _crossed_of_eight(work, x, y, z):
    """Bits of the crossed cells among the eight at (x, y, z) and on, in the order of their codes."""
    row = z * BLOCK + y
    low = work.crossed_cells[row] >> x & 3 | (work.crossed_cells[row + 1] >> x & 3) << 2
    high = work.crossed_cells[row + BLOCK] >> x & 3 | (work.crossed_cells[row + BLOCK + 1] >> x & 3) << 2
    return np.int32(low | high << 4)


@device
def _signs_of_cell(signs, x, row):
    a, b = signs[row] >> x & 3, signs[row + 1] >> x & 3
    c, d = signs[row + _SIDE] >> x & 3, signs[row + _SIDE + 1] >> x & 3
    return a | b << 2 | c << 4 | d << 6


@device
def _add_components(grid, work, case, code, spot, sample, some_unknown, first):
    """Make the components of a cell, from number `first` on; the next free number."""
    word = grid.cases[case]
    flags = BLOCKED if word & AMBIGUOUS else np.int32(0)
    at = 12 * np.int64(case)
    component = first
    for number in range(word >> COUNT_SHIFT & 7):
        mask = grid.component_edges[4 * case + number]
        low, high = splat_doubles(_NOTHING), splat_doubles(_NOTHING)
        bits = bit_count(np.int64(mask))
        for entry in range(at, at + bits):
            place = np.int64(grid.crossings_of_cases[entry])
            crossing = np.int64(work.crossing_of[sample + (place >> 2)])
            work.around[4 * crossing + (place & 3)] = np.int32(component)
            plane = load_doubles(work.planes, PLANE * crossing)
            low, high = low + leading_products(plane), high + later_products(plane)
        at += bits
        store_doubles(work.moments, MOMENTS * component, low)
        store_doubles(work.moments, MOMENTS * component + 8, high)
        work.codes[component] = code
        work.masks[component] = mask | flags
        # Where a crossing has no normal, the trace is less than the number of crossings.
        if some_unknown and double_lane(low, _XX) + double_lane(low, _YY) + double_lane(low, _ZZ) < bits - _HALF:
            work.masks[component] |= BLOCKED
        work.spots[component] = np.int32(spot)
        component += 1
    return component


@device
def _put_edges(work, output, case, code, sample, edge):
    """Put out the crossed edges that start at a cell's low corner; the next free number."""
    for axis in range(3):
        if case & 1 == case >> (1 << axis) & 1:
            continue
        crossing = np.int64(work.crossing_of[axis * BLOCK_SAMPLES + sample])
        output.edges[edge] = case & np.int32(1) | np.int32(axis << AXIS_BIT) | code << np.int32(CODE_BIT)
        store4(output.rings, 4 * edge, load4(work.around, 4 * crossing))
        store4(output.crossings, CROSSING * edge, load4(work.crossings, CROSSING * crossing))
        edge += 1
    return edge


@exact_apart
def gather_cells(grid, work, output, block, corner, side, some_unknown, cell, edge, component, first_edge):
    """Put out the cells of a block that the surface crosses, in the order of their codes, and make their components.

    The block has its number in the brick and its first sample the number `corner` there, of side³ samples; some
    crossings may have no normal. `cell`, `edge` and `component` are the next free numbers, which are returned, and the
    number of ambiguous cells; `first_edge` is the brick's first.
    """
    _find_crossed_cells(work)
    ambiguous = np.int64(0)
    for eight in range(_HALF_BLOCK * _HALF_BLOCK * _HALF_BLOCK):
        at = np.int64(grid.places[eight])
        x, y, z = at & 15, at >> 4 & 15, at >> 8
        crossed = _crossed_of_eight(work, np.int32(x), y, z)
        while crossed != 0:
            child = np.int64(lowest_bit(crossed))
            crossed &= crossed - np.int32(1)
            i, j, k = x + (child & 1), y + (child >> 1 & 1), z + (child >> 2)
            row = k * _SIDE + j
            case = _signs_of_cell(work.rows_of_signs, np.int32(i), row)
            code = np.int32(block * BLOCK * BLOCK * BLOCK + 8 * eight + child)
            output.codes[cell] = code
            output.cases[cell] = case
            output.firsts[cell], output.first_edges[cell] = np.int32(component), np.int32(edge - first_edge)
            if grid.cases[case] & AMBIGUOUS:
                ambiguous += 1
            sample = row * _SIDE + i
            spot = corner + (k * side + j) * side + i
            component = _add_components(grid, work, case, code, spot, sample, some_unknown, component)
            edge = _put_edges(work, output, case, code, sample, edge)
            cell += 1
    return cell, edge, component, ambiguous
