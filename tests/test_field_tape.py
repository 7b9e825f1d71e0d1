"""The interpreters of tapes: values, intervals, gradients and shortened tapes of shapes, against NumPy."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest

from field_tapes import INPUTS, SOLIDS, bounds_of, gradients_of, shortened, values_of
from isophote.kernels.forms import opcodes
from isophote.shapes.field.tape import numpy_values, tape_of

Floats = npt.NDArray[np.float64]

REGION = np.array([[-2.0] * 3, [2.0] * 3])


def boxes(rng: np.random.Generator, widest: float) -> tuple[Floats, Floats]:
    """Corners of sixteen boxes within the region."""
    middles, halves = rng.uniform(-1.5, 1.5, (16, 3)), rng.uniform(0, widest, (16, 3))
    return (middles - halves).astype(np.float32), (middles + halves).astype(np.float32)


def inside(rng: np.random.Generator, low: Floats, high: Floats, count: int) -> Floats:
    """(16, count, 3) single-precision points of the boxes."""
    points = low[:, None] + rng.random((16, count, 3)) * (high - low)[:, None]
    return np.clip(points.astype(np.float32), low[:, None], high[:, None]).astype(float)


@pytest.mark.parametrize("name", SOLIDS)
def test_values_are_numpys(name: str) -> None:
    points = np.random.default_rng(1).uniform(-2, 2, (1000, 3)).astype(np.float32)
    np.testing.assert_allclose(
        values_of(tape_of(SOLIDS[name]).rows, points), numpy_values(SOLIDS[name], points), atol=2e-6
    )


@pytest.mark.parametrize("widest", [0.5, 0.05, 1e-5])
@pytest.mark.parametrize("name", SOLIDS)
def test_intervals_hold_all_values(name: str, widest: float) -> None:
    rng = np.random.default_rng(2)
    rows = tape_of(SOLIDS[name], REGION).rows
    least, most = boxes(rng, widest)
    low, high, _ = bounds_of(rows, least, most)
    points = inside(rng, least, most, 2000)
    exact = numpy_values(SOLIDS[name], points.reshape(-1, 3)).reshape(16, -1)
    single = values_of(rows, points.reshape(-1, 3)).reshape(16, -1)
    for values in (exact, single):
        assert (values >= low[:, None]).all()
        assert (values <= high[:, None]).all()
    # Bounds are no wider than the Lipschitz constant makes them.
    assert ((high - low) <= 2 * np.linalg.norm(most - least, axis=1) / 2 + 1e-4).all()


@pytest.mark.parametrize("name", SOLIDS)
def test_shortened_tapes_have_the_same_values_in_their_regions(name: str) -> None:
    rng = np.random.default_rng(3)
    rows = tape_of(SOLIDS[name], REGION).rows
    low, high = boxes(rng, 0.3)
    choices = bounds_of(rows, low, high).choices
    points = inside(rng, low, high, 500)
    lengths = []
    for lane in range(16):
        left = shortened(rows, choices, lane)
        assert (values_of(left, points[lane]) == values_of(rows, points[lane])).all()
        assert (left[:, opcodes.OUT] == INPUTS + np.arange(len(left))).all()
        lengths.append(len(left))
    assert np.mean(lengths) < 0.8 * len(rows)


@pytest.mark.parametrize("name", SOLIDS)
def test_gradients_are_those_of_differences(name: str) -> None:
    rows = tape_of(SOLIDS[name]).rows
    points = np.random.default_rng(4).uniform(-1.5, 1.5, (16, 3)).astype(np.float32).astype(float)
    found = gradients_of(rows, points)
    step = 1e-6 * np.eye(3)
    ahead, back = (np.stack([numpy_values(SOLIDS[name], points + s * e) for e in step], axis=1) for s in (1, -1))
    np.testing.assert_allclose(found[:, 1:], (ahead - back) / 2e-6, atol=1e-5)
