"""Form factors of whole polygons against closed forms, closure, reciprocity and quadrature."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

import isophote as iso
from isophote.checks.form_factors import parallel_rectangles, perpendicular_rectangles
from isophote.errors import GeometryError

FLOOR = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], float)
CEILING = np.add(FLOOR[::-1], (0, 0, 1))
WALL = np.array([(0, 0, 0), (0, 1, 0), (0, 1, 1), (0, 0, 1)], float)


def area(polygon: np.ndarray) -> float:
    fan = polygon[1:] - polygon[0]
    return float(np.linalg.norm(np.cross(fan[:-1], fan[1:]).sum(axis=0)) / 2)


def test_unit_squares_have_their_closed_forms() -> None:
    assert iso.form_factor(FLOOR, CEILING) == pytest.approx(0.199824896, abs=1e-9)
    assert iso.form_factor(FLOOR, WALL) == pytest.approx(0.200043776, abs=1e-9)


@pytest.mark.parametrize(("x", "y"), [(0.1, 0.2), (0.3, 5), (40, 40), (0.05, 3)])
def test_parallel_rectangles(x: float, y: float) -> None:
    scale = np.array([x, y, 1.0])
    assert iso.form_factor(FLOOR * scale, CEILING * scale) == pytest.approx(parallel_rectangles(x, y), rel=1e-8)


@pytest.mark.parametrize(("h", "w"), [(0.01, 1), (1, 0.01), (20, 1), (3, 2)])
def test_perpendicular_rectangles_that_touch(h: float, w: float) -> None:
    floor, wall = FLOOR * (w, 1, 1), WALL * (1, 1, h)
    assert iso.form_factor(floor, wall) == pytest.approx(perpendicular_rectangles(h, w), rel=1e-8)


def test_a_cube_is_closed() -> None:
    assert iso.form_factor(FLOOR, CEILING) + 4 * iso.form_factor(FLOOR, WALL) == pytest.approx(1, abs=1e-9)


def test_walls_that_touch_in_parts_of_edges_close_a_room() -> None:
    # The floor against walls cut into pieces whose corners lie within the floor's edges.
    total = iso.form_factor(FLOOR, CEILING)
    for low, high in [(0, 0.3), (0.3, 0.301), (0.301, 1)]:
        total += 4 * iso.form_factor(FLOOR, WALL * (1, high - low, 1) + (0, low, 0))
    assert total == pytest.approx(1, abs=1e-9)


@given(st.integers(0, 10**6))
@settings(max_examples=25, deadline=None)
def test_hulls_of_any_points_are_closed_and_reciprocal(seed: int) -> None:
    rng = np.random.default_rng(seed)
    hull = ConvexHull(rng.normal(size=(8, 3)))
    middle = hull.points.mean(axis=0)
    faces = []
    for corners in hull.points[hull.simplices]:
        outward = np.cross(corners[1] - corners[0], corners[2] - corners[0]) @ (corners[0] - middle) > 0
        faces.append(corners[::-1] if outward else corners)
    first = faces[0]
    factors = [iso.form_factor(first, other) for other in faces[1:]]
    assert sum(factors) == pytest.approx(1, abs=1e-7)
    for other, factor in zip(faces[1:], factors, strict=True):
        assert area(first) * factor == pytest.approx(
            area(other) * iso.form_factor(other, first), abs=1e-9 * area(first)
        )


def test_what_is_behind_a_plane_takes_no_part() -> None:
    assert iso.form_factor(FLOOR, np.add(FLOOR, (0, 0, 1))) == 0
    assert iso.form_factor(FLOOR, CEILING - (0, 0, 2)) == 0
    assert iso.form_factor(FLOOR, np.add(FLOOR[::-1], (3, 0, 0))) == 0
    # A wall through the floor counts with its upper half; to a wall within the floor only the part before it counts.
    deep = WALL * (1, 1, 2) - (0, 0, 1)
    assert iso.form_factor(FLOOR, deep) == pytest.approx(iso.form_factor(FLOOR, WALL), abs=1e-12)
    within = iso.form_factor(FLOOR, np.add(WALL, (0.5, 0, 0)))
    assert within == pytest.approx(0.5 * perpendicular_rectangles(1, 0.5), abs=1e-9)


@pytest.mark.parametrize("distance", [30.0, 3e2, 3e3, 1e6])
def test_far_polygons_are_points(distance: float) -> None:
    exact = 1 / (np.pi * distance**2)
    found = iso.form_factor(FLOOR, np.add(FLOOR[::-1], (0, 0, distance)))
    assert found == pytest.approx(exact, rel=max(1 / distance**2, 1e-8))


@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_units_and_places_do_not_matter(scale: float) -> None:
    move = np.array([3.0, -2.0, 5.0]) * scale
    assert iso.form_factor(FLOOR * scale + move, WALL * scale + move) == pytest.approx(0.200043776, abs=1e-9)


def test_other_polygons_are_refused() -> None:
    arrow = [(0, 0, 0), (2, 0, 0), (0.4, 0.4, 0), (0, 2, 0)]
    bent = [(0, 0, 0), (1, 0, 0), (1, 1, 0.5), (0, 1, 0)]
    star = [(np.cos(a), np.sin(a), 0.0) for a in np.arange(5) * 4 * np.pi / 5]
    for polygon, words in ((arrow, "convex"), (star, "convex"), (bent, "flat"), ([(0, 0, 0)] * 3, "no area")):
        with pytest.raises(GeometryError, match=words):
            iso.form_factor(FLOOR, polygon)
    with pytest.raises(GeometryError, match="finite"):
        iso.form_factor([(0, 0, np.nan), (1, 0, 0), (0, 1, 0)], FLOOR)
    with pytest.raises(GeometryError, match="corners"):
        iso.form_factor([(0, 0), (1, 0), (0, 1)], FLOOR)
