"""The interpreters of tapes as entries: compiled once for all kernels that follow rays or ask for values one by one."""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.entry import (
    call_entry,
    element_address,
    entry,
    floats_at,
    ints_at,
    opener_at,
    table_address,
)
from isophote.kernels.base.jit import device
from isophote.kernels.base.table import INT, Table
from isophote.kernels.forms import opcodes as op
from isophote.kernels.forms.field_data import FIELD_DATA
from isophote.kernels.forms.tape import run_tape
from isophote.kernels.forms.tape_gradient import run_gradients
from isophote.kernels.forms.tape_interval import run_intervals

__all__ = ["INTERPRETERS", "bounds_on", "gradients_on", "open_interpreters", "pack_interpreters", "values_on"]

# Addresses of the entries below.
INTERPRETERS = Table("Interpreters", values=INT, bounds=INT, gradients=INT)

open_interpreters = INTERPRETERS.open

# Views of an entry's arguments have no bounds, so that their length does not matter.
_ANY = np.int64(1 << 40)
_NO_RESULT = np.int64(0)

open_data_at = opener_at(FIELD_DATA)


@entry
def _values(rows, first, count, data, slots, width):
    run_tape(ints_at(rows, _ANY), first, count, open_data_at(data), floats_at(slots, _ANY), width)
    return _NO_RESULT


@entry
def _bounds(rows, first, count, data, slots, choices):
    views = ints_at(rows, _ANY), floats_at(slots, _ANY), ints_at(choices, _ANY)
    run_intervals(views[0], first, count, open_data_at(data), views[1], views[2])
    return _NO_RESULT


@entry
def _gradients(rows, first, count, data, slots):
    run_gradients(ints_at(rows, _ANY), first, count, open_data_at(data), floats_at(slots, _ANY))
    return _NO_RESULT


def pack_interpreters(compiled: bool = True, chosen: tuple[int, ...] = (op.VALUES, op.INTERVALS, op.GRADIENTS)):
    """The addresses of the chosen ones as a table; zeros, and nothing compiled, where they are not needed."""
    entries = {"values": _values, "bounds": _bounds, "gradients": _gradients}
    return INTERPRETERS.pack(
        **{name: e.address if compiled and k in chosen else 0 for k, (name, e) in enumerate(entries.items())}
    )


@device
def values_on(interpreters, rows, first, count, data, slots, width):
    """`run_tape`."""
    arguments = element_address(rows, 0), first, count, table_address(data), element_address(slots, 0), width
    call_entry(interpreters.values, arguments)


@device
def bounds_on(interpreters, rows, first, count, data, slots, choices):
    """`run_intervals`."""
    arguments = (
        element_address(rows, 0),
        first,
        count,
        table_address(data),
        element_address(slots, 0),
        element_address(choices, 0),
    )
    call_entry(interpreters.bounds, arguments)


@device
def gradients_on(interpreters, rows, first, count, data, slots):
    """`run_gradients`."""
    arguments = element_address(rows, 0), first, count, table_address(data), element_address(slots, 0)
    call_entry(interpreters.gradients, arguments)
