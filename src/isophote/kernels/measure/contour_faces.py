"""Faces of a contour: for each edge of the grid that the surface crosses, the vertices of the four cells round it."""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import device, kernel
from isophote.kernels.base.table import BYTES, DOUBLE_BOXES, FLOAT, FLOATS, INT, INT_ROWS, INTS, LONGS, Table
from isophote.kernels.measure.contour_cases import COMPONENT_BITS
from isophote.kernels.measure.contour_tables import BRICK
from isophote.kernels.measure.morton import X_BITS, bit_count, morton, stepped_back, unpacked

__all__ = [
    "FACES",
    "cell_at",
    "find_vertices",
    "index_bricks",
    "open_faces",
    "place_of_brick",
    "put_together",
    "write_faces",
]

FACES = Table(
    "ContourFaces",
    bricks=LONGS,
    # Number of each brick among those that have cells, or -1; cells of brick b are starts[b] to starts[b + 1], its
    # components nodes[b] to nodes[b + 1].
    slots=INTS,
    starts=LONGS,
    nodes=LONGS,
    across=INT,
    along=INT,
    # The cells of all bricks, one brick after another, and words of their cases.
    codes=INTS,
    cases=INTS,
    firsts=INTS,
    crossings=FLOATS,
    normals=INTS,
    words=INTS,
    # Components: what they are merged into, the level of their cells, whether they are split into their parts again or
    # shall be; the places of their vertices, in cells of the grid; and what they are merged into in the end.
    parents=INTS,
    levels=BYTES,
    split=BYTES,
    to_split=BYTES,
    places=DOUBLE_BOXES,
    vertices=INTS,
    # How high, in cells, a triangle must be for its turning over to matter.
    least_height=FLOAT,
    # A bit for each cell of a brick, and how many cells come before each word of 32.
    present=INT_ROWS,
    ranks=INT_ROWS,
)

# The bits of a code within a brick.
_CODE = np.int64(BRICK**3 - 1)
# Triangles whose normals are farther than this cosine from that of the surface are folded over.
_TURNED = np.float64(0.1)
_CLOSE = np.float64(1e-4)
open_faces = FACES.open


@kernel
def index_bricks(tables, first, last):
    """Fill in `present` and `ranks` of bricks."""
    t = open_faces(tables)
    for brick in range(first, last):
        for cell in range(t.starts[brick], t.starts[brick + 1]):
            code = t.codes[cell]
            t.present[brick, code >> 5] |= np.int32(1) << np.int32(code & 31)
        before = 0
        for word in range(t.present.columns):
            t.ranks[brick, word] = np.int32(before)
            before += bit_count(np.int64(t.present[brick, word]) & np.int64(0xFFFFFFFF))


@kernel
def find_vertices(tables, first, last):
    """Find what the components `first` ≤ c < `last` are merged into in the end, and not split."""
    t = open_faces(tables)
    for component in range(first, last):
        node = np.int64(component)
        while t.parents[node] >= 0 and t.split[t.parents[node]] == 0:
            node = np.int64(t.parents[node])
        t.vertices[component] = np.int32(node)


@device
def _cell_of_code(t, slot, code):
    """The number of the cell of a code in a brick, which is known to be there."""
    word = code >> 5
    below = np.int64(t.present[slot, word]) & ((np.int64(1) << (code & 31)) - 1)
    return t.starts[slot] + t.ranks[slot, word] + bit_count(below)


@device
def cell_at(t, i, j, k):
    """The number of a cell that is known to be there."""
    brick = (k // BRICK * t.along + j // BRICK) * t.across + i // BRICK
    return _cell_of_code(t, np.int64(t.slots[brick]), morton(i % BRICK, j % BRICK, k % BRICK))


@device
def _cell_before(t, slot, code, bits, i, j, k):
    """The cell at (i, j, k), which is one before that of a code along the axis whose bits are given."""
    return _cell_of_code(t, slot, stepped_back(code, bits)) if code & bits != 0 else cell_at(t, i, j, k)


@device
def _vertex(t, cell, edge):
    component = t.firsts[cell] + (t.words[t.cases[cell]] >> COMPONENT_BITS * edge & 3)
    return np.int64(t.vertices[component])


@device
def _height(t, axis, a, b, c, u0, v0):
    """Where the line along an axis through (u0, v0) meets the plane of three vertices."""
    u, v = (axis + 1) % 3, (axis + 2) % 3
    p = t.places
    bu, bv, bw = p[b, u] - p[a, u], p[b, v] - p[a, v], p[b, axis] - p[a, axis]
    cu, cv, cw = p[c, u] - p[a, u], p[c, v] - p[a, v], p[c, axis] - p[a, axis]
    area = bu * cv - bv * cu
    if area == 0.0:
        return np.inf
    s = (u0 - p[a, u]) * cv - (v0 - p[a, v]) * cu
    r = bu * (v0 - p[a, v]) - bv * (u0 - p[a, u])
    return p[a, axis] + (s * bw + r * cw) / area


@device
def _miss(t, axis, a, b, c, d, u0, v0, height):
    """How far a quad cut from a to c misses the crossing of its edge, which is at (u0, v0) across the axis."""
    u, v = (axis + 1) % 3, (axis + 2) % 3
    p = t.places
    side = (p[c, u] - p[a, u]) * (v0 - p[a, v]) - (p[c, v] - p[a, v]) * (u0 - p[a, u])
    other = (p[c, u] - p[a, u]) * (p[b, v] - p[a, v]) - (p[c, v] - p[a, v]) * (p[b, u] - p[a, u])
    met = _height(t, axis, a, b, c, u0, v0) if side * other >= 0.0 else _height(t, axis, a, c, d, u0, v0)
    return abs(met - height)


@device
def _square(p, a, b):
    """Square distance of two vertices."""
    x, y, z = p[b, 0] - p[a, 0], p[b, 1] - p[a, 1], p[b, 2] - p[a, 2]
    return x * x + y * y + z * z


@device
def _is_cut_from_first(t, axis, a, b, c, d, u0, v0, height):
    """Whether the diagonal from a to c comes nearer to the crossing than that from b to d, or else is shorter."""
    along_ac = _miss(t, axis, a, b, c, d, u0, v0, height)
    along_bd = _miss(t, axis, b, c, d, a, u0, v0, height)
    if abs(along_ac - along_bd) > _CLOSE:
        return along_ac < along_bd
    return _square(t.places, a, c) <= _square(t.places, b, d)


@device
def _is_folded(t, a, b, c, normal):
    """Whether a triangle is turned away from the surface, and high enough for that to matter."""
    p = t.places
    ux, uy, uz = p[b, 0] - p[a, 0], p[b, 1] - p[a, 1], p[b, 2] - p[a, 2]
    vx, vy, vz = p[c, 0] - p[a, 0], p[c, 1] - p[a, 1], p[c, 2] - p[a, 2]
    x, y, z = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    area = np.sqrt(x * x + y * y + z * z)
    longest = max(ux * ux + uy * uy + uz * uz, vx * vx + vy * vy + vz * vz, _square(p, b, c))
    if area <= np.float64(t.least_height) * np.sqrt(longest):
        return False
    nx, ny, nz = (normal & 1023) - 511, (normal >> 10 & 1023) - 511, (normal >> 20 & 1023) - 511
    return x * nx + y * ny + z * nz < _TURNED * 511.0 * area


@device
def _split_largest(t, a, b, c):
    """Ask for the largest merged components of three to be split."""
    most = max(t.levels[a], t.levels[b], t.levels[c])
    if most == 0:
        return
    for vertex in (a, b, c):
        if t.levels[vertex] == most:
            t.to_split[vertex] = 1


@device
def _write(t, out, count, a, b, c, normal):
    if a == b or b == c or c == a:
        return count
    if t.levels[a] | t.levels[b] | t.levels[c] != 0 and _is_folded(t, a, b, c, normal):
        _split_largest(t, a, b, c)
    out[count, 0], out[count, 1], out[count, 2] = np.int32(a), np.int32(b), np.int32(c)
    return count + 1


@device
def _write_quad(t, out, count, axis, place, normal, a, b, c, d, u0, v0):
    """Write the face of four vertices, cut in two; where some are one, the triangle that is left, or nothing."""
    if a == b or b == c or c == d or d == a:
        if a == b or b == c:
            return _write(t, out, count, a, c, d, normal)
        return _write(t, out, count, a, b, c, normal)
    if _is_cut_from_first(t, axis, a, b, c, d, u0, v0, place):
        count = _write(t, out, count, a, b, c, normal)
        return _write(t, out, count, a, c, d, normal)
    count = _write(t, out, count, b, c, d, normal)
    return _write(t, out, count, b, d, a, normal)


@device
def _write_edge(t, out, count, brick, cell, axis, i, j, k):
    """The face of the edge along an axis that starts at the low corner of a cell."""
    u, v = (axis + 1) % 3, (axis + 2) % 3
    ui, uj, uk = np.int64(u == 0), np.int64(u == 1), np.int64(u == 2)
    vi, vj, vk = np.int64(v == 0), np.int64(v == 1), np.int64(v == 2)
    first, code = 4 * axis, np.int64(t.codes[cell])
    u_bits, v_bits = (X_BITS << u) & _CODE, (X_BITS << v) & _CODE
    c = _vertex(t, cell, first)
    b = _vertex(t, _cell_before(t, brick, code, v_bits, i - vi, j - vj, k - vk), first + 2)
    d = _vertex(t, _cell_before(t, brick, code, u_bits, i - ui, j - uj, k - uk), first + 1)
    # Within a merged cell; or along its border, as whole cells are merged.
    if b == c and c == d:
        return count
    if code & u_bits != 0 and code & v_bits != 0:
        across = _cell_of_code(t, brick, stepped_back(stepped_back(code, u_bits), v_bits))
    else:
        across = cell_at(t, i - ui - vi, j - uj - vj, k - uk - vk)
    a = _vertex(t, across, first + 3)
    if (a == b and c == d) or (a == d and b == c):
        return count
    u0, v0 = np.float64(i * ui + j * uj + k * uk), np.float64(i * vi + j * vj + k * vk)
    origin = (i if axis == 0 else j if axis == 1 else k) // BRICK * BRICK
    place = np.float64(t.crossings[3 * cell + axis]) + np.float64(origin)
    normal = np.int64(t.normals[3 * cell + axis])
    if t.cases[cell] & 1 == 0:
        a, b, c, d = d, c, b, a
    return _write_quad(t, out, count, axis, place, normal, a, b, c, d, u0, v0)


@device
def place_of_brick(t, brick):
    """The place of a brick's first cell in the grid."""
    number = t.bricks[brick]
    return number % t.across * BRICK, number // t.across % t.along * BRICK, number // (t.across * t.along) * BRICK


@kernel
def write_faces(tables, brick, out):
    """Write the triangles of a brick's edges into `out`, (n, 3) int32, anticlockwise from outside; their number.

    Asks for merged components to be split where a triangle is folded over.
    """
    t = open_faces(tables)
    x0, y0, z0 = place_of_brick(t, brick)
    count = np.int64(0)
    for cell in range(t.starts[brick], t.starts[brick + 1]):
        case, code = t.cases[cell], np.int64(t.codes[cell])
        i, j, k = x0 + unpacked(code), y0 + unpacked(code >> 1), z0 + unpacked(code >> 2)
        for axis in range(3):
            if (case ^ case >> (1 << axis)) & 1 != 0:
                count = _write_edge(t, out, count, np.int64(brick), cell, np.int64(axis), i, j, k)
    return count


@kernel
def put_together(places, cell, low, triangles, numbers, vertices):
    """Number the components that triangles (m, 3) name, and write their places in the world into `vertices` (n, 3).

    `numbers` (n,) int32 is 0 at first. The triangles name the vertices then; returns how many there are.
    """
    for row in range(triangles.shape[0]):
        for corner in range(3):
            numbers[triangles[row, corner]] = 1
    count = np.int64(0)
    for component in range(numbers.shape[0]):
        if numbers[component] != 0:
            for axis in range(3):
                vertices[count, axis] = places[component, axis] * cell + low[axis]
            numbers[component] = np.int32(count)
            count += 1
    for row in range(triangles.shape[0]):
        for corner in range(3):
            triangles[row, corner] = numbers[triangles[row, corner]]
    return count
