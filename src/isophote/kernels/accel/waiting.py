"""Trees of which parts wait to be built until rays come to them, as the walks through trees see them.

A leaf of no blocks is such a part: its code says −1 − 8 · part. A walk notes the first that it comes to, which is the
nearest, and goes on as if nothing were there. At its end it has the part finished, which puts another code in the place
of the leaf's, and begins anew with what it has found. So the innermost loop has nothing to call, and where rays meet
something before a part, it stays as it is.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from isophote.kernels.base.entry import call_entry
from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import load_int, store_int

__all__ = ["Waiting", "finish_noted", "note_none", "note_part", "waits"]

_NONE, _BLOCKS = np.int32(0), np.int64(7)


class Waiting(NamedTuple):
    """Who finishes parts: the address of the entry finish(tables, part), and of the tables that it is given."""

    finish: int
    tables: int


@device
def note_none(parts, scratch, word):
    """No part is noted in word `word` of a walk's scratch; `parts` is None where all are finished."""
    if parts is not None:
        store_int(scratch, word, _NONE)


@device
def waits(parts, code):
    """Whether the leaf of a number, which is −1 − what stands in the node, is a part that waits."""
    if parts is None:
        return False
    return code & _BLOCKS == 0


@device
def note_part(code, scratch, word):
    """Note a part, given as for `waits`, if it is the first."""
    if load_int(scratch, word) == _NONE:
        store_int(scratch, word, np.int32((code >> 3) + 1))


@device
def finish_noted(parts, scratch, word):
    """Have the part finished that is noted; False where there is none."""
    if parts is None:
        return False
    part = np.int64(load_int(scratch, word)) - 1
    if part < 0:
        return False
    call_entry(parts.finish, (parts.tables, part))
    store_int(scratch, word, _NONE)
    return True
