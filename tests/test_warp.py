"""Maps of the unit square: where samples fall, and that their density is what is claimed."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit

from isophote.checks.statistics import chi_square_deviation
from isophote.kernels.base.vec import normalise, store_vec3, vec3
from isophote.kernels.base.warp import to_cone, to_disk, to_triangle
from isophote.kernels.light.bsdf import fresnel_dielectric, scatter_glass, scatter_matte

COUNT = 200_000
SQUARE = np.random.default_rng(7).integers(0, 2**24, (COUNT, 2)).astype(np.float32) / np.float32(2**24)
CORNERS = np.array([(a, b) for a in (0, 0.5, 1 - 2.0**-24) for b in (0, 0.5, 1 - 2.0**-24)], np.float32)


@njit(error_model="numpy")
def disk(square, out):
    for i in range(len(square)):
        out[i, 0], out[i, 1] = to_disk(square[i, 0], square[i, 1])


@njit(error_model="numpy")
def triangle(square, out):
    for i in range(len(square)):
        out[i, 0], out[i, 1] = to_triangle(square[i, 0], square[i, 1])


@njit(error_model="numpy")
def cone(square, height, out):
    for i in range(len(square)):
        store_vec3(out, 3 * i, to_cone(square[i, 0], square[i, 1], height))


@njit(error_model="numpy")
def matte(square, normal, out, densities):
    n = normalise(vec3(normal[0], normal[1], normal[2]))
    for i in range(len(square)):
        x, y = to_disk(square[i, 0], square[i, 1])
        into, density = scatter_matte(n, x, y)
        store_vec3(out, 3 * i, into)
        densities[i] = density


@njit(error_model="numpy")
def glass(out_direction, normal, ior, u, into):
    o = vec3(out_direction[0], out_direction[1], out_direction[2])
    n = vec3(normal[0], normal[1], normal[2])
    direction, factor = scatter_glass(o, n, ior, u)
    store_vec3(into, 0, direction)
    return factor


@njit(error_model="numpy")
def fresnel(cosine, ior):
    return fresnel_dielectric(cosine, ior)


def polar_cells(points: np.ndarray, along: np.ndarray, rings: int, sectors: int) -> np.ndarray:
    """Samples in equal steps of `along` (0 to 1) and of the angle in the plane."""
    angle = np.arctan2(points[:, 1], points[:, 0]) / (2 * np.pi) + 0.5
    return np.histogram2d(along, angle, bins=(rings, sectors), range=[[0, 1], [0, 1]])[0]


def even(cells: np.ndarray) -> np.ndarray:
    return np.full(cells.shape, cells.sum() / cells.size)


def test_disk_is_filled_evenly():
    points = np.zeros((COUNT, 2), np.float32)
    disk(SQUARE, points)
    radius2 = (points.astype(np.float64) ** 2).sum(axis=1)
    assert radius2.max() <= 1 + 1e-6
    cells = polar_cells(points, np.minimum(radius2, 1), 16, 24)
    assert cells.sum() == COUNT
    assert chi_square_deviation(cells, even(cells)) < 3.72


def test_corners_and_centre_of_the_square_on_the_disk():
    points = np.zeros((9, 2), np.float32)
    disk(CORNERS, points)
    assert np.allclose(np.linalg.norm(points, axis=1), [1, 1, 1, 1, 0, 1, 1, 1, 1], atol=1e-6)
    assert points[4].tolist() == [0, 0]


@pytest.mark.parametrize("height", [1.0, 0.5, 0.01, 1e-6, 1e-12])
def test_cones_are_covered_evenly_however_narrow(height):
    """`height` is 1 − cos of the half angle; equal steps of z are equal solid angles."""
    points = np.zeros((COUNT, 3), np.float32)
    cone(SQUARE, np.float32(height), points.reshape(-1))
    x, y, z = points.astype(np.float64).T
    across2 = x * x + y * y
    # 1 − z by way of the sine, which does not cancel.
    below = across2 / (1 + z)
    assert below.max() <= height * (1 + 1e-5)
    cells = polar_cells(points, np.minimum(below / height, 1), 16, 24)
    assert chi_square_deviation(cells, even(cells)) < 3.72


def test_triangle_is_filled_evenly():
    weights = np.zeros((COUNT, 2), np.float32)
    triangle(SQUARE, weights)
    a, b = weights.astype(np.float64).T
    assert min(a.min(), b.min()) >= 0
    assert (a + b).max() <= 1 + 1e-6
    n = 12
    i, j = np.minimum((a * n).astype(int), n - 1), np.minimum((b * n).astype(int), n - 1)
    upper = (a * n - i) + (b * n - j) > 1
    cells = np.zeros((n, n, 2))
    np.add.at(cells, (i, j, upper.astype(int)), 1)
    inside = np.add.outer(np.arange(n), np.arange(n))[:, :, None] + np.arange(2) < n
    found = cells[inside]
    assert len(found) == n * n
    assert found.sum() >= COUNT - 3
    assert chi_square_deviation(found, even(found)) < 3.72


@pytest.mark.parametrize("normal", [(0, 0, 1), (0, 0, -1), (1, 2, -3), (0.6, -0.8, 1e-8)])
def test_matte_scatters_by_the_cosine_on_the_side_of_its_normal(normal):
    points, densities = np.zeros((COUNT, 3), np.float32), np.zeros(COUNT, np.float32)
    matte(SQUARE, np.array(normal, np.float32), points.reshape(-1), densities)
    n = np.array(normal) / np.linalg.norm(normal)
    tangent = np.cross(n, np.roll(n, 1) + np.array((0.1, 0.2, 0.3)))
    tangent /= np.linalg.norm(tangent)
    local = points.astype(np.float64) @ np.stack([tangent, np.cross(n, tangent), n], 1)
    assert local[:, 2].min() > -1e-6
    assert np.abs(densities - local[:, 2] / np.pi).max() < 1e-6
    # Equal steps of sin² are equal shares of the cosine.
    cells = polar_cells(local, np.minimum((local[:, :2] ** 2).sum(axis=1), 1), 16, 24)
    assert chi_square_deviation(cells, even(cells)) < 3.72


# --- glass ----------------------------------------------------------------------------------------

ANGLES = [0, 5, 20, 33.69, 45, 56.309932, 70, 85, 89.5]


def scattered(degrees: float, ior: float, u: float, side: float = 1.0) -> tuple[np.ndarray, float]:
    """Direction and factor for a ray that leaves at an angle to the normal ±y."""
    theta = np.radians(degrees)
    into = np.zeros(3, np.float32)
    out = np.array([np.sin(theta), side * np.cos(theta), 0], np.float32)
    factor = glass(out, np.array([0, 1, 0], np.float32), np.float32(ior), np.float32(u), into)
    return into.astype(np.float64), factor


def reflectance(degrees: float, n: float) -> float:
    """Fresnel's equations by the angles: ½ (sin²(a−b) / sin²(a+b) + tan²(a−b) / tan²(a+b))."""
    a = np.radians(degrees)
    if np.sin(a) >= n:
        return 1.0
    b = np.arcsin(np.sin(a) / n)
    if degrees == 0:
        return ((n - 1) / (n + 1)) ** 2
    return 0.5 * (np.sin(a - b) ** 2 / np.sin(a + b) ** 2 + np.tan(a - b) ** 2 / np.tan(a + b) ** 2)


@pytest.mark.parametrize("degrees", ANGLES)
@pytest.mark.parametrize("n", [1.5, 1 / 1.5, 1.0001, 2.4, 0.5])
def test_fresnel_agrees_with_its_formulas(degrees, n):
    share, inside = fresnel(np.float32(np.cos(np.radians(degrees))), np.float32(n))
    assert share == pytest.approx(reflectance(degrees, n), abs=3e-6, rel=1e-3)
    if np.sin(np.radians(degrees)) < n:
        assert inside == pytest.approx(np.sqrt(1 - (np.sin(np.radians(degrees)) / n) ** 2), abs=1e-4)


def test_no_light_of_one_polarisation_is_reflected_at_brewsters_angle():
    """There the share is half that of the other polarisation, ((n² − 1) / (n² + 1))²."""
    n = 1.5
    share, _ = fresnel(np.float32(np.cos(np.arctan(n))), np.float32(n))
    assert share == pytest.approx(0.5 * ((n * n - 1) / (n * n + 1)) ** 2, abs=1e-7)


@pytest.mark.parametrize("degrees", ANGLES)
@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("ior", [1.5, 0.7])
def test_glass_obeys_the_laws_of_reflection_and_of_snell(degrees, side, ior):
    n = ior if side > 0 else 1 / ior
    share = reflectance(degrees, n)
    sine, cosine = np.sin(np.radians(degrees)), np.cos(np.radians(degrees))
    into, factor = scattered(degrees, ior, 0.999 * share, side)
    assert factor == 1
    assert np.abs(into - (-sine, side * cosine, 0)).max() < 1e-5
    if share == 1:
        return
    into, factor = scattered(degrees, ior, share + 0.001 * (1 - share) + 1e-5, side)
    assert factor == pytest.approx(1 / n**2, rel=1e-6)
    assert np.linalg.norm(into) == pytest.approx(1, abs=1e-4)
    assert -into[0] * n == pytest.approx(sine, abs=1e-5)
    assert into[1] * side < 0


@pytest.mark.parametrize("degrees", ANGLES)
def test_refraction_is_reciprocal(degrees):
    """Back along the refracted ray: the first direction again, the same share, and factors whose product is 1."""
    ior = 1.5
    into, factor = scattered(degrees, ior, 0.9999)
    inside = np.degrees(np.arcsin(-into[0]))
    assert reflectance(inside, 1 / ior) == pytest.approx(reflectance(degrees, ior), abs=1e-3)
    back, back_factor = scattered(inside, ior, 0.9999, side=-1.0)
    assert -back[0] == pytest.approx(np.sin(np.radians(degrees)), abs=1e-4)
    assert factor * back_factor == pytest.approx(1, rel=1e-6)


@pytest.mark.parametrize("degrees", [41.9, 60, 89])
def test_light_stays_in_the_denser_side_beyond_the_critical_angle(degrees):
    into, factor = scattered(degrees, 1.5, 0.99999, side=-1.0)
    assert factor == 1
    assert into[1] < 0
