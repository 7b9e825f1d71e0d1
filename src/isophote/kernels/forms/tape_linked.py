"""The interpreters of tapes as kernels to be called by their addresses, so that few kernels contain them."""

from __future__ import annotations

from isophote.kernels.base.jit import kernel
from isophote.kernels.base.linked import opener_at
from isophote.kernels.base.table import FLOATS, INTS, Table
from isophote.kernels.forms.field_data import FIELD_DATA
from isophote.kernels.forms.tape import run_tape
from isophote.kernels.forms.tape_gradient import run_gradients
from isophote.kernels.forms.tape_interval import run_intervals

__all__ = ["TAPE_RUN", "gradients", "intervals", "values"]

# What a run reads and writes: a tape's rows and their data, the slots, and the choices of intervals.
TAPE_RUN = Table("TapeRun", rows=INTS, data=FIELD_DATA, slots=FLOATS, choices=INTS)

_open_at = opener_at(TAPE_RUN)


@kernel
def values(run, first, count, width):
    """`run_tape` over the TAPE_RUN at the address `run`."""
    t = _open_at(run)
    run_tape(t.rows, first, count, t.data, t.slots, width)
    return 0


@kernel
def intervals(run, first, count, unused):
    """`run_intervals` over the TAPE_RUN at the address `run`."""
    t = _open_at(run)
    run_intervals(t.rows, first, count, t.data, t.slots, t.choices)
    return unused


@kernel
def gradients(run, first, count, unused):
    """`run_gradients` over the TAPE_RUN at the address `run`."""
    t = _open_at(run)
    run_gradients(t.rows, first, count, t.data, t.slots)
    return unused
