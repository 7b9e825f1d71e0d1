"""Points on meshes: spread by area, on the surface, the same for a seed; blue noise keeps its distance."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree
from scipy.stats import chisquare, kstest

import isophote as iso

sample = iso.analysis.sample_points
# A quad of area 4, a triangle of area 1/2 and one without area.
SHEET = iso.Mesh(
    [(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (0, 0, 1), (1, 0, 1), (0, 1, 1)], [(0, 1, 2, 3), (4, 5, 6), (0, 1, 1)]
)
SQUARE = iso.Mesh([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [(0, 1, 2, 3)])


@pytest.mark.parametrize("method", ["uniform", "blue-noise"])
def test_points_lie_on_their_faces(method: str) -> None:
    found = sample(SHEET, 900, method)
    assert found.points.shape == (900, 3)
    np.testing.assert_allclose(found.points[:, 2], np.where(found.face == 0, 0.0, 1.0), atol=1e-15)
    assert set(found.face.tolist()) == {0, 1}
    np.testing.assert_allclose(found.normal, [(0, 0, 1)] * 900)
    low = found.points[found.face == 1]
    assert (low[:, :2] >= 0).all()
    assert (low[:, 0] + low[:, 1] <= 1 + 1e-12).all()
    assert (found.face == 1).sum() == pytest.approx(100, abs=8)


def test_uniform_points_are_uniform() -> None:
    found = sample(SQUARE, 20_000, seed=4).points
    cells = np.histogram2d(found[:, 0], found[:, 1], bins=8, range=[(0, 1), (0, 1)])[0]
    assert chisquare(cells.reshape(-1)).pvalue > 1e-3
    assert kstest(found[:, 0], "uniform").pvalue > 1e-3


def test_blue_noise_keeps_its_distance() -> None:
    count = 1000
    best = np.sqrt(2 / (np.sqrt(3) * count))  # between the points of a hexagonal lattice
    nearest = {
        method: cKDTree(points).query(points, k=2)[0][:, 1].min() / best
        for method in ("uniform", "blue-noise")
        for points in [sample(SQUARE, count, method).points]
    }
    assert nearest["blue-noise"] > 0.6
    assert nearest["uniform"] < 0.2


def test_a_seed_tells_the_points() -> None:
    for method in ("uniform", "blue-noise"):
        first, again, other = (sample(SHEET, 200, method, seed=s).points for s in (1, 1, 2))
        assert (first == again).all()
        assert not (first[:, :2] == other[:, :2]).any()


@pytest.mark.parametrize("count", [0, -1, 2.5, True, "many", 10**9])
def test_counts_without_meaning_are_refused(count: object) -> None:
    with pytest.raises(iso.GeometryError, match="count"):
        sample(SQUARE, count)


def test_other_methods_and_meshes_without_area_are_refused() -> None:
    with pytest.raises(iso.GeometryError, match="method"):
        sample(SQUARE, 5, "magic")
    with pytest.raises(iso.GeometryError, match="no area"):
        sample(iso.Mesh([(0, 0, 0), (1, 0, 0), (2, 0, 0)], [(0, 1, 2)]), 5)
