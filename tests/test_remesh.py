"""Remeshing: edges of the length that was asked for, near the surface, creases kept, connected as before."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import isophote as iso
from curved_meshes import ellipsoid, torus
from isophote.analysis.remeshing.split import split_long

MODELS = Path(__file__).parents[1] / "../shared/models"
BOX = iso.Mesh(
    [(x, y, z) for x in (0, 2) for y in (0, 1) for z in (0, 1)],
    [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)],
)


def _edges(mesh: iso.Mesh) -> np.ndarray:
    corners = mesh.vertices[mesh.faces]
    return np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).reshape(-1)


@pytest.mark.parametrize("length", [0.05, 0.15])
def test_edges_have_the_length_that_was_asked_for(length: float) -> None:
    known = torus(24)
    found = iso.remesh(known.mesh, length)
    share = _edges(found) / length
    assert 0.9 < np.median(share) < 1.2
    assert np.percentile(share, 2) > 0.6
    assert np.percentile(share, 98) < 1.4
    assert iso.analysis.distance(known.mesh, found.vertices).max() < 1e-9
    told = iso.analysis.topology(found)
    assert (told.closed, told.manifold, told.oriented, told.genus) == (True, True, True, 1)


def test_most_vertices_have_six_neighbours() -> None:
    found = iso.remesh(ellipsoid(20).mesh, 0.12)
    valence = np.bincount(found.indices)
    assert (valence == 6).mean() > 0.7
    assert valence.max() <= 9


def test_a_box_keeps_its_edges_and_corners() -> None:
    found = iso.remesh(BOX, 0.2)
    assert iso.analysis.mass_properties(found).volume == pytest.approx(2, rel=1e-9)
    for corner in BOX.vertices:
        assert np.linalg.norm(found.vertices - corner, axis=1).min() < 1e-12
    lines = iso.analysis.feature_lines(found).sharp
    ends = found.vertices[lines]
    assert np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum() == pytest.approx(16, rel=1e-6)


@pytest.mark.parametrize("name", ["closed/bunny.obj", "genus/double-torus.obj", "boundary/moebius.obj"])
def test_models_stay_connected_as_they_are(name: str) -> None:
    path = MODELS / name
    if not path.exists():
        pytest.skip("the model is not here")
    mesh = iso.load_mesh(path)
    bare = iso.Mesh(mesh.vertices, iso.triangulate(mesh).triangles)
    found = iso.remesh(bare, float(np.ptp(bare.bounds, axis=0).max()) / 25, iterations=4)
    before, after = iso.analysis.topology(bare), iso.analysis.topology(found)
    same = ("euler", "closed", "manifold", "orientable", "loop_count")
    assert [getattr(before, key) for key in same] == [getattr(after, key) for key in same]


def test_splitting_covers_the_same_surface() -> None:
    random = np.random.default_rng(2)
    points = random.random((40, 3))
    triangles = np.array([random.choice(40, 3, replace=False) for _ in range(30)], np.int32)
    positions, pieces = split_long(points, triangles, 0.3)

    def normals(p: np.ndarray, t: np.ndarray) -> np.ndarray:
        return np.cross(p[t[:, 1]] - p[t[:, 0]], p[t[:, 2]] - p[t[:, 0]]) / 2

    np.testing.assert_allclose(normals(positions, pieces).sum(0), normals(points, triangles).sum(0), atol=1e-12)
    areas = [np.linalg.norm(normals(p, t), axis=1).sum() for p, t in ((points, triangles), (positions, pieces))]
    assert areas[0] == pytest.approx(areas[1])
    corners = positions[pieces]
    assert np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max() <= 0.3


def test_the_result_is_the_same_each_time_and_nothing_given_is_changed() -> None:
    mesh = torus(10).mesh
    before = np.array(mesh.vertices)
    assert iso.remesh(mesh, 0.2, iterations=3) == iso.remesh(mesh, 0.2, iterations=3)
    assert (mesh.vertices == before).all()


def test_what_is_left_out_is_said() -> None:
    dressed = BOX.with_(attributes={"uv": np.zeros((8, 2))})
    with pytest.warns(iso.IsophoteWarning, match="uv"):
        iso.remesh(dressed, 0.5, iterations=1)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"length": 0}, "length"),
        ({"length": float("nan")}, "length"),
        ({"length": 1e-6}, "would make some"),
        ({"iterations": 0}, "iterations"),
        ({"crease_degrees": 0}, "crease_degrees"),
    ],
)
def test_what_has_no_meaning_is_refused(change: dict, message: str) -> None:
    with pytest.raises(iso.GeometryError, match=message):
        iso.remesh(BOX, **{"length": 0.5, **change})
