"""Faces of a contour: for each edge of the grid that the surface crosses, the vertices of the four cells round it."""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import device, kernel
from isophote.kernels.base.table import DOUBLE_BOXES, FLOATS, INT, INT_ROWS, INTS, LONGS, Table
from isophote.kernels.measure.contour_cases import COMPONENT_BITS
from isophote.kernels.measure.contour_tables import BRICK
from isophote.kernels.measure.morton import bit_count, morton, unpacked

__all__ = ["FACES", "index_bricks", "write_faces"]

# The cells of all bricks, one brick after another, with their vertices in cells of the grid.
FACES = Table(
    "ContourFaces",
    bricks=LONGS,
    # Number of each brick among those that have cells, or -1; cells of brick b are starts[b] to starts[b + 1].
    slots=INTS,
    starts=LONGS,
    across=INT,
    along=INT,
    codes=INTS,
    cases=INTS,
    firsts=INTS,
    words=INTS,
    crossings=FLOATS,
    vertex_of=INTS,
    vertices=DOUBLE_BOXES,
    # A bit for each cell of a brick, and how many cells come before each word of 32.
    present=INT_ROWS,
    ranks=INT_ROWS,
)

_WORD = np.int64(32)
_open = FACES.open


@kernel
def index_bricks(tables, first, last):
    """Fill in `present` and `ranks` of bricks."""
    t = _open(tables)
    for brick in range(first, last):
        for cell in range(t.starts[brick], t.starts[brick + 1]):
            code = t.codes[cell]
            t.present[brick, code >> 5] |= np.int32(1) << np.int32(code & 31)
        before = 0
        for word in range(t.present.columns):
            t.ranks[brick, word] = np.int32(before)
            before += bit_count(np.int64(t.present[brick, word]) & np.int64(0xFFFFFFFF))


@device
def _cell_at(t, i, j, k):
    """The number of a cell that is known to be there."""
    brick = (k // BRICK * t.along + j // BRICK) * t.across + i // BRICK
    slot = np.int64(t.slots[brick])
    code = morton(i % BRICK, j % BRICK, k % BRICK)
    word, bit = code // _WORD, code % _WORD
    below = np.int64(t.present[slot, word]) & ((np.int64(1) << bit) - 1)
    return t.starts[slot] + t.ranks[slot, word] + bit_count(below)


@device
def _vertex(t, cell, edge):
    component = t.firsts[cell] + (t.words[t.cases[cell]] >> COMPONENT_BITS * edge & 3)
    return np.int64(t.vertex_of[component])


@device
def _height(t, axis, a, b, c, u0, v0):
    """Where the line along an axis through (u0, v0) meets the plane of three vertices."""
    u, v = (axis + 1) % 3, (axis + 2) % 3
    p = t.vertices
    bu, bv, bw = p[b, u] - p[a, u], p[b, v] - p[a, v], p[b, axis] - p[a, axis]
    cu, cv, cw = p[c, u] - p[a, u], p[c, v] - p[a, v], p[c, axis] - p[a, axis]
    area = bu * cv - bv * cu
    if area == 0.0:
        return np.inf
    s = ((u0 - p[a, u]) * cv - (v0 - p[a, v]) * cu) / area
    r = (bu * (v0 - p[a, v]) - bv * (u0 - p[a, u])) / area
    return p[a, axis] + s * bw + r * cw


@device
def _miss(t, axis, a, b, c, d, u0, v0, height):
    """How far a quad cut from a to c misses the crossing of its edge, which is at (u0, v0) across the axis."""
    u, v = (axis + 1) % 3, (axis + 2) % 3
    p = t.vertices
    side = (p[c, u] - p[a, u]) * (v0 - p[a, v]) - (p[c, v] - p[a, v]) * (u0 - p[a, u])
    other = (p[c, u] - p[a, u]) * (p[b, v] - p[a, v]) - (p[c, v] - p[a, v]) * (p[b, u] - p[a, u])
    met = _height(t, axis, a, b, c, u0, v0) if side * other >= 0.0 else _height(t, axis, a, c, d, u0, v0)
    return abs(met - height)


@device
def _length2(p, a, b):
    x, y, z = p[b, 0] - p[a, 0], p[b, 1] - p[a, 1], p[b, 2] - p[a, 2]
    return x * x + y * y + z * z


@device
def _write(out, count, a, b, c):
    if a == b or b == c or c == a:
        return count
    out[count, 0], out[count, 1], out[count, 2] = np.int32(a), np.int32(b), np.int32(c)
    return count + 1


@device
def _write_quad(t, out, count, axis, place, a, b, c, d, u0, v0):
    """Cut a quad along the diagonal that comes nearer to the crossing that it belongs to, else the shorter one."""
    if a == b or b == c or c == d or d == a:
        return _write(out, count, a, b, c) if a != b and b != c else _write(out, count, a, c, d)
    height = np.float64(place)
    along_ac = _miss(t, axis, a, b, c, d, u0, v0, height)
    along_bd = _miss(t, axis, b, c, d, a, u0, v0, height)
    shorter = _length2(t.vertices, a, c) <= _length2(t.vertices, b, d)
    if along_ac + 1e-4 < along_bd or (shorter and along_ac <= along_bd + 1e-4):
        count = _write(out, count, a, b, c)
        return _write(out, count, a, c, d)
    count = _write(out, count, b, c, d)
    return _write(out, count, b, d, a)


@device
def _write_edge(t, out, count, cell, axis, i, j, k):
    """The face of the edge along an axis that starts at the low corner of a cell."""
    u, v = (axis + 1) % 3, (axis + 2) % 3
    ui, uj, uk = np.int64(u == 0), np.int64(u == 1), np.int64(u == 2)
    vi, vj, vk = np.int64(v == 0), np.int64(v == 1), np.int64(v == 2)
    first = 4 * axis
    a = _vertex(t, _cell_at(t, i - ui - vi, j - uj - vj, k - uk - vk), first + 3)
    b = _vertex(t, _cell_at(t, i - vi, j - vj, k - vk), first + 2)
    c = _vertex(t, cell, first)
    d = _vertex(t, _cell_at(t, i - ui, j - uj, k - uk), first + 1)
    u0, v0 = np.float64(i * ui + j * uj + k * uk), np.float64(i * vi + j * vj + k * vk)
    origin = (i if axis == 0 else j if axis == 1 else k) // BRICK * BRICK
    place = np.float64(t.crossings[3 * cell + axis]) + np.float64(origin)
    if t.cases[cell] & 1 != 0:
        return _write_quad(t, out, count, axis, place, a, b, c, d, u0, v0)
    return _write_quad(t, out, count, axis, place, d, c, b, a, u0, v0)


@kernel
def write_faces(tables, brick, out):
    """Write the triangles of a brick's edges into `out`, (n, 3) int32, anticlockwise from outside; their number."""
    t = _open(tables)
    number = t.bricks[brick]
    x0 = number % t.across * BRICK
    y0 = number // t.across % t.along * BRICK
    z0 = number // (t.across * t.along) * BRICK
    count = np.int64(0)
    for cell in range(t.starts[brick], t.starts[brick + 1]):
        case, code = t.cases[cell], np.int64(t.codes[cell])
        i, j, k = x0 + unpacked(code), y0 + unpacked(code >> 1), z0 + unpacked(code >> 2)
        for axis in range(3):
            if (case ^ case >> (1 << axis)) & 1 != 0:
                count = _write_edge(t, out, count, cell, np.int64(axis), i, j, k)
    return count
