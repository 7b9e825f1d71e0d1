"""Normals and curvatures of meshes: closed forms, orders of convergence, Gauss–Bonnet, boundaries."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numba import njit

import isophote as iso
from curved_meshes import Known, ellipsoid, torus
from isophote.kernels.measure.arc import upper_angle

MODELS = Path(__file__).parents[1] / "../shared/models"
CUBE = iso.Mesh(
    [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)],
    [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)],
)
an = iso.analysis


@njit
def _upper_angles(y: np.ndarray, x: np.ndarray, out: np.ndarray) -> None:
    for k in range(len(out)):
        out[k] = upper_angle(y[k], x[k])


def test_angles_are_those_of_the_arctangent() -> None:
    rng = np.random.default_rng(0)
    turn = np.concatenate([rng.uniform(0, np.pi, 20_000), 10.0 ** rng.uniform(-300, 0, 2000), np.arange(9) * np.pi / 8])
    size = 10.0 ** rng.uniform(-100, 100, len(turn))
    x = np.concatenate([size * np.cos(turn), [0.0, -0.0, 1.0, -1.0, 0.0, 1e-300, -1e300, 1e308]])
    y = np.concatenate([size * np.sin(turn), [0.0, 0.0, 0.0, 0.0, 1.0, 1e-300, 1e300, 1e308]]) + 0.0
    found = np.empty(len(x))
    _upper_angles(np.abs(y), x, found)
    np.testing.assert_array_max_ulp(found, np.abs(np.arctan2(np.abs(y), x + 0.0)), 2)


@pytest.mark.parametrize(("a", "b", "c"), [(2, 0, -1), (-1, 0, 2), (1, 1, 1), (1, -1, 1), (-3, 1e-9, 2), (0.5, 0, 0.5)])
def test_directions_of_paraboloids(a: float, b: float, c: float) -> None:
    """Of z = -(a x² + 2 b x y + c y²) / 2 at 0: eigenvalues and eigenvectors of ((a, b), (b, c))."""
    x, y = (grid.reshape(-1) for grid in np.meshgrid(np.arange(-3.0, 4) / 10, np.arange(-3.0, 4) / 10))
    points = np.column_stack([x, y, -(a * x * x + 2 * b * x * y + c * y * y) / 2])
    faces = [(7 * i + j, 7 * i + j + 1, 7 * i + j + 8, 7 * i + j + 7) for i in range(6) for j in range(6)]
    found = an.principal_curvatures(iso.Mesh(points, faces), degree=2)
    least, greatest = np.linalg.eigvalsh([(a, b), (b, c)])
    assert (found.k1[24], found.k2[24]) == pytest.approx((greatest, least), abs=1e-9)
    for k, direction in ((greatest, found.direction1[24]), (least, found.direction2[24])):
        assert np.linalg.norm(direction) == pytest.approx(1)
        np.testing.assert_allclose(np.array([(a, b), (b, c)]) @ direction[:2], k * direction[:2], atol=1e-9)


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _order(surface: Callable[[int], Known], error: Callable[[Known], float], sizes: tuple[int, int]) -> float:
    coarse, fine = (error(surface(n)) for n in sizes)
    return float(np.log(coarse / fine) / np.log(sizes[1] / sizes[0]))


@pytest.mark.parametrize("surface", [torus, ellipsoid])
@pytest.mark.parametrize(("degree", "rings", "least"), [(3, 2, 1.9), (4, 3, 2.9)])
def test_fits_converge_on_irregular_meshes(
    surface: Callable[[int], Known], degree: int, rings: int, least: float
) -> None:
    def error(known: Known) -> float:
        found = an.principal_curvatures(known.mesh, degree, rings)
        assert (found.degree == degree).all()
        return _rms(np.concatenate([found.k1 - known.k1, found.k2 - known.k2]))

    assert _order(surface, error, (40, 80)) > least


@pytest.mark.parametrize("weights", ["angle", "area", "uniform"])
def test_vertex_normals_converge(weights: str) -> None:
    def error(known: Known) -> float:
        return _rms(np.linalg.norm(an.vertex_normals(known.mesh, weights) - known.normals, axis=1))

    assert _order(torus, error, (20, 80)) > 0.9


def test_principal_directions_of_a_torus() -> None:
    known = torus(64)
    found = an.principal_curvatures(known.mesh)
    np.testing.assert_allclose(np.abs((found.direction1 * known.direction1).sum(1)), 1, atol=2e-3)
    np.testing.assert_allclose((found.direction1 * found.direction2).sum(1), 0, atol=1e-12)
    np.testing.assert_allclose(np.cross(found.direction1, found.direction2).__abs__(), np.abs(found.normal), atol=1e-9)


def test_the_shape_operator_has_the_curvatures() -> None:
    known = ellipsoid(12)
    found = an.principal_curvatures(known.mesh)
    operator = found.shape_operator()
    np.testing.assert_allclose(np.trace(operator, axis1=1, axis2=2), found.k1 + found.k2, rtol=1e-9)
    mapped = np.einsum("nij,nj->ni", operator, found.direction2)
    np.testing.assert_allclose(mapped, found.k2[:, None] * found.direction2, atol=1e-9)


@settings(max_examples=20)
@given(st.floats(1e-3, 1e3), st.floats(-3, 3), st.integers(0, 10_000))
def test_curvature_scales_and_turns_with_the_mesh(scale: float, angle: float, seed: int) -> None:
    known = torus(8, seed=seed)
    turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    moved = iso.Mesh(scale * known.mesh.vertices @ turn.T + 5 * scale, known.mesh.indices.reshape(-1, 3))
    before, after = an.principal_curvatures(known.mesh), an.principal_curvatures(moved)
    np.testing.assert_allclose(after.k1 * scale, before.k1, rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(after.k2 * scale, before.k2, rtol=1e-6, atol=1e-6)


def test_turning_a_mesh_inside_out_changes_the_signs() -> None:
    known = ellipsoid(8)
    inside_out = iso.Mesh(known.mesh.vertices, known.mesh.indices.reshape(-1, 3)[:, ::-1])
    before, after = an.principal_curvatures(known.mesh), an.principal_curvatures(inside_out)
    np.testing.assert_allclose(after.k1, -before.k2, atol=1e-9)
    np.testing.assert_allclose(an.mean_curvature(inside_out, "cotangent"), -an.mean_curvature(known.mesh, "cotangent"))


def test_corners_of_a_cube() -> None:
    np.testing.assert_allclose(an.angle_deficit(CUBE), np.pi / 2, atol=1e-15)
    normals = an.vertex_normals(CUBE)
    expected = (np.array(CUBE.vertices) - 0.5) * 2 / np.sqrt(3)
    np.testing.assert_allclose(normals, expected, atol=1e-15)
    # Weights by area or one for each triangle depend on how the squares are cut.
    assert np.abs(an.vertex_normals(CUBE, "uniform") - expected).max() > 0.1
    assert an.curvature_totals(CUBE).mean == pytest.approx(12 * np.pi / 4)


def test_the_weight_by_angle_is_the_limit_of_the_mean_normal() -> None:
    random = np.random.default_rng(3)
    angles, heights = np.array([0.1, 0.9, 2.5, 3.6, 5.2]), random.uniform(-1, 1, 5)
    fan = np.stack([np.cos(angles), np.sin(angles), heights], 1)
    mesh = iso.Mesh(np.vstack([np.zeros(3), fan]), [(0, 1 + i, 1 + (i + 1) % 5) for i in range(5)])
    total = np.zeros(3)
    for a, b in zip(fan, np.roll(fan, -1, axis=0), strict=True):
        # Points all over the triangle; those within a small circle count.
        weights = np.sort(random.random((400_000, 2)), axis=1)
        points = weights[:, :1] * a + (weights[:, 1:] - weights[:, :1]) * b
        total += np.cross(a, b) * (np.linalg.norm(points, axis=1) < 0.2).mean()
    np.testing.assert_allclose(an.vertex_normals(mesh)[0], total / np.linalg.norm(total), atol=5e-3)


@pytest.mark.parametrize("method", ["deficit", "image"])
def test_curvature_of_a_sphere_without_a_fit(method: str) -> None:
    known = ellipsoid(24, (2.0, 2.0, 2.0))
    inner = np.bincount(known.mesh.indices) == 6
    found = an.gaussian_curvature(known.mesh, method)
    assert abs(np.median(found[inner]) - 0.25) < 0.005
    assert np.abs(found[inner] - 0.25).max() < 0.1


def test_the_image_of_the_normals_covers_the_sphere_once() -> None:
    known = ellipsoid(16)
    image = an.gaussian_curvature(known.mesh, "image")
    corners = known.mesh.vertices[known.mesh.indices.reshape(-1, 3)]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
    around = np.bincount(known.mesh.indices, np.repeat(areas, 3))
    # Each triangle counts at its three corners.
    assert (image * around).sum() / 3 == pytest.approx(4 * np.pi, rel=1e-9)


def test_mean_curvature_by_cotangents_is_near_the_fit() -> None:
    known = torus(96)
    by_cotangents = an.mean_curvature(known.mesh, "cotangent")
    assert abs(by_cotangents.mean() - ((known.k1 + known.k2) / 2).mean()) < 0.01
    assert _rms(an.mean_curvature(known.mesh) - (known.k1 + known.k2) / 2) < 0.01


@pytest.mark.parametrize(
    "name", ["closed/bunny.obj", "genus/double-torus.obj", "boundary/moebius.obj", "boundary/cat_head.obj"]
)
def test_gauss_and_bonnet(name: str) -> None:
    path = MODELS / name
    if not path.exists():
        pytest.skip("the model is not here")
    mesh = iso.load_mesh(path)
    totals = an.curvature_totals(mesh)
    assert abs(totals.error) <= 1e-11 * len(mesh.vertices)
    assert totals.euler == an.topology(mesh).euler


def test_total_mean_curvature_of_a_torus() -> None:
    assert an.curvature_totals(torus(96).mesh).mean == pytest.approx(2 * np.pi**2, rel=1e-3)


def _saddle(n: int) -> Known:
    """z = x² / 2 − y² over a square, a boundary all around."""
    u, v = np.meshgrid(np.linspace(-0.5, 0.5, n), np.linspace(-0.5, 0.5, n), indexing="ij")
    x, y = u.reshape(-1), v.reshape(-1)
    i, j = (a.reshape(-1) for a in np.meshgrid(np.arange(n - 1), np.arange(n - 1), indexing="ij"))
    a = i * n + j
    faces = np.concatenate([np.stack([a, a + n, a + n + 1], 1), np.stack([a, a + n + 1, a + 1], 1)])
    w = np.sqrt(1 + x**2 + 4 * y**2)
    gaussian = -2 / w**4
    # H of a height: ((1 + fy²) fxx + (1 + fx²) fyy) / 2w³ here, where fxy = 0; negative where bent up.
    mean = -((1 + 4 * y**2) - 2 * (1 + x**2)) / (2 * w**3)
    root = np.sqrt(mean**2 - gaussian)
    mesh = iso.Mesh(np.stack([x, y, x**2 / 2 - y**2], 1), faces)
    return Known(mesh, np.zeros((n * n, 3)), mean + root, mean - root, np.zeros((n * n, 3)))


def test_curvatures_converge_on_the_boundary_too() -> None:
    def error(known: Known) -> float:
        found = an.principal_curvatures(known.mesh, 4, 3)
        assert (found.degree == 4).all()
        return float(np.abs(np.concatenate([found.k1 - known.k1, found.k2 - known.k2])).max())

    # Fits from one side, at corners from a quarter: an order less than inside.
    assert error(_saddle(48)) < 0.02
    assert _order(_saddle, error, (24, 48)) > 1.9


def test_a_plane_has_none() -> None:
    mesh = iso.Mesh(
        [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0.5, 0.4, 0)], [(0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)]
    )
    # Four neighbours and a fifth determine no polynomial of degree 2: nothing is claimed.
    found = an.principal_curvatures(mesh)
    assert (found.degree == 0).all()
    assert np.isnan(found.k1).all()
    np.testing.assert_allclose(an.gaussian_curvature(mesh, "deficit")[4], 0, atol=1e-12)


def test_what_has_no_faces_and_what_makes_no_sense_is_refused() -> None:
    with pytest.raises(iso.GeometryError, match="no faces"):
        an.vertex_normals(iso.Mesh([(0, 0, 0)], np.zeros((0, 3), int)))
    with pytest.raises(iso.GeometryError, match="weights"):
        an.vertex_normals(CUBE, "magic")
    with pytest.raises(iso.GeometryError, match="degree"):
        an.principal_curvatures(CUBE, degree=7)
    with pytest.raises(iso.GeometryError, match="method"):
        an.mean_curvature(CUBE, "magic")
    with pytest.raises(iso.GeometryError, match="Mesh"):
        an.gaussian_curvature("bunny.obj")


def test_unused_vertices_have_nothing() -> None:
    mesh = iso.Mesh([*CUBE.vertices, (9, 9, 9)], iso.triangulate(CUBE).triangles)
    assert an.angle_deficit(mesh)[8] == 0
    assert (an.vertex_normals(mesh)[8] == 0).all()
    assert np.isnan(an.principal_curvatures(mesh).k1[8])
