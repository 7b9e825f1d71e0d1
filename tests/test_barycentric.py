"""Barycentric coordinates: round trips, unit sums, exact weights, values between corners; half-planes of polygons."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import isophote as iso
from isophote.analysis import (
    barycentric,
    from_barycentric,
    interpolate,
    point_in_convex_polygon,
    point_in_polygon,
    ray_triangle,
)
from isophote.errors import GeometryError

RNG = np.random.default_rng(9)


@pytest.mark.parametrize("dimension", [2, 3])
def test_points_to_weights_and_back(dimension: int) -> None:
    corners = RNG.normal(size=(500, 3, dimension))
    weights = RNG.normal(size=(500, 3))
    weights[:, 0] = 1 - weights[:, 1] - weights[:, 2]
    points = from_barycentric(corners, weights)
    found = barycentric(corners, points)
    thin = np.linalg.cond(np.diff(corners, axis=1))
    assert (np.abs(found - weights).max(axis=1) < 1e-13 * thin**2).all()
    assert np.abs(found.sum(axis=1) - 1).max() <= 2.0**-51 * np.abs(found).max()
    # Weights stand for the same point, however large they are.
    assert (np.abs(from_barycentric(corners, found) - points).max(axis=1) < 1e-13 * thin).all()


def test_weights_are_those_of_rational_arithmetic() -> None:
    for _ in range(200):
        v, p = RNG.normal(size=(3, 2)), RNG.normal(size=2)
        (ax, ay), (bx, by), (cx, cy) = [[Fraction(x) for x in row] for row in v.tolist()]
        x, y = map(Fraction, p.tolist())
        area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        second = ((x - ax) * (cy - ay) - (y - ay) * (cx - ax)) / area
        third = ((bx - ax) * (y - ay) - (by - ay) * (x - ax)) / area
        expected = [float(1 - second - third), float(second), float(third)]
        scale = 1 / abs(float(area))
        assert np.allclose(barycentric(v, [p])[0], expected, atol=1e-14 * scale, rtol=0)


def test_corners_and_edges_are_exact() -> None:
    corners = np.array([[1.0, 2, 3], [4, 6, 3], [0, 1, 9]])
    middles = (corners + np.roll(corners, -1, axis=0)) / 2
    assert barycentric(corners, corners).tolist() == np.eye(3).tolist()
    assert np.allclose(barycentric(corners, middles), [[0.5, 0.5, 0], [0, 0.5, 0.5], [0.5, 0, 0.5]], atol=1e-15)


def test_a_point_off_the_plane_has_the_weights_of_its_foot() -> None:
    corners = RNG.normal(size=(3, 3))
    normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
    foot = [0.2, 0.5, 0.3] @ corners
    assert barycentric(corners, [foot + 7 * normal])[0] == pytest.approx([0.2, 0.5, 0.3], abs=1e-12)


def test_where_a_ray_meets_a_triangle_no_weight_is_negative() -> None:
    corners = RNG.normal(size=(2000, 3, 3))
    o, d = RNG.normal(size=(2, 2000, 3))
    found = ray_triangle(o, d, corners)
    with np.errstate(invalid="ignore"):
        place = np.where(np.isnan(found.distances), 0, o + found.distances * d)
    weights = barycentric(corners, place)
    inside = (weights > 1e-9).all(axis=1)
    crossed = ~np.isnan(found.distances[:, 0])
    assert crossed.sum() > 100
    assert (weights[crossed] > -1e-9).all()
    assert not (inside & ~crossed & place.any(axis=1)).any()


def test_attributes_between_corners() -> None:
    """Texture coordinates with seams, normals, and positions of what a tracer hit."""
    uvs = iso.Attribute(np.array([[0, 0], [1, 0], [1, 1], [0, 1], [5, 5]], float), np.array([0, 1, 2, 4, 4, 4]))
    mesh = iso.Mesh(
        [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)],
        [(0, 1, 2), (0, 2, 3)],
        attributes={"uv": uvs, "heat": [[0.0], [1.0], [2.0], [3.0]]},
    )
    hits = iso.Tracer(mesh).closest([(0.75, 0.25, 1), (0.25, 0.75, 1)], [0, 0, -1])
    weights = np.column_stack([1 - hits.uv.sum(axis=1), hits.uv])
    assert np.allclose(interpolate(mesh, "position", hits.primitive, weights), hits.point)
    assert np.allclose(interpolate(mesh, "uv", hits.primitive, weights), [[0.75, 0.25], [5, 5]], atol=1e-6)
    assert np.allclose(interpolate(mesh, "heat", hits.primitive, weights), [[1.0], [2.0]], atol=1e-6)
    assert np.allclose(interpolate(mesh, [0, 1, 2, 3], hits.primitive, weights), [[1.0], [2.0]], atol=1e-6)


def regular(count: int, turn: float) -> np.ndarray:
    angle = turn + 2 * np.pi * np.arange(count) / count
    return np.stack([np.cos(angle), np.sin(angle)], axis=1)


@settings(deadline=None)
@given(count=st.integers(3, 12), turn=st.floats(0, 7), reverse=st.booleans(), seed=st.integers(0, 99))
def test_half_planes_give_the_answer_of_the_crossing_rule(count: int, turn: float, reverse: bool, seed: int) -> None:
    rng = np.random.default_rng(seed)
    # Affine images of regular polygons, with corners in the middle of edges and twice.
    ring = regular(count, turn) @ rng.normal(size=(2, 2)) + rng.normal(size=2)
    ring = np.insert(ring, 1, ring[0], axis=0)[:: -1 if reverse else 1]
    points = np.concatenate([rng.normal(size=(40, 2)), ring, (ring + np.roll(ring, 1, axis=0)) / 2])
    assert (point_in_convex_polygon(ring, points) == point_in_polygon(ring, points)).all()


def test_half_planes_on_a_grid_are_exact() -> None:
    """Points on edges, at corners, and on edges drawn out."""
    ring = [(0, 0), (2, 0), (4, 0), (5, 2), (2, 4), (0, 2)]
    x, y = np.meshgrid(np.arange(-1, 7), np.arange(-1, 7))
    points = np.stack([x.ravel(), y.ravel()], axis=1)
    expected = point_in_polygon(ring, points)
    assert {-1, 0, 1} == set(expected.tolist())
    assert (point_in_convex_polygon(ring, points) == expected).all()


STAR = regular(5, 0.0)[[0, 2, 4, 1, 3]]
BAD: list[tuple[Callable[[], Any], str]] = [
    (lambda: barycentric([(0, 0), (1, 1), (2, 2)], [(0, 1)]), "triangle 0 has no area"),
    (lambda: barycentric([(0, 0, 0), (0, 0, 0), (2, 2, 1)], [(0, 1, 0)]), "triangle 0 has no area"),
    (lambda: barycentric([(0, 0), (1, 0), (0, np.nan)], [(0, 1)]), "triangles must be finite"),
    (lambda: barycentric([(0, 0), (1, 0), (0, 1)], [(0, 1, 2)]), "triangles must have shape"),
    (lambda: barycentric([(0, 0), (1, 0), (0, 1)], [0, 1]), "points must have shape"),
    (lambda: from_barycentric([(0, 0), (1, 0), (0, 1)], [(1, 0)]), r"weights must have shape \(n, 3\)"),
    (lambda: interpolate(iso.Mesh(np.eye(3), [(0, 1, 2)]), "uv", [0], [(1, 0, 0)]), 'no attribute "uv"'),
    (lambda: interpolate(iso.Mesh(np.eye(3), [(0, 1, 2)]), "position", [1], [(1, 0, 0)]), "triangles must be 0 to 0"),
    (lambda: point_in_convex_polygon([(0, 0), (4, 0), (1, 1), (0, 4)], [(0, 0)]), "not convex at corner 2"),
    (lambda: point_in_convex_polygon(STAR, [(0, 0)]), "round more than once"),
    (lambda: point_in_convex_polygon([(0, 0), (1, 1), (2, 2)], [(0, 0)]), "no area"),
    (lambda: point_in_convex_polygon([(0, 0), (3, 0), (1, 0), (1, 1)], [(0, 0)]), "not convex"),
]


@pytest.mark.parametrize("case", range(len(BAD)))
def test_bad_input_is_told(case: int) -> None:
    call, message = BAD[case]
    with pytest.raises(GeometryError, match=message):
        call()
