"""How functions of tables read their arguments from slots and write what they give, one point or region at a time."""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import load_float, store_float
from isophote.kernels.forms.tape_gradient import GRADIENT_SLOT
from isophote.kernels.forms.tape_interval import REGION_HIGH, REGION_MIDDLE

__all__ = ["ANY", "LANES", "reach_of", "store_around", "store_gradient"]

# The length of views into slots, which have no bounds.
ANY = np.int64(0)
LANES = 16

_STEP = np.float32(1 + 2.0**-20)


@device
def reach_of(slots, a, i):
    """How far an argument is from its value at region i's middle, at most."""
    middle = load_float(slots, a + REGION_MIDDLE + i)
    return max(middle - load_float(slots, a + i), load_float(slots, a + REGION_HIGH + i) - middle)


@device
def store_around(slots, out, i, value, spread):
    """Bounds of region i: no farther than `spread` from the value at the middle."""
    store_float(slots, out + i, value - spread * _STEP)
    store_float(slots, out + REGION_MIDDLE + i, value)
    store_float(slots, out + REGION_HIGH + i, value + spread * _STEP)


@device
def store_gradient(slots, out, i, value, arguments, slopes):
    """The value at point i, and its derivatives, from those by its three arguments."""
    for part in range(LANES, GRADIENT_SLOT, LANES):
        total = np.float32(0)
        for k in range(3):
            total += slopes[k] * load_float(slots, arguments[k] + part + i)
        store_float(slots, out + part + i, total)
    store_float(slots, out + i, value)
