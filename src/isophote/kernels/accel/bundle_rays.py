"""Rays of a bundle (bundle.py): their scratch, what is worked out for sixteen at once, and single ones again."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from isophote.kernels.accel.bvh import Slabs
from isophote.kernels.accel.layout import LANES, MAX_DEPTH, STACK, UPPER, WIDTH
from isophote.kernels.accel.spread import LARGEST, LEAST_SHARE, PLACE_SLACK, TINY
from isophote.kernels.base.bit_set import leading
from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import (
    absolute,
    least,
    load16,
    load_float,
    maximum,
    minimum,
    select,
    splat8,
    splat16,
    store16,
    store_float,
)
from isophote.kernels.forms.triangle import Shear

__all__ = [
    "BUNDLE",
    "BUNDLE_SCRATCH",
    "CORNERS",
    "FIRST_ENTRY",
    "GROUP",
    "GROUPS",
    "INVERSE",
    "LANES_OF_GROUP",
    "NO_RAYS",
    "ONE_RAY",
    "PLANES",
    "ROW",
    "SHEARS",
    "SINGLES",
    "Bundle",
    "Cone",
    "prepare_bundle",
    "set_direction_of_bundle",
    "sheared_ray",
    "slabs_of_ray",
]

# Rays of a bundle, and of a group: one register of theirs.
BUNDLE = 64
GROUP = 16
GROUPS = np.int64(BUNDLE // GROUP)
LANES_OF_GROUP = np.int64(0xFFFF)

# Rows of the scratch, BUNDLE words each: directions, 1/d, o/d moved outward on both sides, shears.
_DIRECTIONS, INVERSE, _ENTER, _LEAVE, SHEARS = (np.int64(row * BUNDLE) for row in (0, 3, 6, 9, 12))
ROW = np.int64(BUNDLE)
# Planes of a node's boxes from the origin, corners of a block's triangles from there, sets of rays that enter the
# children, then the stacks: of the bundle, whose entries are a code and a set, and of single rays.
PLANES = np.int64(15 * BUNDLE)
CORNERS = np.int64(15 * BUNDLE + 6 * WIDTH)
FIRST_ENTRY = np.int64(15 * BUNDLE + 6 * WIDTH + 9 * LANES)
SINGLES = np.int64(15 * BUNDLE + 6 * WIDTH + 9 * LANES + 3 * (WIDTH - 1) * (MAX_DEPTH + 4))
BUNDLE_SCRATCH = 15 * BUNDLE + 6 * WIDTH + 9 * LANES + 3 * (WIDTH - 1) * (MAX_DEPTH + 4) + STACK

_ZERO, _ONE = np.float32(0), np.float32(1)
NO_RAYS, ONE_RAY = np.int64(0), np.int64(1)
# Rounding of n · d, for vectors of length 1.
_COSINE_SLACK = np.float32(2.0**-21)


class Cone(NamedTuple):
    """What rays can reach at all: the normal n; c where it is positive, and −c where it is not; how uncertain places
    are."""

    nx: float
    ny: float
    nz: float
    above: float
    below: float
    place: float


class Bundle(NamedTuple):
    """The origin, the rays whose directions are longest along x, y and z, their cone, and where they end."""

    origin: object
    along_x: int
    along_y: int
    along_z: int
    cone: Cone
    limit: float


@device
def set_direction_of_bundle(scratch, column, direction):
    """Write the direction of ray `column`, of length 1."""
    store_float(scratch, _DIRECTIONS + column, direction.x)
    store_float(scratch, _DIRECTIONS + ROW + column, direction.y)
    store_float(scratch, _DIRECTIONS + 2 * ROW + column, direction.z)


@device
def _finite(x):
    widest = splat16(LARGEST)
    return maximum(minimum(x, widest), splat16(_ZERO) - widest)


@device
def _prepare_axis(scratch, at, row, d, smallest, origin, place):
    """Rows of 1/d and o/d of one axis (spread.py)."""
    zero = splat16(_ZERO)
    safe = select(absolute(d) > smallest, d, select(d >= zero, smallest, zero - smallest))
    inverse = splat16(_ONE) / safe
    along = _finite(splat16(origin) * inverse)
    slack = _finite(splat16(place) * absolute(inverse))
    store16(scratch, INVERSE + row + at, inverse)
    store16(scratch, _ENTER + row + at, along + slack)
    store16(scratch, _LEAVE + row + at, along - slack)


@device
def _prepare_group(scratch, at, origin, normal, place):
    """Write the rows that are told by the directions of the sixteen rays from column `at` on; the least n · d."""
    x, y, z = (
        load16(scratch, _DIRECTIONS + at),
        load16(scratch, _DIRECTIONS + ROW + at),
        load16(scratch, _DIRECTIONS + 2 * ROW + at),
    )
    ax, ay, az = absolute(x), absolute(y), absolute(z)
    smallest = maximum(maximum(ax, maximum(ay, az)) * splat16(LEAST_SHARE), splat16(TINY))
    _prepare_axis(scratch, at, np.int64(0), x, smallest, origin.x, place)
    _prepare_axis(scratch, at, ROW, y, smallest, origin.y, place)
    _prepare_axis(scratch, at, 2 * ROW, z, smallest, origin.z, place)
    # As `shear` in forms/triangle.py, lane by lane.
    on_x, on_y = (ax >= ay) & (ax >= az), ay >= az
    scale = splat16(_ONE) / select(on_x, x, select(on_y, y, z))
    store16(scratch, SHEARS + at, select(on_x, y, select(on_y, z, x)) * scale)
    store16(scratch, SHEARS + ROW + at, select(on_x, z, select(on_y, x, y)) * scale)
    store16(scratch, SHEARS + 2 * ROW + at, scale)
    return least(splat16(normal.x) * x + splat16(normal.y) * y + splat16(normal.z) * z)


@device
def prepare_bundle(scratch, count, along_x, along_y, origin, normal, limit, reach):
    most = max(reach, max(abs(origin.x), max(abs(origin.y), abs(origin.z))))
    place = min(most * PLACE_SLACK, LARGEST)
    cosine = _ONE
    for column in range(count, (count + (GROUP - 1)) // GROUP * GROUP):
        for row in range(3):
            store_float(scratch, _DIRECTIONS + row * ROW + column, load_float(scratch, _DIRECTIONS + row * ROW))
    for at in range(0, count, GROUP):
        cosine = min(cosine, _prepare_group(scratch, at, origin, normal, place))
    cosine -= _COSINE_SLACK
    cone = Cone(normal.x, normal.y, normal.z, max(cosine, _ZERO), max(-cosine, _ZERO), place)
    x, y = leading(along_x), leading(along_x + along_y)
    return Bundle(origin, x, y & ~x, leading(count) & ~y, cone, limit)


@device
def _along(vector, axis):
    return vector.x if axis == 0 else (vector.y if axis == 1 else vector.z)


@device
def sheared_ray(scratch, bundle, i):
    """Ray `i` made ready for triangles."""
    ray = ONE_RAY << i
    kz = np.int64(0 if bundle.along_x & ray != 0 else (1 if bundle.along_y & ray != 0 else 2))
    kx = np.int64(kz + 1 if kz < 2 else 0)
    ky = np.int64(kx + 1 if kx < 2 else 0)
    o = bundle.origin
    return Shear(
        kx,
        ky,
        kz,
        splat8(_along(o, kx)),
        splat8(_along(o, ky)),
        splat8(_along(o, kz)),
        splat8(load_float(scratch, SHEARS + i)),
        splat8(load_float(scratch, SHEARS + ROW + i)),
        splat8(load_float(scratch, SHEARS + 2 * ROW + i)),
    )


@device
def slabs_of_ray(scratch, i):
    """Ray `i` made ready for boxes."""
    ix, iy, iz = (
        load_float(scratch, INVERSE + i),
        load_float(scratch, INVERSE + ROW + i),
        load_float(scratch, INVERSE + 2 * ROW + i),
    )
    return Slabs(
        np.int64(0 if ix >= _ZERO else UPPER),
        np.int64(8 if iy >= _ZERO else UPPER + 8),
        np.int64(16 if iz >= _ZERO else UPPER + 16),
        splat8(ix),
        splat8(iy),
        splat8(iz),
        splat8(load_float(scratch, _ENTER + i)),
        splat8(load_float(scratch, _ENTER + ROW + i)),
        splat8(load_float(scratch, _ENTER + 2 * ROW + i)),
        splat8(load_float(scratch, _LEAVE + i)),
        splat8(load_float(scratch, _LEAVE + ROW + i)),
        splat8(load_float(scratch, _LEAVE + 2 * ROW + i)),
    )
