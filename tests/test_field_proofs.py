"""What fields claim, against their values: Lipschitz constants of all that they are made of, intervals, bounds."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
import pytest

import isophote as iso
from field_shapes import EXACT, OPERATIONS
from isophote.shapes.field.intervals import numpy_intervals
from isophote.shapes.field.tape import node_values, numpy_values, written

Floats = npt.NDArray[np.float64]
RANDOM = np.random.default_rng(11)
BOUNDED = OPERATIONS | {name: field for name, (field, _) in EXACT.items() if np.isfinite(field.bounds).all()}


def values(field: iso.Field, points: npt.ArrayLike) -> Floats:
    return numpy_values(field.form, points)


def slope_in(field: iso.Field, region: Floats) -> float:
    graph, result = written(field.form, region)
    return graph.lipschitz()[result]


@pytest.mark.parametrize("name", BOUNDED)
def test_no_two_points_differ_by_more_than_the_lipschitz_constant(name: str) -> None:
    field = BOUNDED[name]
    low, high = field.bounds
    p = RANDOM.uniform(low, high, (100_000, 3))
    q = np.clip(p + RANDOM.normal(size=p.shape) * 10 ** RANDOM.uniform(-4, -0.3, (len(p), 1)), low, high)
    away = np.linalg.norm(p - q, axis=1)
    assert math.isfinite(field.lipschitz)
    assert (np.abs(values(field, p) - values(field, q)) <= field.lipschitz * away + 1e-12).all()


@pytest.mark.parametrize("name", BOUNDED)
def test_lipschitz_constants_hold_in_small_regions(name: str) -> None:
    field = BOUNDED[name]
    for _ in range(5):
        middle = RANDOM.uniform(*field.bounds)
        region = np.stack([middle - 0.06, middle + 0.06])
        p, q = RANDOM.uniform(*region, (2, 1000, 3))
        most = slope_in(field, region) * np.linalg.norm(p - q, axis=1)
        assert (np.abs(values(field, p) - values(field, q)) <= most + 1e-12).all()


@pytest.mark.parametrize("name", BOUNDED)
def test_slopes_of_rows_hold_in_small_regions(name: str) -> None:
    """Not the value alone: what tapes are shortened by are the constants of all that it is made of."""
    field = BOUNDED[name]
    for _ in range(2):
        middle = RANDOM.uniform(*field.bounds)
        graph, result = written(field.form, np.stack([middle - 0.1, middle + 0.1]))
        constants = graph.lipschitz()
        p, q = RANDOM.uniform(middle - 0.1, middle + 0.1, (2, 1000, 3))
        away = np.linalg.norm(p - q, axis=1)
        at_p, at_q = node_values(graph, result, p), node_values(graph, result, q)
        for node in graph.used(result):
            low, high = graph.interval(node)
            assert (at_p[node] >= low - 1e-9).all()
            assert (at_p[node] <= high + 1e-9).all()
            if math.isfinite(constants[node]):
                assert (np.abs(at_p[node] - at_q[node]) <= constants[node] * away + 1e-9).all(), graph.nodes[node]


@pytest.mark.parametrize("name", BOUNDED)
def test_bounds_hold_what_is_inside_and_are_tight(name: str) -> None:
    field = BOUNDED[name]
    size = field.bounds[1] - field.bounds[0]
    points = RANDOM.uniform(field.bounds[0] - 0.3 * size, field.bounds[1] + 0.3 * size, (100_000, 3))
    inside = points[values(field, points) <= 0]
    assert len(inside) > 300
    assert (inside >= field.bounds[0]).all()
    assert (inside <= field.bounds[1]).all()
    slack = np.maximum(inside.min(axis=0) - field.bounds[0], field.bounds[1] - inside.max(axis=0)) / size
    assert slack.max() < 0.1


@pytest.mark.parametrize("name", BOUNDED)
def test_intervals_hold_the_values(name: str) -> None:
    field = BOUNDED[name]
    low = RANDOM.uniform(*field.bounds, (1000, 3))
    high = low + 10 ** RANDOM.uniform(-2, -0.3, (1000, 1)) * RANDOM.uniform(0, 1, (1000, 3))
    least, most = numpy_intervals(field.form, low, high)
    for _ in range(5):
        found = values(field, RANDOM.uniform(low, high))
        assert (found >= least).all()
        assert (found <= most).all()


def test_bent_fields_hold_away_from_the_middle_of_the_circle() -> None:
    """There the map has no bound, but the value does, and is no more than the distance to the bent solid."""
    for part, curvature in ((iso.box((0.5, 4, 0.4)), 1.2), (iso.ellipsoid((0.3, 1.8, 0.2)), -0.9)):
        field = part.bend(curvature)
        p = RANDOM.normal(size=(40_000, 3)) * 0.3 + [1 / curvature, 0, 0]
        q = p + RANDOM.normal(size=p.shape) * 0.05
        away = np.linalg.norm(p - q, axis=1)
        region = np.stack([np.minimum(p, q).min(axis=0), np.maximum(p, q).max(axis=0)])
        slope = slope_in(field, region)
        assert slope < 6
        assert (np.abs(values(field, p) - values(field, q)) <= slope * away + 1e-12).all()
        assert (values(field, p)[np.hypot(p[:, 0] - 1 / curvature, p[:, 1]) < 0.4] > 0).all()


def test_an_empty_intersection_has_bounds_without_size() -> None:
    apart = iso.sphere(0.5) & iso.sphere(0.5).translate((0.9, 0.9, 0))
    assert (apart.bounds[0] == apart.bounds[1]).all()
