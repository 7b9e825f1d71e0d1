"""Boxes and spheres around shapes: nothing outside, no slack, and the least sphere against all small supports."""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import isophote as iso
from isophote.analysis import bounding_box, bounding_sphere
from isophote.errors import GeometryError
from scenes import icosphere

RNG = np.random.default_rng(4)


def brute_force(points: np.ndarray) -> float:
    """Radius of the least sphere that has 2 to 4 of the points on it and none outside."""
    best = np.inf
    for count in range(2, points.shape[1] + 2):
        for chosen in combinations(points, count):
            p = np.array(chosen)
            edges = p[1:] - p[0]
            share = np.linalg.lstsq(2 * edges @ edges.T, (edges * edges).sum(axis=1), rcond=None)[0]
            centre = p[0] + share @ edges
            radius = np.linalg.norm(p - centre, axis=1).max()
            if (np.linalg.norm(points - centre, axis=1) <= radius * (1 + 1e-10)).all():
                best = min(best, radius)
    return best


@settings(deadline=None)
@given(
    count=st.integers(2, 9),
    dimension=st.sampled_from([2, 3]),
    seed=st.integers(0, 1000),
    grid=st.booleans(),
    scale=st.sampled_from([1e-150, 1.0, 1e150]),
)
def test_the_least_sphere_is_that_of_all_supports(
    count: int, dimension: int, seed: int, grid: bool, scale: float
) -> None:
    """On a grid many points lie on one sphere, on one line, or twice."""
    rng = np.random.default_rng(seed)
    points = rng.integers(-2, 3, (count, dimension)).astype(float) if grid else rng.normal(size=(count, dimension))
    ball = bounding_sphere(points * scale)
    expected = brute_force(points) if np.ptp(points, axis=0).any() else 0.0
    assert ball.radius == pytest.approx(expected * scale, rel=1e-9, abs=1e-12 * scale)
    assert (np.linalg.norm((points * scale - ball.centre) / scale, axis=1) <= ball.radius / scale * (1 + 1e-15)).all()
    ritter = bounding_sphere(points * scale, method="ritter")
    assert ritter.radius >= ball.radius * (1 - 1e-12)
    assert (
        np.linalg.norm((points * scale - ritter.centre) / scale, axis=1) <= ritter.radius / scale * (1 + 1e-15)
    ).all()


def test_the_support_holds_the_sphere() -> None:
    points = RNG.normal(size=(5000, 3))
    ball = bounding_sphere(points)
    held = points[ball.support]
    assert 2 <= len(held) <= 4
    assert np.allclose(np.linalg.norm(held - ball.centre, axis=1), ball.radius, rtol=1e-12)
    # The centre lies within the support's hull, or a smaller sphere would do.
    weights = np.linalg.lstsq(np.vstack([held.T, np.ones(len(held))]), np.append(ball.centre, 1), rcond=None)[0]
    assert (weights >= -1e-9).all()
    assert bounding_sphere(points, method="ritter").radius < 1.15 * ball.radius


def test_points_that_all_lie_on_one_sphere() -> None:
    mesh = icosphere(5, 2.0)
    moved = mesh.with_(vertices=mesh.vertices + np.array([1e3, 0, 0]))
    ball = bounding_sphere(moved)
    assert ball.radius == pytest.approx(2.0, rel=1e-9)
    assert np.allclose(ball.centre, (1e3, 0, 0), atol=1e-8)


SHAPES = {
    "sphere": iso.sphere(0.8),
    "ellipsoid": iso.ellipsoid((0.3, 0.9, 0.5)),
    "box": iso.box((0.4, 1.0, 0.7)),
    "cylinder": iso.cylinder(0.4, 1.2),
    "cone": iso.cone(0.5, 1.3),
    "part of a cone": iso.cone(0.3, 0.7, 0.8),
    "torus": iso.torus(0.6, 0.2),
    "disk": iso.Disk(0.7),
    "ball of a quadric": iso.Quadric((1, 2, 3, 0.5, -0.3, 0.7, 0.1, -0.2, 0.3, -0.5), [[-9] * 3, [9] * 3]),
    "polygon": iso.Polygon([(0, 0, 0), (1, 0, 0.5), (1, 1, 0.5), (0, 2, 0)]),
}
SHEAR = np.array([[1, 0.4, 0, 0.3], [0, 0.8, -0.3, -1], [0.2, 0, 1.5, 2], [0, 0, 0, 1]])
PLACES = {
    "as it is": iso.Transform.identity(),
    "turned": iso.Transform.identity().rotate((1, 2, 3), 0.9).scale(1.7).translate((1, -2, 3)),
    "sheared": iso.Transform(SHEAR),
}


def surface_points(item: iso.Item) -> np.ndarray:
    """Many points of the surface: where rays from all around towards the middle of its box meet it."""
    low, high = item.bounds
    around = RNG.normal(size=(200_000, 3))
    around /= np.linalg.norm(around, axis=1, keepdims=True)
    reach = np.linalg.norm(high - low)
    targets = RNG.uniform(low, high, (200_000, 3))
    origins = targets + around * reach
    hits = iso.Tracer(item).closest(origins, -around)
    return hits.point[hits.hit]


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("name", SHAPES)
def test_boxes_are_tight(name: str, place: str) -> None:
    item = iso.Item(SHAPES[name], transform=PLACES[place])
    box, points = bounding_box(item), surface_points(item)
    size = np.linalg.norm(box[1] - box[0])
    assert (points >= box[0] - 1e-5 * size).all()
    assert (points <= box[1] + 1e-5 * size).all()
    # 200,000 rays come this near to each side.
    assert (points.min(axis=0) - box[0] < 0.02 * size).all()
    assert (box[1] - points.max(axis=0) < 0.02 * size).all()


@pytest.mark.parametrize("place", ["as it is", "turned"])
@pytest.mark.parametrize("name", SHAPES)
def test_spheres_are_tight(name: str, place: str) -> None:
    shape = SHAPES[name]
    item = iso.Item(shape, transform=PLACES[place])
    points = surface_points(item)
    if isinstance(shape, iso.Field):
        matrix = item.transform.matrix
        ball = bounding_sphere(shape.affine(matrix))
    elif place == "as it is":
        ball = bounding_sphere(shape)
    else:
        return
    assert np.linalg.norm(points - ball.centre, axis=1).max() < ball.radius * (1 + 1e-5)
    if name != "ball of a quadric":
        assert ball.radius < bounding_sphere(points).radius * 1.03


def test_endless_shapes_have_endless_boxes() -> None:
    assert bounding_box(iso.plane()).tolist() == [[-np.inf] * 3, [np.inf, 0, np.inf]]
    assert bounding_box(iso.cylinder(1).along("x")).tolist() == [[-np.inf, -1, -1], [np.inf, 1, 1]]
    assert bounding_box(iso.slab(2.0).translate((0, 1, 0))).tolist() == [[-np.inf, 0, -np.inf], [np.inf, 2, np.inf]]
    tilted = bounding_box(iso.cylinder(1).rotate("z", 0.3))
    assert np.isinf(tilted[:, :2]).all()
    assert tilted[:, 2].tolist() == [-1, 1]


def test_fields_that_are_no_simple_solid_have_their_bounds() -> None:
    part = iso.box(1) - iso.sphere(0.4)
    assert (bounding_box(part) == part.bounds).all()
    assert (bounding_box([(0, 1, 2), (3, -1, 5)]) == [[0, -1, 2], [3, 1, 5]]).all()


BAD: list[tuple[Callable[[], Any], str]] = [
    (lambda: bounding_sphere(np.zeros((0, 3))), "n ≥ 1"),
    (lambda: bounding_sphere([(0, 0, np.nan)]), "number 0 is not finite"),
    (lambda: bounding_sphere([(0, 0, 1)], method="fast"), 'must be "welzl" or "ritter"'),  # type: ignore[arg-type]
    (lambda: bounding_sphere(iso.plane()), "endless"),
    (lambda: bounding_sphere(iso.box(1) - iso.sphere(0.4)), "one simple solid"),
    (lambda: bounding_box([(0, 0)]), r"shape \(n, 3\)"),
]


@pytest.mark.parametrize("case", range(len(BAD)))
def test_bad_input_is_told(case: int) -> None:
    call, message = BAD[case]
    with pytest.raises(GeometryError, match=message):
        call()
