"""Cells and their crossings found again among those of all bricks; vertices of what was merged and is split again."""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import device, kernel
from isophote.kernels.base.simd_double import load_doubles, splat_doubles, store_doubles
from isophote.kernels.base.simd_planes import later_products, leading_products
from isophote.kernels.base.table import DOUBLE_BOXES, FLOATS, INTS, Table
from isophote.kernels.measure.contour_cases import COMPONENT_BITS, COUNT_SHIFT
from isophote.kernels.measure.contour_faces import cell_of, open_faces, place_of_brick, slot_at
from isophote.kernels.measure.contour_tables import MOMENTS
from isophote.kernels.measure.contour_vertices import VERTICES, load_error, place_found, put_plane
from isophote.kernels.measure.morton import unpacked
from isophote.kernels.measure.qef import solve_qefs

__all__ = ["PARTS", "crossing_at", "is_crossed", "place_of_cell", "place_parts", "start_of_edge"]

PARTS = Table(
    "ContourParts",
    # The components whose vertices are sought together, the codes of their cells, their error functions, and one plane.
    components=INTS,
    codes=INTS,
    moments=DOUBLE_BOXES,
    places=DOUBLE_BOXES,
    plane=DOUBLE_BOXES,
    qefs=FLOATS,
)

_EDGES = np.int64(12)
_NONE = np.int64(0)
_NOTHING = np.float64(0)
_open_parts = PARTS.open


@device
def place_of_cell(t, brick, cell):
    """The place of a brick's cell in the grid."""
    x0, y0, z0 = place_of_brick(t, brick)
    code = np.int64(t.codes[cell])
    return x0 + unpacked(code), y0 + unpacked(code >> 1), z0 + unpacked(code >> 2)


@device
def is_crossed(case, edge):
    """Whether the surface crosses an edge of a cell."""
    axis, u, v = edge // 4, edge & 1, edge >> 1 & 1
    low = u << (axis + 1) % 3 | v << (axis + 2) % 3
    return (case >> low ^ case >> (low | 1 << axis)) & 1 != 0


@device
def start_of_edge(edge, i, j, k):
    """The axis of an edge of the cell at (i, j, k), and where it starts."""
    axis, u, v = edge // 4, edge & 1, edge >> 1 & 1
    low = u << (axis + 1) % 3 | v << (axis + 2) % 3
    return axis, i + (low & 1), j + (low >> 1 & 1), k + (low >> 2)


@device
def crossing_at(t, axis, i, j, k):
    """The brick and the number of the crossed edge along an axis that starts at (i, j, k)."""
    brick = slot_at(t, i, j, k)
    cell = cell_of(t, brick, i, j, k)
    edge = t.edge_starts[brick] + t.first_edges[cell]
    for before in range(axis):
        edge += (t.cases[cell] ^ t.cases[cell] >> (1 << before)) & 1
    return brick, edge


@device
def _weigh(t, parts, lane, brick, cell, number):
    """The error function of a component of a cell."""
    x0, y0, z0 = place_of_brick(t, brick)
    i, j, k = place_of_cell(t, brick, cell)
    case = t.cases[cell]
    word = np.int64(t.words[case])
    low, high = splat_doubles(_NOTHING), splat_doubles(_NOTHING)
    for edge in range(_EDGES):
        if not is_crossed(case, edge) or word >> COMPONENT_BITS * edge & 3 != number:
            continue
        axis, a, b, c = start_of_edge(edge, i, j, k)
        _, found = crossing_at(t, axis, a, b, c)
        crossing = t.crossings[found]
        along = np.float64(crossing[0])
        x = np.float64(a - x0) + (along if axis == 0 else 0.0)
        y = np.float64(b - y0) + (along if axis == 1 else 0.0)
        z = np.float64(c - z0) + (along if axis == 2 else 0.0)
        put_plane(parts.plane[0], x, y, z, np.float64(crossing[1]), np.float64(crossing[2]), np.float64(crossing[3]))
        plane = load_doubles(parts.plane, _NONE)
        low, high = low + leading_products(plane), high + later_products(plane)
    store_doubles(parts.moments, MOMENTS * lane, low)
    store_doubles(parts.moments, MOMENTS * lane + 8, high)


@device
def _solve(t, parts, count, brick):
    """Place the vertices of a batch."""
    x0, y0, z0 = place_of_brick(t, brick)
    solve_qefs(parts.qefs)
    for lane in range(count):
        place_found(parts, lane, lane)
        place, found = t.places[parts.components[lane]], parts.places[lane]
        place[0], place[1], place[2] = found[0] + np.float64(x0), found[1] + np.float64(y0), found[2] + np.float64(z0)


@kernel
def place_parts(tables, bricks, scratch):
    """Place the vertices of the smallest cells' components, in bricks, that were merged and are split again."""
    t, parts = open_faces(tables), _open_parts(scratch)
    for brick in bricks:
        first, pending = t.nodes[brick], _NONE
        for cell in range(t.starts[brick], t.starts[brick + 1]):
            for number in range(t.words[t.cases[cell]] >> COUNT_SHIFT & 7):
                component = first + t.firsts[cell] + number
                parent = first + t.parents[component]
                if parent < first or t.split[parent] == 0:
                    continue
                _weigh(t, parts, pending, brick, cell, number)
                parts.components[pending], parts.codes[pending] = np.int32(component), t.codes[cell]
                load_error(parts, pending, pending, np.int64(1))
                pending += 1
                if pending == VERTICES:
                    _solve(t, parts, pending, brick)
                    pending = _NONE
        _solve(t, parts, pending, brick)
