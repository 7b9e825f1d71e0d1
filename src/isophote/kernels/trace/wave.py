"""A wave: some hundred paths that take each step together.

Every step of a path tracer is a loop over the wave, so that sampling, which is plain arithmetic, runs eight or more
paths at a time, while tracing and shading go ray by ray. Paths that end are squeezed out: the first `n` columns
are always the living ones. Rows of the float state are below; whole numbers have rows of their own.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from isophote.kernels.accel.geometry import SCRATCH_WORDS, Hit
from isophote.kernels.base import table
from isophote.kernels.base.jit import device
from isophote.kernels.base.table import Packed
from isophote.kernels.base.vec import vec3
from isophote.kernels.light.light_tree_layout import ASK_WORDS

__all__ = [
    "WAVE",
    "add_radiance",
    "hit_of",
    "new_wave",
    "row_vec3",
    "set_row_vec3",
]

# Float rows of three: ray origin, ray direction, what the path carries (β), radiance gathered by the path in the same
# column of the wave's start, shadow ray's origin and direction, and what its light would add.
ORIGIN, DIRECTION, CARRIED, RADIANCE, SHADOW_ORIGIN, SHADOW_DIRECTION, SHADOW_LIGHT = 0, 3, 6, 9, 12, 15, 18
# Single rows: density of the last scattering (0: none, or a single direction), shadow ray's end, hit (its t is the
# limit of the search before it), sample numbers
# for the film and lens, or for picking a light and ending the path, for a place on the light, and for scattering.
DENSITY, SHADOW_END, HIT_T, HIT_W1, HIT_W2 = 21, 22, 23, 24, 25
PICK_U, PICK_V, LIGHT_U, LIGHT_V, SCATTER_U, SCATTER_V = 26, 27, 28, 29, 30, 31
# Three rows: the normal by which lights were picked where the ray begins (light_tree_layout.py).
FROM_NORMAL = 32
# Share of a shadow ray's light that cut-outs leave, where the scene has any (holes.py).
LEFT = 35
# The ray's cone (cone.py).
WIDTH, SPREAD = 36, 37
# Numbers by which rays fly through air that scatters (air_rays.py).
FLIGHT_U, FLIGHT_V = 38, 39
# Three rows: shares of the channels in the density of the path that began in this column, 1 on the average.
SHARES = 40
FLOAT_COUNT = 43

# Unsigned rows: the pixel's number for sampling, sample, column of the path at the wave's start, the same for its
# shadow ray, whether that is blocked, the place on the film of the path that began in this column, and the medium that
# the shadow ray of a path goes through.
PIXEL, SAMPLE, OWNER, SHADOW_OWNER, BLOCKED, PLACE, SHADOW_MEDIUM = 0, 1, 2, 3, 4, 5, 6
INT_COUNT = 7

# Long rows: slot and instance of the hit, order in which packets take rays, media that the ray is in (medium.py).
HIT_SLOT, HIT_INSTANCE, ORDER, INSIDE = 0, 1, 2, 3
LONG_COUNT = 4

# Columns that are worked on at once, and rows for what is found of them.
LANES, LANE_ROWS = np.int64(16), 48
# Floats in a line of the processor's memory, which what primitives keep in the scratch shall not cross.
_LINE = 16


# `floats`, `ints`, `longs`: the rows above; `scratch` for the traversal; `ask`: what a light tree is asked; `lanes`:
# what is worked out for sixteen columns at a time (matte_lanes.py).
WAVE = table.Table(
    "Wave",
    floats=table.FLOAT_ROWS,
    ints=table.WORD_ROWS,
    longs=table.LONG_ROWS,
    scratch=table.FLOATS,
    ask=table.FLOATS,
    lanes=table.FLOAT_ROWS,
)


def _aligned(words: int) -> npt.NDArray[np.float32]:
    """So many zeros from the start of a line of the processor's memory on."""
    wide = np.zeros(words + _LINE, np.float32)
    first = -(wide.ctypes.data // wide.itemsize) % _LINE
    return wide[first : first + words]


def new_wave(size: int, scratch: int = SCRATCH_WORDS) -> Packed:
    """Scratch for waves of `size` paths, made whole sixteens, with so many words for traversals; one a thread."""
    size = -(-size // int(LANES)) * int(LANES)
    return WAVE.pack(
        floats=np.zeros((FLOAT_COUNT, size), np.float32),
        ints=np.zeros((INT_COUNT, size), np.uint32),
        longs=np.zeros((LONG_COUNT, size), np.int64),
        scratch=_aligned(scratch),
        ask=np.zeros(ASK_WORDS, np.float32),
        lanes=_aligned(LANE_ROWS * int(LANES)).reshape(LANE_ROWS, int(LANES)),
    )


@device
def row_vec3(floats, row, i):
    """The vector in rows `row` to `row + 2` of column `i`."""
    return vec3(floats[row, i], floats[row + 1, i], floats[row + 2, i])


@device
def set_row_vec3(floats, row, i, v):
    """Store a vector in rows `row` to `row + 2` of column `i`."""
    floats[row, i] = v.x
    floats[row + 1, i] = v.y
    floats[row + 2, i] = v.z


@device
def hit_of(wave, i):
    """The `Hit` in column `i`."""
    floats, longs = wave.floats, wave.longs
    return Hit(floats[HIT_T, i], floats[HIT_W1, i], floats[HIT_W2, i], longs[HIT_SLOT, i], longs[HIT_INSTANCE, i])


@device
def add_radiance(wave, owner, radiance):
    """Add to what the path that began in column `owner` has gathered."""
    floats = wave.floats
    floats[RADIANCE, owner] += radiance.x
    floats[RADIANCE + 1, owner] += radiance.y
    floats[RADIANCE + 2, owner] += radiance.z
