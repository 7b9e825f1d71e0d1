"""Constrained Delaunay triangulations: constraints are sides, everything else is Delaunay, inside is inside."""

from __future__ import annotations

import json
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import isophote as iso
from isophote.analysis import Delaunay

POLYGONS = Path(__file__).parents[1] / "../shared/models/polygons/earcut"


def sides_of(d: Delaunay) -> set[tuple[int, int]]:
    return {(min(a, b), max(a, b)) for a, b in d.constraint_edges.tolist()}


def parts(points: np.ndarray, used: np.ndarray, a: int, b: int) -> list[tuple[int, int]]:
    """The segment from a to b, cut at the points that lie on it."""
    on = iso.analysis.orient2d(points[a], points[b], points[used]) == 0
    low, high = np.minimum(points[a], points[b]), np.maximum(points[a], points[b])
    between = used[on & (points[used] >= low).all(axis=1) & (points[used] <= high).all(axis=1)]
    order = between[np.lexsort((points[between, 1], points[between, 0]))]
    return [(min(p, q), max(p, q)) for p, q in zip(order[:-1].tolist(), order[1:].tolist(), strict=True)]


def is_valid(d: Delaunay, constraints: np.ndarray | None = None) -> None:
    p, t = d.points, d.triangles
    a, b, c = (p[t[:, k]] for k in range(3))
    assert (iso.analysis.orient2d(a, b, c) == 1).all()
    used = np.unique(d.representative)
    np.testing.assert_array_equal(np.unique(t), used)
    assert len(t) == 2 * len(used) - 2 - len(d.hull)
    # No corner across a side that is free lies inside the circle; sides look the same from both triangles.
    for k in range(3):
        inner = np.flatnonzero(d.neighbours[:, k] >= 0)
        across = d.neighbours[inner, k]
        back = np.argmax(d.neighbours[across] == inner[:, None], axis=1)
        np.testing.assert_array_equal(d.neighbours[across, back], inner)
        np.testing.assert_array_equal(d.constrained[across, back], d.constrained[inner, k])
        far = p[t[across, back]]
        inside = iso.analysis.incircle(a[inner], b[inner], c[inner], far) > 0
        assert not (inside & ~d.constrained[inner, k]).any()
    if constraints is not None:
        expected = {part for u, v in d.representative[constraints].tolist() for part in parts(p, used, u, v)}
        assert sides_of(d) == expected


def winding_at(points: np.ndarray, constraints: np.ndarray, place: np.ndarray) -> int:
    """Signed crossings of the ray to the right."""
    a, b = points[constraints[:, 0]], points[constraints[:, 1]]
    side = iso.analysis.orient2d(a, b, place)
    up = (a[:, 1] <= place[1]) & (b[:, 1] > place[1]) & (side > 0)
    down = (b[:, 1] <= place[1]) & (a[:, 1] > place[1]) & (side < 0)
    return int(up.sum() - down.sum())


def has_winding_numbers(d: Delaunay, constraints: np.ndarray) -> None:
    """At the middle of each triangle, if rounding leaves it there."""
    a, b, c = (d.points[d.triangles[:, k]] for k in range(3))
    middle = (a + b + c) / 3
    held = np.all([iso.analysis.orient2d(u, v, middle) > 0 for u, v in ((a, b), (b, c), (c, a))], axis=0)
    for k in np.flatnonzero(held):
        assert d.winding[k] == winding_at(d.points, constraints, middle[k])


def test_a_square_with_a_hole() -> None:
    points = [(0, 0), (4, 0), (4, 4), (0, 4), (1, 1), (1, 3), (3, 3), (3, 1)]
    edges = np.array([(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4)])
    d = iso.analysis.delaunay(points, edges)
    is_valid(d, edges)
    corners = d.points[d.triangles[d.inside()]]
    assert np.linalg.det(np.insert(corners, 2, 1, axis=2)).sum() / 2 == pytest.approx(12, rel=1e-14)
    assert d.inside("positive").sum() == 8
    assert not d.inside("negative").any()
    with pytest.raises(iso.GeometryError, match="winding rule"):
        d.inside("odd")


def loops(rng: np.random.Generator, count: int, turns: int) -> tuple[np.ndarray, np.ndarray]:
    """Star-shaped loops about one middle, one in another, each going round counterclockwise `turns` may change."""
    points, edges = [], []
    for k in range(count):
        n = int(rng.integers(5, 60))
        angle = np.sort(rng.random(n)) * 2 * np.pi
        radius = (k + 1 + 0.4 * rng.random(n))[:, None]
        first = sum(map(len, points))
        points.append(radius * np.stack([np.cos(angle), np.sin(angle)], axis=1))
        number = np.arange(n) + first
        loop = np.stack([number, np.roll(number, -1)], axis=1)
        edges.append(loop if (turns >> k) & 1 == 0 else loop[:, ::-1])
    return np.concatenate(points), np.concatenate(edges)


@pytest.mark.parametrize("turns", [0, 2, 5])
def test_loops_with_points_around(turns: int) -> None:
    rng = np.random.default_rng(turns)
    points, edges = loops(rng, 3, turns)
    points = np.concatenate([points, rng.normal(size=(300, 2)) * 2])
    d = iso.analysis.delaunay(points, edges, crossings="split")
    is_valid(d)
    if len(d.points) == len(points):
        is_valid(d, edges)
        has_winding_numbers(d, edges)


@settings(max_examples=150, deadline=None)
@given(st.data())
def test_constraints_through_points_of_a_grid(data) -> None:
    """Random constraints that do not cross: each is taken if it is not refused."""
    place = st.tuples(st.integers(0, 5), st.integers(0, 5))
    points = np.array(data.draw(st.lists(place, min_size=4, max_size=30)), float)
    number = st.integers(0, len(points) - 1)
    taken = np.empty((0, 2), int)
    for u, v in data.draw(st.lists(st.tuples(number, number), max_size=12)):
        if (points[u] == points[v]).all():
            continue
        tried = np.concatenate([taken, [[u, v]]])
        crossing = crosses(points, tried)
        if crossing:
            with pytest.raises(iso.GeometryError, match=f"number {len(tried) - 1}, from point {u} to {v}"):
                iso.analysis.delaunay(points, tried)
        else:
            taken = tried
    d = iso.analysis.delaunay(points, taken)
    if len(d.triangles):
        is_valid(d, taken)


def crosses(points: np.ndarray, edges: np.ndarray) -> bool:
    """Whether the last edge crosses another in the inside of both."""
    a, b = points[edges[-1]]
    c, d = points[edges[:-1, 0]], points[edges[:-1, 1]]
    orient2d = iso.analysis.orient2d
    apart = orient2d(a, b, c) * orient2d(a, b, d), orient2d(c, d, a) * orient2d(c, d, b)
    candidates = (apart[0] < 0) & (apart[1] < 0)
    # Where another point is at the crossing, both pass through it.
    for k in np.flatnonzero(candidates):
        meets = (orient2d(a, b, points) == 0) & (orient2d(c[k], d[k], points) == 0)
        if not meets.any():
            return True
    return False


def test_crossings_are_named() -> None:
    points = [(0, 0), (2, 2), (0, 2), (2, 0), (5, 5)]
    with pytest.raises(iso.GeometryError, match=r"cross at \(1, 1\): number 0, from point 0 to 1, and number 2, from"):
        iso.analysis.delaunay(points, [(0, 1), (1, 4), (2, 3)])


def test_crossings_are_split() -> None:
    rng = np.random.default_rng(3)
    points = rng.random((60, 2))
    edges = rng.permutation(60).reshape(-1, 2)
    d = iso.analysis.delaunay(points, edges, crossings="split")
    is_valid(d)
    np.testing.assert_array_equal(d.points[:60], points)
    assert len(d.points) > 100
    # Each new point lies on two of the constraints, but for its rounding.
    a, b = points[edges[:, 0]], points[edges[:, 1]]
    way = (b - a) / np.linalg.norm(b - a, axis=1)[:, None]
    for p in d.points[60:]:
        distance = np.abs(way[:, 0] * (p - a)[:, 1] - way[:, 1] * (p - a)[:, 0])
        assert (distance < 1e-15).sum() >= 2
    # Every constraint is a path of sides from end to end.
    following: dict[int, set[int]] = {}
    for u, v in d.constraint_edges.tolist():
        following.setdefault(u, set()).add(v)
        following.setdefault(v, set()).add(u)
    for k, (u, v) in enumerate(edges.tolist()):
        at, before = u, -1
        while at != v:
            ahead = [w for w in following[at] if w != before]
            ahead.sort(
                key=lambda w, k=k, at=at: (
                    -(way[k] @ (d.points[w] - d.points[at])) / np.linalg.norm(d.points[w] - d.points[at])
                )
            )
            before, at = at, ahead[0]


def test_crossings_in_one_point_and_on_top_of_each_other() -> None:
    angle = np.arange(12) * np.pi / 6
    points = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    edges = np.stack([np.arange(6), np.arange(6) + 6], axis=1)
    d = iso.analysis.delaunay(points, edges, crossings="split")
    is_valid(d)
    assert np.abs(d.points[12:]).max() < 1e-15
    overlapping = [(0, 0), (4, 0), (1, 0), (6, 0), (3, -2), (3, 2), (2, 2)]
    d = iso.analysis.delaunay(overlapping, [(0, 1), (2, 3), (4, 5)], crossings="split")
    is_valid(d)
    assert d.points[-1].tolist() == [3, 0]
    assert sides_of(d) == {(0, 2), (2, 7), (1, 7), (1, 3), (4, 7), (5, 7)}


def test_what_does_not_close_up_encloses() -> None:
    """A square in no direction with a diagonal: the winding is no number, but the inside is enclosed."""
    points = [(0, 0), (1, 0), (1, 1), (0, 1), (-3, -3), (4, -3), (0, 5)]
    d = iso.analysis.delaunay(points, [(0, 1), (2, 1), (2, 3), (0, 3), (0, 2)])
    assert d.inside().sum() == 2
    assert {v for t in d.triangles[d.inside()].tolist() for v in t} == {0, 1, 2, 3}
    crack = iso.analysis.delaunay(points, [(0, 1), (1, 2)])
    assert not crack.inside().any()


def test_duplicates_and_a_line() -> None:
    points = [(0, 0), (1, 0), (0, 0), (1, 1), (0, 1)]
    d = iso.analysis.delaunay(points, [(2, 3), (0, 2)])
    assert sides_of(d) == {(0, 3)}
    line = iso.analysis.delaunay([(0, 0), (1, 1), (2, 2)], [(0, 2)])
    assert len(line.triangles) == 0


@pytest.mark.parametrize(
    ("edges", "said"),
    [
        ([(0, 4)], "not there: row 0"),
        ([(0, 1), (2, 2)], "number 1 joins point 2 to itself"),
        ([(0, 1, 2)], "whole numbers"),
        ([(0.0, 1.0)], "whole numbers"),
    ],
)
def test_bad_constraints(edges, said: str) -> None:
    with pytest.raises(iso.GeometryError, match=said):
        iso.analysis.delaunay([(0, 0), (1, 0), (1, 1), (0, 1)], edges)


def test_constraints_of_space_are_refused() -> None:
    with pytest.raises(iso.GeometryError, match="of the plane"):
        iso.analysis.delaunay(np.eye(3), [(0, 1)])
    with pytest.raises(iso.GeometryError, match="crossings"):
        iso.analysis.delaunay(np.eye(3)[:, :2], [(0, 1)], crossings="join")


def polygons() -> list[Path]:
    return sorted(path for path in POLYGONS.glob("*.json") if path.stem != "expected") if POLYGONS.exists() else []


@pytest.mark.parametrize("path", polygons(), ids=lambda path: path.stem)
def test_collected_polygons(path: Path) -> None:
    """Outlines with holes, touching and crossing ones too: inside is where a ray crosses an odd number of times."""
    rings = [np.array(ring, float).reshape(-1, 2) for ring in json.loads(path.read_text()) if len(ring)]
    points = np.concatenate(rings)
    starts = np.cumsum([0, *map(len, rings)])
    edges = np.concatenate([np.stack([r := np.arange(a, b), np.roll(r, -1)], axis=1) for a, b in pairwise(starts)])
    edges = edges[edges[:, 0] != edges[:, 1]]
    d = iso.analysis.delaunay(points, edges, crossings="split")
    if len(d.triangles) == 0:
        return
    is_valid(d)
    rng = np.random.default_rng(0)
    low, high = points.min(axis=0), points.max(axis=0)
    a, b, c = (d.points[d.triangles[:, k]] for k in range(3))
    for place in low + rng.random((40, 2)) * (high - low):
        holds = np.all([iso.analysis.orient2d(u, v, place) > 0 for u, v in ((a, b), (b, c), (c, a))], axis=0)
        if holds.any():
            assert d.inside("evenodd")[holds][0] == winding_at(points, edges, place) % 2
