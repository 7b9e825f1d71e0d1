"""The 4 × 4 × 4 cells of a cube that a ray goes through, all at once.

Coordinates are mirrored so that the ray goes up along every axis. Then cells in the order of their numbers
x + 4 y + 16 z are in an order in which the ray meets them, and a set of cells is 64 bits. The planes between cells lie
at whole numbers, and the place at which the ray crosses one is computed in one way only: so cells leave no gap between
them, whatever the rounding.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.field_layout import LEAVES_AT
from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import bits, load16, maximum, minimum, splat16, store16

__all__ = ["cells_met", "mirrored"]

_LAYER, _LEAVES = np.int64(16), np.int64(LEAVES_AT)
_ZERO, _ONE = np.float32(0), np.float32(1)
# Numbers along x and y of the sixteen cells of a layer.
_COLUMNS = np.concatenate([np.tile(np.arange(4), 4), np.repeat(np.arange(4), 4)]).astype(np.float32)

# Numbers change by `number ^ mirror`, where 3, 12 and 48 stand for the axes; sets of bits by swapping neighbours, pairs
# and so on.
_X, _Y, _Z = np.int64(3), np.int64(12), np.int64(48)
_ONES, _PAIRS, _FOURS, _BYTES, _HALVES, _LOW = (
    np.int64(word)
    for word in (
        0x5555555555555555,
        0x3333333333333333,
        0x0F0F0F0F0F0F0F0F,
        0x00FF00FF00FF00FF,
        0x0000FFFF0000FFFF,
        0x00000000FFFFFFFF,
    )
)


@device
def _swapped(cells, mask, shift):
    return ((cells >> shift) & mask) | ((cells & mask) << shift)


@device
def mirrored(cells, mirror):
    """A set of cells, with those numbered `n` become `n ^ mirror`."""
    x = _swapped(_swapped(cells, _ONES, np.int64(1)), _PAIRS, np.int64(2))
    cells = x if mirror & _X else cells
    y = _swapped(_swapped(cells, _FOURS, np.int64(4)), _BYTES, np.int64(8))
    cells = y if mirror & _Y else cells
    z = _swapped(_swapped(cells, _HALVES, np.int64(16)), _LOW, np.int64(32))
    return z if mirror & _Z else cells


@device
def cells_met(walk, x, y, z, width, cells, base):
    """The set of cells, `width` wide and from the corner (x, y, z) on, that a ray goes through. Where it enters and
    leaves each goes to `cells`, from `base` and `base` + LEAVES_AT on."""
    planes = load16(_COLUMNS, 0) * splat16(width) + splat16(x)
    near = (planes - splat16(walk.x)) * splat16(walk.ix)
    far = (planes + splat16(width) - splat16(walk.x)) * splat16(walk.ix)
    planes = load16(_COLUMNS, _LAYER) * splat16(width) + splat16(y)
    near = maximum(near, (planes - splat16(walk.y)) * splat16(walk.iy))
    far = minimum(far, (planes + splat16(width) - splat16(walk.y)) * splat16(walk.iy))
    near, far = maximum(near, splat16(_ZERO)), minimum(far, splat16(walk.end))
    met = np.int64(0)
    for layer in range(4):
        plane = z + np.float32(layer) * width
        enter = maximum(near, splat16((plane - walk.z) * walk.iz))
        leave = minimum(far, splat16((plane + width - walk.z) * walk.iz))
        store16(cells, base + layer * _LAYER, enter)
        store16(cells, base + _LEAVES + layer * _LAYER, leave)
        met |= np.int64(bits(enter < leave)) << (layer * _LAYER)
    return met
