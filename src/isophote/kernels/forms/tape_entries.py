"""The interpreters of tapes as entries: compiled once for all kernels that call them by address (interpreters.py)."""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.entry import entry, floats_at, ints_at, opener_at
from isophote.kernels.base.table import Packed
from isophote.kernels.forms import opcodes as op
from isophote.kernels.forms.field_data import FIELD_DATA
from isophote.kernels.forms.interpreters import INTERPRETERS
from isophote.kernels.forms.tape import run_tape
from isophote.kernels.forms.tape_gradient import run_gradients
from isophote.kernels.forms.tape_interval import run_intervals

__all__ = ["pack_interpreters"]

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


def pack_interpreters(chosen: tuple[int, ...] = (op.VALUES, op.INTERVALS, op.GRADIENTS)) -> Packed:
    """The addresses of the chosen entries, which are compiled, or loaded, if they were not yet; zeros for the
    others."""
    entries = {"values": _values, "bounds": _bounds, "gradients": _gradients}
    return INTERPRETERS.pack(**{name: e.address if k in chosen else 0 for k, (name, e) in enumerate(entries.items())})
