"""Medial axes of polygons: closed forms, nearest points of the boundary, Euler's number, what the balls fill."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import isophote as iso
from isophote.analysis import MedialAxis

POLYGONS = Path(__file__).parents[1] / "../shared/models/polygons/earcut"
medial_axis = iso.analysis.medial_axis


def boundary_distances(axis: MedialAxis, points: np.ndarray) -> np.ndarray:
    """(points, edges) distances to all edges with their ends."""
    a = np.concatenate(axis.rings)
    d = np.concatenate([np.roll(ring, -1, axis=0) - ring for ring in axis.rings])
    t = np.clip(((points[:, None] - a) * d).sum(axis=2) / (d * d).sum(axis=1), 0, 1)
    return np.linalg.norm(points[:, None] - a - t[..., None] * d, axis=2)


def size(axis: MedialAxis) -> float:
    return float(np.linalg.norm(np.ptp(axis.rings[0], axis=0)))


def is_exact(axis: MedialAxis, tolerance: float = 1e-9) -> None:
    """Balls lie within the polygon and touch it twice; all of the boundary is touched; Euler's number is right."""
    assert axis.euler == 1 - (len(axis.rings) - 1)
    rng = np.random.default_rng(0)
    arcs = np.arange(len(axis.arcs))
    if len(arcs) > 300:
        arcs = rng.choice(arcs, 300, replace=False)
    eps = tolerance * size(axis)
    for t in (0.0, 0.3, 0.7, 1.0):
        balls = axis.at(arcs, t)
        nearest = boundary_distances(axis, balls.centre).min(axis=1)
        np.testing.assert_allclose(balls.radius, nearest, atol=eps)
        for side in range(2):
            touching = np.linalg.norm(balls.feet[:, side] - balls.centre, axis=1)
            np.testing.assert_allclose(touching, nearest, atol=eps)
            np.testing.assert_allclose(boundary_distances(axis, balls.feet[:, side]).min(axis=1), 0, atol=eps)
    np.testing.assert_allclose(axis.at(np.arange(len(axis.arcs)), 0.0).radius, axis.radius[axis.arcs[:, 0]], atol=eps)
    # Feet run over the whole boundary: along each edge, over its length once.
    corners = np.concatenate(axis.rings)
    lengths = np.concatenate([np.linalg.norm(np.roll(r, -1, axis=0) - r, axis=1) for r in axis.rings])
    covered = np.zeros(len(corners))
    every = np.arange(len(axis.arcs))
    first, last = axis.at(every, 0.0).feet, axis.at(every, 1.0).feet
    for side in range(2):
        of_edge = axis.sites[:, side] < len(corners)
        way = np.linalg.norm(first[:, side] - last[:, side], axis=1)
        np.add.at(covered, axis.sites[of_edge, side], way[of_edge])
    np.testing.assert_allclose(covered, lengths, atol=20 * eps)


def test_a_rectangle() -> None:
    axis = medial_axis([(0, 0), (3, 0), (3, 1), (0, 1)])
    is_exact(axis, 1e-14)
    found = {(*v, r) for v, r in zip(axis.vertices.round(12).tolist(), axis.radius.round(12), strict=True)}
    assert found == {(0, 0, 0), (3, 0, 0), (3, 1, 0), (0, 1, 0), (0.5, 0.5, 0.5), (2.5, 0.5, 0.5)}
    assert not axis.parabolic.any()
    assert len(axis.arcs) == 5


def test_a_square_meets_in_one_point() -> None:
    axis = medial_axis([(0, 0), (0, 2), (2, 2), (2, 0)])
    assert (len(axis.vertices), len(axis.arcs)) == (5, 4)
    np.testing.assert_allclose(axis.vertices[np.argmax(axis.radius)], (1, 1), atol=1e-15)


def test_an_l_has_parabolas_around_its_inner_corner() -> None:
    axis = medial_axis([(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)])
    is_exact(axis, 1e-14)
    assert axis.parabolic.sum() == 2
    # Equally far from both outer sides and the corner (1, 1): r with (1 - r) √2 = r.
    r = np.sqrt(2) / (1 + np.sqrt(2))
    assert np.abs(axis.vertices - r).max(axis=1).min() < 1e-15
    # Along a parabola, the point above the foot (x, 0) is as far from it as from (1, 1).
    arc = int(np.flatnonzero(axis.parabolic)[0])
    x, y = axis.at(arc, np.linspace(0, 1, 11)).centre.T
    low = np.minimum(x, y)
    np.testing.assert_allclose(np.hypot(x - 1, y - 1), low, atol=1e-14)


def test_a_frame_has_a_loop() -> None:
    axis = medial_axis([[(0, 0), (4, 0), (4, 4), (0, 4)], [(1, 1), (3, 1), (3, 3), (1, 3)]])
    is_exact(axis, 1e-13)
    assert axis.euler == 0


def test_a_fine_ellipse_has_the_axis_of_an_ellipse() -> None:
    """The axis of an ellipse with half-axes a > b ends at its centres of curvature, ± (a² - b²) / a."""
    a, b, n = 2.0, 1.0, 2000
    angle = (np.arange(n) + 0.5) * 2 * np.pi / n
    axis = medial_axis(np.stack([a * np.cos(angle), b * np.sin(angle)], axis=1))
    is_exact(axis, 1e-10)
    trunk = axis.pruned(feature=0.05)
    x, y = trunk.vertices.T
    assert np.abs(y).max() < 1e-6
    assert np.abs(x).max() == pytest.approx((a * a - b * b) / a, abs=2e-3)
    # The ball around (x, 0) has the radius b √(1 - x² / (a² - b²)).
    np.testing.assert_allclose(trunk.radius, b * np.sqrt(1 - x**2 / (a * a - b * b)), atol=2e-5)


def wavy(n: int, seed: int = 1) -> np.ndarray:
    rng = np.random.default_rng(seed)
    a = np.arange(n) * 2 * np.pi / n
    r = 1 + 0.3 * np.sin(5 * a) + 0.2 * np.sin(17 * a) + 2 / n * rng.normal(size=n)
    return np.stack([r * np.cos(a), r * np.sin(a)], axis=1)


@pytest.mark.parametrize("n", [10, 100, 1000])
def test_wavy_polygons(n: int) -> None:
    is_exact(medial_axis(wavy(n)), 1e-10)


def test_ten_thousand_edges() -> None:
    is_exact(medial_axis(wavy(10_000)))


def test_many_holes() -> None:
    """Small islands in a wide square: branches must not pass over them."""
    rng = np.random.default_rng(4)
    rings = [np.array([(0, 0), (10, 0), (10, 10), (0, 10)], float)]
    for i in range(9):
        for j in range(9):
            angle = np.sort(rng.random(5)) * 2 * np.pi
            if np.diff(angle, append=angle[0] + 2 * np.pi).max() > np.pi:
                angle = np.arange(5) * 2 * np.pi / 5
            radius = 10.0 ** rng.uniform(-3, -0.6)
            middle = np.array([i + 1, j + 1]) + rng.uniform(-0.2, 0.2, 2)
            rings.append(middle + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1))
    is_exact(medial_axis(rings))


@settings(max_examples=150, deadline=None)
@given(st.lists(st.tuples(st.integers(1, 6), st.integers(1, 6)), min_size=1, max_size=8))
def test_stairs_and_combs_on_a_grid(steps: list[tuple[int, int]]) -> None:
    """Right angles and many equal distances: columns of whole widths and heights side by side."""
    top = []
    x = 0
    for width, height in steps:
        top += [(x, height), (x + width, height)]
        x += width
    is_exact(medial_axis([(0, 0), (x, 0), *top[::-1]]), 1e-11)


@settings(max_examples=150, deadline=None)
@given(st.lists(st.integers(1, 9), min_size=3, max_size=24), st.integers(0, 3))
def test_stars_around_a_point(radii: list[int], turn: int) -> None:
    angle = np.arange(len(radii)) * 2 * np.pi / len(radii) + turn * np.pi / 7
    is_exact(medial_axis(np.array(radii)[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)))


@pytest.mark.parametrize("turn", [0.0, 0.3])
def test_regular_polygons_meet_in_their_middle(turn: float) -> None:
    for n in (3, 4, 5, 6, 12, 40):
        angle = np.arange(n) * 2 * np.pi / n + turn
        axis = medial_axis(np.stack([np.cos(angle), np.sin(angle)], axis=1))
        assert axis.euler == 1
        np.testing.assert_allclose(axis.radius.max(), np.cos(np.pi / n), atol=1e-12)
        assert len(axis.vertices) == n + 1


@pytest.mark.parametrize("name", ["dude", "hilbert", "issue17", "issue29", "issue35", "issue52"])
def test_collected_polygons(name: str) -> None:
    path = POLYGONS / f"{name}.json"
    if not path.exists():
        pytest.skip("collected polygons are not there")
    is_exact(medial_axis(json.loads(path.read_text())))


def test_pruning_keeps_what_hangs_together() -> None:
    rings = [np.array([(0, 0), (8, 0), (8, 5), (0, 5)]), np.array([(3, 2), (5, 2), (5, 3), (3, 3)])]
    axis = medial_axis(rings)
    for pruned in (axis.pruned(feature=0.7), axis.pruned(scale=1.5), axis.pruned(0.3, 1.2)):
        assert pruned.euler == 0
        assert len(pruned.arcs) < len(axis.arcs) or pruned.radius.min() > axis.radius.min()
    # At a right angle the feet of a ball of radius r are √2 r apart: branches end where that is 2 · 0.7.
    tips = axis.pruned(feature=0.7).radius.min()
    assert tips == pytest.approx(0.7 * np.sqrt(2))
    # Along the bisector of a right angle balls grow by 1 / √2 of the way: enlarged by more than √2 one holds another.
    assert axis.pruned(scale=1.4).radius.min() == 0
    assert axis.pruned(scale=1.42).radius.min() > 0
    assert len(medial_axis([(0, 0), (1, 0), (0, 1)]).pruned(feature=100).vertices) >= 1


def test_samples_lie_along_the_axis() -> None:
    axis = medial_axis(wavy(60))
    balls = axis.sampled(0.01)
    np.testing.assert_allclose(balls.radius, boundary_distances(axis, balls.centre).min(axis=1), atol=1e-12)


def test_balls_fill_the_polygon() -> None:
    axis = medial_axis(wavy(40))
    balls = axis.sampled(1e-3)
    rng = np.random.default_rng(2)
    points = rng.uniform(-1.5, 1.5, (300, 2))
    ring = axis.rings[0]
    after = np.roll(ring, -1, axis=0)
    crossed = ((ring[:, 1] > points[:, 1:]) != (after[:, 1] > points[:, 1:])) & (
        points[:, :1] < ring[:, 0] + (points[:, 1:] - ring[:, 1]) / (after[:, 1] - ring[:, 1]) * (after - ring)[:, 0]
    )
    inside = crossed.sum(axis=1) % 2 == 1
    deepest = (balls.radius - np.linalg.norm(points[:, None] - balls.centre, axis=2)).max(axis=1)
    assert (deepest[~inside] < 0).all()
    depth = boundary_distances(axis, points).min(axis=1)
    assert (deepest[inside & (depth > 1e-3)] > 0).all()


@pytest.mark.parametrize(
    ("polygon", "message"),
    [
        ([(0, 0), (1, 1), (1, 0), (0, 1)], "crosses or touches"),
        ([(0, 0), (1, 0)], "three corners"),
        ([(0, 0), (1, 0), (np.inf, 1)], "not finite"),
        ([(0, 0), (1, 0), (2, 0)], "runs back|no area"),
        ([[(0, 0), (4, 0), (4, 4), (0, 4)], [(9, 9), (10, 9), (9, 10)]], "does not lie within"),
        ([[(0, 0), (4, 0), (4, 4), (0, 4)], [(0, 1), (1, 1), (1, 2)]], "crosses or touches"),
        ("polygon", "numbers"),
        ([], "numbers"),
    ],
)
def test_what_is_no_polygon_is_refused(polygon: object, message: str) -> None:
    with pytest.raises(iso.GeometryError, match=message):
        medial_axis(polygon)
