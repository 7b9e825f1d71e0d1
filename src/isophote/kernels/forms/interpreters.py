"""The interpreters of tapes as they are called by their addresses, by kernels that follow rays or ask for values."""

from __future__ import annotations

from isophote.kernels.base.entry import call_entry, element_address, table_address
from isophote.kernels.base.jit import device
from isophote.kernels.base.table import INT, Table

__all__ = ["INTERPRETERS", "bounds_on", "gradients_on", "open_interpreters", "values_on"]

# Addresses of the entries in tape_entries.py; zeros where a scene has no fields.
INTERPRETERS = Table("Interpreters", values=INT, bounds=INT, gradients=INT)

open_interpreters = INTERPRETERS.open


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
