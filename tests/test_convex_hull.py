"""Convex hulls: every point inside or on every facet, in exact arithmetic, and corners only, on any input."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull as QhullHull

import isophote as iso


def rows(array: np.ndarray) -> set[tuple[int, ...]]:
    return set(map(tuple, np.sort(array, axis=1).tolist()))


def is_hull_2d(points: np.ndarray) -> None:
    hull = iso.analysis.convex_hull(points)
    p, v = hull.points, hull.vertices
    distinct = np.unique(points + 0.0, axis=0)
    if len(v) > 2:
        # Strictly convex, going round once: no three corners on a line, all points to the left of all sides.
        assert (iso.analysis.orient2d(p[np.roll(v, 1)], p[v], p[np.roll(v, -1)]) == 1).all()
        assert (iso.analysis.orient2d(p[hull.facets[:, :1]], p[hull.facets[:, 1:]], distinct[None]) >= 0).all()
    elif len(v) == 2:
        # All between the two ends.
        assert (iso.analysis.orient2d(p[v[0]], p[v[1]], distinct) == 0).all()
        ends = np.sort(p[v], axis=0)
        assert ((distinct >= ends[0]) & (distinct <= ends[1])).all()
    else:
        assert len(distinct) == 1
    for k in range(len(hull.facets)):
        a, b = hull.neighbours[k]
        assert hull.facets[a, 0] == hull.facets[k, 1]
        assert hull.facets[b, 1] == hull.facets[k, 0]


@settings(max_examples=200, deadline=None)
@given(
    st.lists(st.tuples(st.integers(-4, 4), st.integers(-4, 4)), min_size=1), st.sampled_from([1, 0.1, 1e307, 5e-324])
)
def test_plane_small_integers(points, scale) -> None:
    is_hull_2d(np.array(points, float) * scale)


@settings(max_examples=100, deadline=None)
@given(st.lists(st.tuples(*[st.floats(allow_nan=False, allow_infinity=False)] * 2), min_size=1, max_size=30))
def test_plane_any_doubles(points) -> None:
    is_hull_2d(np.array(points, float))


def test_plane_random_points_as_qhull() -> None:
    points = np.random.default_rng(0).random((5000, 2))
    hull, qhull = iso.analysis.convex_hull(points), QhullHull(points)
    assert rows(hull.facets) == rows(qhull.simplices)
    # Qhull calls the area of two dimensions a volume, too.
    assert hull.volume == pytest.approx(qhull.volume, rel=1e-13)
    assert hull.surface == pytest.approx(qhull.area, rel=1e-13)


def extreme_3d(points: np.ndarray) -> set[tuple[float, ...]]:
    """Corners of the hull of few points: those that are not on a segment, triangle or tetrahedron of others."""
    distinct = np.unique(points + 0.0, axis=0)
    full = iso.analysis.convex_hull(distinct).volume
    found = set()
    for k in range(len(distinct)):
        rest = np.delete(distinct, k, axis=0)
        try:
            smaller = iso.analysis.convex_hull(rest).volume < full * (1 - 1e-9)
        except iso.GeometryError:
            smaller = True
        if smaller:
            found.add(tuple(distinct[k]))
    return found


def is_hull_3d(points: np.ndarray) -> None:
    hull = iso.analysis.convex_hull(points)
    p, f = hull.points, hull.facets
    sides = iso.analysis.orient3d(p[f[:, None, 0]], p[f[:, None, 1]], p[f[:, None, 2]], points[None])
    assert (sides >= 0).all()
    assert (sides == 1).any(axis=1).all()
    assert len(f) == 2 * len(hull.vertices) - 4
    for k in range(3):
        u, v = f[:, (k + 1) % 3], f[:, (k + 2) % 3]
        across = f[hull.neighbours[:, k]]
        assert ((across == u[:, None]).any(axis=1) & (across == v[:, None]).any(axis=1)).all()
        assert (hull.neighbours[hull.neighbours[:, k]] == np.arange(len(f))[:, None]).any(axis=1).all()


def is_flat(points: np.ndarray) -> bool:
    p = np.unique(points, axis=0)
    return not any((iso.analysis.orient3d(*q) != 0) for q in combinations(p, 4))


@settings(max_examples=100, deadline=None)
@given(st.lists(st.tuples(*[st.integers(-2, 2)] * 3), min_size=1, max_size=14), st.sampled_from([1.0, 0.1, 1e-100]))
def test_space_small_integers(points, scale) -> None:
    array = np.array(points, float) * scale
    if is_flat(array):
        with pytest.raises(iso.GeometryError, match="in one plane"):
            iso.analysis.convex_hull(array)
        return
    is_hull_3d(array)
    if scale == 1:
        assert {tuple(array[v]) for v in iso.analysis.convex_hull(array).vertices} == extreme_3d(array)


@pytest.mark.parametrize("shape", ["grid", "sphere", "cylinder", "scales"])
def test_space_special_points(shape: str) -> None:
    rng = np.random.default_rng(3)
    angle = np.linspace(0, 2 * np.pi, 40, endpoint=False)
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    points = {
        "grid": np.stack(np.meshgrid(*[np.arange(6) * 0.1] * 3), axis=-1).reshape(-1, 3),
        "sphere": (lambda q: q / np.linalg.norm(q, axis=1, keepdims=True))(rng.normal(size=(500, 3))),
        "cylinder": np.concatenate([np.insert(ring, 2, z, axis=1) for z in (0.0, 0.3, 1.0)]),
        "scales": rng.choice([-1, 1], (80, 3)) * 2.0 ** rng.integers(-300, 300, (80, 3)),
    }[shape]
    is_hull_3d(points)
    if shape == "sphere":
        assert len(iso.analysis.convex_hull(points).vertices) == 500
    if shape == "cylinder":
        assert len(iso.analysis.convex_hull(points).vertices) == 80


def test_a_cube_has_eight_corners() -> None:
    grid = np.stack(np.meshgrid(*[np.arange(5.0)] * 3), axis=-1).reshape(-1, 3)
    hull = iso.analysis.convex_hull(grid)
    assert len(hull.vertices) == 8
    assert len(hull.facets) == 12
    assert hull.volume == pytest.approx(64, rel=1e-14)
    assert hull.surface == pytest.approx(96, rel=1e-14)


@pytest.mark.parametrize("dimension", [3, 4, 5])
def test_random_points_as_qhull(dimension: int) -> None:
    points = np.random.default_rng(dimension).normal(size=(400, dimension))
    hull, qhull = iso.analysis.convex_hull(points), QhullHull(points)
    assert rows(hull.facets) == rows(qhull.simplices)
    assert hull.volume == pytest.approx(qhull.volume, rel=1e-12)
    assert hull.surface == pytest.approx(qhull.area, rel=1e-12)
    for k in range(dimension):
        across = hull.facets[hull.neighbours[:, k]]
        shared = (across[:, :, None] == np.delete(hull.facets, k, axis=1)[:, None, :]).any(axis=1).sum(axis=1)
        assert (shared == dimension - 1).all()


def test_four_dimensions_on_a_grid() -> None:
    points = np.stack(np.meshgrid(*[np.arange(3.0)] * 4), axis=-1).reshape(-1, 4)
    assert iso.analysis.convex_hull(points).volume == pytest.approx(16, rel=1e-13)


def test_bad_points() -> None:
    with pytest.raises(iso.GeometryError, match="n >= 1"):
        iso.analysis.convex_hull(np.empty((0, 3)))
    with pytest.raises(iso.GeometryError, match="number 1"):
        iso.analysis.convex_hull([(0, 0, 0), (np.nan, 0, 0)])
    with pytest.raises(iso.GeometryError, match="flat"):
        iso.analysis.convex_hull(np.eye(5)[:4])
    with pytest.raises(iso.GeometryError, match="flat"):
        iso.analysis.convex_hull(np.eye(4))
