"""The Laplacian and the mass matrix of a mesh, for equations on its surface."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from isophote.analysis.curvature.fan import fans
from isophote.errors import GeometryError
from isophote.shapes.mesh import Mesh

if TYPE_CHECKING:
    from scipy.sparse import csr_array

__all__ = ["laplacian", "mass_matrix"]


def laplacian(mesh: Mesh) -> csr_array:
    """(n, n) the cotangent Laplacian, symmetric and positive semidefinite: (L f)_i = ½ Σ (cot α + cot β)(f_i − f_j).

    fᵀ L f is the energy ∫ |∇f|² of the piecewise linear f, without a weight by area: M⁻¹ L f, with `mass_matrix`,
    approximates −Δf. Rows sum to 0; on a boundary that means no flow across it. Triangles without area count nothing.

    Source: Pinkall, Polthier, "Computing Discrete Minimal Surfaces and Their Conjugates", 1993.
    """
    from scipy.sparse import coo_array

    fan = fans(mesh)
    p, count = fan.positions[fan.triangles], len(fan.positions)
    rows, columns, values = [], [], []
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        a, b = p[:, j] - p[:, i], p[:, k] - p[:, i]
        twice = np.linalg.norm(np.cross(a, b), axis=1)
        half = np.where(twice > 0, 0.5 * (a * b).sum(axis=1) / np.where(twice > 0, twice, 1.0), 0.0)
        u, v = fan.triangles[:, j], fan.triangles[:, k]
        rows += [u, v, u, v]
        columns += [v, u, u, v]
        values += [-half, -half, half, half]
    place = np.concatenate(rows), np.concatenate(columns)
    return coo_array((np.concatenate(values), place), shape=(count, count)).tocsr()


def mass_matrix(mesh: Mesh, kind: str = "mixed") -> csr_array:
    """(n, n) the mass matrix: fᵀ M g approximates the integral of f g over the surface; its entries sum to the area.

    `kind`: "mixed", diagonal, each vertex with the area nearest to it (in triangles with an obtuse angle, half or a
    quarter of them); "barycentric", diagonal, a third of each triangle; "full", exact for linear f and g.
    Source of the first: Meyer et al., "Discrete Differential-Geometry Operators", 2003.
    """
    from scipy.sparse import coo_array, diags_array

    fan = fans(mesh)
    count = len(fan.positions)
    if kind == "mixed":
        return diags_array(fan.sums.areas).tocsr()
    p = fan.positions[fan.triangles]
    areas = np.linalg.norm(np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), axis=1) / 2
    if kind == "barycentric":
        return diags_array(np.bincount(fan.triangles.reshape(-1), np.repeat(areas / 3, 3), count)).tocsr()
    if kind != "full":
        raise GeometryError(f'kind must be "mixed", "barycentric" or "full", not {kind!r}')
    pairs = [(i, j) for i in range(3) for j in range(3)]
    values = np.concatenate([areas / (6 if i == j else 12) for i, j in pairs])
    rows = np.concatenate([fan.triangles[:, i] for i, _ in pairs])
    columns = np.concatenate([fan.triangles[:, j] for _, j in pairs])
    return coo_array((values, (rows, columns)), shape=(count, count)).tocsr()
