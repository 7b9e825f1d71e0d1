"""Voronoi diagrams by both methods: against each other, Delaunay triangulations, brute force, closed forms."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import isophote as iso
from isophote.analysis import Voronoi
from test_delaunay import cases, is_valid

FIXTURES = Path(__file__).parents[1] / "../shared/models/points2d"
SQUARE = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])
STAR = np.array([(0, 0), (3, 1), (6, 0), (5, 3), (6, 6), (3, 5), (0, 6), (1, 3)], float)
voronoi = iso.analysis.voronoi


def edge_names(v: Voronoi) -> set[tuple[int, int]]:
    return {(min(e), max(e)) for e in v.edge_sites.tolist()}


def agrees_with_the_dual(points: np.ndarray, everywhere: bool = True) -> Voronoi:
    """A sweep gives a Delaunay triangulation, and the same diagram as dividing and conquering."""
    swept, divided = voronoi(points, method="sweep"), voronoi(points)
    is_valid(swept.delaunay(), points, everywhere)
    np.testing.assert_array_equal(swept.representative, divided.representative)
    assert edge_names(swept) == edge_names(divided)
    assert len(swept.edges) == len(edge_names(swept))
    assert len(swept.vertices) == len(divided.vertices)
    return swept


@pytest.mark.parametrize("count", [0, 1, 2, 3, 4, 5, 8, 30, 1000])
def test_random_points(count: int) -> None:
    agrees_with_the_dual(np.random.default_rng(count).random((count, 2)))


@pytest.mark.parametrize("name", cases())
def test_special_points(name: str) -> None:
    agrees_with_the_dual(cases()[name])


@pytest.mark.parametrize(
    "name", ["ukraine.json", "issue13.json", "issue43.json", "robustness1.json", "voronoi_testdata_issue85.txt"]
)
def test_collected_points(name: str) -> None:
    path = FIXTURES / name
    if not path.exists():
        pytest.skip("collected points are not there")
    points = np.array(json.loads(path.read_text()), float) if path.suffix == ".json" else np.loadtxt(path)
    agrees_with_the_dual(points)
    agrees_with_the_dual(points[:, ::-1])


@settings(max_examples=300, deadline=None)
@given(
    st.lists(st.tuples(st.integers(-3, 3), st.integers(-3, 3)), max_size=40),
    st.sampled_from([1.0, 0.1, 1e-200, 1e200]),
    st.integers(0, 3),
)
def test_small_integers(points: list[tuple[int, int]], scale: float, turns: int) -> None:
    """Sites and circles end at once, rows and columns of sites, repetitions."""
    array = np.array(points, float).reshape(-1, 2) * scale
    for _ in range(turns):
        array = np.stack([-array[:, 1], array[:, 0]], axis=1)
    agrees_with_the_dual(array)


@settings(max_examples=100, deadline=None)
@given(st.lists(st.tuples(*[st.floats(-1e9, 1e9)] * 2), max_size=20))
def test_any_doubles_of_a_wide_range(points: list[tuple[float, float]]) -> None:
    agrees_with_the_dual(np.array(points, float).reshape(-1, 2))


@pytest.mark.parametrize("turn", range(4))
def test_sites_and_circles_at_the_same_moment(turn: int) -> None:
    """Many whole points on circles of whole radius about whole middles: their tops are sites."""
    ring = [(x, y) for x in range(-25, 26) for y in range(-25, 26) if x * x + y * y == 625]
    points = np.array([(x + 50 * i, y + 25 * j) for x, y in ring for i in range(3) for j in range(4)], float)
    points = np.unique(points, axis=0) @ np.linalg.matrix_power(np.array([[0.0, -1.0], [1.0, 0.0]]), turn)
    v = agrees_with_the_dual(points)
    middles = np.array([(50 * i, 25 * j) for i in range(3) for j in (0, 3)], float)
    middles = middles @ np.linalg.matrix_power(np.array([[0.0, -1.0], [1.0, 0.0]]), turn)
    empty = [m for m in middles if np.hypot(*(points - m).T).min() == 25]
    assert all(np.abs(v.vertices - m).max(axis=1).min() == 0 for m in empty)


def test_a_replay_shows_what_the_sweep_knows() -> None:
    points = np.concatenate([np.random.default_rng(11).random((40, 2)), [(0.2, -1), (0.5, -1), (0.9, -1)]])
    v = voronoi(points)
    drawn: set[tuple[int, int]] = set()
    vertices = []
    y = -np.inf
    for event in v.replay():
        assert event.y >= y - 1e-12
        y = event.y
        drawn |= {(min(e), max(e)) for e in event.edges.tolist()}
        if event.vertex is not None:
            vertices.append(event.vertex)
            np.testing.assert_allclose(event.vertex[1] + np.linalg.norm(points[event.sites] - event.vertex, axis=1), y)
        # Breakpoints come from left to right, as far from both of their sites as from the sweep line.
        reached = np.isfinite(event.breakpoints).all(axis=1)
        x = event.breakpoints[reached, 0]
        assert (np.diff(x) >= -1e-6 * (1 + np.abs(x[1:]))).all()
        near = reached & (np.abs(event.breakpoints).max(axis=1) < 100)
        for k in range(2):
            away = np.linalg.norm(event.breakpoints - points[event.arcs[k : len(event.arcs) - 1 + k]], axis=1)
            np.testing.assert_allclose(away[near], y - event.breakpoints[near, 1], atol=1e-9)
        np.testing.assert_allclose(event.beach(event.breakpoints[near, 0]), event.breakpoints[near, 1], atol=1e-6)
    assert drawn == edge_names(v)
    np.testing.assert_allclose(np.sort(vertices, axis=0), np.sort(v.vertices, axis=0))


@pytest.mark.parametrize("scale", [1.0, 1e-200, 1e200])
def test_both_methods_tell_the_same_edges(scale: float) -> None:
    """Between the same vertices, with the same sites to the left and to the right; or all turned round."""
    points = np.random.default_rng(7).random((3000, 2)) * scale
    found = []
    for method in ("dual", "sweep"):
        v = voronoi(points, method=method)
        turned = (v.edge_sites[:, 0] > v.edge_sites[:, 1]) & (v.edges[:, 1] >= 0)
        sites, ends = v.edge_sites.copy(), np.where(v.edges[..., None] >= 0, v.vertices[v.edges], np.inf)
        sites[turned], ends[turned] = sites[turned, ::-1], ends[turned, ::-1]
        order = np.lexsort(sites.T)
        found.append((sites[order], ends[order]))
    np.testing.assert_array_equal(found[0][0], found[1][0])
    np.testing.assert_allclose(found[0][1], found[1][1], rtol=1e-9, atol=1e-9 * scale)


def test_vertices_are_equally_near_to_their_sites_and_to_none_nearer() -> None:
    points = np.random.default_rng(5).random((400, 2))
    v = voronoi(points)
    away = np.linalg.norm(v.vertices[:, None] - points, axis=2)
    nearest = np.sort(away, axis=1)
    np.testing.assert_allclose(nearest[:, 2], nearest[:, 0], rtol=1e-9)
    ends = v.edges[v.edges[:, 1] >= 0]
    sites = v.edge_sites[v.edges[:, 1] >= 0]
    for k in range(2):
        for side in range(2):
            np.testing.assert_allclose(away[ends[:, k], sites[:, side]], nearest[ends[:, k], 0], rtol=1e-9)


def test_edges_run_along_their_directions_with_sites_on_their_sides() -> None:
    points = np.random.default_rng(6).random((300, 2))
    v = voronoi(points)
    finite = v.edges[:, 1] >= 0
    along = v.vertices[v.edges[finite, 1]] - v.vertices[v.edges[finite, 0]]
    length = np.linalg.norm(along, axis=1)
    np.testing.assert_allclose((along * v.directions[finite]).sum(axis=1), length, atol=1e-9)
    left, right = points[v.edge_sites[:, 0]], points[v.edge_sites[:, 1]]
    middle = (left + right) / 2
    assert (iso.analysis.orient2d(middle, middle + v.directions, left) == 1).all()
    assert (iso.analysis.orient2d(middle, middle + v.directions, right) == -1).all()
    # Rays leave between their sites: far out these two are nearest.
    for e in np.flatnonzero(~finite):
        far = v.vertices[v.edges[e, 0]] + 1e6 * v.directions[e]
        nearest = np.argsort(np.linalg.norm(points - far, axis=1))[:2]
        assert set(nearest) == set(v.edge_sites[e])


@pytest.mark.parametrize("bounds", [SQUARE, SQUARE[::-1], STAR / 6, [(0.1, 0.1), (2, 0.2), (0.3, 3)]])
def test_cells_fill_the_bounds_and_hold_what_is_nearest(bounds: np.ndarray) -> None:
    rng = np.random.default_rng(8)
    points = rng.random((60, 2))
    v = voronoi(points, bounds)
    x, y = np.array(bounds, float).T
    area = abs((x * np.roll(y, -1) - np.roll(x, -1) * y).sum() / 2)
    assert v.cells.areas.sum() == pytest.approx(area, rel=1e-12)
    np.testing.assert_allclose([cell.area for cell in v.cells], v.cells.areas, atol=1e-14)
    queries = rng.random((2000, 2)) * np.ptp(bounds, axis=0) + np.min(bounds, axis=0)
    nearest = np.argmin(np.linalg.norm(queries[:, None] - points, axis=2), axis=1)
    np.testing.assert_array_equal(v.nearest(queries), nearest)
    within = crossings(np.array(bounds, float), queries)
    for i, cell in enumerate(v.cells):
        held = np.zeros(len(queries), bool)
        for piece in cell.pieces:
            held |= crossings(piece, queries)
        np.testing.assert_array_equal(held, within & (nearest == i))
        np.testing.assert_array_equal(cell.neighbours, v.neighbours(i))


def crossings(polygon: np.ndarray, queries: np.ndarray) -> np.ndarray:
    """Whether points lie inside a polygon."""
    (ax, ay), (bx, by) = polygon.T, np.roll(polygon, -1, axis=0).T
    x, y = queries[:, :1], queries[:, 1:]
    with np.errstate(all="ignore"):
        crossed = ((ay > y) != (by > y)) & (x < ax + (y - ay) / (by - ay) * (bx - ax))
    return crossed.sum(axis=1) % 2 == 1


def test_a_cell_in_a_horseshoe_has_two_pieces() -> None:
    horseshoe = [(0, 0), (5, 0), (5, 5), (4, 5), (4, 1), (1, 1), (1, 5), (0, 5)]
    v = voronoi([(2.5, 0.5), (2.5, 4)], horseshoe)
    upper = v.cells[1]
    # The line between them is y = 2.25: two legs of 1 by 2.75 lie above it.
    assert len(upper.pieces) == 2
    assert [cell.area for cell in v.cells] == pytest.approx([5 + 2 * 1.25, 2 * 2.75])
    assert {tuple(corner) for piece in upper.pieces for corner in piece} == {
        (0, 2.25), (1, 2.25), (1, 5), (0, 5), (4, 2.25), (5, 2.25), (5, 5), (4, 5)
    }  # fmt: skip


def test_a_grid_has_square_cells_and_no_edge_without_length() -> None:
    x, y = np.meshgrid(np.arange(6.0), np.arange(5.0))
    v = voronoi(np.stack([x.ravel(), y.ravel()], axis=1), [(-0.5, -0.5), (5.5, -0.5), (5.5, 4.5), (-0.5, 4.5)])
    np.testing.assert_allclose(v.cells.areas, 1)
    assert (len(v.vertices), len(v.edges)) == (20, 5 * 5 + 6 * 4)
    assert v.cells[7].neighbours.tolist() == [1, 6, 8, 13]
    np.testing.assert_allclose(np.sort(v.cells[7].polygon, axis=0)[[0, -1]], [(0.5, 0.5), (1.5, 1.5)])
    finite = v.edges[v.edges[:, 1] >= 0]
    np.testing.assert_array_equal(np.linalg.norm(v.vertices[finite[:, 0]] - v.vertices[finite[:, 1]], axis=1), 1)


def test_points_on_a_line_have_strips() -> None:
    for points in ([(1, 0), (0, 0), (3, 0)], [(0, 1), (0, 0), (0, 3)]):
        v = voronoi(points, [(-1, -1), (4, -1), (4, 4), (-1, 4)])
        assert len(v.vertices) == 0
        assert v.edges.tolist() == [[-1, -1], [-1, -1]]
        np.testing.assert_allclose(v.cells.areas, [7.5, 7.5, 10])
        assert v.neighbours(0).tolist() == [1, 2]


def test_repeated_points_are_one_site() -> None:
    v = voronoi([(0, 0), (1, 0), (0, 0), (1, 1)], SQUARE)
    assert v.representative.tolist() == [0, 1, 0, 3]
    assert v.cells[2].area == 0
    assert v.cells[2].polygon.shape == (0, 2)
    assert v.cells.areas.sum() == pytest.approx(1)


def test_lloyd_makes_cells_alike() -> None:
    points = np.random.default_rng(1).random((40, 2)) * 0.1
    before, after = voronoi(points, SQUARE), iso.analysis.lloyd(points, SQUARE, iterations=300)
    assert after.cells.areas.std() < 0.1 * before.cells.areas.std()
    np.testing.assert_allclose(after.points, after.cells.centroids, atol=2e-3)
    np.testing.assert_array_equal(iso.analysis.lloyd(points, SQUARE, 0).points, points)
    # Two sites in a square come to rest at the centroids of its halves.
    two = iso.analysis.lloyd([(0.1, 0.45), (0.3, 0.55)], SQUARE, 200)
    np.testing.assert_allclose(two.cells.areas, 0.5, atol=1e-9)


@pytest.mark.parametrize("method", ["dual", "sweep"])
def test_the_number_of_processors_changes_nothing(monkeypatch: pytest.MonkeyPatch, method: str) -> None:
    points = np.random.default_rng(2).random((70_000, 2))
    found = []
    for count in (1, 3):
        monkeypatch.setattr("isophote.analysis.crew.processors", lambda count=count: count)
        found.append(voronoi(points, method=method))
    for name in ("vertices", "edges", "edge_sites", "directions"):
        np.testing.assert_array_equal(getattr(found[0], name), getattr(found[1], name))
    np.testing.assert_array_equal(found[0].cells.areas, found[1].cells.areas)


def many_points() -> dict[str, np.ndarray]:
    rng = np.random.default_rng(3)
    flat = np.stack([rng.random(20_000), 1e-9 * rng.random(20_000)], axis=1)
    rows = np.stack([rng.random(20_000), rng.integers(0, 1000, 20_000) + 1e-11 * rng.integers(0, 9, 20_000)], axis=1)
    return {
        "evenly": rng.random((40_000, 2)),
        "at many scales": rng.normal(size=(30_000, 2)) * 10.0 ** rng.integers(-6, 1, (30_000, 1)),
        "flat, and one far away": np.concatenate([flat, [(0.5, 1e3)]]),
        "in rows that are nearly straight": rows,
    }


@pytest.mark.parametrize("name", many_points())
def test_many_points(name: str) -> None:
    v = agrees_with_the_dual(many_points()[name], everywhere=False)
    assert v.cells.areas.sum() == pytest.approx(v.region.area, rel=1e-9)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (([(0, 0), (np.nan, 1)],), "not finite"),
        (([(0, 0, 0)],), "shape"),
        (([(0, 0)], [(0, 0), (1, 1)]), "bounds"),
        (([(0, 0)], [(0, 0), (1, 1), (2, 2)]), "no area"),
        (([(0, 0)], [(0, 0), (2, 2), (2, 0), (0, 3)]), "cross"),
        (([(0, 0)], None, "magic"), "method"),
    ],
)
def test_what_makes_no_sense_is_refused(arguments: tuple, message: str) -> None:
    with pytest.raises(iso.GeometryError, match=message):
        voronoi(*arguments)
    with pytest.raises(iso.GeometryError, match="iterations"):
        iso.analysis.lloyd([(0, 0)], iterations=-1)
    with pytest.raises(iso.GeometryError, match="no sites"):
        voronoi([]).nearest([(0, 0)])
