"""Medial axes of meshes: Euler's number kept, balls inside, and the solid back from its balls and cones."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import isophote as iso
from curved_meshes import ellipsoid, torus

MODELS = Path(__file__).parents[1] / "../shared/models"
medial_axis = iso.analysis.medial_axis


def volume(mesh: iso.Mesh) -> float:
    return float(iso.analysis.mass_properties(mesh).volume)


def brick(x: float, y: float, z: float) -> iso.Mesh:
    corners = [(i * x, j * y, k * z) for i in (0, 1) for j in (0, 1) for k in (0, 1)]
    return iso.Mesh(corners, [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)])


def test_a_ball_has_a_point() -> None:
    axis = medial_axis(ellipsoid(12, (1.0, 1.0, 1.0)).mesh, samples=1500, feature=0.5)
    assert axis.euler == 1
    assert np.linalg.norm(axis.vertices, axis=1).max() < 0.1
    np.testing.assert_allclose(axis.radius, 1, atol=0.05)


def test_a_torus_has_a_circle() -> None:
    known = torus(24)
    axis = medial_axis(known.mesh, samples=3000, feature=0.35)
    assert axis.euler == 0
    corners = known.mesh.vertices
    # The torus' own axis is the one along which it is thinnest.
    up = int(np.argmin(np.ptp(corners, axis=0)))
    tube = np.ptp(corners[:, up]) / 2
    ring = np.ptp(corners[:, (up + 1) % 3]) / 2 - tube
    away = np.hypot(*np.delete(axis.vertices, up, axis=1).T)
    assert np.abs(away - ring).max() < 0.25 * tube
    assert np.abs(axis.vertices[:, up]).max() < 0.25 * tube


def test_a_flat_brick_has_a_sheet_in_its_middle() -> None:
    axis = medial_axis(brick(4, 4, 1), samples=3000, feature=0.45)
    assert axis.euler == 1
    middle = np.abs(axis.vertices[:, 2] - 0.5)
    assert np.median(middle) < 0.02
    np.testing.assert_allclose(np.median(axis.radius), 0.5, atol=0.02)
    sheets = axis.sheets()
    assert iso.analysis.topology(sheets).euler == 1
    # Between the parts of the axis that lead to the edges: a square of 3 by 3.
    assert iso.analysis.area(sheets) > 8


@pytest.mark.parametrize("name", ["closed/bunny.obj", "genus/double-torus.obj"])
def test_real_meshes_keep_their_holes(name: str) -> None:
    path = MODELS / name
    if not path.exists():
        pytest.skip("the model is not here")
    mesh = iso.load_mesh(path)
    axis = medial_axis(mesh, samples=3000)
    assert 2 * axis.euler == iso.analysis.topology(mesh).euler
    assert iso.analysis.contains(mesh, axis.vertices).all()
    away = iso.analysis.distance(mesh, axis.vertices)
    # Balls touch samples, so they reach a little beyond what is between those.
    assert (axis.radius >= away - 1e-9).all()
    assert (axis.radius - away).max() < 0.05 * np.linalg.norm(np.ptp(mesh.bounds, axis=0))


def test_balls_and_cones_give_the_solid_back() -> None:
    mesh = ellipsoid(12, (1.0, 0.6, 0.4)).mesh
    axis = medial_axis(mesh, samples=2500, feature=0.02)
    shape = axis.shape()
    assert isinstance(shape, iso.Field)
    again = axis.mesh(cell=0.05)
    assert iso.analysis.topology(again).euler == 2
    assert volume(again) == pytest.approx(volume(mesh), rel=0.06)
    assert iso.analysis.distance(mesh, again.vertices).max() < 0.06


def test_a_seed_gives_the_same_axis() -> None:
    mesh = brick(2, 1, 1)
    first, second = medial_axis(mesh, samples=500, seed=3), medial_axis(mesh, samples=500, seed=3)
    np.testing.assert_array_equal(first.vertices, second.vertices)
    np.testing.assert_array_equal(first.edges, second.edges)


@pytest.mark.parametrize(
    ("mesh", "options", "message"),
    [
        (iso.Mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)]), {}, "closed"),
        (brick(1, 1, 1), {"samples": 2}, "samples"),
        (brick(1, 1, 1), {"feature": float("nan")}, "feature"),
    ],
)
def test_what_bounds_nothing_is_refused(mesh: iso.Mesh, options: dict, message: str) -> None:
    with pytest.raises(iso.GeometryError, match=message):
        medial_axis(mesh, **options)
