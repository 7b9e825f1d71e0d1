"""Faces of a contour: for each edge of the grid that the surface crosses, the vertices of the four cells round it."""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.double3 import Double3, cross3, difference, dot3
from isophote.kernels.base.jit import device, exact_inline, kernel
from isophote.kernels.base.table import BYTES, DOUBLE_BOXES, FLOAT, FLOAT_ROWS, INT, INT_ROWS, INTS, LONGS, Table
from isophote.kernels.measure.contour_cases import COMPONENT_BITS
from isophote.kernels.measure.contour_tables import AXIS_BIT, BRICK, CODE_BIT, ELSEWHERE
from isophote.kernels.measure.morton import bit_count, morton, unpacked

__all__ = [
    "FACES",
    "TRIANGLES",
    "cell_of",
    "find_vertices",
    "index_bricks",
    "mend_faces",
    "number_vertices",
    "open_faces",
    "place_of_brick",
    "place_of_edge",
    "place_vertices",
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
    first_edges=INTS,
    words=INTS,
    # Edges, see contour_tables.py; components of other bricks are put into their rings when they are found.
    edges=INTS,
    rings=INT_ROWS,
    crossings=FLOAT_ROWS,
    # Components: what they are merged into, the level of their cells, whether they are split into their parts again or
    # shall be; the places of their vertices, in cells of the grid; how far on what they are merged into in the end is,
    # and whether that has just changed.
    parents=INTS,
    levels=BYTES,
    split=BYTES,
    to_split=BYTES,
    places=DOUBLE_BOXES,
    roots=INTS,
    changed=BYTES,
    # How high, in cells, a triangle must be for its turning over to matter.
    least_height=FLOAT,
    # A bit for each cell of a brick, and how many cells come before each word of 32.
    present=INT_ROWS,
    ranks=INT_ROWS,
)

# What is written: triangles, (n, 3), in the order of the edges that they are at, and these.
TRIANGLES = Table("ContourTriangles", vertices=INT_ROWS, edges=INTS)

# Triangles whose normals are farther than this cosine from that of the surface are folded over.
_TURNED = np.float64(0.1)
# Heights are the same, in cells, that are so close; and the square of a length that is none.
_CLOSE, _NO_LENGTH = np.float64(1e-4), np.float64(1e-8)
_ENDLESS = np.float64(np.inf)
_ELSEWHERE = np.int32(ELSEWHERE)
_ITSELF = np.int64(0)
open_faces = FACES.open
_open_triangles = TRIANGLES.open


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
    """Find what the components of bricks are merged into in the end, and not split; notes what has changed."""
    t = open_faces(tables)
    for brick in bricks:
        first = t.nodes[brick]
        # What components are merged into comes after them.
        for component in range(t.nodes[brick + 1] - 1, first - 1, -1):
            parent = first + t.parents[component]
            merged = parent >= first and t.split[parent] == 0
            root = parent - component + t.roots[parent] if merged else _ITSELF
            t.changed[component] = np.uint8(root != t.roots[component])
            t.roots[component] = np.int32(root)


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
def _find_in_ring(t, edge, axis, around, first, i, j, k):
    """The component in one of the four cells round an edge, numbered by bits along the two axes after the edge's own,
    that starts at (i, j, k). It is put into the ring, counted from the first one of the edge's brick."""
    u, v = (axis + 1) % 3, (axis + 2) % 3
    back_u, back_v = around & 1, around >> 1
    i -= back_u * np.int64(u == 0) + back_v * np.int64(v == 0)
    j -= back_u * np.int64(u == 1) + back_v * np.int64(v == 1)
    k -= back_u * np.int64(u == 2) + back_v * np.int64(v == 2)
    slot = slot_at(t, i, j, k)
    cell = cell_of(t, slot, i, j, k)
    number = t.words[t.cases[cell]] >> COMPONENT_BITS * (4 * axis + around) & 3
    found = t.nodes[slot] + t.firsts[cell] + number - first
    t.rings[edge, around] = np.int32(found)


@device
def place_of_edge(t, edge, x0, y0, z0):
    """Where an edge of the brick at (x0, y0, z0) starts in the grid."""
    code = np.int64(t.edges[edge]) >> CODE_BIT
    return x0 + unpacked(code), y0 + unpacked(code >> 1), z0 + unpacked(code >> 2)


@device
def _complete_ring(t, edge, first, x0, y0, z0):
    """Find the components of an edge's ring that lie in other blocks."""
    ring = t.rings[edge]
    if min(ring[1], ring[2], ring[3]) != _ELSEWHERE:
        return
    axis = np.int64(t.edges[edge]) >> AXIS_BIT & 3
    i, j, k = place_of_edge(t, edge, x0, y0, z0)
    for around in range(1, 4):
        if ring[around] == _ELSEWHERE:
            _find_in_ring(t, edge, axis, np.int64(around), first, i, j, k)


@exact_inline
def _seen_from(t, vertex, axis, u0, v0, w0):
    """A vertex relative to a point; coordinates begin with those of the two axes after the given one."""
    place = t.places[vertex]
    return Double3(place[(axis + 1) % 3] - u0, place[(axis + 2) % 3] - v0, place[axis] - w0)


@exact_inline
def _area(a, b):
    """Twice the area, seen along the axis, of the triangle of two points and the crossing."""
    return a.x * b.y - a.y * b.x


@exact_inline
def _miss(a, b, c, d, ab, bc, cd, da, ac):
    """How far from the crossing a quad cut from a to c meets the axis, by the areas between its corners."""
    abc, acd = ab + bc - ac, ac + cd + da
    over_abc, over_acd = a.z * bc - b.z * ac + c.z * ab, a.z * cd + c.z * da + d.z * ac
    # The triangle that the crossing lies in. Both are worked out, since nobody can foretell which it is.
    in_abc = ac * abc <= 0.0
    over, whole = over_abc if in_abc else over_acd, abc if in_abc else acd
    return abs(over / whole) if whole != 0.0 else _ENDLESS


@exact_inline
def _is_cut_from_first(a, b, c, d):
    """Whether the diagonal from a to c comes nearer to the crossing than that from b to d, or else is shorter.

    A diagonal of no length would leave a triangle of no size, turned anyhow.
    """
    first, second = difference(c, a), difference(d, b)
    first_square, second_square = dot3(first, first), dot3(second, second)
    if min(first_square, second_square) < _NO_LENGTH:
        return second_square < first_square
    ab, bc, cd, da, ac, bd = _area(a, b), _area(b, c), _area(c, d), _area(d, a), _area(a, c), _area(b, d)
    along_ac, along_bd = _miss(a, b, c, d, ab, bc, cd, da, ac), _miss(b, c, d, a, bc, cd, da, ab, bd)
    if abs(along_ac - along_bd) > _CLOSE:
        return along_ac < along_bd
    return first_square <= second_square


@exact_inline
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
    return along < 0.0 or along * along < _TURNED * _TURNED * square


@device
def _split_largest(t, a, b, c):
    """Ask for the largest merged components of three to be split."""
    most = max(t.levels[a], t.levels[b], t.levels[c])
    for vertex in (a, b, c):
        if t.levels[vertex] == most:
            t.to_split[vertex] = 1


@exact_inline
def _write(t, out, count, a, b, c, p, q, r, normal):
    """Write the triangle of vertices a, b, c at p, q, r; asks for what is folded over to be split."""
    if a == b or b == c or c == a:
        return count
    if t.levels[a] | t.levels[b] | t.levels[c] != 0 and _is_folded(t, p, q, r, normal):
        _split_largest(t, a, b, c)
    row = out.vertices[count]
    row[0], row[1], row[2] = np.int32(a), np.int32(b), np.int32(c)
    return count + 1


@exact_inline
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


@exact_inline
def _write_face(t, out, count, edge, x0, y0, z0, a, b, c, d):
    """The face of an edge of the brick at (x0, y0, z0), between these vertices."""
    word = np.int64(t.edges[edge])
    axis = word >> AXIS_BIT & 3
    i, j, k = place_of_edge(t, edge, x0, y0, z0)
    u0 = np.float64(j if axis == 0 else k if axis == 1 else i)
    v0 = np.float64(k if axis == 0 else i if axis == 1 else j)
    crossing = t.crossings[edge]
    w0 = np.float64(i if axis == 0 else j if axis == 1 else k) + np.float64(crossing[0])
    u, v = (axis + 1) % 3, (axis + 2) % 3
    normal = Double3(np.float64(crossing[1 + u]), np.float64(crossing[1 + v]), np.float64(crossing[1 + axis]))
    if word & 1 == 0:
        a, b, c, d = d, c, b, a
    p, q = _seen_from(t, a, axis, u0, v0, w0), _seen_from(t, b, axis, u0, v0, w0)
    r, s = _seen_from(t, c, axis, u0, v0, w0), _seen_from(t, d, axis, u0, v0, w0)
    return _write_quad(t, out, count, a, b, c, d, p, q, r, s, normal)


@device
def _root_in_ring(t, ring, around, first):
    """The vertex of a component in a ring."""
    component = first + ring[around]
    return component + t.roots[component]


@device
def _write_edge(t, out, count, edge, first, x0, y0, z0):
    """Write the face of an edge of the brick at (x0, y0, z0), whose components are numbered from `first` on."""
    ring = t.rings[edge]
    c, d = _root_in_ring(t, ring, 0, first), _root_in_ring(t, ring, 1, first)
    b, a = _root_in_ring(t, ring, 2, first), _root_in_ring(t, ring, 3, first)
    # Within a merged cell; or along its border, as whole cells are merged.
    if (a == b and c == d) or (a == d and b == c):
        return count
    end = _write_face(t, out, count, edge, x0, y0, z0, a, b, c, d)
    for triangle in range(count, end):
        out.edges[triangle] = np.int32(edge)
    return end


@kernel
def write_faces(tables, bricks, triangles, ends):
    """Write the triangles of bricks' edges, anticlockwise from outside, and where those of each brick end.

    Asks for merged components to be split where a triangle is folded over.
    """
    t, out = open_faces(tables), _open_triangles(triangles)
    count = np.int64(0)
    for number in range(len(bricks)):
        brick = bricks[number]
        x0, y0, z0 = place_of_brick(t, brick)
        first = t.nodes[brick]
        for edge in range(t.edge_starts[brick], t.edge_starts[brick + 1]):
            _complete_ring(t, edge, first, x0, y0, z0)
            count = _write_edge(t, out, count, edge, first, x0, y0, z0)
        ends[number] = count


@device
def _has_changed(t, edge, first):
    """Whether the vertex of a component round an edge has changed."""
    ring = t.rings[edge]
    changed = t.changed[first + ring[0]] | t.changed[first + ring[1]]
    return changed | t.changed[first + ring[2]] | t.changed[first + ring[3]] != 0


@kernel
def mend_faces(tables, brick, vertices, edges, triangles, count):
    """Write the triangles of a brick's edges again where vertices have changed; others stay.

    `vertices` (n, 3) int32 and `edges` (n,) int32 are the triangles before. The new ones are written from number
    `count` on; returns where they end.
    """
    t, out = open_faces(tables), _open_triangles(triangles)
    x0, y0, z0 = place_of_brick(t, brick)
    first = t.nodes[brick]
    at = np.int64(0)
    for edge in range(t.edge_starts[brick], t.edge_starts[brick + 1]):
        has_changed = _has_changed(t, edge, first)
        while at < len(edges) and edges[at] == edge:
            if not has_changed:
                for corner in range(3):
                    out.vertices[count, corner] = vertices[at, corner]
                out.edges[count] = np.int32(edge)
                count += 1
            at += 1
        if has_changed:
            count = _write_edge(t, out, count, edge, first, x0, y0, z0)
    return count


@kernel
def number_vertices(triangles, numbers):
    """Let triangles (m, 3) name the vertices that they have, from 0 on; returns how many there are.

    `numbers` (n,) int32 is 0 at first. It becomes 1 more than the vertex that each component is, or stays 0.
    """
    for row in range(triangles.shape[0]):
        for corner in range(3):
            numbers[triangles[row, corner]] = 1
    count = np.int64(0)
    for component in range(numbers.shape[0]):
        count += numbers[component]
        numbers[component] *= count
    for row in range(triangles.shape[0]):
        for corner in range(3):
            triangles[row, corner] = numbers[triangles[row, corner]] - 1
    return count


@kernel
def place_vertices(places, cell, low, numbers, vertices):
    """Write the places in the world of the components that are vertices into `vertices` (n, 3)."""
    for component in range(numbers.shape[0]):
        vertex = numbers[component] - 1
        if vertex >= 0:
            for axis in range(3):
                vertices[vertex, axis] = places[component, axis] * cell + low[axis]
