"""Sixteen rays against a primitive at once: rows of LANES doubles, over which loops become vector instructions.

Rows of a block: origins X, Y, Z and directions U, V, W in the primitive's own space, HIGH, the limit of t, and what is
found at 0 < t < HIGH: T, infinite for nothing, and PART; then rows of a kind's own. Loops over them have no branches:
what one ray needs and another does not is worked out for both, and chosen. They are given how many rays there are,
though there are always LANES, since loops of a known length are taken apart before they could become vectors.
"""

from __future__ import annotations

import math

import numpy as np
from numba import types
from numba.extending import intrinsic

from isophote.kernels.base.jit import device

__all__ = [
    "BLOCK_DOUBLES",
    "HIGH",
    "LANES",
    "OWN",
    "PART",
    "T",
    "U",
    "V",
    "W",
    "X",
    "Y",
    "Z",
    "chosen",
    "keep_crossing",
    "keep_first_end",
    "keep_within_lids",
]

LANES = 16
X, Y, Z, U, V, W, HIGH, T, PART, OWN = (np.int64(LANES * row) for row in range(10))
BLOCK_DOUBLES = np.int64(LANES * 23)

_FAR, _NOTHING, _WHOLE = math.inf, 0.0, 1.0
_SIDE, _TOP, _BOTTOM = 0.0, 1.0, 2.0


@intrinsic
def chosen(typingctx, condition, a, b):
    """`a` where a condition holds, else `b`: both are there, and nothing branches."""

    def codegen(context, builder, signature, args):
        return builder.select(*args)

    return types.float64(types.boolean, types.float64, types.float64), codegen


@device
def keep_crossing(block, lane, t, met):
    """Write down the one crossing of a surface, if it is `met` there."""
    block[T + lane] = t if met & (t > _NOTHING) & (t < block[HIGH + lane]) else _FAR
    block[PART + lane] = _NOTHING


@device
def keep_first_end(block, lane, enter, leave, first, last):
    """Write down which end of the stretch that a ray is within a convex solid it comes to first; `first` and `last` are
    the parts there."""
    outside = enter > _NOTHING
    t = enter if outside else leave
    met = (enter <= leave) & (t > _NOTHING) & (t < block[HIGH + lane])
    block[T + lane] = t if met else _FAR
    block[PART + lane] = first if outside else last


@device
def keep_within_lids(block, lane, enter, leave):
    """As line.within_lids, for the first crossing of one of sixteen rays."""
    inverse = _WHOLE / block[V + lane]
    low, high = (-_WHOLE - block[Y + lane]) * inverse, (_WHOLE - block[Y + lane]) * inverse
    upward = inverse > _NOTHING
    near, far = (low, high) if upward else (high, low)
    below, above = (_BOTTOM, _TOP) if upward else (_TOP, _BOTTOM)
    # A NaN end, of a line that passes by the side, must stay.
    first, last = (below if near > enter else _SIDE), (above if far < leave else _SIDE)
    keep_first_end(block, lane, near if near > enter else enter, far if far < leave else leave, first, last)
