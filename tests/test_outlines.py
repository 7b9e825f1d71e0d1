"""Outlines of quadratic arcs: distances, winding numbers, and what is boundary where they cross and overlap."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

import isophote as iso
from isophote.shapes.field.arcs import arc_points, nearest_on_arcs, nearest_parameters, winding_numbers
from isophote.shapes.field.crossings import split_monotone
from isophote.shapes.field.outline import line_arcs, outline_data

SQUARE = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]


def values(data: Any, points: Any) -> Any:
    return data.value(*np.asarray(points, np.float64).T)


def outline(*polygons: Any) -> Any:
    return outline_data([line_arcs(np.asarray(p, np.float64)) for p in polygons], "polygon")


def dense(arcs: Any, count: int = 4001) -> Any:
    """Many points of each arc, (n, count, 2)."""
    t = np.linspace(0, 1, count)
    rows = np.repeat(arcs, count, axis=0)
    return np.stack(arc_points(rows, np.tile(t, len(arcs))), axis=-1).reshape(len(arcs), count, 2)


def square_distance(p: Any) -> Any:
    q = np.abs(np.asarray(p) - 0.5) - 0.5
    return np.linalg.norm(np.maximum(q, 0), axis=1) + np.minimum(q.max(axis=1), 0)


# --- nearest points -------------------------------------------------------------------------------


def test_nearest_points_of_random_arcs_are_nearer_than_all_sampled_ones():
    rng = np.random.default_rng(0)
    arcs = rng.normal(size=(300, 6))
    points = rng.normal(size=(300, 2)) * 2
    t = nearest_parameters(arcs, *points.T)
    found = np.linalg.norm(np.stack(arc_points(arcs, t), axis=1) - points, axis=1)
    sampled = np.linalg.norm(dense(arcs) - points[:, None], axis=2).min(axis=1)
    assert ((t >= 0) & (t <= 1)).all()
    assert (found <= sampled * (1 + 1e-12)).all()
    assert (sampled - found).max() < 1e-5


@settings(max_examples=200, deadline=None)
@given(st.lists(st.integers(-8, 8), min_size=6, max_size=6), st.integers(-8, 8), st.integers(-8, 8))
def test_the_distance_stops_changing_at_the_nearest_point(arc, x, y):
    """At the parameter found, the cubic (B − p) · B′ has a root, or the end of the arc is nearest: in exact numbers."""
    row = np.array([arc], np.float64)
    t = float(nearest_parameters(row, np.array([float(x)]), np.array([float(y)]))[0])
    x0, y0, x1, y1, x2, y2 = map(Fraction, arc)

    def square(s: Fraction) -> Fraction:
        bx = (1 - s) ** 2 * x0 + 2 * s * (1 - s) * x1 + s**2 * x2
        by = (1 - s) ** 2 * y0 + 2 * s * (1 - s) * y1 + s**2 * y2
        return (bx - x) ** 2 + (by - y) ** 2

    at = square(Fraction(t))
    for other in (Fraction(0), Fraction(1), *(Fraction(k, 64) for k in range(1, 64))):
        assert at <= square(other) + Fraction(1, 10**12) * (1 + at)


def test_nearly_straight_arcs_and_double_roots():
    # The middle of a parabola's axis: three roots meet at the focus of curvature.
    arc = np.array([[-1.0, 1.0, 0.0, -1.0, 1.0, 1.0]])
    for height in (0.5, 0.5 - 1e-9, 0.5 + 1e-9, 3.0):
        t = nearest_parameters(arc, np.zeros(1), np.array([height]))
        px, py = arc_points(arc, t)
        sampled = np.hypot(dense(arc, 200001)[0, :, 0], dense(arc, 200001)[0, :, 1] - height).min()
        assert np.hypot(px, py - height)[0] <= sampled + 1e-12
    line = np.array([[0.0, 0.0, 0.5 + 1e-9, 0.5, 1.0, 1.0]])
    t = nearest_parameters(line, np.array([0.0]), np.array([1.0]))
    assert t[0] == pytest.approx(0.5, abs=1e-8)


def test_the_arc_found_is_the_nearest_of_all():
    rng = np.random.default_rng(1)
    arcs = rng.normal(size=(60, 6))
    pieces, _ = split_monotone(arcs)
    points = rng.normal(size=(500, 2)) * 3
    found = nearest_on_arcs(pieces, *points.T)
    sampled = cKDTree(dense(arcs).reshape(-1, 2)).query(points)[0]
    assert np.abs(found.distance - sampled).max() < 1e-3
    assert (found.distance <= sampled + 1e-12).all()
    ends = np.stack(arc_points(pieces[found.arc], found.parameter), axis=1)
    assert np.linalg.norm(ends - points, axis=1) == pytest.approx(found.distance, abs=1e-12)


def test_monotone_pieces_stay_on_the_arc():
    rng = np.random.default_rng(2)
    arcs = rng.normal(size=(200, 6))
    pieces, origin = split_monotone(arcs)
    assert len(pieces) > 300
    for axis in (0, 1):
        low, high = np.minimum(pieces[:, axis], pieces[:, axis + 4]), np.maximum(pieces[:, axis], pieces[:, axis + 4])
        assert ((pieces[:, axis + 2] >= low) & (pieces[:, axis + 2] <= high)).all()
    middles = np.stack(arc_points(pieces, np.full(len(pieces), 0.3)), axis=1)
    t = nearest_parameters(arcs[origin], *middles.T)
    assert np.linalg.norm(np.stack(arc_points(arcs[origin], t), axis=1) - middles, axis=1).max() < 1e-12


# --- winding numbers ------------------------------------------------------------------------------


def test_winding_numbers_are_sums_of_angles():
    rng = np.random.default_rng(3)
    loop = rng.normal(size=(40, 2))
    following = np.roll(loop, -1, axis=0)
    arcs = np.column_stack([loop, (loop + following) / 2 + rng.normal(size=loop.shape) * 0.5, following])
    pieces, _ = split_monotone(arcs)
    points = rng.normal(size=(400, 2)) * 1.5
    path = dense(arcs, 2001)[:, :-1].reshape(-1, 2)
    path = np.concatenate([path, path[:1]])
    angles = np.arctan2(path[:, 1, None] - points[:, 1], path[:, 0, None] - points[:, 0])
    turns = (np.diff(angles, axis=0) + np.pi) % (2 * np.pi) - np.pi
    expected = turns.sum(axis=0) / (2 * np.pi)
    clear = nearest_on_arcs(pieces, *points.T).distance > 1e-2
    assert np.abs(expected - np.rint(expected))[clear].max() < 1e-6
    assert (winding_numbers(pieces, *points.T)[clear] == np.rint(expected)[clear]).all()
    assert len(np.unique(np.rint(expected)[clear])) > 3


def test_each_end_of_an_arc_is_counted_once():
    arcs = line_arcs(np.array([(0.0, 0.0), (2.0, 1.0), (0.0, 2.0), (-2.0, 1.0)]))
    x = np.array([-3.0, -1.9, 0.0, 1.9, 3.0])
    for y in (1.0, 0.0, 2.0):
        expected = [0, 1, 1, 1, 0] if y == 1.0 else [0, 0, 1 if y == 0 else 0, 0, 0]
        clear = np.abs(x) + abs(y - 1) != 2 if y == 1.0 else np.abs(x) > 0.1
        assert (winding_numbers(arcs, x, np.full(5, y)) == expected)[clear].all()


# --- crossing and overlapping outlines ------------------------------------------------------------


def test_a_pentagram_is_the_star_of_ten_corners():
    angles = np.pi / 2 + np.arange(5) * 4 * np.pi / 5
    crossed = np.column_stack([np.cos(angles), np.sin(angles)])
    inner = np.cos(2 * np.pi / 5) / np.cos(np.pi / 5)
    star = iso.star(5, 1.0, float(inner))
    points = np.random.default_rng(4).uniform(-1.3, 1.3, (4000, 2))
    data = outline(crossed)
    assert (data.sides == 0).sum() == 5
    from isophote.shapes.field.tape import numpy_values

    assert np.abs(values(data, points) - numpy_values(star.form, points)).max() < 3e-7


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize(
    "offset", [(1.0, 0.0), (0.5, 0.25), (0.5, 0.0), (0.0, 0.0), (1.0, 0.5), (1.0, 1.0), (3.0, 0.0)]
)
def test_two_squares(offset, turned):
    """By the nonzero rule, of two squares turning the same way the union, of opposite ones the difference both ways."""
    second = np.array(SQUARE) + offset
    if turned and offset == (0.0, 0.0):
        with pytest.raises(iso.GeometryError, match="encloses nothing"):
            outline(SQUARE, second[::-1])
        return
    data = outline(SQUARE, second[::-1] if turned else second)
    points = np.random.default_rng(5).uniform(-1, 3, (3000, 2))
    in_first = ((points > 0) & (points < 1)).all(axis=1)
    in_second = ((points > offset) & (points < np.array(offset) + 1)).all(axis=1)
    inside = (in_first ^ in_second) if turned else (in_first | in_second)
    # Points of both outlines with something outside near them and something inside.
    edge = np.concatenate([dense(line_arcs(np.array(SQUARE)), 2001), dense(line_arcs(second), 2001)]).reshape(-1, 2)
    near = edge[:, None] + 1e-4 * np.array([(1, 1), (1, -1), (-1, 1), (-1, -1)])
    a = ((near > 0) & (near < 1)).all(axis=2)
    b = ((near > offset) & (near < np.array(offset) + 1)).all(axis=2)
    held = (a ^ b) if turned else (a | b)
    boundary = edge[held.any(axis=1) & ~held.all(axis=1)]
    expected = np.where(inside, -1, 1) * cKDTree(boundary).query(points)[0]
    assert np.abs(values(data, points) - expected).max() < 2e-3
    clear = np.abs(expected) > 2e-3
    assert (np.sign(values(data, points)) == np.sign(expected))[clear].all()


def test_overlapping_discs_of_arcs():
    """Two discs of eight arcs each: all arcs inside the other disc are cut away from the boundary."""

    def disc(x: float) -> Any:
        angle = np.arange(8) * np.pi / 4
        reach = 1 / np.cos(np.pi / 8)
        ends = np.column_stack([x + np.cos(angle), np.sin(angle)])
        controls = np.column_stack([x + reach * np.cos(angle + np.pi / 8), reach * np.sin(angle + np.pi / 8)])
        return np.column_stack([ends, controls, np.roll(ends, -1, axis=0)])

    data = outline_data([disc(0.0), disc(1.0)], "discs")
    points = np.random.default_rng(6).uniform(-2, 3, (4000, 2))
    both = np.stack([outline_data([disc(x)], "disc").value(*points.T) for x in (0.0, 1.0)])
    v = values(data, points)
    assert (np.sign(v) == np.sign(both.min(axis=0))).all()
    # Outside, the union's distance is the lesser one; inside, that to what is left of both circles.
    assert v[v > 0] == pytest.approx(both.min(axis=0)[v > 0], abs=1e-6)
    path = np.concatenate([dense(disc(0.0), 4001), dense(disc(1.0), 4001)]).reshape(-1, 2)
    other = np.concatenate([np.hypot(path[:32008, 0] - 1, path[:32008, 1]), np.hypot(*path[32008:].T)])
    left = cKDTree(path[other > 1.0 - 5e-3]).query(points)[0]
    # Eight parabolas are off a circle by half a hundredth.
    assert np.abs(np.abs(v) - left)[v < 0].max() < 2e-2


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10_000), st.integers(3, 25))
def test_the_sign_is_that_of_the_winding_number_and_the_slope_one(seed, corners):
    rng = np.random.default_rng(seed)
    polygon = rng.integers(-4, 5, (corners, 2)).astype(float)
    try:
        data = outline(polygon)
    except iso.GeometryError:
        return
    points = rng.uniform(-5, 5, (300, 2))
    v = values(data, points)
    assert ((winding_numbers(line_arcs(polygon), *points.T) != 0) == (v < 0)).all()
    near = points + rng.normal(size=points.shape) * 0.1
    assert (np.abs(values(data, near) - v) <= np.linalg.norm(near - points, axis=1) * (1 + 1e-9) + 1e-6).all()
    # Along the gradient the boundary is reached within the distance.
    gx, gy = data.partials(*points.T)
    landed = values(data, points - v[:, None] * np.stack([gx, gy], axis=1))
    assert np.abs(landed).max() < 1e-5


def test_gradients_hold_on_the_boundary():
    data = outline(SQUARE, np.array([(0.25, 0.25), (0.25, 0.75), (0.75, 0.75), (0.75, 0.25)]))
    gx, gy = data.partials(np.array([0.5, 1.0, 0.25, 0.5]), np.array([0.0, 0.5, 0.5, 0.75]))
    assert gx == pytest.approx([0, 1, 1, 0])
    assert gy == pytest.approx([-1, 0, 0, -1])


def test_intervals_hold_the_values():
    rng = np.random.default_rng(7)
    data = outline(rng.normal(size=(12, 2)))
    low = rng.uniform(-3, 3, (200, 2))
    high = low + rng.uniform(0, 1, (200, 2))
    least, most = data.interval((low[:, 0], high[:, 0]), (low[:, 1], high[:, 1]))
    for _ in range(20):
        v = values(data, rng.uniform(low, high))
        assert ((least <= v) & (v <= most)).all()
    assert data.interval((-np.inf, np.inf), (0.0, 1.0)) == (-np.inf, np.inf)


@pytest.mark.parametrize(
    ("polygon", "message"),
    [
        ([(0, 0), (1, 0)], "n ≥ 3"),
        ([(0, 0), (1, 0), (2, 0)], "encloses nothing"),
        ([(1, 1), (1, 1), (1, 1)], "encloses nothing"),
        ([(0, 0), (1, 0), (float("nan"), 1)], "point 2 of outline 0 is not finite"),
        ([(0, 0), (1, 0), (1e30, 1)], "beyond 1e18"),
        ([(0, 0, 0), (1, 0, 0), (0, 1, 0)], r"must be points \(n, 2\)"),
        ([], "polygon: it takes points"),
        ("square", "polygon: it takes points"),
        (None, "polygon: it takes points"),
    ],
)
def test_outlines_that_are_none_are_refused(polygon, message):
    with pytest.raises(iso.GeometryError, match=message):
        iso.polygon(polygon)


def test_a_simple_square_far_from_the_origin():
    data = outline(np.array(SQUARE) + 1000.0)
    points = np.random.default_rng(8).uniform(-0.5, 1.5, (1000, 2))
    assert np.abs(values(data, points + 1000.0) - square_distance(points)).max() < 1e-9
