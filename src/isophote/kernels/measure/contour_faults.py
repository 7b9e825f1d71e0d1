"""Cells whose components would make one edge of the mesh too many: found, and given their vertices anew."""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import kernel
from isophote.kernels.measure.contour_cases import COMPONENT_BITS, COUNT_SHIFT
from isophote.kernels.measure.contour_faces import cell_of, open_faces, slot_at
from isophote.kernels.measure.contour_parts import crossing_at, is_crossed, place_of_cell, start_of_edge

__all__ = ["find_faults", "place_components"]

_EDGES = np.int64(12)


@kernel
def find_faults(tables, cells, bricks, twice, out):
    """Pairs of cells whose components both cross the face between them along two curves.

    `cells` (n,) int64 are those to look at and `bricks` the bricks that they are in; `twice` (256,) int32 are bits of
    such faces for all signs. Writes rows (cell, the next along the axis, axis) into `out`; returns their number.
    """
    t = open_faces(tables)
    count = 0
    for number in range(len(cells)):
        cell = cells[number]
        i, j, k = place_of_cell(t, bricks[number], cell)
        for axis in range(3):
            if twice[t.cases[cell]] >> (2 * axis + 1) & 1 == 0:
                continue
            u, v, w = i + np.int64(axis == 0), j + np.int64(axis == 1), k + np.int64(axis == 2)
            other = cell_of(t, slot_at(t, u, v, w), u, v, w)
            if twice[t.cases[other]] >> 2 * axis & 1 != 0:
                out[count, 0], out[count, 1], out[count, 2] = cell, other, axis
                count += 1
    return count


@kernel
def place_components(tables, cells, bricks):
    """Place the vertices of the components of cells in the middle of their crossings, and put them into the rings of
    their edges."""
    t = open_faces(tables)
    for number in range(len(cells)):
        cell, brick = cells[number], bricks[number]
        i, j, k = place_of_cell(t, brick, cell)
        case, first = t.cases[cell], np.int64(t.firsts[cell])
        word = np.int64(t.words[case])
        for component in range(word >> COUNT_SHIFT & 7):
            x, y, z, crossings = 0.0, 0.0, 0.0, 0.0
            for edge in range(_EDGES):
                if not is_crossed(case, edge) or word >> COMPONENT_BITS * edge & 3 != component:
                    continue
                axis, a, b, c = start_of_edge(edge, i, j, k)
                owner, crossing = crossing_at(t, axis, a, b, c)
                if owner == brick:
                    t.rings[crossing, edge & 3] = np.int32(first + component)
                along = np.float64(t.crossings[crossing, 0])
                x += np.float64(a) + (along if axis == 0 else 0.0)
                y += np.float64(b) + (along if axis == 1 else 0.0)
                z += np.float64(c) + (along if axis == 2 else 0.0)
                crossings += 1.0
            node = t.nodes[brick] + first + component
            t.places[node, 0], t.places[node, 1], t.places[node, 2] = x / crossings, y / crossings, z / crossings
