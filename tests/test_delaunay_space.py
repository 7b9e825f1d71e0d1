"""Delaunay triangulations of space: exact on any input, equal to lifted hulls, and of more dimensions."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import Delaunay as QhullDelaunay

import isophote as iso
from isophote.analysis import DelaunayComplex

FIXTURES = Path(__file__).parents[1] / "../shared/models/points3d"


def rows(array: np.ndarray) -> set[tuple[int, ...]]:
    return set(map(tuple, np.sort(array, axis=1).tolist()))


def is_valid(d: DelaunayComplex, points: np.ndarray, everywhere: bool = True) -> None:
    kept = np.unique(d.representative)
    assert len(kept) == len(np.unique(points + 0.0, axis=0))
    np.testing.assert_array_equal(points[d.representative], points)
    assert (d.representative <= np.arange(len(points))).all()
    t = d.tetrahedra
    if len(t) == 0:
        with pytest.raises(iso.GeometryError, match=r"in one plane|n >= 1"):
            iso.analysis.convex_hull(points)
        return
    np.testing.assert_array_equal(np.unique(t), kept)
    corners = [points[t[:, k]] for k in range(4)]
    assert (iso.analysis.orient3d(*corners) == 1).all()
    # Neighbours share three corners, and no neighbour's far corner lies inside the sphere.
    for k in range(4):
        inner = np.flatnonzero(d.neighbours[:, k] >= 0)
        across = d.neighbours[inner, k]
        back = np.argmax(d.neighbours[across] == inner[:, None], axis=1)
        far = t[across, back]
        assert (
            np.sort(np.where(t[across] == far[:, None], -1, t[across]), axis=1)[:, 1:]
            == np.sort(np.delete(t[inner], k, axis=1), axis=1)
        ).all()
        assert (iso.analysis.insphere(*(c[inner] for c in corners), points[far]) <= 0).all()
    if everywhere:
        assert (iso.analysis.insphere(*(c[:, None] for c in corners), points[None, kept]) <= 0).all()
    # Closed, convex and of the hull's volume: nothing overlaps and nothing is left out.
    a, b, c = (points[d.hull[:, k]] for k in range(3))
    hull = iso.analysis.convex_hull(points)
    assert len(d.hull) == (d.neighbours < 0).sum()
    if everywhere:
        assert (iso.analysis.orient3d(a[:, None], b[:, None], c[:, None], points[None, kept]) >= 0).all()
    centre = points[hull.vertices[0]]
    volumes = np.linalg.det(points[t[:, :3]] - points[t[:, 3:]]) / 6
    assert volumes.sum() == pytest.approx(hull.volume, rel=1e-9)
    assert np.linalg.det(np.stack([a - centre, b - centre, c - centre], axis=1)).sum() / 6 == pytest.approx(
        hull.volume, rel=1e-9
    )


@pytest.mark.parametrize("method", ["direct", "lifted"])
@pytest.mark.parametrize("count", [5, 6, 9, 40, 300])
def test_random_points(count: int, method: str) -> None:
    points = np.random.default_rng(count).random((count, 3))
    d = iso.analysis.delaunay(points, method=method)
    is_valid(d, points)
    assert rows(d.simplices) == rows(QhullDelaunay(points).simplices)


def cases() -> dict[str, np.ndarray]:
    rng = np.random.default_rng(1)
    grid = np.stack(np.meshgrid(*[np.arange(5.0)] * 3), axis=-1).reshape(-1, 3)
    sphere = rng.normal(size=(150, 3))
    cubes = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
    return {
        "grid": grid,
        "grid of tenths": grid * 0.1,
        "shuffled grid with repetitions": rng.permutation(np.concatenate([grid, grid[::3]])),
        "cube": cubes,
        "cube and its middle": np.concatenate([cubes, np.zeros((1, 3))]),
        "nearly on a sphere": sphere / np.linalg.norm(sphere, axis=1, keepdims=True),
        "plane and a point": np.concatenate([grid * [1, 1, 0], [[2.0, 2.0, 1.0]]]),
        "two lines": np.concatenate(
            [
                np.insert(np.arange(12.0)[:, None], [0, 1], 0.0, axis=1),
                np.insert(np.arange(12.0)[:, None], [0, 0], 1.0, axis=1),
            ]
        ),
        "last bits": 1 + rng.integers(0, 4, (60, 3)) * 2.0**-52,
        "scales": rng.choice([-1, 1], (60, 3)) * 2.0 ** rng.integers(-60, 60, (60, 3)),
        "moment curve": np.stack([np.arange(-30.0, 30) ** k for k in (1, 2, 3)], axis=1),
    }


@pytest.mark.parametrize("name", cases())
def test_special_points(name: str) -> None:
    points = cases()[name]
    is_valid(iso.analysis.delaunay(points), points)


@pytest.mark.parametrize("name", [name for name in cases() if name != "cube"])
def test_lifted_hulls_of_special_points(name: str) -> None:
    points = cases()[name]
    is_valid(iso.analysis.delaunay(points, method="lifted"), points)


@settings(max_examples=100, deadline=None)
@given(st.lists(st.tuples(*[st.integers(-2, 2)] * 3), max_size=30), st.sampled_from([1.0, 0.1, 1e-80, 1e80]))
def test_small_integers(points, scale) -> None:
    array = np.array(points, float).reshape(-1, 3) * scale
    is_valid(iso.analysis.delaunay(array), array)


@pytest.mark.parametrize(
    "points",
    [
        np.empty((0, 3)),
        np.zeros((4, 3)),
        np.tile([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]], (5, 1)),
        np.insert(np.random.default_rng(0).integers(0, 5, (30, 2)).astype(float), 2, 7, axis=1),
    ],
    ids=["none", "one", "two", "plane"],
)
def test_points_that_span_no_space(points: np.ndarray) -> None:
    d = iso.analysis.delaunay(points)
    assert d.simplices.shape == (0, 4)
    is_valid(d, points)
    if len(points):
        with pytest.raises(iso.GeometryError, match="lifted hull is flat"):
            iso.analysis.delaunay(points, method="lifted")


def test_scanned_points() -> None:
    path = FIXTURES / "cactus.pts"
    if not path.exists():
        pytest.skip("scanned points are not there")
    points = np.array([line.split()[1:] for line in path.read_text().splitlines() if line.startswith("p ")], float)
    d = iso.analysis.delaunay(points)
    is_valid(d, points, everywhere=False)
    is_valid(iso.analysis.delaunay(points, method="lifted"), points, everywhere=False)


def test_many_points_as_lifted() -> None:
    points = np.random.default_rng(5).random((8000, 3))
    direct, lifted = iso.analysis.delaunay(points), iso.analysis.delaunay(points, method="lifted")
    is_valid(direct, points, everywhere=False)
    assert rows(direct.simplices) == rows(lifted.simplices)
    assert rows(direct.hull) == rows(lifted.hull)


def test_many_neighbours_of_one_point() -> None:
    """Points on a sphere about one: its tetrahedra are all, and a hole is as large as everything."""
    sphere = np.random.default_rng(6).normal(size=(3000, 3))
    points = np.concatenate([sphere / np.linalg.norm(sphere, axis=1, keepdims=True), np.zeros((1, 3))])
    is_valid(iso.analysis.delaunay(points), points, everywhere=False)


@pytest.mark.parametrize("dimension", [4, 5])
def test_more_dimensions(dimension: int) -> None:
    points = np.random.default_rng(dimension).random((40, dimension))
    d = iso.analysis.delaunay(np.concatenate([points, points[:3]]))
    assert rows(d.simplices) == rows(QhullDelaunay(points).simplices)
    assert d.duplicates.tolist() == [40, 41, 42]
    with pytest.raises(iso.GeometryError, match="tetrahedra"):
        _ = d.tetrahedra
    with pytest.raises(iso.GeometryError, match="Qhull"):
        iso.analysis.delaunay(points * ([0] * (dimension - 1) + [1]))


def test_bad_points() -> None:
    with pytest.raises(iso.GeometryError, match="d >= 2"):
        iso.analysis.delaunay([[1.0], [2.0]])
    with pytest.raises(iso.GeometryError, match="method"):
        iso.analysis.delaunay([(0, 0, 0)], method="quick")
