"""What a hit on a primitive says about the surface: place, normal, error, texture coordinates."""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.base.doubles import doubles_at
from isophote.kernels.base.entry import call_entry, element_address, entry, floats_at, opener_at
from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import load_int
from isophote.kernels.primitive import layout
from isophote.kernels.primitive.layout import PRIMITIVES
from isophote.kernels.primitive.line import placed

__all__ = ["primitive_surface"]

_ONE, _WORD = 1.0, np.int64(4)
# A place is rounded to single precision, moved off the surface, and rounded again, each by half a unit in the last
# place of each coordinate, which along the normal come to √3 times as much at most; and the next ray must start as far
# off as that again.
_PLACE_ERROR = 8 * 2.0**-24
# How many of its errors a place keeps from the rim of its part.
_FROM_RIM = 4.0

open_primitives_at = opener_at(PRIMITIVES)


@device
def _along_normal(m, k, line):
    """The normal in the world: it goes by the transposed inverse."""
    x, y, z = line[layout.NORMAL], line[layout.NORMAL + 1], line[layout.NORMAL + 2]
    nx = m[k, 0] * x + m[k, 4] * y + m[k, 8] * z
    ny = m[k, 1] * x + m[k, 5] * y + m[k, 9] * z
    nz = m[k, 2] * x + m[k, 6] * y + m[k, 10] * z
    inverse = _ONE / math.sqrt(nx * nx + ny * ny + nz * nz)
    return nx * inverse, ny * inverse, nz * inverse


@entry
def primitive_surface(primitives_address, scratch_address):
    """Place, outward unit normal, error and texture coordinates of a hit.

    Words of the scratch: the ray's origin and direction, t, and as int32 the numbers of the primitive and of the part
    of its surface. The first nine become what is told.
    """
    primitives = open_primitives_at(primitives_address)
    words = floats_at(scratch_address, np.int64(layout.RAY_WORDS))
    line = doubles_at(scratch_address + _WORD * layout.LINE_AT, np.int64(layout.WORDS))
    k, part = np.int64(load_int(words, np.int64(7))), np.int64(load_int(words, np.int64(8)))
    t = np.float64(words[6])
    x, y, z = words[0] + t * words[3], words[1] + t * words[4], words[2] + t * words[5]
    reach = max(abs(x), max(abs(y), abs(z)))
    error = _PLACE_ERROR * reach + np.float64(primitives.reach[k, layout.ERROR])
    line[layout.PART] = np.float64(part)
    line[layout.SLACK] = _FROM_RIM * error * np.float64(primitives.reach[k, layout.STRETCH])
    line[layout.PLACE], line[layout.PLACE + 1], line[layout.PLACE + 2] = placed(primitives.to_object, k, x, y, z, _ONE)
    own = element_address(primitives.values, np.int64(primitives.numbers[k, layout.FIRST]))
    call_entry(primitives.entries[k, layout.DESCRIBE], (own, element_address(line, np.int64(0))))
    px, py, pz = placed(
        primitives.to_world, k, line[layout.PLACE], line[layout.PLACE + 1], line[layout.PLACE + 2], _ONE
    )
    words[0], words[1], words[2] = px, py, pz
    words[3], words[4], words[5] = _along_normal(primitives.to_object, k, line)
    words[6], words[7], words[8] = error, line[layout.UV], line[layout.UV + 1]
    return np.int64(0)
