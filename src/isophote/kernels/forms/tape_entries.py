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
from isophote.kernels.forms.field_data import FIELD_DATA
from isophote.kernels.forms.tape import run_tape
from isophote.kernels.forms.tape_gradient import run_gradients
from isophote.kernels.forms.tape_interval import run_intervals

__all__ = ["INTERPRETERS", "bounds_on", "gradients_on", "pack_interpreters", "values_on"]

# Addresses of the entries below.
INTERPRETERS = Table("Interpreters", values=INT, bounds=INT, gradients=INT)

# Views of an entry's arguments have no bounds, so that their length does not matter.
_ANY = np.int64(1 << 40)
_NO_RESULT = np.int64(0)
_ONE_VECTOR = np.int64(1)

open_data_at = opener_at(FIELD_DATA)


@entry
def _values(rows, first, count, data, slots):
    run_tape(ints_at(rows, _ANY), first, count, open_data_at(data), floats_at(slots, _ANY), _ONE_VECTOR)
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


def pack_interpreters(compiled: bool = True):
    """The addresses as a table; zeros, and nothing compiled, where they are not needed."""
    entries = {"values": _values, "bounds": _bounds, "gradients": _gradients}
    return INTERPRETERS.pack(**{name: each.address if compiled else 0 for name, each in entries.items()})


@device
def values_on(interpreters, rows, first, count, data, slots):
    """`run_tape` at sixteen points."""
    arguments = element_address(rows, 0), first, count, table_address(data), element_address(slots, 0)
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
