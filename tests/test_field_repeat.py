"""Repetition: against copies written out one by one, inside, outside and where cells meet."""

from __future__ import annotations

import math
from itertools import product

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import isophote as iso
from isophote.shapes.field.repeat import near
from isophote.shapes.field.tape import numpy_values, written

Floats = npt.NDArray[np.float64]
RANDOM = np.random.default_rng(17)


def values(field: iso.Field, points: npt.ArrayLike) -> Floats:
    return numpy_values(field.form, points)


def copied(field: iso.Field, offsets: npt.ArrayLike, points: Floats) -> Floats:
    """The least of the values of copies."""
    return np.min([values(field, points - offset) for offset in np.asarray(offsets, float)], axis=0)


def grid(spacing: tuple[float, ...], *steps: range) -> Floats:
    return np.array([np.multiply(spacing, step) for step in product(*steps)])


def around(field: iso.Field, count: int, points: Floats) -> Floats:
    """The least of the values of copies about y."""
    found = []
    for k in range(count):
        c, s = math.cos(math.tau * k / count), math.sin(math.tau * k / count)
        x, y, z = points.T
        found.append(values(field, np.column_stack([c * x - s * z, y, s * x + c * z])))
    return np.asarray(np.min(found, axis=0))


EXACT = {
    "ball": iso.sphere(0.3),
    "box that fills its cell": iso.box((1, 0.4, 0.7)),
    "box that is off its cell": iso.box((0.3, 0.4, 0.2)).translate((0.35, 0.3, 2.2)),
    "turned box": iso.box((1.1, 0.2, 0.3)).rotate("z", 0.5),
    "long box": iso.box((2.7, 0.2, 0.3)).rotate("z", 0.2).translate((0.4, 0, 0)),
    "cone": iso.cone(0.4, 0.9).rotate("x", 1.2),
}
BOUNDS = {
    "egg": iso.ellipsoid((0.2, 0.6, 0.1)).rotate("z", 0.7),
    "twisted": iso.box((0.4, 0.9, 0.2)).twist(3).translate((0.2, 0, 0.1)),
    "long egg": iso.ellipsoid((1.4, 0.1, 0.2)),
}
SPACING = (1.0, 0.9, 0.0)


@pytest.mark.parametrize("name", EXACT)
def test_endless_copies_are_the_least_of_all(name: str) -> None:
    field = EXACT[name]
    points = RANDOM.uniform(-1.5, 1.5, (30_000, 3)) * [1, 1, 2]
    expected = copied(field, grid(SPACING, range(-6, 7), range(-6, 7), range(1)), points)
    np.testing.assert_allclose(values(field.repeat(SPACING), points), expected, atol=1e-12)


@pytest.mark.parametrize("name", EXACT)
@pytest.mark.parametrize("count", [(2, 1, 1), (5, 1, 1), (6, 8, 1), (50, 1, 1)])
def test_counted_copies_are_the_least_of_all(name: str, count: tuple[int, int, int]) -> None:
    field = EXACT[name]
    points = RANDOM.uniform(-5, 5, (20_000, 3))
    offsets = grid(SPACING, *(range(n) for n in count)) - np.multiply(SPACING, [(n - 1) / 2 for n in count])
    repeated = field.repeat(SPACING, count=count)
    expected = copied(field, offsets, points)
    np.testing.assert_allclose(values(repeated, points), expected, atol=1e-12)
    inside = points[expected <= 0]
    assert (inside >= repeated.bounds[0]).all()
    assert (inside <= repeated.bounds[1]).all()


@pytest.mark.parametrize("name", BOUNDS)
@pytest.mark.parametrize("count", [None, (6, 4, 1), (7, 6, 1)])
def test_copies_of_bounds_have_the_sign_of_all_and_no_larger_values(name: str, count: tuple[int, ...] | None) -> None:
    field = BOUNDS[name]
    points = RANDOM.uniform(-1.5, 1.5, (30_000, 3))
    if count is None:
        offsets = grid(SPACING, range(-6, 7), range(-6, 7), range(1))
    else:
        offsets = grid(SPACING, *(range(n) for n in count)) - np.multiply(SPACING, [(n - 1) / 2 for n in count])
    expected = copied(field, offsets, points)
    found = values(field.repeat(SPACING, count=count), points)
    np.testing.assert_array_equal(found <= 0, expected <= 0)
    near_by = np.abs(expected) < 0.05
    assert near_by.sum() > 300
    assert (found[expected > 0] > 0).all()


@pytest.mark.parametrize("name", BOUNDS)
def test_copies_of_bounds_are_continuous_where_cells_meet(name: str) -> None:
    field = BOUNDS[name].repeat(SPACING)
    p = RANDOM.uniform(-1.5, 1.5, (200_000, 3))
    step = RANDOM.normal(size=p.shape) * 1e-6
    region = np.array([[-1.6] * 3, [1.6] * 3])
    graph, result = written(field.form, region)
    slope = graph.lipschitz()[result]
    assert slope < 8
    away = np.linalg.norm(step, axis=1)
    assert (np.abs(values(field, p + step) - values(field, p)) <= slope * away + 1e-13).all()


@pytest.mark.parametrize("count", [1, 2, 3, 4, 7, 12, 33, 40, 97])
@pytest.mark.parametrize("distance", [0.0, 0.5, 1.5])
def test_rings_are_the_least_of_all(count: int, distance: float) -> None:
    for field in (iso.sphere(0.2), iso.box((0.2, 0.5, 0.9)).rotate("y", 0.4), iso.cone(0.3, 0.7).along("x")):
        placed = field.translate((distance, 0.1, 0.2))
        points = RANDOM.uniform(-2, 2, (4000, 3))
        expected = around(placed, count, points)
        np.testing.assert_allclose(values(placed.repeat_around("y", count), points), expected, atol=1e-12)


@pytest.mark.parametrize("count", [5, 33, 40])
def test_rings_of_bounds_have_the_sign_of_all(count: int) -> None:
    field = iso.ellipsoid((0.1, 0.4, 0.3)).translate((0.9, 0, 0.1))
    ring = field.repeat_around("y", count)
    points = RANDOM.uniform(-1.4, 1.4, (60_000, 3))
    expected = around(field, count, points)
    np.testing.assert_array_equal(values(ring, points) <= 0, expected <= 0)
    # No surface on the axis either.
    axis = np.column_stack([np.zeros(100), np.linspace(-1, 1, 100), np.zeros(100)])
    assert (values(ring, axis) > 0.1).all()
    step = RANDOM.normal(size=points.shape) * 1e-6
    away = np.linalg.norm(step, axis=1)
    assert (np.abs(values(ring, points + step) - values(ring, points)) <= 1.0001 * away + 1e-13).all()


def test_rings_in_the_plane_and_about_other_axes() -> None:
    flat = iso.rectangle((0.4, 0.2)).translate((0.8, 0.1))
    points = RANDOM.uniform(-1.2, 1.2, (5000, 2))
    turned = [flat.rotate(math.tau * k / 5) for k in range(5)]
    expected = np.min([numpy_values(each.form, points) for each in turned], axis=0)
    np.testing.assert_allclose(numpy_values(flat.repeat_around(5).form, points), expected, atol=1e-12)
    solid, points = iso.box((0.2, 0.3, 0.4)).translate((0.5, 0.6, 0.7)), RANDOM.uniform(-1.5, 1.5, (5000, 3))
    for axis in "xyz":
        expected = np.min([values(solid.rotate(axis, math.tau * k / 6), points) for k in range(6)], axis=0)
        np.testing.assert_allclose(values(solid.repeat_around(axis, 6), points), expected, atol=1e-12)


def test_one_neighbour_suffices_for_forms_that_fit_their_cells() -> None:
    assert near(0.5, exact=True) == range(2)
    assert near(0.3, exact=False) == range(2)
    assert near(0.6, exact=True) == range(-1, 2)
    assert near(1.2, exact=True) == range(-1, 3)
    assert len(near(10, exact=True)) == 21


@settings(max_examples=60, deadline=None)
@given(
    st.floats(0.05, 3),
    st.floats(-2, 2),
    st.floats(0.2, 2),
    st.integers(1, 60),
    st.booleans(),
    st.floats(-math.pi, math.pi),
)
def test_any_row_is_the_least_of_all(
    size: float, offset: float, spacing: float, count: int, endless: bool, turn: float
) -> None:
    field = iso.box((size, 0.3, 0.2)).rotate("z", turn).translate((offset, 0, 0))
    points = np.random.default_rng(count).uniform(-3, 3, (800, 3))
    repeated = field.repeat((spacing, 0, 0), count=None if endless else count)
    steps = np.arange(-60, 61) if endless else np.arange(count) - (count - 1) / 2
    expected = copied(field, np.outer(steps, [spacing, 0, 0]), points)
    np.testing.assert_allclose(values(repeated, points), expected, atol=1e-9)


def test_exactness_of_copies() -> None:
    ball = iso.sphere(0.3)
    assert ball.repeat((0.7, 0, 0)).exactness is iso.Exactness.EXACT
    assert ball.repeat((0.5, 0, 0)).exactness is iso.Exactness.BOUND
    assert ball.translate((1, 0, 0)).repeat_around("y", 6).exactness is iso.Exactness.EXACT
    assert ball.translate((1, 0, 0)).repeat_around("y", 12).exactness is iso.Exactness.BOUND


def test_edges_of_copies_are_finished() -> None:
    row = iso.box(0.6).repeat((1, 0, 0), count=5).round(0.1)
    points = RANDOM.uniform(-2, 2, (5000, 3))
    rounded = iso.box(0.6).round(0.1).repeat((1, 0, 0), count=5)
    np.testing.assert_allclose(values(row, points), values(rounded, points), atol=1e-12)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: iso.sphere(1).repeat((0, 0, 0)), "spacing is 0 along every axis"),
        (lambda: iso.sphere(1).repeat((1, 1)), "repeat: spacing must be 3 finite numbers"),
        (lambda: iso.sphere(1).repeat((-1, 0, 0)), "0 or above"),
        (lambda: iso.sphere(1).repeat((1, 0, 0), count=0), "whole numbers from 1"),
        (lambda: iso.sphere(1).repeat((1, 0, 0), count=(2.5, 1, 1)), "whole numbers from 1"),
        (lambda: iso.sphere(1).repeat((1, 0, 0), count=(2, 1)), "must be 3 whole numbers"),
        (lambda: iso.plane().repeat((1, 0, 0)), "endless along x; intersect it with a box first"),
        (lambda: iso.sphere(1).repeat((1e-6, 1e-6, 0)), "give a larger spacing"),
        (lambda: iso.sphere(1).repeat_around("w", 3), "axis must be one of x, y, z"),
        (lambda: iso.sphere(1).repeat_around("y", 0), "count must be a whole number from 1"),
        (lambda: iso.sphere(1).repeat_around("y", 5000), "copies overlap at a point"),
    ],
)
def test_bad_repetitions_are_refused(make, words: str) -> None:
    with pytest.raises(iso.GeometryError) as error:
        make()
    assert words in str(error.value)
