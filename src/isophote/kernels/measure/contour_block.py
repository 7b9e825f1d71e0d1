"""A block of 8³ cells: samples of a field, and the crossings of the grid's edges."""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import device, exact_apart
from isophote.kernels.base.simd import bits, load16, lowest_bit, splat16, store16
from isophote.kernels.forms.interpreters import values_on
from isophote.kernels.forms.opcodes import INPUTS
from isophote.kernels.measure.contour_tables import BLOCK, BLOCK_SAMPLES, ELSEWHERE, POINTS, WIDTH

__all__ = ["find_crossed_edges", "sample_block"]

_SIDE = np.int64(BLOCK + 1)
_LAYER = _SIDE * _SIDE
_WIDTH, _STRIDE = np.int64(WIDTH), np.int64(16 * WIDTH)
_ALL = np.int32(0xFFFF)
_ZERO = np.float32(0)
_ELSEWHERE = np.int32(ELSEWHERE)
_X, _Y, _Z = np.int64(0), np.int64(1), np.int64(2)
_FIRST_ROW = np.int64(0)


@device
def _place_samples(grid, points, i, j, k):
    """The samples' coordinates; rows of nine are written sixteen at a time, the next row over the rest of the last."""
    xs = load16(grid.xs, i)
    at = _X
    for z in range(_SIDE):
        zs = splat16(grid.zs[k + z])
        for y in range(_SIDE):
            store16(points, at, xs)
            store16(points, POINTS + at, splat16(grid.ys[j + y]))
            store16(points, 2 * POINTS + at, zs)
            at += _SIDE
    for axis in range(INPUTS):
        last = splat16(points[axis * POINTS + BLOCK_SAMPLES - 1])
        store16(points, axis * POINTS + BLOCK_SAMPLES, last)
        store16(points, axis * POINTS + POINTS - 32, last)
        store16(points, axis * POINTS + POINTS - 16, last)


@exact_apart
def sample_block(grid, work, count, i, j, k):
    """The values at the samples of the block at cell (i, j, k), by the tape in `work.leaf`; False if one is NaN."""
    _place_samples(grid, work.points, i, j, k)
    result = (INPUTS - 1 + count) * _STRIDE
    numbers = _ALL
    for start in range(0, POINTS, 16 * WIDTH):
        for axis in range(INPUTS):
            for lane in range(0, 16 * WIDTH, 16):
                store16(work.slots, axis * _STRIDE + lane, load16(work.points, axis * POINTS + start + lane))
        values_on(grid.interpreters, work.leaf, _FIRST_ROW, count, work.data, work.slots, _WIDTH)
        for lane in range(0, 16 * WIDTH, 16):
            v = load16(work.slots, result + lane)
            store16(work.values, start + lane, v)
            work.signs[(start + lane) >> 4] = bits(v < splat16(_ZERO))
            numbers &= bits(v == v)
    for row in range(_LAYER):
        bit = row * _SIDE
        pair = work.signs[bit >> 4] | work.signs[(bit >> 4) + 1] << 16
        work.rows_of_signs[row] = pair >> np.int32(bit & 15) & np.int32((1 << _SIDE) - 1)
    return numbers == _ALL


@device
def _add_edges(work, crossed, axis, y, z, count):
    """Number the edges along an axis that start at the samples of set bits of a row."""
    start, corner = axis * BLOCK_SAMPLES + (z * _SIDE + y) * _SIDE, axis << 12 | z << 8 | y << 4
    while crossed != 0:
        x = np.int64(lowest_bit(crossed))
        crossed &= crossed - np.int32(1)
        work.starts[count], work.corners[count] = np.int32(start + x), np.int32(corner + x)
        work.crossing_of[start + x] = np.int32(count)
        count += 1
    return count


@exact_apart
def find_crossed_edges(work):
    """List the edges of the block between samples of unlike signs, in `work.starts`: axis · BLOCK_SAMPLES + sample."""
    signs = work.rows_of_signs
    count = _X
    inner = np.int32((1 << BLOCK) - 1)
    for z in range(_SIDE):
        for y in range(_SIDE):
            here = signs[z * _SIDE + y]
            count = _add_edges(work, np.int32((here ^ here >> 1) & inner), _X, y, z, count)
    for z in range(_SIDE):
        for y in range(BLOCK):
            row = z * _SIDE + y
            count = _add_edges(work, np.int32(signs[row] ^ signs[row + 1]), _Y, y, z, count)
    for z in range(BLOCK):
        for y in range(_SIDE):
            row = z * _SIDE + y
            count = _add_edges(work, np.int32(signs[row] ^ signs[row + _SIDE]), _Z, y, z, count)
    for entry in range(4 * count):
        work.around[entry] = _ELSEWHERE
    return count
