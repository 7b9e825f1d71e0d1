"""Delaunay triangulations of the plane: against rational arithmetic, on any input, and Euler's and Sibson's facts."""

from __future__ import annotations

import json
from fractions import Fraction
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import isophote as iso
from isophote.analysis import Delaunay

FIXTURES = Path(__file__).parents[1] / "../shared/models/points2d"


def cross(a, b, c) -> Fraction:
    (ax, ay), (bx, by), (cx, cy) = ([Fraction(float(x)) for x in p] for p in (a, b, c))
    return (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)


def hull_area(points: np.ndarray) -> Fraction:
    """Twice the area of the convex hull, by Andrew's chains in rational numbers."""
    order = sorted({(float(x), float(y)) for x, y in points})
    area = Fraction(0)
    for ordered in (order, order[::-1]):
        chain: list[tuple[float, float]] = []
        for p in ordered:
            while len(chain) > 1 and cross(chain[-2], chain[-1], p) <= 0:
                chain.pop()
            chain.append(p)
        for (ax, ay), (bx, by) in pairwise(chain):
            area += Fraction(ax) * Fraction(by) - Fraction(ay) * Fraction(bx)
    return area


def is_valid(d: Delaunay, points: np.ndarray, everywhere: bool = True) -> None:
    """Everything that makes a Delaunay triangulation, of whatever points."""
    used = np.unique(d.triangles)
    distinct = np.unique(points + 0.0, axis=0)
    kept = np.unique(d.representative)
    np.testing.assert_array_equal(d.points, points)
    np.testing.assert_array_equal(points[d.representative], points)
    assert len(kept) == len(distinct)
    assert (d.representative <= np.arange(len(points))).all()
    if len(d.triangles) == 0:
        assert hull_area(points) == 0
        np.testing.assert_array_equal(np.sort(d.hull), kept)
        return
    np.testing.assert_array_equal(used, kept)
    # Counterclockwise, of the hull's area in all, of Euler's number: so nothing overlaps and nothing is left out.
    a, b, c = (points[d.triangles[:, k]] for k in range(3))
    assert (iso.analysis.orient2d(a, b, c) == 1).all()
    assert len(d.triangles) == 2 * len(distinct) - 2 - len(d.hull)
    if len(d.triangles) < 700:
        assert sum(cross(*points[t]) for t in d.triangles) == hull_area(points)
    # Neighbours share the side.
    for k in range(3):
        side = d.triangles[:, [(k + 1) % 3, (k + 2) % 3]]
        inner = d.neighbours[:, k] >= 0
        across = d.neighbours[inner, k]
        back = np.argmax(d.neighbours[across] == np.flatnonzero(inner)[:, None], axis=1)
        rows = np.arange(len(across))
        np.testing.assert_array_equal(d.triangles[across][rows, (back + 2) % 3], side[inner, 0])
        np.testing.assert_array_equal(d.triangles[across][rows, (back + 1) % 3], side[inner, 1])
    assert (d.neighbours < 0).sum() == len(d.hull)
    before, after = points[np.roll(d.hull, 1)], points[np.roll(d.hull, -1)]
    assert (iso.analysis.orient2d(before, points[d.hull], after) >= 0).all()
    assert len(iso.analysis.empty_circle_violations(points, d.triangles)) == 0
    if everywhere:
        assert len(iso.analysis.empty_circle_violations(points[kept], np.searchsorted(kept, d.triangles), True)) == 0


@pytest.mark.parametrize("count", [0, 1, 2, 3, 4, 5, 8, 30, 1000])
def test_random_points(count: int) -> None:
    points = np.random.default_rng(count).random((count, 2))
    is_valid(iso.analysis.delaunay(points), points)


def cases() -> dict[str, np.ndarray]:
    rng = np.random.default_rng(1)
    x, y = np.meshgrid(np.arange(20.0), np.arange(15.0))
    grid = np.stack([x.ravel(), y.ravel()], axis=1)
    angle = np.arange(360) * np.pi / 180
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    line = np.arange(50.0)[:, None] * np.array([[3.0, 7.0]])
    return {
        "grid": grid,
        "grid of tenths": grid * 0.1,
        "grid turned": grid @ np.array([[3.0, 4.0], [-4.0, 3.0]]),
        "shuffled grid with repetitions": rng.permutation(np.concatenate([grid, grid[::3], grid[:40]])),
        "circle": circle,
        "circle and its middle": np.concatenate([circle, np.zeros((1, 2))]),
        "integer circle": np.array(
            [(s * a, t * b) for a, b in [(15, 20), (7, 24), (20, 15), (24, 7)] for s in (1, -1) for t in (1, -1)], float
        ),
        "line": line,
        "line along x": line * [1, 0],
        "line along y": rng.permutation(line * [0, 1]),
        "line and a point": np.concatenate([line, [[1.0, 0.0]]]),
        "all equal": np.full((100, 2), 2.5),
        "two, often": np.tile([[0.0, 1.0], [-0.0, 1.0], [2.0, 0.0]], (20, 1)),
        "huge": rng.choice([-1.7e308, 1.7e308, 1e300, 3.0], (60, 2)),
        "tiny": rng.integers(-5, 6, (80, 2)) * 5e-324,
        "scales": rng.choice([-1, 1], (300, 2)) * 2.0 ** rng.integers(-1000, 1000, (300, 2)),
        "cluster in a cluster": np.concatenate([rng.random((50, 2)) * 2.0 ** (-40 * k) for k in range(12)]),
        "last bits": 1 + rng.integers(0, 6, (100, 2)) * 2.0**-52,
        "thin": rng.random((500, 2)) * [1, 1e-12],
        "parabola": np.stack([np.arange(-100.0, 100), np.arange(-100.0, 100) ** 2], axis=1),
    }


@pytest.mark.parametrize("name", cases())
def test_special_points(name: str) -> None:
    points = cases()[name]
    is_valid(iso.analysis.delaunay(points), points)


@pytest.mark.parametrize("name", cases())
def test_lifted_hulls_of_special_points(name: str) -> None:
    points = cases()[name]
    if name in ("integer circle", "line", "line along x", "line along y", "all equal", "two, often"):
        with pytest.raises(iso.GeometryError, match="lifted hull is flat"):
            iso.analysis.delaunay(points, method="lifted")
        return
    is_valid(iso.analysis.delaunay(points, method="lifted"), points)


def test_lifted_hulls_are_equal_to_direct_triangulations() -> None:
    points = np.random.default_rng(9).random((20_000, 2))
    direct, lifted = iso.analysis.delaunay(points), iso.analysis.delaunay(points, method="lifted")
    is_valid(lifted, points, everywhere=False)
    assert {tuple(sorted(t)) for t in direct.triangles.tolist()} == {
        tuple(sorted(t)) for t in lifted.triangles.tolist()
    }
    assert iso.analysis.compare_equiangularity(direct, lifted) == 0


@settings(max_examples=200, deadline=None)
@given(
    st.lists(st.tuples(st.integers(-3, 3), st.integers(-3, 3)), max_size=40), st.sampled_from([1.0, 0.1, 1e-200, 1e200])
)
def test_small_integers(points: list[tuple[int, int]], scale: float) -> None:
    array = np.array(points, float).reshape(-1, 2) * scale
    is_valid(iso.analysis.delaunay(array), array)


@settings(max_examples=100, deadline=None)
@given(st.lists(st.tuples(*[st.floats(allow_nan=False, allow_infinity=False)] * 2), max_size=20))
def test_any_finite_doubles(points: list[tuple[float, float]]) -> None:
    array = np.array(points, float).reshape(-1, 2)
    is_valid(iso.analysis.delaunay(array), array)


@pytest.mark.parametrize(
    "name", ["ukraine.json", "issue13.json", "issue43.json", "robustness1.json", "voronoi_testdata_issue85.txt"]
)
def test_collected_points(name: str) -> None:
    path = FIXTURES / name
    if not path.exists():
        pytest.skip("collected points are not there")
    points = np.array(json.loads(path.read_text()), float) if path.suffix == ".json" else np.loadtxt(path)
    is_valid(iso.analysis.delaunay(points), points)


@pytest.mark.parametrize("kind", ["uniform", "grid", "clusters", "one cell"])
def test_many_points_in_parts(kind: str) -> None:
    """Enough for several parts, which are triangulated side by side and merged."""
    rng = np.random.default_rng(7)
    points = {
        "uniform": lambda: rng.random((150_000, 2)),
        "grid": lambda: np.stack(np.divmod(rng.permutation(100_000), 400), axis=1).astype(float),
        "clusters": lambda: rng.normal(size=(140_000, 2)) * 10.0 ** rng.integers(-9, 1, (140_000, 1)),
        "one cell": lambda: np.concatenate([rng.random((90_000, 2)), [[1e30, 1e30], [0, 1e15]]]),
    }[kind]()
    is_valid(iso.analysis.delaunay(points), points, everywhere=False)


def test_the_number_of_processors_changes_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    points = np.random.default_rng(2).random((140_000, 2))
    found = []
    for count in (1, 3):
        monkeypatch.setattr("isophote.analysis.crew.processors", lambda count=count: count)
        found.append(iso.analysis.delaunay(points))
    for name in ("triangles", "neighbours", "hull", "representative"):
        np.testing.assert_array_equal(getattr(found[0], name), getattr(found[1], name))


def test_duplicates_are_told() -> None:
    d = iso.analysis.delaunay([(0, 0), (1, 0), (0, 0), (0, 1), (1, 0), (0, 0)])
    assert d.duplicates.tolist() == [2, 4, 5]
    assert d.representative.tolist() == [0, 1, 0, 3, 1, 0]
    assert d.triangles.tolist() == [[0, 1, 3]] or sorted(d.triangles[0]) == [0, 1, 3]
    assert len(d.edges) == 3


def test_points_on_a_line_come_in_order() -> None:
    d = iso.analysis.delaunay([(0, 0), (3, 3), (1, 1), (2, 2)])
    assert d.hull.tolist() in ([0, 2, 3, 1], [1, 3, 2, 0])
    assert {tuple(sorted(e)) for e in d.edges.tolist()} == {(0, 2), (2, 3), (1, 3)}


def flipped(d: Delaunay, triangle: int, k: int) -> np.ndarray | None:
    """The triangles after exchanging the diagonal across a side; None where that gives none."""
    other = d.neighbours[triangle, k]
    if other < 0:
        return None
    a, b, c = np.roll(d.triangles[triangle], -k)
    e = d.triangles[other][d.neighbours[other] == triangle][0]
    p = d.points
    if iso.analysis.orient2d(p[a], p[b], p[e]) <= 0 or iso.analysis.orient2d(p[a], p[e], p[c]) <= 0:
        return None
    triangles = d.triangles.copy()
    triangles[triangle], triangles[other] = (a, b, e), (a, e, c)
    return triangles


def test_no_flip_raises_the_angles() -> None:
    d = iso.analysis.delaunay(np.random.default_rng(11).random((40, 2)))
    flips = 0
    for t in range(len(d.triangles)):
        for k in range(3):
            triangles = flipped(d, t, k)
            if triangles is not None:
                assert np.allclose(sum(iso.analysis.equiangularity(d.points, triangles)), len(triangles) * np.pi)
                other = Delaunay(d.points, triangles, d.neighbours, d.hull, d.representative, d.constrained, d.winding)
                assert iso.analysis.compare_equiangularity(d, other) == 1
                assert iso.analysis.compare_equiangularity(other, d) == -1
                assert len(iso.analysis.empty_circle_violations(d.points, triangles)) > 0
                flips += 1
    assert flips > 40
    assert iso.analysis.compare_equiangularity(d, d) == 0


def test_circumcircles() -> None:
    centre, radius = iso.analysis.circumcircle((3, 0), (0, 4), (0, 0))
    np.testing.assert_array_equal(centre, (1.5, 2))
    assert radius == 2.5
    centre, radius = iso.analysis.circumcircle((0, 0), (1, 1), (2, 2))
    assert np.isnan(centre).all()
    assert radius == np.inf


def test_circumcircles_of_flat_triangles_are_right_in_the_last_places() -> None:
    rng = np.random.default_rng(8)
    a, b = rng.random((2, 50, 2))
    c = a + 0.37 * (b - a) + rng.normal(size=(50, 2)) * 1e-12
    centres, radii = iso.analysis.circumcircle(a, b, c)
    for p, q, r, centre, radius in zip(a, b, c, centres, radii, strict=True):
        (px, py), ux, uy, vx, vy = (
            [Fraction(float(x)) for x in p],
            *(Fraction(float(e)) - Fraction(float(s)) for v in (q, r) for e, s in zip(v, p, strict=True)),
        )
        u, v, twice = ux * ux + uy * uy, vx * vx + vy * vy, 2 * (ux * vy - uy * vx)
        x, y = (vy * u - uy * v) / twice, (ux * v - vx * u) / twice
        np.testing.assert_allclose(centre, [float(px + x), float(py + y)], rtol=4e-16)
        assert radius == pytest.approx(float(x * x + y * y) ** 0.5, rel=4e-16)


def test_violations_name_triangle_and_point() -> None:
    points = [(0, 0), (4, 0), (4, 3), (0, 3), (2, 1)]
    found = iso.analysis.empty_circle_violations(points, [(0, 1, 2), (0, 2, 3)], everywhere=True)
    assert sorted(map(tuple, found.tolist())) == [(0, 4), (1, 4)]
    assert len(iso.analysis.empty_circle_violations(points, [(0, 2, 1), (0, 2, 3)])) == 0


@pytest.mark.parametrize(
    ("points", "said"),
    [
        ([(0, 0), (np.nan, 1)], "number 1"),
        ([(0, 0), (1, np.inf)], "not finite"),
        ([1.0, 2.0, 3.0], "shape"),
        ([(0,), (1,)], "shape"),
        ("points", "numbers"),
    ],
)
def test_bad_points(points, said: str) -> None:
    with pytest.raises(iso.GeometryError, match=said):
        iso.analysis.delaunay(points)


def test_bad_triangles() -> None:
    square = [(0, 0), (1, 0), (1, 1), (0, 1)]
    with pytest.raises(iso.GeometryError, match="not there: row 1"):
        iso.analysis.empty_circle_violations(square, [(0, 1, 2), (0, 2, 4)])
    with pytest.raises(iso.GeometryError, match="more than two"):
        iso.analysis.empty_circle_violations([*square, (2, 0)], [(0, 1, 2), (0, 1, 3), (0, 1, 4)])
    with pytest.raises(iso.GeometryError, match="whole numbers"):
        iso.analysis.equiangularity(square, [(0.0, 1.0, 2.0)])
