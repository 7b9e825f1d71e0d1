"""Meshes of surfaces with known normals and curvatures, irregular on purpose."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from isophote.shapes.mesh import Mesh


class Known(NamedTuple):
    """A mesh whose vertices lie on a surface, with what is true there."""

    mesh: Mesh
    normals: np.ndarray
    k1: np.ndarray
    k2: np.ndarray
    direction1: np.ndarray


def _grid(n: int, m: int, random: np.random.Generator) -> np.ndarray:
    """Triangles of an n × m grid that is closed both ways, each square cut along a diagonal by chance."""
    i, j = np.meshgrid(np.arange(n), np.arange(m), indexing="ij")
    a, b, c, d = ((p % n) * m + q % m for p, q in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)))
    cut = random.random(a.shape) < 0.5
    pair = np.where(cut[..., None], np.stack([a, b, c, a, c, d], -1), np.stack([a, b, d, b, c, d], -1))
    return pair.reshape(-1, 3)


def torus(n: int, radius: float = 1.0, tube: float = 0.4, seed: int = 0) -> Known:
    """An irregular torus about z with 2n × n vertices."""
    random = np.random.default_rng(seed)
    u, v = np.meshgrid(np.arange(2.0 * n), np.arange(float(n)), indexing="ij")
    u = (u + random.uniform(-0.25, 0.25, u.shape)).reshape(-1) * np.pi / n
    v = (v + random.uniform(-0.25, 0.25, v.shape)).reshape(-1) * 2 * np.pi / n
    around = radius + tube * np.cos(v)
    points = np.stack([around * np.cos(u), around * np.sin(u), tube * np.sin(v)], 1)
    normals = np.stack([np.cos(v) * np.cos(u), np.cos(v) * np.sin(u), np.sin(v)], 1)
    direction = np.stack([-np.sin(v) * np.cos(u), -np.sin(v) * np.sin(u), np.cos(v)], 1)
    mesh = Mesh(points, _grid(2 * n, n, random))
    return Known(mesh, normals, np.full(len(u), 1 / tube), np.cos(v) / around, direction)


def _sphere_grid(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Vertices and triangles of an octahedron cut n times along each edge, on the unit sphere."""
    corners = np.array([(1, 0, 0), (0, 1, 0), (-1, 0, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)], float)
    faces = [(0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4), (1, 0, 5), (2, 1, 5), (3, 2, 5), (0, 3, 5)]
    points, triangles, known = [], [], {}

    def number(p: np.ndarray) -> int:
        key = tuple(np.rint(p * n).astype(int))
        if key not in known:
            known[key] = len(points)
            points.append(p)
        return known[key]

    for a, b, c in (corners[list(face)] for face in faces):
        rows = [[number((a * (n - i - j) + b * i + c * j) / n) for i in range(n - j + 1)] for j in range(n + 1)]
        for lower, upper in pairwise(rows):
            triangles += [(lower[i], lower[i + 1], upper[i]) for i in range(len(upper))]
            triangles += [(lower[i + 1], upper[i + 1], upper[i]) for i in range(len(upper) - 1)]
    directions = np.array(points)
    return directions / np.linalg.norm(directions, axis=1, keepdims=True), np.array(triangles)


def ellipsoid(n: int, axes: tuple[float, float, float] = (1.5, 1.0, 0.7)) -> Known:
    """An ellipsoid with 4 n² + 2 vertices, moved about on the surface by chance; curvatures by their closed form."""
    directions, triangles = _sphere_grid(n)
    random = np.random.default_rng(n)
    directions = directions + random.uniform(-0.2, 0.2, directions.shape) / n
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    a = np.array(axes)
    points = directions * a
    gradient = points / a**2
    size = np.linalg.norm(gradient, axis=1)
    normals = gradient / size[:, None]
    # The shape operator is P H P / |∇f| for f = Σ x² / a² / 2, with H = diag(1 / a²) and P = I − n nᵀ.
    project = np.eye(3) - normals[:, :, None] * normals[:, None, :]
    operator = project @ np.diag(1 / a**2) @ project / size[:, None, None]
    values, vectors = np.linalg.eigh(operator)
    # One of the three belongs to the normal, with the eigenvalue 0: the other two are positive here.
    return Known(Mesh(points, triangles), normals, values[:, 2], values[:, 1], vectors[:, :, 2])
