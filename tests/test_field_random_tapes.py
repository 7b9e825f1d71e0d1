"""Expressions put together at random from all operators: bounds, shortened tapes and rounding, against NumPy."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from field_tapes import Written, bounds_of, gradients_of, shortened, values_of
from isophote.shapes.field.expression import Point, Value
from isophote.shapes.field.operators import OPERATORS
from isophote.shapes.field.rounding import roundings
from isophote.shapes.field.tape import numpy_gradients, numpy_values, tape_of, written

TABLES = ("CONSTANT", "OUTLINE", "GRID2", "GRID3", "MESH")
# What jumps, and what makes numbers too large or nothing at all of others, comes seldom.
RARE = ("FLOOR", "ROUND", "SELECT", "DIVIDE", "CONSTANT_OVER", "LOGARITHM", "EXPONENTIAL")
NAMES = [name for name in OPERATORS if name not in TABLES for _ in range(1 if name in RARE else 4)]
REGION = np.array([[-2.0] * 3, [2.0] * 3])


def expression(seed: int, operators: int, names: list[str]) -> Written:
    """A random expression; its constants are the same in single precision."""

    def write(p: Point) -> Value:
        rng = np.random.default_rng(seed)
        known = [p.x, p.y, p.z]
        for _ in range(operators):
            name = names[rng.integers(len(names))]
            count = OPERATORS[name].arity
            # Mostly what was made last, so that most of it is used.
            places = np.minimum(rng.geometric(0.3, count), len(known))
            constant = float(rng.integers(1, 32)) / 8
            known.append(p.graph.apply(name, *(known[-place] for place in places), constant=constant))
        return known[-1] + p.x * 0.0 if known[-1].constant is None else p.x

    return Written(write)


def boxes(rng: np.random.Generator) -> tuple[Any, Any]:
    """Corners of sixteen boxes within the region, from thin ones to wide ones."""
    middles = rng.uniform(-1.5, 1.5, (16, 3))
    halves = rng.uniform(0, 1, (16, 3)) * 10.0 ** rng.uniform(-5, -0.3, (16, 1))
    return (middles - halves).astype(np.float32), (middles + halves).astype(np.float32)


@pytest.mark.parametrize("block", range(6))
def test_bounds_hold_and_shortened_tapes_are_the_same(block: int) -> None:
    rng = np.random.default_rng(block)
    shorter = tried = 0
    for seed in range(40 * block, 40 * block + 40):
        form = expression(seed, int(rng.integers(3, 40)), NAMES)
        rows = tape_of(form, REGION).rows
        low, high = boxes(rng)
        found = bounds_of(rows, low, high)
        points = low[:, None] + rng.random((16, 60, 3)) * (high - low)[:, None]
        points = np.clip(points.astype(np.float32), low[:, None], high[:, None])
        singles = values_of(rows, points.reshape(-1, 3)).reshape(16, -1)
        exact = numpy_values(form, points.reshape(-1, 3)).reshape(16, -1)
        for values in (singles, exact):
            held = (values >= found.low[:, None]) & (values <= found.high[:, None]) | np.isnan(values)
            assert held.all(), (seed, np.argwhere(~held)[0])
        for lane in range(16):
            left = shortened(rows, found.choices, lane)
            assert np.array_equal(values_of(left, points[lane]), singles[lane], equal_nan=True), (seed, lane)
            shorter += len(left) < len(rows)
            tried += 1
    assert shorter > 0.3 * tried


# Operators with slopes that have a bound, or whose values at numbers that are close are close; and the first of them.
GROWING = ("MULTIPLY", "SQUARE", "MULTIPLY_ADD", "ARC_TANGENT", *RARE)
STEADY = [name for name in NAMES if name not in GROWING]
CALM = [name for name in STEADY if name not in ("SQUARE_ROOT", "ARC_SINE", "ARC_COSINE")]


@pytest.mark.parametrize(("names", "size"), [(STEADY, np.inf), (CALM, 2e-5)], ids=["steady", "calm"])
def test_rounding_is_not_more_than_is_told(names: list[str], size: float) -> None:
    rng = np.random.default_rng(7)
    told, points = [], rng.uniform(-2, 2, (4000, 3)).astype(np.float32)
    for seed in range(80):
        form = expression(seed, int(rng.integers(3, 30)), names)
        graph, result = written(form, REGION)
        bound = roundings(graph, [0.0] * len(graph.nodes))[result] / 2
        error = np.abs(values_of(tape_of(form).rows, points) - numpy_values(form, points)).max()
        assert error <= bound + 1e-18, seed
        told.append(bound)
    assert np.isfinite(told).all()
    assert np.median(told) < size


@pytest.mark.parametrize("block", range(3))
def test_gradients_are_numpys(block: int) -> None:
    rng = np.random.default_rng(block)
    points = rng.uniform(-1, 1, (160, 3)).astype(np.float32)
    agree = []
    for seed in range(20 * block, 20 * block + 20):
        form = expression(seed, int(rng.integers(3, 15)), STEADY)
        found = gradients_of(tape_of(form).rows, points)[:, 1:]
        wanted = numpy_gradients(form, points)[1]
        size = 1 + np.abs(wanted).max(axis=1)
        # Near a bend without a slope, or where arms meet, rounding decides.
        agree.append((np.abs(found - wanted).max(axis=1) < 1e-3 * size).mean())
    assert min(agree) > 0.9
    assert np.mean(agree) > 0.99
