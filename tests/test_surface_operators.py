"""The Laplacian and mass matrices of meshes: closed forms and invariants."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse.linalg import eigsh

import isophote as iso
from curved_meshes import ellipsoid, torus

KINDS = ["mixed", "barycentric", "full"]
laplacian, mass_matrix = iso.analysis.laplacian, iso.analysis.mass_matrix


def test_the_laplacian_is_symmetric_positive_and_knows_constants() -> None:
    mesh = torus(10).mesh
    matrix = laplacian(mesh)
    assert abs(matrix - matrix.T).max() < 1e-12
    np.testing.assert_allclose(matrix @ np.ones(len(mesh.vertices)), 0, atol=1e-12)
    assert np.linalg.eigvalsh(matrix.toarray()).min() > -1e-10


@pytest.mark.parametrize("kind", KINDS)
def test_mass_sums_to_the_area(kind: str) -> None:
    mesh = torus(12).mesh
    assert mass_matrix(mesh, kind).sum() == pytest.approx(iso.analysis.area(mesh))


def test_linear_functions_are_harmonic_on_flat_meshes() -> None:
    random = np.random.default_rng(1)
    points = np.vstack([random.random((60, 2)), [(0, 0), (1, 0), (1, 1), (0, 1)]])
    flat = iso.analysis.delaunay(points)
    mesh = iso.Mesh(np.column_stack([points, np.zeros(len(points))]), flat.triangles)
    inside = (points > 0.12).all(axis=1) & (points < 0.88).all(axis=1)
    np.testing.assert_allclose((laplacian(mesh) @ points)[inside], 0, atol=1e-9)
    energy = points[:, 0] @ (laplacian(mesh) @ points[:, 0])
    assert energy == pytest.approx(1.0)


@pytest.mark.parametrize("kind", KINDS)
def test_the_least_frequencies_of_a_sphere(kind: str) -> None:
    sphere = ellipsoid(24, (1.0, 1.0, 1.0)).mesh
    found = eigsh(laplacian(sphere), 9, mass_matrix(sphere, kind), sigma=-0.1, which="LM")[0]
    # l(l + 1), each 2l + 1 times.
    np.testing.assert_allclose(np.sort(found), [0, 2, 2, 2, 6, 6, 6, 6, 6], atol=0.06)


def test_the_full_mass_matrix_integrates_products_exactly() -> None:
    mesh = iso.Mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)])
    x, y = mesh.vertices[:, 0], mesh.vertices[:, 1]
    assert x @ (mass_matrix(mesh, "full") @ y) == pytest.approx(1 / 24)
    assert x @ (mass_matrix(mesh, "full") @ x) == pytest.approx(1 / 12)


def test_other_kinds_are_refused() -> None:
    with pytest.raises(iso.GeometryError, match="kind"):
        mass_matrix(torus(6).mesh, "magic")
