"""Exact predicates against rational arithmetic: random, nearly degenerate, huge and tiny coordinates."""

from __future__ import annotations

from fractions import Fraction
from itertools import permutations
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import isophote as iso

FIXTURES = Path(__file__).parents[1] / "../shared/models/predicates"

# Predicate, dimension, number of points, whether it is about a circle or sphere.
PREDICATES = [
    (iso.analysis.orient2d, 2, 3, False),
    (iso.analysis.incircle, 2, 4, True),
    (iso.analysis.orient3d, 3, 4, False),
    (iso.analysis.insphere, 3, 5, True),
]
each = pytest.mark.parametrize(
    ("predicate", "dimension", "count", "lifted"), PREDICATES, ids=[p[0].__name__ for p in PREDICATES]
)


def determinant(rows: list[list[Fraction]]) -> Fraction:
    """By elimination."""
    rows = [list(row) for row in rows]
    value = Fraction(1)
    for k in range(len(rows)):
        pivot = next((i for i in range(k, len(rows)) if rows[i][k] != 0), None)
        if pivot is None:
            return Fraction(0)
        if pivot != k:
            rows[k], rows[pivot] = rows[pivot], rows[k]
            value = -value
        value *= rows[k][k]
        for i in range(k + 1, len(rows)):
            ratio = rows[i][k] / rows[k][k]
            rows[i] = [x - ratio * y for x, y in zip(rows[i], rows[k], strict=True)]
    return value


def rational_sign(points: np.ndarray, lifted: bool) -> int:
    exact = [[Fraction(float(x)) for x in p] for p in points]
    rows = [[x - y for x, y in zip(p, exact[-1], strict=True)] for p in exact[:-1]]
    if lifted:
        rows = [[*row, sum((x * x for x in row), Fraction(0))] for row in rows]
    value = determinant(rows)
    return (value > 0) - (value < 0)


def agrees(predicate, points: np.ndarray, lifted: bool) -> None:
    """Points (n, count, dimension)."""
    found = predicate(*np.moveaxis(points, 1, 0))
    assert found.dtype == np.int8
    expected = [rational_sign(p, lifted) for p in points]
    np.testing.assert_array_equal(found, expected)


def test_signs_mean_what_is_said() -> None:
    o, x, y, z = np.vstack([np.zeros(3), np.eye(3)])
    assert iso.analysis.orient2d(o[:2], x[:2], y[:2]) == 1
    assert iso.analysis.incircle(o[:2], x[:2], y[:2], (0.5, 0.5)) == 1
    assert iso.analysis.incircle(o[:2], x[:2], y[:2], (1, 1)) == 0
    assert iso.analysis.incircle(o[:2], x[:2], y[:2], (1, 1.1)) == -1
    assert iso.analysis.orient3d(x, y, z, o) == 1
    assert iso.analysis.insphere(x, y, z, o, (0.5, 0.5, 0.5)) == 1
    assert iso.analysis.insphere(x, y, z, o, (1, 1, 1)) == 0
    assert iso.analysis.insphere(x, y, z, o, (1, 1, 1.1)) == -1
    assert iso.analysis.insphere(y, x, z, o, (0.5, 0.5, 0.5)) == -1


@each
def test_nearly_degenerate_points(predicate, dimension, count, lifted) -> None:
    """Points of a small grid, moved by nothing, by last bits, scaled and shifted so that differences are rounded."""
    rng = np.random.default_rng(3)
    shape = (60, count, dimension)
    grid = rng.integers(-2, 3, shape).astype(float)
    near = grid + rng.integers(-1, 2, shape) * 2.0**-52
    batches = [grid, near, grid / 3, grid * 0.1 + 12.5, grid + 2.0**52, near * 1e-3 + 1e5]
    agrees(predicate, np.concatenate(batches), lifted)


@each
def test_collinear_and_on_a_circle(predicate, dimension, count, lifted) -> None:
    """Points on a line or plane, or on a circle or sphere, by rational parameters, some moved by a last bit."""
    rng = np.random.default_rng(4)
    points = np.empty((200, count, dimension))
    for i in range(len(points)):
        if lifted:
            ring = rng.permutation([*permutations((15, 20, 0)[:dimension]), (7, 24, 0)[:dimension]])
            ring = np.concatenate([ring, -ring])[rng.permutation(2 * len(ring))[:count]]
            points[i] = ring * 2.0 ** rng.integers(-40, 40) / rng.choice([1, 5, 25])
        else:
            basis = rng.random((dimension - 1, dimension)) * rng.choice([1, 1e-8, 1e8])
            points[i] = rng.integers(-5, 6, (count, dimension - 1)) @ basis
    moved = np.where(rng.random(points.shape) < 0.1, np.nextafter(points, np.inf), points)
    agrees(predicate, np.concatenate([points, moved]), lifted)


@each
@settings(max_examples=150, deadline=None)
@given(data=st.data())
def test_all_finite_doubles(predicate, dimension, count, lifted, data) -> None:
    """Any mixture of subnormal, tiny, ordinary and huge numbers: nothing overflows, nothing is lost."""
    number = st.one_of(
        st.floats(allow_nan=False, allow_infinity=False),
        st.sampled_from([0.0, 5e-324, -5e-324, 2.2e-308, 1e-160, 1.0, 3.0, -1.0, 1e150, 1.7e308, -1.7e308]),
        st.integers(-3, 3).map(float),
    )
    points = data.draw(st.lists(number, min_size=count * dimension, max_size=count * dimension))
    agrees(predicate, np.reshape(points, (1, count, dimension)), lifted)


@each
def test_scales_where_products_underflow_or_overflow(predicate, dimension, count, lifted) -> None:
    rng = np.random.default_rng(5)
    grid = rng.integers(-2, 3, (40, count, dimension)).astype(float)
    near = grid + rng.integers(-1, 2, grid.shape) * 2.0**-50
    for power in (-1020, -540, -370, -280, -215, 200, 260, 350, 510, 1020):
        agrees(predicate, near * 2.0**power, lifted)
    agrees(predicate, near * 2.0 ** rng.integers(-1000, 1000, near.shape), lifted)
    agrees(predicate, grid * 2.0 ** rng.integers(-1000, 1000, (40, 1, dimension)), lifted)


@each
def test_exchanging_two_points_changes_the_sign(predicate, dimension, count, lifted) -> None:
    rng = np.random.default_rng(6)
    points = list(rng.integers(-3, 4, (count, 500, dimension)) * 0.1)
    changed = [points[1], points[0], *points[2:]]
    np.testing.assert_array_equal(predicate(*points), -predicate(*changed))


@pytest.mark.parametrize("name", ["orient2d", "incircle"])
def test_collected_cases(name: str) -> None:
    path = FIXTURES / f"{name}.txt"
    if not path.exists():
        pytest.skip("collected cases are not there")
    table = np.loadtxt(path)
    points = np.moveaxis(table[:, 1:-1].reshape(len(table), -1, 2), 1, 0)
    found = getattr(iso.analysis, name)(*points)
    assert len(found) == 1000
    np.testing.assert_array_equal(found, table[:, -1])


def test_broadcasting_and_bad_points() -> None:
    signs = iso.analysis.orient2d((0, 0), (1, 0), np.random.default_rng(0).random((4, 5, 2)))
    assert signs.shape == (4, 5)
    assert (signs == 1).all()
    with pytest.raises(iso.GeometryError, match=r"shape \(\.\.\., 2\)"):
        iso.analysis.orient2d((0, 0, 0), (1, 0), (0, 1))
    with pytest.raises(iso.GeometryError, match="not finite"):
        iso.analysis.orient2d((0, np.nan), (1, 0), (0, 1))
    with pytest.raises(iso.GeometryError, match="fit together"):
        iso.analysis.orient2d(np.zeros((2, 2)), np.zeros((3, 2)), (0, 1))
