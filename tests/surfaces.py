"""Meshes whose topology is known from how they are made."""

from __future__ import annotations

import itertools

import numpy as np

import isophote as iso

Face = tuple[int, ...]

CUBE = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
"""The faces of a cube whose corner 4 x + 2 y + z has the coordinates x, y, z; they look outward."""


def mesh_of(faces: list[Face] | tuple[Face, ...], seed: int = 0) -> iso.Mesh:
    """A mesh of these faces with its vertices anywhere."""
    count = max(map(max, faces)) + 1
    return iso.Mesh(np.random.default_rng(seed).normal(size=(count, 3)), list(faces))


def cube(size: float = 1.0, offset: tuple[float, float, float] = (0, 0, 0)) -> iso.Mesh:
    """A cube with its least corner at `offset`."""
    corners = np.array(list(itertools.product((0, 1), repeat=3)), float)
    return iso.Mesh(corners * size + offset, CUBE)


def together(*meshes: iso.Mesh) -> iso.Mesh:
    """All faces in one mesh, without labels and attributes."""
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    faces = [
        tuple(np.asarray(face) + start) for mesh, start in zip(meshes, starts, strict=False) for face in mesh.faces
    ]
    return iso.Mesh(np.concatenate([mesh.vertices for mesh in meshes]), faces)


def turned(mesh: iso.Mesh, *chosen: int) -> iso.Mesh:
    """The mesh with some faces the other way round."""
    return iso.Mesh(mesh.vertices, [face[::-1] if i in chosen else face for i, face in enumerate(mesh.faces)])


def strip(rows: int, columns: int, wrap_rows: str = "", wrap_columns: str = "") -> list[Face]:
    """Quads of a grid whose opposite sides are glued: "" not, "even" straight, "odd" turned over."""
    height, width = rows + (wrap_rows == ""), columns + (wrap_columns == "")

    def vertex(r: int, c: int) -> int:
        if wrap_columns and c >= width:
            c -= width
            # Wrapping the columns may turn the rows over.
            r = (-r if wrap_rows else rows - r) if wrap_columns == "odd" else r
        if wrap_rows:
            r %= height
        return r * width + c

    return [
        (vertex(r, c), vertex(r, c + 1), vertex(r + 1, c + 1), vertex(r + 1, c))
        for r in range(rows)
        for c in range(columns)
    ]


def torus(rows: int = 5, columns: int = 6) -> list[Face]:
    return strip(rows, columns, "even", "even")


def klein_bottle(rows: int = 5, columns: int = 6) -> list[Face]:
    return strip(rows, columns, "even", "odd")


def moebius(columns: int = 7) -> list[Face]:
    return strip(1, columns, "", "odd")


def annulus(columns: int = 7) -> list[Face]:
    return strip(1, columns, "", "even")


def with_handles(genus: int) -> list[Face]:
    """Tori glued one to the next: a quad of each is cut out, and the rims are made one."""
    if genus == 0:
        return list(CUBE)
    faces: list[Face] = torus()
    for _ in range(genus - 1):
        rim, opened = faces[-1], faces[:-1]
        shift = max(map(max, faces)) + 1
        other = [tuple(v + shift for v in face) for face in torus()]
        # The rims run against each other, so that the sides fit.
        glue = dict(zip(other[0], (rim[0], rim[3], rim[2], rim[1]), strict=True))
        faces = opened + [tuple(glue.get(v, v) for v in face) for face in other[1:]]
    used = sorted({v for face in faces for v in face})
    number = {v: i for i, v in enumerate(used)}
    return [tuple(number[v] for v in face) for face in faces]


def triangles_of(faces: list[Face]) -> list[Face]:
    """Each face cut from its first corner."""
    return [(face[0], face[i], face[i + 1]) for face in faces for i in range(1, len(face) - 1)]


def plate_with_holes(holes: int) -> iso.Mesh:
    """The surface of a row of cubes around `holes` holes: a solid of genus `holes`, of squares that look outward."""
    solid = {(x, y, 0) for x in range(2 * holes + 1) for y in range(3)} - {(2 * i + 1, 1, 0) for i in range(holes)}
    number: dict[tuple[int, ...], int] = {}
    faces = []
    for cell in sorted(solid):
        for axis, side in itertools.product(range(3), (0, 1)):
            beyond = tuple(c + (2 * side - 1) * (k == axis) for k, c in enumerate(cell))
            if beyond in solid:
                continue
            u, v = (axis + 1) % 3, (axis + 2) % 3
            ring = []
            for du, dv in ((0, 0), (1, 0), (1, 1), (0, 1))[:: 2 * side - 1]:
                corner = list(cell)
                corner[axis] += side
                corner[u] += du
                corner[v] += dv
                ring.append(number.setdefault(tuple(corner), len(number)))
            faces.append(tuple(ring))
    return iso.Mesh(np.array(list(number), float), faces)
