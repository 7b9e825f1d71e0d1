"""Faces of a contour: for each edge of the grid that the surface crosses, the vertices of the four cells round it."""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.double3 import Double3, cross3, difference, dot3
from isophote.kernels.base.jit import device, kernel
from isophote.kernels.base.table import BYTES, DOUBLE_BOXES, FLOAT, FLOATS, INT, INT_ROWS, INTS, LONGS, Table
from isophote.kernels.measure.contour_cases import COMPONENT_BITS
from isophote.kernels.measure.contour_tables import AXIS_BIT, BRICK, CODE_BIT
from isophote.kernels.measure.morton import bit_count, morton, unpacked

__all__ = [
    "FACES",
    "cell_of",
    "find_vertices",
    "index_bricks",
    "open_faces",
    "place_of_brick",
    "put_together",
    "slot_at",
    "write_faces",
]

FACES = Table(
    "ContourFaces",
    bricks=LONGS,
    # Number of each brick among those that have cells, or -1; cells of brick b are starts[b] to starts[b + 1], its
    # edges and components likewise. A brick's components are numbered from its first one.
    slots=INTS,
    starts=LONGS,
    edge_starts=LONGS,
    nodes=LONGS,
    across=INT,
    along=INT,
    # The cells of all bricks, one brick after another, and words of their cases.
    codes=INTS,
    cases=INTS,
    firsts=INTS,
    words=INTS,
    # Edges, see contour_tables.py.
    edges=INTS,
    rings=INT_ROWS,
    crossings=FLOATS,
    normals=INTS,
    # Components: what they are merged into, the level of their cells, whether they are split into their parts again or
    # shall be; the places of their vertices, in cells of the grid; and what they are merged into in the end.
    parents=INTS,
    levels=BYTES,
    split=BYTES,
    to_split=BYTES,
    places=DOUBLE_BOXES,
    roots=INTS,
    # How high, in cells, a triangle must be for its turning over to matter.
    least_height=FLOAT,
    # A bit for each cell of a brick, and how many cells come before each word of 32.
    present=INT_ROWS,
    ranks=INT_ROWS,
)

# Triangles whose normals are farther than this cosine from that of the surface are folded over.
_TURNED = np.float64(0.1)
# Heights are the same, in cells, that are so close; and the square of a length that is none.
_CLOSE, _NO_LENGTH = np.float64(1e-4), np.float64(1e-8)
_ENDLESS = np.float64(np.inf)
# Normals are whole numbers, so long.
_LENGTH = np.int64(511)
# The cells round an edge, besides that which it starts in.
_BY_U, _BY_V, _FAR = np.int64(1), np.int64(2), np.int64(3)
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
def find_vertices(tables, bricks):
    """Find what the components of bricks are merged into in the end, and not split."""
    t = open_faces(tables)
    for brick in bricks:
        first = t.nodes[brick]
        # What components are merged into comes after them.
        for component in range(t.nodes[brick + 1] - 1, first - 1, -1):
            parent = first + t.parents[component]
            merged = parent >= first and t.split[parent] == 0
            t.roots[component] = t.roots[parent] if merged else np.int32(component - first)


@device
def slot_at(t, i, j, k):
    """The number, among those that have cells, of the brick that the cell at (i, j, k) lies in."""
    return np.int64(t.slots[(k // BRICK * t.along + j // BRICK) * t.across + i // BRICK])


@device
def cell_of(t, slot, i, j, k):
    """The number of a cell that is known to be there, in a brick."""
    code = morton(i % BRICK, j % BRICK, k % BRICK)
    word = code >> 5
    below = np.int64(t.present[slot, word]) & ((np.int64(1) << (code & 31)) - 1)
    return t.starts[slot] + t.ranks[slot, word] + bit_count(below)


@device
def place_of_brick(t, brick):
    """The place of a brick's first cell in the grid."""
    number = t.bricks[brick]
    return number % t.across * BRICK, number // t.across % t.along * BRICK, number // (t.across * t.along) * BRICK


@device
def _root(t, first, component):
    """The vertex of a component, counted from a brick's first, among all."""
    return first + t.roots[first + component]


@device
def _root_in_ring(t, axis, around, i, j, k):
    """The vertex in one of the four cells round an edge, numbered by bits along the two axes after the edge's own, that
    starts at (i, j, k)."""
    u, v = (axis + 1) % 3, (axis + 2) % 3
    back_u, back_v = around & 1, around >> 1
    i -= back_u * np.int64(u == 0) + back_v * np.int64(v == 0)
    j -= back_u * np.int64(u == 1) + back_v * np.int64(v == 1)
    k -= back_u * np.int64(u == 2) + back_v * np.int64(v == 2)
    slot = slot_at(t, i, j, k)
    cell = cell_of(t, slot, i, j, k)
    number = t.words[t.cases[cell]] >> COMPONENT_BITS * (4 * axis + around) & 3
    return _root(t, t.nodes[slot], np.int64(t.firsts[cell] + number))


@device
def _seen_from(t, vertex, axis, u0, v0, w0):
    """A vertex relative to a point; coordinates begin with those of the two axes after the given one."""
    place = t.places[vertex]
    return Double3(place[(axis + 1) % 3] - u0, place[(axis + 2) % 3] - v0, place[axis] - w0)


@device
def _area(a, b):
    """Twice the area, seen along the axis, of the triangle of two points and the crossing."""
    return a.x * b.y - a.y * b.x


@device
def _miss(a, b, c, ab, bc, ac):
    """How far from the crossing the plane of three points meets the axis."""
    whole = ab + bc - ac
    return abs((a.z * bc - b.z * ac + c.z * ab) / whole) if whole != 0.0 else _ENDLESS


@device
def _is_cut_from_first(a, b, c, d):
    """Whether the diagonal from a to c comes nearer to the crossing than that from b to d, or else is shorter.

    A diagonal of no length would leave a triangle of no size, turned anyhow.
    """
    first, second = difference(c, a), difference(d, b)
    first_square, second_square = dot3(first, first), dot3(second, second)
    if first_square < _NO_LENGTH or second_square < _NO_LENGTH:
        return second_square < first_square
    ab, bc, cd, da, ac, bd = _area(a, b), _area(b, c), _area(c, d), _area(d, a), _area(a, c), _area(b, d)
    along_ac = _miss(a, b, c, ab, bc, ac) if ac * (ab + bc - ac) <= 0.0 else _miss(a, c, d, ac, cd, -da)
    along_bd = _miss(b, c, d, bc, cd, bd) if bd * (bc + cd - bd) <= 0.0 else _miss(b, d, a, bd, da, -ab)
    if abs(along_ac - along_bd) > _CLOSE:
        return along_ac < along_bd
    return first_square <= second_square


@device
def _is_folded(t, a, b, c, normal):
    """Whether a triangle is turned away from the surface, and high enough for that to matter."""
    ab, ac, bc = difference(b, a), difference(c, a), difference(c, b)
    across = cross3(ab, ac)
    square = dot3(across, across)
    longest = max(dot3(ab, ab), dot3(ac, ac), dot3(bc, bc))
    height = np.float64(t.least_height)
    if square <= height * height * longest:
        return False
    along = dot3(across, normal)
    return along < 0.0 or along * along < (_TURNED * _LENGTH) * (_TURNED * _LENGTH) * square


@device
def _split_largest(t, a, b, c):
    """Ask for the largest merged components of three to be split."""
    most = max(t.levels[a], t.levels[b], t.levels[c])
    for vertex in (a, b, c):
        if t.levels[vertex] == most:
            t.to_split[vertex] = 1


@device
def _write(t, out, count, a, b, c, p, q, r, normal):
    """Write the triangle of vertices a, b, c at p, q, r; asks for what is folded over to be split."""
    if a == b or b == c or c == a:
        return count
    if t.levels[a] | t.levels[b] | t.levels[c] != 0 and _is_folded(t, p, q, r, normal):
        _split_largest(t, a, b, c)
    out[count, 0], out[count, 1], out[count, 2] = np.int32(a), np.int32(b), np.int32(c)
    return count + 1


@device
def _write_quad(t, out, count, a, b, c, d, p, q, r, s, normal):
    """Write the face of vertices a, b, c, d at p, q, r, s, cut in two; where some are one, what is left."""
    if a == b or b == c:
        return _write(t, out, count, a, c, d, p, r, s, normal)
    if c == d or d == a:
        return _write(t, out, count, a, b, c, p, q, r, normal)
    if _is_cut_from_first(p, q, r, s):
        count = _write(t, out, count, a, b, c, p, q, r, normal)
        return _write(t, out, count, a, c, d, p, r, s, normal)
    count = _write(t, out, count, b, c, d, q, r, s, normal)
    return _write(t, out, count, b, d, a, q, s, p, normal)


@device
def _normal(packed, axis):
    """The normal at a crossing, times `_LENGTH`; coordinates begin with those of the two axes after the given one."""
    u, v = (axis + 1) % 3, (axis + 2) % 3
    x = (packed >> 10 * u & 1023) - _LENGTH
    y = (packed >> 10 * v & 1023) - _LENGTH
    z = (packed >> 10 * axis & 1023) - _LENGTH
    return Double3(np.float64(x), np.float64(y), np.float64(z))


@device
def _write_face(t, out, count, edge, axis, i, j, k, a, b, c, d):
    """The face of the edge along an axis that starts at (i, j, k), between these vertices."""
    along = i if axis == 0 else j if axis == 1 else k
    u0 = np.float64(j if axis == 0 else k if axis == 1 else i)
    v0 = np.float64(k if axis == 0 else i if axis == 1 else j)
    w0 = np.float64(along // BRICK * BRICK) + np.float64(t.crossings[edge])
    if t.edges[edge] & 1 == 0:
        a, b, c, d = d, c, b, a
    p, q = _seen_from(t, a, axis, u0, v0, w0), _seen_from(t, b, axis, u0, v0, w0)
    r, s = _seen_from(t, c, axis, u0, v0, w0), _seen_from(t, d, axis, u0, v0, w0)
    return _write_quad(t, out, count, a, b, c, d, p, q, r, s, _normal(np.int64(t.normals[edge]), axis))


@device
def _write_edge(t, out, count, edge, first, x0, y0, z0):
    """The face of an edge of the brick at (x0, y0, z0), whose components are numbered from `first` on."""
    ring = t.rings[edge]
    near, by_u, by_v, far = np.int64(ring[0]), np.int64(ring[1]), np.int64(ring[2]), np.int64(ring[3])
    c = _root(t, first, near)
    if by_u >= 0 and by_v >= 0 and far >= 0:
        d, b, a = _root(t, first, by_u), _root(t, first, by_v), _root(t, first, far)
        # Within a merged cell; or along its border, as whole cells are merged.
        if (a == b and c == d) or (a == d and b == c):
            return count
    word = np.int64(t.edges[edge])
    axis, code = word >> AXIS_BIT & 3, word >> CODE_BIT
    i, j, k = x0 + unpacked(code), y0 + unpacked(code >> 1), z0 + unpacked(code >> 2)
    d = _root(t, first, by_u) if by_u >= 0 else _root_in_ring(t, axis, _BY_U, i, j, k)
    b = _root(t, first, by_v) if by_v >= 0 else _root_in_ring(t, axis, _BY_V, i, j, k)
    a = _root(t, first, far) if far >= 0 else _root_in_ring(t, axis, _FAR, i, j, k)
    if (a == b and c == d) or (a == d and b == c):
        return count
    return _write_face(t, out, count, edge, axis, i, j, k, a, b, c, d)


@kernel
def write_faces(tables, bricks, out, ends):
    """Write the triangles of bricks' edges into `out`, (n, 3) int32, anticlockwise from outside.

    `ends` (m,) int64 are where those of each brick end. Asks for merged components to be split where a triangle is
    folded over.
    """
    t = open_faces(tables)
    count = np.int64(0)
    for number in range(len(bricks)):
        brick = bricks[number]
        x0, y0, z0 = place_of_brick(t, brick)
        first = t.nodes[brick]
        for edge in range(t.edge_starts[brick], t.edge_starts[brick + 1]):
            count = _write_edge(t, out, count, edge, first, x0, y0, z0)
        ends[number] = count


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
