"""Rays of a wave that share their origins, up to 64 through the tree at a time."""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.bundle import blocked_of_bundle
from isophote.kernels.accel.bundle_rays import BUNDLE, set_direction_of_bundle
from isophote.kernels.base.bit_set import first_of, leading
from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import absolute, bits, load16, select, splat16
from isophote.kernels.trace import wave as rows
from isophote.kernels.trace.wave import row_vec3

__all__ = ["blocked_in_bundles", "in_bundles"]

_BUNDLE, _ONE_RAY, _NO_RAYS = np.int64(BUNDLE), np.int64(1), np.int64(0)
_LANES, _DIRECTION = np.int64(16), np.int64(rows.SHADOW_DIRECTION)
_ZERO = np.float32(0)


@device
def in_bundles(geometry):
    """Whether rays can go in bundles: through trees that are finished, and for one object."""
    tree = geometry.closest == 0 and geometry.finish == 0
    return geometry.top_nodes.rows == 0 and tree and geometry.blocks.rows > 0


@device
def blocked_in_bundles(geometry, wave, origin, normal, limit, first, last):
    """Whether each shadow ray of columns first ≤ i < last meets a triangle at 0 < t < limit, 0 or 1 in its row BLOCKED.
    All start at `origin`; most directions, which are of length 1, lie above the unit vector `normal`."""
    for begin in range(first, last, _BUNDLE):
        _blocked_in_bundle(geometry, wave, origin, normal, limit, begin, min(begin + _BUNDLE, last))


@device
def _blocked_in_bundle(geometry, wave, origin, normal, limit, first, last):
    along_x, along_y, along_z, down = _faces(wave, first, last)
    # Rays through one side of a cube around the origin together.
    place = _take(wave, first, along_x & ~down, _NO_RAYS)
    place = _take(wave, first, along_x & down, place)
    count_x = place
    place = _take(wave, first, along_y & ~down, place)
    place = _take(wave, first, along_y & down, place)
    count_y = place - count_x
    place = _take(wave, first, along_z & ~down, place)
    _take(wave, first, along_z & down, place)
    nodes, blocks, root = geometry.nodes, geometry.blocks, geometry.roots[0]
    blocked = blocked_of_bundle(
        nodes, blocks, root, origin, normal, limit, last - first, count_x, count_y, wave.scratch
    )
    order, row = wave.longs[rows.ORDER], wave.ints[rows.BLOCKED]
    for i in range(last - first):
        row[order[first + i]] = (blocked >> i) & 1


@device
def _faces(wave, first, last):
    """The rays whose directions are longest along x, y and z, as sets, and those that go down the longest axis."""
    floats, columns = wave.floats, wave.floats.columns
    on_x, on_y, down = _NO_RAYS, _NO_RAYS, _NO_RAYS
    for i in range(first, last, _LANES):
        # What is read beyond the last ray is left out below.
        x, y, z = (
            load16(floats, _DIRECTION * columns + i),
            load16(floats, (_DIRECTION + 1) * columns + i),
            load16(floats, (_DIRECTION + 2) * columns + i),
        )
        ax, ay, az = absolute(x), absolute(y), absolute(z)
        longest_x, longer_y = (ax >= ay) & (ax >= az), ay >= az
        longest = select(longest_x, x, select(longer_y, y, z))
        on_x |= np.int64(bits(longest_x)) << (i - first)
        on_y |= np.int64(bits(longer_y)) << (i - first)
        down |= np.int64(bits(longest < splat16(_ZERO))) << (i - first)
    rays = leading(last - first)
    return on_x & rays, on_y & ~on_x & rays, rays & ~(on_x | on_y), down


@device
def _take(wave, first, rays, place):
    """Copy the directions of some rays into the bundle from column `place` on. Returns the next column."""
    order = wave.longs[rows.ORDER]
    while rays != 0:
        i = first + first_of(rays)
        rays &= rays - _ONE_RAY
        set_direction_of_bundle(wave.scratch, place, row_vec3(wave.floats, rows.SHADOW_DIRECTION, i))
        order[first + place] = i
        place += 1
    return place
