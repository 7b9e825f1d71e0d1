"""Simplification: fewer triangles, near the surface, connected as before."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import isophote as iso
from curved_meshes import ellipsoid, torus

MODELS = Path(__file__).parents[1] / "../shared/models"


def _sheet(n: int) -> iso.Mesh:
    """A flat square of 2n² triangles."""
    x, y = (a.reshape(-1) for a in np.meshgrid(np.linspace(0, 1, n + 1), np.linspace(0, 1, n + 1), indexing="ij"))
    i, j = (a.reshape(-1) for a in np.meshgrid(np.arange(n), np.arange(n), indexing="ij"))
    a = i * (n + 1) + j
    faces = np.concatenate([np.stack([a, a + n + 1, a + n + 2], 1), np.stack([a, a + n + 2, a + 1], 1)])
    return iso.Mesh(np.stack([x, y, 0 * x], 1), faces)


def test_a_flat_square_becomes_two_triangles() -> None:
    found = iso.simplify(_sheet(12), error=1e-9)
    assert len(found.faces) <= 4
    np.testing.assert_allclose(iso.analysis.area(found), 1, atol=1e-9)
    np.testing.assert_allclose(found.bounds, [(0, 0, 0), (1, 1, 0)], atol=1e-9)


def test_the_error_of_a_sphere_falls_with_the_square_of_the_size() -> None:
    sphere = ellipsoid(60, (1.0, 1.0, 1.0)).mesh
    distances = [np.abs(np.linalg.norm(iso.simplify(sphere, faces).vertices, axis=1) - 1).max() for faces in (200, 800)]
    assert distances[0] < 0.05
    assert distances[1] < distances[0] / 3


def test_as_few_as_the_error_allows() -> None:
    known = torus(48)
    coarse, fine = (iso.simplify(known.mesh, error=error) for error in (1e-2, 1e-3))
    assert len(coarse.faces) < len(fine.faces) < len(known.mesh.faces)
    for mesh, error in ((coarse, 1e-2), (fine, 1e-3)):
        # The error is a mean; single vertices may be a few times as far off.
        assert iso.analysis.distance(mesh, known.mesh.vertices).max() < 5 * error


@settings(max_examples=15)
@given(st.integers(6, 14), st.integers(4, 300), st.integers(0, 100))
def test_a_torus_stays_a_torus(n: int, faces: int, seed: int) -> None:
    found = iso.analysis.topology(iso.simplify(torus(n, seed=seed).mesh, faces))
    assert (found.closed, found.manifold, found.oriented, found.genus) == (True, True, True, 1)


@pytest.mark.parametrize(
    "name", ["closed/bunny.obj", "genus/double-torus.obj", "boundary/suzanne.obj", "boundary/moebius.obj"]
)
def test_models_stay_connected_as_they_are(name: str) -> None:
    path = MODELS / name
    if not path.exists():
        pytest.skip("the model is not here")
    mesh = iso.load_mesh(path)
    # Cutting polygons can connect them otherwise: two quads of one diagonal.
    bare = iso.Mesh(mesh.vertices, iso.triangulate(mesh).triangles)
    found = iso.simplify(bare, 300)
    before, after = iso.analysis.topology(bare), iso.analysis.topology(found)
    same = ("euler", "closed", "orientable", "loop_count")
    assert [getattr(before, key) for key in same] == [getattr(after, key) for key in same]


def test_nothing_given_is_changed_and_the_result_is_the_same_each_time() -> None:
    mesh = torus(16).mesh
    before = np.array(mesh.vertices)
    first, again = iso.simplify(mesh, 100), iso.simplify(mesh, 100)
    assert first == again
    assert (mesh.vertices == before).all()
    assert len(first.faces) <= 100


def test_what_is_left_out_is_said() -> None:
    mesh = torus(8).mesh
    dressed = mesh.with_(attributes={"uv": np.zeros((len(mesh.vertices), 2))})
    with pytest.warns(iso.IsophoteWarning, match="uv"):
        iso.simplify(dressed, 50)


@pytest.mark.parametrize("goal", [{}, {"faces": 0}, {"faces": 2.5}, {"error": -1.0}, {"error": float("nan")}])
def test_goals_without_meaning_are_refused(goal: dict) -> None:
    with pytest.raises(iso.GeometryError, match="simplify"):
        iso.simplify(_sheet(2), **goal)
