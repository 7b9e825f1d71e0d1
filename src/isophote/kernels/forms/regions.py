"""Regions of the plane or of space that are split into sixteen children at a time, for the interval interpreter.

A split is 4 × 4 children in the plane, or one layer of 4 × 4 of the 4 × 4 × 4 in space. All share their parent's tape,
so one pass bounds them all; those that are not decided get a tape of their own by `shorten`.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import bits, load16, splat16, store_float
from isophote.kernels.forms import opcodes as op
from isophote.kernels.forms.interpreters import bounds_on
from isophote.kernels.forms.tape_interval import REGION_HIGH, REGION_MIDDLE, REGION_SLOT

__all__ = ["REGIONS", "bound_regions", "load_region"]

# Regions of a pass.
REGIONS = 16

_ZERO, _HALF = np.float32(0), np.float32(0.5)


@device
def load_region(slots, region, axis, low, high):
    """Ends of one of sixteen regions along an axis, and its middle."""
    at = np.int64(axis) * REGION_SLOT + np.int64(region)
    store_float(slots, at, low)
    store_float(slots, at + REGION_MIDDLE, low + (high - low) * _HALF)
    store_float(slots, at + REGION_HIGH, high)


@device
def bound_regions(interpreters, rows, first, count, data, slots, choices):
    """(not negative, negative): bits of the loaded regions where a tape's value is proven to be so all over."""
    bounds_on(interpreters, rows, first, count, data, slots, choices)
    result = (np.int64(op.INPUTS) - 1 + count) * REGION_SLOT
    outside = bits(load16(slots, result) >= splat16(_ZERO))
    return outside, bits(load16(slots, result + REGION_HIGH) < splat16(_ZERO))
