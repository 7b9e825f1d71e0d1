"""The cube of a contour: how its corners, edges and faces are numbered, and how a surface runs through it.

Corner c lies at (c & 1, c >> 1 & 1, c >> 2). Edge 4a + u + 2v runs along axis a, at the offsets u along the axis
after a and v along the one after that. Face 2a + s lies across axis a, on its low (s = 0) or high side.

The signs of a cube are a bit for each corner, set where it is inside. A surface crosses the edges between corners of
unlike signs, and each face along curves from crossing to crossing. Where all four edges of a face are crossed there are
two ways: the inside corners are kept apart, or joined. Crossings connected over faces are one component of the surface
within the cube, and get one vertex (Nielson, "Dual marching cubes", 2004).
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

__all__ = [
    "AMBIGUOUS",
    "CASES",
    "COMPONENT_BITS",
    "COMPONENT_EDGES",
    "COUNT_SHIFT",
    "CROSSED",
    "FACE_BITS",
    "FACE_EDGES",
    "HIGH_FACES",
    "INNER_EDGES",
    "LOW_FACES",
    "OUTER_EDGES",
    "SIMPLE",
    "case_word",
    "edge_starts",
    "twice_crossed_faces",
]

Numbers: TypeAlias = npt.NDArray[np.int32]

# A case's word: the component of edge k in bits 2k and 2k + 1, then the number of components, then whether a face is
# ambiguous.
COMPONENT_BITS = 2
COUNT_SHIFT = 24
AMBIGUOUS = 1 << 27

# Beside the six bits of the faces that edges cross: no face is crossed along more than one curve.
SIMPLE = 1 << 6


def _edge_between(a: int, b: int) -> int:
    low, axis = min(a, b), (a ^ b).bit_length() - 1
    return 4 * axis + (low >> (axis + 1) % 3 & 1) + 2 * (low >> (axis + 2) % 3 & 1)


def _corners_of_edge(edge: int) -> tuple[int, int]:
    axis = edge // 4
    low = (edge & 1) << (axis + 1) % 3 | (edge >> 1 & 1) << (axis + 2) % 3
    return low, low | 1 << axis


def _corners_of_face(face: int) -> list[int]:
    """Round the face."""
    axis, base = face // 2, (face & 1) << face // 2
    u, v = 1 << (axis + 1) % 3, 1 << (axis + 2) % 3
    return [base, base | u, base | u | v, base | v]


def _edges_of_face(face: int) -> list[int]:
    """Edge k runs from corner k to corner k + 1 of the face."""
    corners = _corners_of_face(face)
    return [_edge_between(corners[k], corners[(k + 1) % 4]) for k in range(4)]


_FACES = [_edges_of_face(face) for face in range(6)]

# Bits of the edges round each face.
FACE_EDGES: Numbers = np.array([sum(1 << edge for edge in edges) for edges in _FACES], np.int32)
# Bits of the three edges that meet at each corner. In a cube cut into eight, those of the child at corner c that meet
# at c lie on the edges of the whole; those that meet at the opposite corner lie within it.
OUTER_EDGES: Numbers = np.array(
    [sum(1 << edge for edge in range(12) if corner in _corners_of_edge(edge)) for corner in range(8)], np.int32
)
INNER_EDGES: Numbers = OUTER_EDGES[::-1].copy()


def _is_crossed(signs: int, edge: int) -> bool:
    a, b = _corners_of_edge(edge)
    return (signs >> a & 1) != (signs >> b & 1)


def _crossed_of_face(signs: int, face: int) -> list[int]:
    return [edge for edge in _FACES[face] if _is_crossed(signs, edge)]


def _curves(signs: int, joined: int) -> list[tuple[int, int]]:
    """Pairs of edges that a curve on a face connects; inside corners of face f are joined where bit f is set."""
    pairs = []
    for face in range(6):
        crossed = _crossed_of_face(signs, face)
        if len(crossed) == 2:
            pairs.append((crossed[0], crossed[1]))
        elif crossed:
            # Edges k - 1 and k meet at corner k.
            edges, first = _FACES[face], _corners_of_face(face)[0]
            round_even = bool(signs >> first & 1) != bool(joined >> face & 1)
            start = 0 if round_even else 1
            pairs += [(edges[start - 1], edges[start]), (edges[start + 1], edges[(start + 2) % 4])]
    return pairs


def _components(signs: int, joined: int) -> list[int]:
    """The component of each edge, numbered in the order of the edges; -1 where it is not crossed."""
    least = list(range(12))
    pairs = _curves(signs, joined)
    for _ in range(12):
        for a, b in pairs:
            least[a] = least[b] = min(least[a], least[b])
    crossed = [edge for edge in range(12) if _is_crossed(signs, edge)]
    names = sorted({least[edge] for edge in crossed})
    return [names.index(least[edge]) if edge in crossed else -1 for edge in range(12)]


def case_word(signs: int, joined: int = 0) -> int:
    """The word of a case: components of the edges, how many there are, and whether a face is ambiguous."""
    components = _components(signs, joined)
    ambiguous = any(len(_crossed_of_face(signs, face)) == 4 for face in range(6))
    word = sum(max(component, 0) << COMPONENT_BITS * edge for edge, component in enumerate(components))
    return word | (max(components) + 1) << COUNT_SHIFT | (AMBIGUOUS if ambiguous else 0)


def twice_crossed_faces(signs: int, joined: int = 0) -> int:
    """Bits of the faces that one component crosses along two curves.

    Where the cubes on both sides of a face do so, their two vertices would be joined by an edge of four faces.
    """
    components = _components(signs, joined)
    found = 0
    for face in range(6):
        crossed = _crossed_of_face(signs, face)
        if len(crossed) == 4 and len({components[edge] for edge in crossed}) == 1:
            found |= 1 << face
    return found


# The words of all signs with inside corners kept apart, and the bits of the edges that are crossed.
CASES: Numbers = np.array([case_word(signs) for signs in range(256)], np.int32)
CROSSED: Numbers = np.array(
    [sum(1 << edge for edge in range(12) if _is_crossed(signs, edge)) for signs in range(256)], np.int32
)

# Bits of the edges of each component of a case, four words a case.
COMPONENT_EDGES: Numbers = np.array(
    [
        sum(1 << edge for edge, of in enumerate(_components(signs, 0)) if of == component)
        for signs in range(256)
        for component in range(4)
    ],
    np.int32,
)


def _face_bits() -> Numbers:
    edges = np.arange(1 << 12)
    bits = np.full(len(edges), SIMPLE)
    for face in range(6):
        crossed = sum((edges >> edge & 1 for edge in _FACES[face]), np.zeros_like(edges))
        bits |= (crossed > 0) << face
        bits[(crossed != 0) & (crossed != 2)] &= ~SIMPLE
    return bits.astype(np.int32)


def _inner_faces(child: int, faces: int, high: int) -> int:
    """The faces within a cube cut into eight that a child crosses, being on their low or their high side.

    `faces` are bits of the child's own faces. The face between the children c and c | 1 << axis has bit 8 axis + c.
    """
    found = 0
    for axis in range(3):
        if child >> axis & 1 == high and faces >> (2 * axis + 1 - high) & 1:
            found |= 1 << 8 * axis + (child & ~(1 << axis))
    return found


# The faces that edges cross, and SIMPLE, by the edges' bits.
FACE_BITS: Numbers = _face_bits()
# Bits of the faces that a child crosses within its cube, by 64 · child + bits of its faces: from their low sides, and
# from their high sides.
LOW_FACES, HIGH_FACES = (
    np.array([_inner_faces(child, faces, high) for child in range(8) for faces in range(64)], np.int32)
    for high in range(2)
)


def edge_starts(side: int) -> list[int]:
    """The sample that each edge of a cell starts at, less that of the cell, in a grid of side³ samples."""
    corners = [_corners_of_edge(edge)[0] for edge in range(12)]
    return [(c & 1) + (c >> 1 & 1) * side + (c >> 2) * side * side for c in corners]
