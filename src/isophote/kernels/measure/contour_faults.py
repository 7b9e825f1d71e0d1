"""Cells whose components would make one edge of the mesh too many: found, and given their vertices anew."""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import device, kernel
from isophote.kernels.measure.contour_cases import COMPONENT_BITS, COUNT_SHIFT
from isophote.kernels.measure.contour_faces import cell_of, open_faces, place_of_brick, slot_at
from isophote.kernels.measure.contour_tables import BRICK
from isophote.kernels.measure.morton import unpacked

__all__ = ["find_faults", "place_components"]

_EDGES = np.int64(12)


@device
def _place_of_cell(t, brick, cell):
    """The place of a brick's cell in the grid."""
    x0, y0, z0 = place_of_brick(t, brick)
    code = np.int64(t.codes[cell])
    return x0 + unpacked(code), y0 + unpacked(code >> 1), z0 + unpacked(code >> 2)


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
        i, j, k = _place_of_cell(t, bricks[number], cell)
        for axis in range(3):
            if twice[t.cases[cell]] >> (2 * axis + 1) & 1 == 0:
                continue
            u, v, w = i + np.int64(axis == 0), j + np.int64(axis == 1), k + np.int64(axis == 2)
            other = cell_of(t, slot_at(t, u, v, w), u, v, w)
            if twice[t.cases[other]] >> 2 * axis & 1 != 0:
                out[count, 0], out[count, 1], out[count, 2] = cell, other, axis
                count += 1
    return count


@device
def _edge_of(t, first_edges, axis, i, j, k):
    """The number of the crossed edge along an axis that starts at (i, j, k)."""
    cell = cell_of(t, slot_at(t, i, j, k), i, j, k)
    edge = np.int64(first_edges[cell])
    for before in range(axis):
        edge += (t.cases[cell] ^ t.cases[cell] >> (1 << before)) & 1
    return edge


@kernel
def place_components(tables, cells, bricks, first_edges):
    """Place the vertices of the components of cells in the middle of their crossings, and put them into the rings of
    their edges.

    `first_edges` (n,) int64 are the numbers of the first edge of each of all cells.
    """
    t = open_faces(tables)
    for number in range(len(cells)):
        cell, brick = cells[number], bricks[number]
        i, j, k = _place_of_cell(t, brick, cell)
        case, first = t.cases[cell], np.int64(t.firsts[cell])
        word = np.int64(t.words[case])
        for component in range(word >> COUNT_SHIFT & 7):
            x, y, z, crossings = 0.0, 0.0, 0.0, 0.0
            for edge in range(_EDGES):
                axis, u, v = edge // 4, edge & 1, edge >> 1 & 1
                low = u << (axis + 1) % 3 | v << (axis + 2) % 3
                crossed = (case >> low ^ case >> (low | 1 << axis)) & 1
                if crossed == 0 or word >> COMPONENT_BITS * edge & 3 != component:
                    continue
                a, b, c = i + (low & 1), j + (low >> 1 & 1), k + (low >> 2)
                crossing = _edge_of(t, first_edges, axis, a, b, c)
                if slot_at(t, a, b, c) == brick:
                    t.rings[crossing, edge & 3] = np.int32(first + component)
                along = np.float64(t.crossings[crossing])
                along += np.float64((a if axis == 0 else b if axis == 1 else c) // BRICK * BRICK)
                x += along if axis == 0 else np.float64(a)
                y += along if axis == 1 else np.float64(b)
                z += along if axis == 2 else np.float64(c)
                crossings += 1.0
            node = t.nodes[brick] + first + component
            t.roots[node] = np.int32(first + component)
            t.places[node, 0], t.places[node, 1], t.places[node, 2] = x / crossings, y / crossings, z / crossings
