"""What the tests of tapes share: the interpreters as functions of arrays."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import attrs
import numpy as np
import numpy.typing as npt
from numba import njit

from isophote.kernels.forms import opcodes
from isophote.kernels.forms.field_data import open_field_data, pack_field_data
from isophote.kernels.forms.tape import LANES
from isophote.kernels.forms.tape_arrays import evaluate_points
from isophote.kernels.forms.tape_entries import pack_interpreters
from isophote.kernels.forms.tape_gradient import GRADIENT_SLOT, run_gradients
from isophote.kernels.forms.tape_interval import REGION_HIGH, REGION_MIDDLE, REGION_SLOT, run_intervals
from isophote.kernels.forms.tape_prune import shorten
from isophote.shapes.field.expression import Point, Value
from isophote.shapes.field.form import Form
from isophote.shapes.field.functions import absolute, length, maximum, minimum, smooth_maximum, smooth_minimum

Floats = npt.NDArray[np.float64]
Singles = npt.NDArray[np.float32]
Ints = npt.NDArray[np.int32]

ROW, INPUTS = np.int64(opcodes.ROW), opcodes.INPUTS
NOTHING = pack_field_data(()).words


@attrs.frozen(eq=False)
class Written(Form):
    """A form by what it writes, and no more."""

    write: Callable[[Point], Value]
    dimension: int = 3  # type: ignore[misc]

    def expression(self, p: Point) -> Value:
        return self.write(p)


def ball(p: Point, radius: float, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Value:
    """Distance to a ball about (x, y, z)."""
    return p.bounded(length(p.x - x, p.y - y, p.z - z) - radius, 1.0)


def block(p: Point, size: float, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Value:
    """Distance to a cube about (x, y, z)."""
    q = [absolute(c) - size / 2 for c in (p.x - x, p.y - y, p.z - z)]
    outside = length(*(maximum(c, 0.0) for c in q))
    return p.bounded(outside + minimum(maximum(maximum(q[0], q[1]), q[2]), 0.0), 1.0)


def pole(p: Point, radius: float, x: float = 0.0, z: float = 0.0) -> Value:
    """Distance to an endless cylinder along y."""
    return p.bounded(length(p.x - x, p.z - z) - radius, 1.0)


SOLIDS = {
    "part": Written(lambda p: maximum(maximum(ball(p, 1), block(p, 1.5)), -pole(p, 0.5))),
    "moved": Written(lambda p: maximum(maximum(ball(p, 1, 0.25, 0.125), block(p, 1.5, 0.25)), -pole(p, 0.25, 0.25))),
    "blended": Written(lambda p: smooth_minimum(ball(p, 1), block(p, 1, 1, 0.25), 0.25)),
    "cut": Written(lambda p: smooth_maximum(block(p, 1.5), -minimum(pole(p, 0.5), ball(p, 0.5, 0.5, 0.5, 0.5)), 0.125)),
}


@njit(error_model="numpy")
def _intervals(rows, data, slots, choices):
    run_intervals(rows, np.int64(0), np.int64(rows.size) // ROW, open_field_data(data), slots, choices)


@njit(error_model="numpy")
def _gradients(rows, data, slots):
    run_gradients(rows, np.int64(0), np.int64(rows.size) // ROW, open_field_data(data), slots)


@njit(error_model="numpy")
def _shortened(rows, choices, lane, out, scratch):
    return shorten(rows, np.int64(0), np.int64(rows.size) // ROW, choices, lane, out, np.int64(0), scratch)


def values_of(rows: Ints, points: npt.ArrayLike, data: npt.NDArray[np.int64] = NOTHING) -> Singles:
    """Values at points (n, 3)."""
    array = np.ascontiguousarray(points, np.float32)
    out = np.empty(len(array), np.float32)
    slots = np.empty((len(rows) + INPUTS + 1) * LANES, np.float32)
    runners = pack_interpreters(chosen=(opcodes.VALUES,)).words
    evaluate_points(rows.reshape(-1), data, runners, array, slots, out, 0, len(array))
    return out


class Bounds(NamedTuple):
    """Ends of a field's value in sixteen boxes, each (16,), and the choices of all rows."""

    low: Singles
    high: Singles
    choices: Ints


def bounds_of(rows: Ints, low: npt.ArrayLike, high: npt.ArrayLike, data: npt.NDArray[np.int64] = NOTHING) -> Bounds:
    """Bounds of the value in boxes with corners (16, 3), which are in single precision."""
    low, high = np.asarray(low, np.float32), np.asarray(high, np.float32)
    slots = np.zeros((len(rows) + INPUTS, REGION_SLOT), np.float32)
    slots[:INPUTS, :REGION_MIDDLE] = low.T
    with np.errstate(all="ignore"):
        slots[:INPUTS, REGION_MIDDLE:REGION_HIGH] = (low + (high - low) / 2).T
    slots[:INPUTS, REGION_HIGH:] = high.T
    choices = np.zeros(len(rows), np.int32)
    _intervals(rows.reshape(-1), data, slots.reshape(-1), choices)
    return Bounds(slots[-1, :REGION_MIDDLE], slots[-1, REGION_HIGH:], choices)


def gradients_of(rows: Ints, points: npt.ArrayLike, data: npt.NDArray[np.int64] = NOTHING) -> Singles:
    """Value and gradient, (n, 4), at points (n, 3), of which there are a multiple of sixteen."""
    blocks = np.asarray(points, np.float32).reshape(-1, 16, 3)
    slots = np.zeros((len(rows) + INPUTS, 4, GRADIENT_SLOT // 4), np.float32)
    found = []
    for block in blocks:
        slots[:INPUTS, 0] = block.T
        _gradients(rows.reshape(-1), data, slots.reshape(-1))
        found.append(slots[-1].T.copy())
    return np.concatenate(found)


def shortened(rows: Ints, choices: Ints, lane: int) -> Ints:
    """The rows left in the region of a lane."""
    out = np.full((len(rows) + 1, ROW), -1, np.int32)
    scratch = np.full(len(rows) + INPUTS + 1, -7, np.int32)
    count = _shortened(rows.reshape(-1), choices, lane, out.reshape(-1), scratch)
    # Nothing is written beyond what was asked for.
    assert (out[len(rows) :] == -1).all()
    assert scratch[-1] == -7
    return out[:count].copy()


def tape_row(code: int, k: float = 0.0, arguments: tuple[int, ...] = (0, 1, 2), lipschitz: float = np.inf) -> Ints:
    """A tape of one row."""
    row = np.zeros((1, opcodes.ROW), np.int32)
    row[0, opcodes.OP], row[0, opcodes.OUT] = code, INPUTS
    row[0, opcodes.A : opcodes.A + len(arguments)] = arguments
    row.view(np.float32)[0, opcodes.IMM] = k
    row.view(np.float32)[0, opcodes.LIPSCHITZ] = lipschitz
    return row
