"""Refined triangulations: angles and areas as wanted, the boundary and the constraints where they were."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import isophote as iso
from isophote.analysis import Delaunay


def area_of(d: Delaunay, chosen: np.ndarray) -> float:
    corners = d.points[d.triangles[chosen]]
    u, v = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    return float((u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]).sum() / 2)


def is_refined(before: Delaunay, d: Delaunay, degrees: float, area: float = np.inf) -> None:
    inside = d.inside() if before.constrained.any() else np.ones(len(d.triangles), bool)
    old = before.inside() if before.constrained.any() else np.ones(len(before.triangles), bool)
    t, p = d.triangles, d.points
    np.testing.assert_array_equal(p[: len(before.points)], before.points)
    assert (iso.analysis.orient2d(p[t[:, 0]], p[t[:, 1]], p[t[:, 2]]) == 1).all()
    assert len(t) == 2 * len(np.unique(d.representative)) - 2 - len(d.hull)
    assert np.degrees(iso.analysis.equiangularity(p, t[inside])[0]) >= degrees - 1e-9
    corners = p[t[inside]]
    u, v = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    assert ((u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]) / 2 <= area * (1 + 1e-12)).all()
    assert area_of(d, inside) == pytest.approx(area_of(before, old), rel=1e-12)
    for w in np.unique(before.winding):
        assert area_of(d, d.winding == w) == pytest.approx(area_of(before, before.winding == w), rel=1e-11)
    # Free sides are Delaunay still; constraints have their length and their place.
    for k in range(3):
        inner = np.flatnonzero((d.neighbours[:, k] >= 0) & ~d.constrained[:, k])
        across = d.neighbours[inner, k]
        back = np.argmax(d.neighbours[across] == inner[:, None], axis=1)
        a, b, c = (p[t[inner, j]] for j in range(3))
        assert not (iso.analysis.incircle(a, b, c, p[t[across, back]]) > 0).any()
    assert length(d) == pytest.approx(length(before), rel=1e-12)


def length(d: Delaunay) -> float:
    ends = d.points[d.constraint_edges]
    return float(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum())


def ring(count: int, radius: float) -> np.ndarray:
    angle = np.arange(count) * 2 * np.pi / count
    return radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def loop(first: int, count: int) -> np.ndarray:
    number = first + np.arange(count)
    return np.stack([number, np.roll(number, -1)], axis=1)


@pytest.mark.parametrize("degrees", [0, 20, 30])
def test_random_points(degrees: float) -> None:
    before = iso.analysis.delaunay(np.random.default_rng(1).random((300, 2)))
    is_refined(before, iso.analysis.refine_triangulation(before, degrees), degrees)


@pytest.mark.parametrize("degrees", [20, 32])
def test_an_outline_with_a_hole(degrees: float) -> None:
    points = np.concatenate([ring(40, 2.0), ring(7, 0.4) + 0.5, [(-0.5, -0.5), (-0.5, -0.501)]])
    edges = np.concatenate([loop(0, 40), loop(40, 7)[:, ::-1]])
    before = iso.analysis.delaunay(points, edges)
    after = iso.analysis.refine_triangulation(before, degrees)
    is_refined(before, after, degrees)
    assert len(after.points) > len(points)


def test_areas() -> None:
    points = [(0, 0), (3, 0), (3, 1), (1, 1), (1, 2), (0, 2)]
    before = iso.analysis.delaunay(points, loop(0, 6))
    after = iso.analysis.refine_triangulation(before, 25, max_area=0.002)
    is_refined(before, after, 25, 0.002)
    assert 4 / 0.002 < after.inside().sum() < 8 * 4 / 0.002


@pytest.mark.parametrize("degrees", [1.0, 5.0, 20.0, 40.0])
def test_acute_corners_end(degrees: float) -> None:
    """Angles that were given stay, and triangles whose shortest side lies across them, on a circle about the corner."""
    wedge = np.array([(0, 0), (1, 0), (np.cos(np.radians(degrees)), np.sin(np.radians(degrees)))])
    before = iso.analysis.delaunay(wedge, loop(0, 3))
    after = iso.analysis.refine_triangulation(before, 25, max_area=0.01, max_points=20_000)
    assert len(after.points) < 2000
    for triangle in after.triangles:
        if np.degrees(iso.analysis.equiangularity(after.points, [triangle])[0]) < 25:
            corners = after.points[triangle]
            sides = np.linalg.norm(np.roll(corners, -1, axis=0) - np.roll(corners, 1, axis=0), axis=1)
            ends = np.linalg.norm(np.delete(corners, np.argmin(sides), axis=0), axis=1)
            assert 0 in triangle or ends[0] == pytest.approx(ends[1], rel=1e-3)


def test_many_segments_at_a_point_end() -> None:
    points = np.concatenate([ring(23, 1.0), ring(31, 0.3) * 1.7, [(0, 0)]])
    edges = np.stack([np.full(23, len(points) - 1), np.arange(23)], axis=1)
    before = iso.analysis.delaunay(points, np.concatenate([edges, loop(0, 23)]), crossings="split")
    after = iso.analysis.refine_triangulation(before, 20, max_points=50_000)
    assert len(after.points) < 10_000
    assert length(after) == pytest.approx(length(before), rel=1e-12)


def test_it_stops_at_the_most_points_and_says_so() -> None:
    before = iso.analysis.delaunay(np.random.default_rng(2).random((100, 2)))
    with pytest.warns(iso.IsophoteWarning, match="there are 150 points already"):
        after = iso.analysis.refine_triangulation(before, 30, max_points=150)
    assert len(after.points) == 150


def test_what_is_as_wanted_stays() -> None:
    before = iso.analysis.delaunay([(0, 0), (1, 0), (1, 1), (0, 1)])
    after = iso.analysis.refine_triangulation(before, 20)
    np.testing.assert_array_equal(after.points, before.points)
    line = iso.analysis.delaunay([(0, 0), (1, 0), (2, 0)])
    assert iso.analysis.refine_triangulation(line) is line


def test_points_that_are_nearly_equal_end() -> None:
    points = [(0, 0), (1, 0), (1, 1), (0, 1), (0.5, 0.5), (0.5, 0.5 + 2**-50)]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", iso.IsophoteWarning)
        after = iso.analysis.refine_triangulation(iso.analysis.delaunay(points), 30, max_points=100_000)
    assert len(after.points) < 5000


def test_bad_wishes() -> None:
    d = iso.analysis.delaunay([(0, 0), (1, 0), (0, 1)])
    with pytest.raises(iso.GeometryError, match="0 to 40"):
        iso.analysis.refine_triangulation(d, 60)
    with pytest.raises(iso.GeometryError, match="positive"):
        iso.analysis.refine_triangulation(d, max_area=0)
