"""Formulas of users' own and fields as textures: their tapes, run by the interpreter that all tapes share.

The interpreter takes sixteen places at once. They are spread over what is looked at, and the mean of the colours there
is the texture's: whatever the formula is, it is averaged.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.entry import entry, opener_at
from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import load_int, store_float
from isophote.kernels.base.stack import stack_floats
from isophote.kernels.base.table import FLOAT, FLOATS, INT, INT_ROWS, INTS, LONG_ROWS, Table
from isophote.kernels.base.vec import dot, load_vec3, vec3
from isophote.kernels.forms import opcodes as op
from isophote.kernels.forms.field_data import open_field_data
from isophote.kernels.forms.interpreters import INTERPRETERS, values_on
from isophote.kernels.texture.combine import ramp_colour
from isophote.kernels.texture.contract import OWN, OWN_A, OWN_B, PICTURE, answer, open_place

__all__ = ["FORMULA", "LANES", "formula"]

LANES = 16

# `rows`: the rows of all tapes. `spans` (tapes, 2): first row and how many. `slots`: how many the longest needs. `data`
# (tapes, words): the tables that they name. `ramp`: what makes a colour of the value of one tape (combine.py); empty
# where three tapes give a colour. `period`: after which the ramp begins anew, or 0.
FORMULA = Table(
    "Formula",
    rows=INTS,
    spans=INT_ROWS,
    slots=INT,
    data=LONG_ROWS,
    interpreters=INTERPRETERS,
    ramp=FLOATS,
    period=FLOAT,
)

_LANES, _ROW, _ONE_VECTOR, _FIRST = np.int64(LANES), np.int64(op.ROW), np.int64(1), np.int64(0)
_ZERO, _ONE = np.float32(0), np.float32(1)
# Colours beyond are as good as infinite.
_MOST = np.float32(1e30)

_formula_at = opener_at(FORMULA)


@device
def _spread(lane):
    """Hammersley's points in the square from −1 to 1, the middle first where there is but one to see."""
    k, reverse = lane, np.int64(0)
    for _ in range(4):
        reverse = 2 * reverse + (k & 1)
        k >>= 1
    return np.float32(2 * lane - 15) / np.float32(16), np.float32(2 * reverse - 15) / np.float32(16)


@device
def _write_places(place, lanes, slots):
    """The places over what is looked at, in slots 0 to 2; all the same for one lane."""
    record = place.record
    p, a, b = load_vec3(record, OWN), load_vec3(record, OWN_A), load_vec3(record, OWN_B)
    for lane in range(_LANES):
        x, y = _spread(lane)
        q = p + a * x + b * y if lanes > 1 else p
        store_float(slots, lane, q.x)
        store_float(slots, _LANES + lane, q.y)
        store_float(slots, 2 * _LANES + lane, q.z)


@device
def _run(table, tape, slots):
    """Run a tape; returns where its values begin."""
    first, count = np.int64(table.spans[tape, 0]), np.int64(table.spans[tape, 1])
    values_on(table.interpreters, table.rows, first, count, open_field_data(table.data[tape]), slots, _ONE_VECTOR)
    return np.int64(load_int(table.rows, (first + count - 1) * _ROW + op.OUT)) * _LANES


@device
def _mean_channel(slots, at, lanes):
    total = _ZERO
    for lane in range(lanes):
        value = slots[at + lane]
        total += min(value, _MOST) if value > _ZERO else _ZERO
    return total / np.float32(lanes)


@device
def _mean_of_ramp(table, slots, at, lanes):
    total = vec3(_ZERO, _ZERO, _ZERO)
    for lane in range(lanes):
        value = slots[at + lane]
        if table.period > _ZERO:
            value /= table.period
            value -= np.floor(value)
        total = total + ramp_colour(table.ramp, _FIRST, value)
    return total / np.float32(lanes)


@entry
def formula(textures, node, record):
    """The mean of a formula's colours; its FORMULA lies where the node says."""
    place = open_place(textures, node, record)
    table = _formula_at(place.textures.nodes[node, PICTURE])
    slots = stack_floats(table.slots * _LANES)
    a, b = load_vec3(place.record, OWN_A), load_vec3(place.record, OWN_B)
    lanes = _LANES if dot(a, a) + dot(b, b) > _ZERO else np.int64(1)
    _write_places(place, lanes, slots)
    if table.ramp.rows > 0:
        return answer(place, _mean_of_ramp(table, slots, _run(table, 0, slots), lanes), _ONE)
    red = _mean_channel(slots, _run(table, 0, slots), lanes)
    green = _mean_channel(slots, _run(table, 1, slots), lanes)
    blue = _mean_channel(slots, _run(table, 2, slots), lanes)
    return answer(place, vec3(red, green, blue), _ONE)
