"""The interpreters of tapes: values, intervals, gradients and shortened tapes of shapes, against NumPy."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest

from isophote.kernels.base.jit import kernel
from isophote.kernels.forms import opcodes
from isophote.kernels.forms.field_data import open_field_data, pack_field_data
from isophote.kernels.forms.tape import LANES, evaluate_points
from isophote.kernels.forms.tape_gradient import GRADIENT_SLOT, run_gradients
from isophote.kernels.forms.tape_interval import REGION_HIGH, REGION_MIDDLE, REGION_SLOT, run_intervals
from isophote.kernels.forms.tape_prune import shorten
from isophote.shapes.field.field import Field, box, cylinder, sphere
from isophote.shapes.field.tape import numpy_values, tape_of

Floats = npt.NDArray[np.float64]
Singles = npt.NDArray[np.float32]
Ints = npt.NDArray[np.int32]

REGION = np.array([[-2.0] * 3, [2.0] * 3])
ROW, INPUTS = np.int64(opcodes.ROW), opcodes.INPUTS
NOTHING = pack_field_data(()).words

SHAPES = {
    "part": (sphere(1) & box(1.5)) - cylinder(0.5),
    "moved": ((sphere(1) & box(1.5)) - cylinder(0.25)).translate((0.25, 0.125, -0.25)),
    "blended": sphere(1).union(box(1).translate((1, 0.25, 0)), blend=0.25),
    "cut": box(1.5).difference(cylinder(0.5, 1), sphere(0.5).translate((0.5, 0.5, 0.5)), blend=0.125),
}


@kernel
def intervals(rows, data, slots, choices):
    """Bounds in sixteen regions."""
    run_intervals(rows, np.int64(0), np.int64(rows.size) // ROW, open_field_data(data), slots, choices)


@kernel
def gradients(rows, data, slots):
    """Values and gradients at sixteen points."""
    run_gradients(rows, np.int64(0), np.int64(rows.size) // ROW, open_field_data(data), slots)


@kernel
def shortened(rows, choices, lane, out, scratch):
    """Rows left in the region of a lane."""
    return shorten(rows, np.int64(0), np.int64(rows.size) // ROW, choices, lane, out, np.int64(0), scratch)


def values_of(rows: Ints, points: Floats) -> Singles:
    """What the interpreter of points gives."""
    out = np.empty(len(points), np.float32)
    slots = np.empty((len(rows) + INPUTS) * LANES, np.float32)
    evaluate_points(rows.reshape(-1), NOTHING, points.astype(np.float32), slots, out, 0, len(points))
    return out


def bounds_of(rows: Ints, middles: Floats, halves: Floats) -> tuple[Singles, Singles, Ints]:
    """Low and high ends of the value in sixteen boxes, and the choices of all rows."""
    slots = np.zeros((len(rows) + INPUTS, REGION_SLOT), np.float32)
    middles = middles.astype(np.float32)
    slots[:INPUTS, REGION_MIDDLE:REGION_HIGH] = middles.T
    slots[:INPUTS, :REGION_MIDDLE] = (middles - halves).T
    slots[:INPUTS, REGION_HIGH:] = (middles + halves).T
    choices = np.zeros(len(rows), np.int32)
    intervals(rows.reshape(-1), NOTHING, slots.reshape(-1), choices)
    return slots[-1, :REGION_MIDDLE], slots[-1, REGION_HIGH:], choices


def boxes(rng: np.random.Generator, widest: float) -> tuple[Floats, Floats]:
    """Middles and half sizes of sixteen boxes within the region."""
    return rng.uniform(-1.5, 1.5, (16, 3)), rng.uniform(0, widest, (16, 3))


def inside(rng: np.random.Generator, middles: Floats, halves: Floats, count: int) -> Floats:
    """(16, count, 3) single-precision points of the boxes."""
    middles = middles.astype(np.float32).astype(float)
    points = middles[:, None] + rng.uniform(-1, 1, (16, count, 3)) * halves[:, None] * (1 - 1e-6)
    return points.astype(np.float32).astype(float)


@pytest.mark.parametrize("name", SHAPES)
def test_values_are_numpys(name: str) -> None:
    points = np.random.default_rng(1).uniform(-2, 2, (1000, 3)).astype(np.float32)
    np.testing.assert_allclose(SHAPES[name](points), numpy_values(SHAPES[name].form, points), atol=2e-6)


@pytest.mark.parametrize("widest", [0.5, 0.05, 1e-5])
@pytest.mark.parametrize("name", SHAPES)
def test_intervals_hold_all_values(name: str, widest: float) -> None:
    rng = np.random.default_rng(2)
    rows = tape_of(SHAPES[name].form, REGION).rows
    middles, halves = boxes(rng, widest)
    low, high, _ = bounds_of(rows, middles, halves)
    points = inside(rng, middles, halves, 2000)
    exact = numpy_values(SHAPES[name].form, points.reshape(-1, 3)).reshape(16, -1)
    single = values_of(rows, points.reshape(-1, 3)).reshape(16, -1)
    for values in (exact, single):
        assert (values >= low[:, None]).all()
        assert (values <= high[:, None]).all()
    # Bounds are no wider than the Lipschitz constant makes them.
    assert ((high - low) <= 2 * np.linalg.norm(halves, axis=1) + 1e-4).all()


@pytest.mark.parametrize("name", SHAPES)
def test_shortened_tapes_have_the_same_values_in_their_regions(name: str) -> None:
    rng = np.random.default_rng(3)
    rows = tape_of(SHAPES[name].form, REGION).rows
    middles, halves = boxes(rng, 0.3)
    choices = bounds_of(rows, middles, halves)[2]
    points = inside(rng, middles, halves, 500)
    scratch = np.zeros(len(rows) + INPUTS, np.int32)
    lengths = []
    for lane in range(16):
        out = np.zeros((len(rows), ROW), np.int32)
        count = shortened(rows.reshape(-1), choices, lane, out.reshape(-1), scratch)
        assert (values_of(out[:count], points[lane]) == values_of(rows, points[lane])).all()
        assert (out[:count, opcodes.OUT] == INPUTS + np.arange(count)).all()
        lengths.append(count)
    assert np.mean(lengths) < 0.8 * len(rows)


@pytest.mark.parametrize("name", SHAPES)
def test_gradients_are_those_of_differences(name: str) -> None:
    field: Field = SHAPES[name]
    rows = tape_of(field.form).rows
    points = np.random.default_rng(4).uniform(-1.5, 1.5, (16, 3)).astype(np.float32).astype(float)
    slots = np.zeros((len(rows) + INPUTS, 4, GRADIENT_SLOT // 4), np.float32)
    slots[:INPUTS, 0] = points.T
    gradients(rows.reshape(-1), NOTHING, slots.reshape(-1))
    step = 1e-6 * np.eye(3)
    ahead, back = (np.stack([numpy_values(field.form, points + s * e) for e in step]) for s in (1, -1))
    np.testing.assert_allclose(slots[-1, 1:], (ahead - back) / 2e-6, atol=1e-5)
