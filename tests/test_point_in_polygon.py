"""Points against polygons: winding numbers in fractions, shapes of known area, real outlines."""

from __future__ import annotations

import json
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from isophote import analysis
from isophote.errors import GeometryError

MODELS = Path(__file__).parents[1] / "../shared/models/polygons"

SQUARE = [(0, 0), (4, 0), (4, 4), (0, 4)]
HOLE = [(1, 1), (1, 3), (3, 3), (3, 1)]


def winding(rings: list, point: tuple[float, float]) -> int | None:
    """The winding number by the angles' quadrants, in fractions; None on the boundary."""
    x, y = map(Fraction, point)
    total = 0
    for ring in rings:
        moved = [(Fraction(a) - x, Fraction(b) - y) for a, b in ring]
        for (ax, ay), (bx, by) in zip(moved, moved[1:] + moved[:1], strict=True):
            turn = ax * by - ay * bx
            if turn == 0 and ax * bx <= 0 and ay * by <= 0:
                return None
            # Quarter turns between quadrants; half turns by the side on which the point is passed.
            quarters = (quadrant(bx, by) - quadrant(ax, ay)) % 4
            total += {0: 0, 1: 1, 2: 2 if turn > 0 else -2, 3: -1}[quarters]
    assert total % 4 == 0
    return total // 4


def quadrant(x: Fraction, y: Fraction) -> int:
    if x > 0 and y >= 0:
        return 0
    if x <= 0 and y > 0:
        return 1
    return 2 if x < 0 and y <= 0 else 3


def expected(rings: list, points: np.ndarray, rule: str) -> list[int]:
    inside = {
        "nonzero": lambda w: w != 0,
        "evenodd": lambda w: w % 2 == 1,
        "positive": lambda w: w > 0,
        "negative": lambda w: w < 0,
    }[rule]
    found = [winding(rings, p) for p in points.tolist()]
    return [0 if w is None else (1 if inside(w) else -1) for w in found]


RULES = st.sampled_from(["nonzero", "evenodd", "positive", "negative"])


@settings(max_examples=150, deadline=None)
@given(st.integers(0, 2**32 - 1), RULES, st.integers(1, 5))
def test_grids_are_exact(seed: int, rule: str, size: int) -> None:
    rng = np.random.default_rng(seed)
    rings = [rng.integers(0, size + 1, (rng.integers(1, 9), 2)).tolist() for _ in range(rng.integers(1, 4))]
    points = rng.integers(-1, 2 * size + 3, (30, 2)) / 2
    assert analysis.point_in_polygon(rings, points, rule).tolist() == expected(rings, points, rule)


@settings(max_examples=100, deadline=None)
@given(st.data(), RULES)
def test_any_doubles_are_exact(data: st.DataObject, rule: str) -> None:
    """Points in general and on the edges, as nearly as doubles allow."""
    value = st.one_of(st.floats(-1, 1), st.sampled_from([0.0, 1e-300, 1e300, -1e308, 0.1, 1 / 3, 1.0]))
    rings = data.draw(st.lists(st.lists(st.tuples(value, value), min_size=1, max_size=6), min_size=1, max_size=3))
    corners = np.array([p for ring in rings for p in ring])
    with np.errstate(over="ignore"):
        middles = corners / 2 + np.roll(corners, -1, axis=0) / 2
        thirds = corners + (np.roll(corners, -1, axis=0) - corners) / 3
    points = np.concatenate([corners, middles, thirds[np.isfinite(thirds).all(axis=1)]])
    assert analysis.point_in_polygon(rings, points, rule).tolist() == expected(rings, points, rule)


def test_rings_and_rules() -> None:
    points = [(0.5, 0.5), (2, 2), (1, 2), (4, 4), (5, 2)]
    for polygons in (
        [SQUARE, HOLE],
        [[SQUARE, HOLE]],
        np.array([SQUARE, HOLE]),
        [[*SQUARE, SQUARE[0]], np.array(HOLE)],
    ):
        assert analysis.point_in_polygon(polygons, points).tolist() == [1, -1, 0, 0, -1]
    same_way = [SQUARE, HOLE[::-1]]
    assert analysis.point_in_polygon(same_way, points).tolist() == [1, 1, 0, 0, -1]
    assert analysis.point_in_polygon(same_way, points, "evenodd").tolist() == [1, -1, 0, 0, -1]
    assert analysis.point_in_polygon(SQUARE[::-1], points, "positive").tolist() == [-1, -1, -1, 0, -1]
    assert analysis.point_in_polygon(SQUARE[::-1], points, "negative").tolist() == [1, 1, 1, 0, -1]
    assert analysis.point_in_polygon([], points).tolist() == [-1] * 5
    assert analysis.point_in_polygon(SQUARE, (2, 2)).tolist() == [1]
    assert analysis.point_in_polygon(SQUARE, np.empty((0, 2))).shape == (0,)


def test_a_point_on_an_edge_that_doubles_cannot_hold_is_beside_it() -> None:
    """0.1 × 3 is not 0.3: the edge from (0, 0) to (1, 3) passes by (0.1, 0.3), on the side that fractions say."""
    triangle = [(0, 0), (1, 3), (-1, 3)]
    side = 3 * Fraction(0.1) - Fraction(0.3)
    assert analysis.point_in_polygon(triangle, [(0.1, 0.3)]).tolist() == [-1 if side > 0 else 1]
    assert analysis.point_in_polygon(triangle, [(0.125, 0.375)]).tolist() == [0]


def area(ring: list) -> float:
    x, y = np.array(ring, float).T
    return abs(float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum())) / 2


@pytest.mark.parametrize("name", ["dude", "water3", "water4", "issue17", "eberly-3", "simplified-us-border"])
def test_the_share_of_points_inside_is_the_area(name: str) -> None:
    path = MODELS / "earcut" / f"{name}.json"
    if not path.exists():
        pytest.skip(f"{name} is not there")
    rings = json.loads(path.read_text())
    corners = np.array([p for ring in rings for p in ring], float)
    low, high = corners.min(axis=0), corners.max(axis=0)
    points = np.random.default_rng(0).uniform(low, high, (200_000, 2))
    share = (analysis.point_in_polygon(rings, points, "evenodd") == 1).mean()
    true = (area(rings[0]) - sum(area(ring) for ring in rings[1:])) / float((high - low).prod())
    assert share == pytest.approx(true, abs=4 * np.sqrt(0.25 / len(points)))
    assert not analysis.point_in_polygon(rings, corners).any()
    assert analysis.point_in_polygon(rings, points[:300], "evenodd").tolist() == expected(
        rings, points[:300], "evenodd"
    )


@pytest.mark.parametrize(
    ("polygons", "points", "rule", "message"),
    [
        (SQUARE, [(0, np.nan)], "nonzero", "points: number 0 is not finite"),
        ([(0, 0), (1, np.inf), (2, 2)], [(0, 0)], "nonzero", "ring 0: number 1 is not finite"),
        (SQUARE, [(0, 0, 0)], "nonzero", "shape"),
        ([[(0, 0, 0), (1, 0, 0), (1, 1, 0)]], [(0, 0)], "nonzero", "rings"),
        (SQUARE, [(0, 0)], "winding", "rule must be"),
    ],
)
def test_bad_input_is_refused(polygons: list, points: list, rule: str, message: str) -> None:
    with pytest.raises(GeometryError, match=message):
        analysis.point_in_polygon(polygons, points, rule)
