"""Every operator of the table in every interpreter: values, intervals, derivatives, choices, against NumPy."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from field_tapes import INPUTS, bounds_of, gradients_of, shortened, tape_row, values_of
from isophote.kernels.forms import opcodes
from isophote.shapes.field.operators import OPERATORS, Operator

TABLES = ("OUTLINE", "GRID2", "GRID3", "MESH")
NAMES = [name for name in OPERATORS if name not in TABLES]

# Constants that an operator is tried with, in single precision.
CONSTANTS = dict.fromkeys(NAMES, (0.75, -1.25, 40.0))
CONSTANTS |= {"SMOOTH_MINIMUM": (0.5, 0.01, 20.0), "SMOOTH_MAXIMUM": (0.5, 0.01, 20.0)}

SPECIAL = np.array([0.0, -0.0, 1.0, -1.0, 0.5, -2.0, 1e-30, 3e5], np.float32)


def row_of(name: str, k: float) -> Any:
    """A tape of the operator alone, of the point's coordinates."""
    operator = OPERATORS[name]
    return tape_row(operator.code, np.float32(k), tuple(range(operator.arity)))


def exact(operator: Operator, points: Any, k: float) -> Any:
    """What NumPy gives in double precision."""
    k = float(np.float32(k))
    columns = points.astype(np.float64).T[: operator.arity]
    with np.errstate(all="ignore"):
        return np.broadcast_to(operator.value(*columns, k), len(points)).astype(np.float64)


def numbers(rng: np.random.Generator, shape: tuple[int, ...]) -> Any:
    """Numbers of many sizes, single precision."""
    sizes = 10.0 ** rng.uniform(-4, 3, shape)
    return (rng.choice([-1, 1], shape) * sizes).astype(np.float32)


@pytest.mark.parametrize("name", NAMES)
def test_values(name: str) -> None:
    rng = np.random.default_rng(1)
    grid = np.stack(np.meshgrid(SPECIAL, SPECIAL, SPECIAL), axis=-1).reshape(-1, 3)
    points = np.concatenate([numbers(rng, (2000, 3)), rng.uniform(-1, 1, (1000, 3)).astype(np.float32), grid])
    for k in CONSTANTS[name]:
        wanted = exact(OPERATORS[name], points, k)
        size = np.abs(wanted)
        if name == "MULTIPLY_ADD":
            size = np.maximum(size, np.abs(points.astype(float)).max(axis=1) ** 2)
        if name.startswith("SMOOTH"):
            size = size + k
        found = values_of(row_of(name, k), points)
        with np.errstate(all="ignore"):
            difference = np.abs(found - wanted)
        # Squares of small numbers vanish in single precision.
        least = 1e-18 if name.startswith("LENGTH") else 1e-37
        with np.errstate(over="ignore"):
            both_infinite = np.isinf(wanted.astype(np.float32)) & (found == wanted.astype(np.float32))
        same = (difference <= 4e-7 * size + least) | (np.isnan(wanted) & np.isnan(found)) | both_infinite
        assert same.all(), (k, points[~same][0], wanted[~same][0], found[~same][0])


def boxes(rng: np.random.Generator, rounds: int) -> Any:
    """Corners of boxes, (rounds, 2, 16, 3): from thin ones to wide ones, some with a side of no length."""
    middles = np.where(
        rng.random((rounds, 16, 3)) < 0.5, rng.uniform(-2, 2, (rounds, 16, 3)), numbers(rng, (rounds, 16, 3))
    )
    halves = 10.0 ** rng.uniform(-7, 1, (rounds, 16, 3)) * (rng.random((rounds, 16, 3)) < 0.9)
    return np.stack([middles - halves, middles + halves], axis=1).astype(np.float32)


def samples(rng: np.random.Generator, low: Any, high: Any, count: int) -> Any:
    """(16, count, 3) single-precision points of boxes, their corners among them."""
    weights = rng.random((16, count, 3))
    weights[:, :8] = np.stack(np.meshgrid((0, 1), (0, 1), (0, 1)), axis=-1).reshape(8, 3)
    points = low[:, None].astype(float) * (1 - weights) + high[:, None].astype(float) * weights
    return np.clip(points.astype(np.float32), low[:, None], high[:, None])


@pytest.mark.parametrize("name", NAMES)
def test_intervals_hold_exact_and_single_precision_values_and_are_tight(name: str) -> None:
    rng = np.random.default_rng(2)
    operator = OPERATORS[name]
    for k in CONSTANTS[name]:
        for low, high in boxes(rng, 30):
            found = bounds_of(row_of(name, k), low, high)
            points = samples(rng, low, high, 80).reshape(-1, 3)
            for values in (exact(operator, points, k), values_of(row_of(name, k), points)):
                values = values.reshape(16, -1)
                held = (values >= found.low[:, None]) & (values <= found.high[:, None]) | np.isnan(values)
                assert held.all(), (k, low[~held.all(axis=1)], high[~held.all(axis=1)], found)
            intervals = [(low[:, a].astype(float), high[:, a].astype(float)) for a in range(operator.arity)]
            with np.errstate(all="ignore"):
                least, most = operator.interval(*intervals, float(np.float32(k)))
            known = (np.abs(least) < 1e37) | (np.abs(most) < 1e37)
            size = np.where(np.isfinite(least), np.abs(least), 0) + np.where(np.isfinite(most), np.abs(most), 0)
            slack = 4e-6 * size + 1e-6 * (1 + abs(k))
            if name in ("SINE", "COSINE"):
                slack += 1e-6 * np.maximum(np.abs(low[:, 0]), np.abs(high[:, 0]))
            if name == "MULTIPLY_ADD":
                slack += 4e-6 * np.maximum(np.abs(low), np.abs(high)).max(axis=1) ** 2
            assert (found.low >= least - slack)[known].all()
            assert (found.high <= most + slack)[known].all()


@pytest.mark.parametrize("name", NAMES)
def test_intervals_of_endless_boxes(name: str) -> None:
    rng = np.random.default_rng(3)
    low, high = boxes(rng, 1)[0]
    low[::3, 0], high[1::4, 1], high[2::5, 2] = -np.inf, np.inf, np.inf
    points = samples(rng, np.maximum(low, -1e3), np.minimum(high, 1e3), 50).reshape(-1, 3)
    for k in CONSTANTS[name]:
        found = bounds_of(row_of(name, k), low, high)
        assert not np.isnan(found.low).any()
        assert not np.isnan(found.high).any()
        values = exact(OPERATORS[name], points, k).reshape(16, -1)
        assert ((values >= found.low[:, None]) & (values <= found.high[:, None]) | np.isnan(values)).all()


@pytest.mark.parametrize("name", NAMES)
def test_derivatives(name: str) -> None:
    rng = np.random.default_rng(4)
    operator = OPERATORS[name]
    points = np.concatenate([rng.uniform(-0.95, 0.95, (160, 3)), rng.uniform(0.05, 3, (160, 3))]).astype(np.float32)
    for k in CONSTANTS[name]:
        found = gradients_of(row_of(name, k), points)
        columns = points.astype(float).T[: operator.arity]
        value = exact(operator, points, k)
        with np.errstate(all="ignore"):
            partials = operator.partials(*columns, value, float(np.float32(k)))
        wanted = np.zeros((len(points), 3))
        for axis, part in enumerate(partials):
            wanted[:, axis] = part
        defined = ~np.isnan(value)
        np.testing.assert_allclose(found[:, 0], values_of(row_of(name, k), points), rtol=1e-6, atol=1e-7)
        np.testing.assert_allclose(found[defined, 1:], wanted[defined], rtol=3e-6, atol=3e-6)
        # Differences of the exact value, where it has no step nearby.
        step = 1e-6
        for axis in range(operator.arity):
            ahead, back = (exact(operator, points.astype(float) + s * np.eye(3)[axis], k) for s in (step, -step))
            slope = (ahead - back) / (2 * step)
            bend = np.abs(ahead + back - 2 * value) / step
            smooth = defined & (bend < 1e-3) & (np.abs(slope) < 1e3)
            assert smooth.mean() > 0.3
            np.testing.assert_allclose(found[smooth, 1 + axis], slope[smooth], rtol=1e-3, atol=1e-3)


CHOOSING = [
    "ABSOLUTE", "MINIMUM", "MAXIMUM", "MINIMUM_CONSTANT", "MAXIMUM_CONSTANT", "SMOOTH_MINIMUM", "SMOOTH_MAXIMUM",
    "SELECT",
]  # fmt: skip


@pytest.mark.parametrize("name", NAMES)
def test_shortened_rows_have_the_same_values(name: str) -> None:
    rng = np.random.default_rng(5)
    gone = 0
    for k in CONSTANTS[name]:
        row = row_of(name, k)
        for low, high in boxes(rng, 5):
            choices = bounds_of(row, low, high).choices
            points = samples(rng, low, high, 40)
            for lane in range(16):
                left = shortened(row, choices, lane)
                assert len(left) == 1
                gone += left[0, opcodes.OP] != row[0, opcodes.OP]
                assert np.array_equal(values_of(left, points[lane]), values_of(row, points[lane]), equal_nan=True)
    assert (gone > 0) == (name in CHOOSING)


def test_every_operator_is_tried() -> None:
    assert {*NAMES, *TABLES} == set(OPERATORS)
    codes = {getattr(opcodes, name) for name in OPERATORS}
    assert codes == set(range(len(OPERATORS)))
    assert INPUTS == 3
