"""Where a field is zero on the edges of a grid, and its normals there."""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import device
from isophote.kernels.base.linked import call_linked
from isophote.kernels.base.simd import absolute, bits, load16, maximum, minimum, select, splat16, square_root, store16
from isophote.kernels.forms.opcodes import INPUTS
from isophote.kernels.forms.tape_gradient import GRADIENT_SLOT
from isophote.kernels.measure.contour_tables import BLOCK, BLOCK_SAMPLES, CROSSING, POINTS, WIDTH

__all__ = ["find_roots"]

_SIDE = BLOCK + 1
_BATCH = 16 * WIDTH
# Rows of a batch: starts and lengths of the edges along x, y, z; the bracket (t, f) at both ends; which end moved last;
# the place t along the edge; the difference of the values at the edge's ends.
_STARTS, _STEPS, _TA, _FA, _TB, _FB, _LAST, _T, _RANGE = 0, 3, 6, 7, 8, 9, 10, 11, 12
_MOST_STEPS = 12
# A value this small, relative to the difference along the edge, is left to the last step of Newton's.
_SMALL = np.float32(1e-5)
# Gradients are taken this far inside, in cells: right on the surface, where arms meet, there may be none.
_INWARD = np.float32(2.0**-10)
_ZERO, _HALF, _ONE, _TINY = np.float32(0), np.float32(0.5), np.float32(1), np.float32(1e-30)


@device
def _load_edges(work, begin, size, padded):
    """Fill the batch with edges `begin` and on; the last one fills up the last vector."""
    roots, points = work.roots, work.points
    for lane in range(size):
        start = np.int64(work.starts[begin + lane])
        axis, sample = np.int64(0), start
        end = sample + 1
        if start >= 2 * BLOCK_SAMPLES:
            axis, sample = np.int64(2), start - 2 * BLOCK_SAMPLES
            end = sample + _SIDE * _SIDE
        elif start >= BLOCK_SAMPLES:
            axis, sample = np.int64(1), start - BLOCK_SAMPLES
            end = sample + _SIDE
        for k in range(INPUTS):
            roots[(_STARTS + k) * _BATCH + lane] = points[k * POINTS + sample]
            roots[(_STEPS + k) * _BATCH + lane] = _ZERO
        roots[(_STEPS + axis) * _BATCH + lane] = points[axis * POINTS + end] - points[axis * POINTS + sample]
        roots[_FA * _BATCH + lane], roots[_FB * _BATCH + lane] = work.values[sample], work.values[end]
    for lane in range(size, padded):
        for row in range(_FB + 1):
            roots[row * _BATCH + lane] = roots[row * _BATCH + size - 1]
    for j in range(0, padded, 16):
        store16(roots, _TA * _BATCH + j, splat16(_ZERO))
        store16(roots, _TB * _BATCH + j, splat16(_ONE))
        store16(roots, _LAST * _BATCH + j, splat16(_ZERO))
        store16(roots, _RANGE * _BATCH + j, absolute(_row(roots, _FA, j) - _row(roots, _FB, j)))


@device
def _row(roots, row, j):
    return load16(roots, row * _BATCH + j)


@device
def _secant(roots, j):
    """Next place within the bracket: where the chord is zero, or the middle where there is no such number."""
    ta, fa, tb, fb = _row(roots, _TA, j), _row(roots, _FA, j), _row(roots, _TB, j), _row(roots, _FB, j)
    t = ta + (tb - ta) * (fa / (fa - fb))
    t = select((t >= ta) & (t <= tb), t, (ta + tb) * splat16(_HALF))
    store16(roots, _T * _BATCH + j, t)
    return t


@device
def _narrow(roots, j, f):
    """Put the value at t into the bracket; lanes that are not there yet.

    An end that stays twice in a row has its value halved (Dowell and Jarratt, "A modified regula falsi method", 1971).
    """
    zero, half, one = splat16(_ZERO), splat16(_HALF), splat16(_ONE)
    t, fa, fb, last = _row(roots, _T, j), _row(roots, _FA, j), _row(roots, _FB, j), _row(roots, _LAST, j)
    low = f * fa > zero
    store16(roots, _TA * _BATCH + j, select(low, t, _row(roots, _TA, j)))
    store16(roots, _TB * _BATCH + j, select(low, _row(roots, _TB, j), t))
    store16(roots, _FA * _BATCH + j, select(low, f, select(last < zero, fa * half, fa)))
    store16(roots, _FB * _BATCH + j, select(low, select(last > zero, fb * half, fb), f))
    store16(roots, _LAST * _BATCH + j, select(low, one, zero - one))
    return bits(absolute(f) > splat16(_SMALL) * _row(roots, _RANGE, j))


@device
def _place(roots, axis, j, t):
    return _row(roots, _STARTS + axis, j) + t * _row(roots, _STEPS + axis, j)


@device
def _bracket_roots(grid, work, count, padded):
    """Narrow the brackets of a batch until all values are small."""
    result = (INPUTS - 1 + count) * padded
    for _ in range(_MOST_STEPS):
        for j in range(0, padded, 16):
            t = _secant(work.roots, j)
            for axis in range(INPUTS):
                store16(work.slots, axis * padded + j, _place(work.roots, axis, j, t))
        call_linked(grid.run_values, work.leaf_run, np.int64(0), count, padded // 16)
        open_lanes = np.int32(0)
        for j in range(0, padded, 16):
            open_lanes |= _narrow(work.roots, j, load16(work.slots, result + j))
        if open_lanes == 0:
            break


@device
def _inward(roots, j):
    """Move the places along the edges a little towards their inner ends."""
    zero, one, inward = splat16(_ZERO), splat16(_ONE), splat16(_INWARD)
    t = _row(roots, _T, j)
    moved = select(_row(roots, _FA, j) < zero, maximum(t - inward, zero), minimum(t + inward, one))
    store16(roots, _T * _BATCH + j, moved)
    return moved


@device
def _finish(work, j, result):
    """A last step of Newton's; the place along the edges into the batch, unit normals (or 0) over the gradients."""
    roots, slots = work.roots, work.slots
    f = load16(slots, result)
    gx, gy, gz = load16(slots, result + 16), load16(slots, result + 32), load16(slots, result + 48)
    slope = gx * _row(roots, _STEPS, j) + gy * _row(roots, _STEPS + 1, j) + gz * _row(roots, _STEPS + 2, j)
    t = _row(roots, _T, j)
    better = t - f / slope
    chord = _secant(roots, j)
    fits = (better >= _row(roots, _TA, j)) & (better <= _row(roots, _TB, j))
    store16(roots, _T * _BATCH + j, select(fits, better, chord))
    square = gx * gx + gy * gy + gz * gz
    # Neither a vanishing gradient nor an endless one has a direction.
    known = (square > splat16(_TINY)) & (square < splat16(_ONE / _TINY))
    scale = select(known, splat16(_ONE) / square_root(square), splat16(_ZERO))
    store16(slots, result + 16, select(known, gx * scale, splat16(_ZERO)))
    store16(slots, result + 32, select(known, gy * scale, splat16(_ZERO)))
    store16(slots, result + 48, select(known, gz * scale, splat16(_ZERO)))


@device
def _write_places(work, begin, size, x0, y0, z0):
    """The places of a batch's crossings in the brick, in cells."""
    for lane in range(size):
        start = np.int64(work.starts[begin + lane])
        axis = np.int64(start >= BLOCK_SAMPLES) + np.int64(start >= 2 * BLOCK_SAMPLES)
        sample = start - axis * BLOCK_SAMPLES
        layer, at = sample // (_SIDE * _SIDE), (begin + lane) * CROSSING
        row = sample // _SIDE
        work.crossings[at] = np.float32(x0 + sample - row * _SIDE)
        work.crossings[at + 1] = np.float32(y0 + row - layer * _SIDE)
        work.crossings[at + 2] = np.float32(z0 + layer)
        work.crossings[at + axis] += work.roots[_T * _BATCH + lane]


@device
def _write_normals(grid, work, count, begin, size, j):
    """Gradients at sixteen crossings of a batch, the last step to their places, and their normals."""
    result = (INPUTS - 1 + count) * GRADIENT_SLOT
    t = _inward(work.roots, j)
    for axis in range(INPUTS):
        store16(work.slots, axis * GRADIENT_SLOT, _place(work.roots, axis, j, t))
    call_linked(grid.run_gradients, work.leaf_run, np.int64(0), count, np.int64(0))
    _finish(work, j, result)
    for lane in range(min(np.int64(16), size - j)):
        at = (begin + j + lane) * CROSSING + 3
        for axis in range(3):
            work.crossings[at + axis] = work.slots[result + 16 * (1 + axis) + lane]


@device
def find_roots(grid, work, count, crossings, x0, y0, z0):
    """Places and normals of the crossings listed in `work.starts`; the block lies at (x0, y0, z0) in its brick.

    For surface nets places are those of linear interpolation, and normals are left alone.
    """
    for begin in range(0, crossings, _BATCH):
        size = min(np.int64(_BATCH), crossings - begin)
        padded = (size + 15) // 16 * 16
        _load_edges(work, begin, size, padded)
        if grid.sharp != 0:
            _bracket_roots(grid, work, count, padded)
        for j in range(0, padded, 16):
            _secant(work.roots, j)
            if grid.sharp != 0:
                _write_normals(grid, work, count, begin, size, j)
        _write_places(work, begin, size, x0, y0, z0)
