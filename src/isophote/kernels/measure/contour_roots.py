"""Where a field is zero on the edges of a grid, and its normals there.

Most edges are crossed by one smooth surface: the chord, one more value, and a parabola through the three lead so near
to the crossing that a step of Newton's ends there. Where that step is longer than it would be then, arms of the field
meet on the edge; those few are bracketed.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import device, exact_apart
from isophote.kernels.base.simd import absolute, bits, load16, maximum, minimum, select, splat16, square_root, store16
from isophote.kernels.forms.interpreters import gradients_on, values_on
from isophote.kernels.forms.opcodes import INPUTS
from isophote.kernels.forms.tape_gradient import GRADIENT_SLOT
from isophote.kernels.measure.contour_tables import BLOCK, BLOCK_SAMPLES, CROSSING, POINTS, WIDTH
from isophote.kernels.measure.contour_vertices import put_plane

__all__ = ["find_roots"]

_SIDE = BLOCK + 1
_BATCH = 16 * WIDTH
# Rows of a batch: starts and lengths of the edges along x, y, z; the bracket (t, f) at both ends; which end moved last;
# the place t along the edge; the difference of the values at the edge's ends; the normals.
_STARTS, _STEPS, _TA, _FA, _TB = np.int64(0), np.int64(3), np.int64(6), np.int64(7), np.int64(8)
_FB, _LAST, _T, _RANGE, _NORMALS = np.int64(9), np.int64(10), np.int64(11), np.int64(12), np.int64(13)
_MOST_STEPS = 12
# A value this small, relative to the difference along the edge, is left to the last step of Newton's.
_SMALL = np.float32(1e-5)
# Gradients are taken this far inside, in cells: right on the surface, where arms meet, there may be none.
_INWARD = np.float32(2.0**-10)
# The longest step of Newton's, in cells, from a place that a parabola gave.
_LONGEST = np.float32(2.0**-13)
_NOTHING = np.float64(0)
_FIRST_ROW, _AT_FIRST, _AGAIN = np.int64(0), np.int64(0), np.int64(1)
_ZERO, _HALF, _ONE, _TINY = np.float32(0), np.float32(0.5), np.float32(1), np.float32(1e-30)


@device
def _row(roots, row, j):
    return load16(roots, row * _BATCH + j)


@device
def _load_edges(work, begin, size, padded):
    """Fill the batch with the edges in `work.pending` from `begin` on; the last one fills up the last vector."""
    roots, points = work.roots, work.points
    for lane in range(size):
        start = np.int64(work.starts[work.pending[begin + lane]])
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
def _chord(roots, j):
    """Next place within the bracket: where the chord is zero, or the middle where there is no such number."""
    ta, fa, tb, fb = _row(roots, _TA, j), _row(roots, _FA, j), _row(roots, _TB, j), _row(roots, _FB, j)
    t = ta + (tb - ta) * (fa / (fa - fb))
    return select((t >= ta) & (t <= tb), t, (ta + tb) * splat16(_HALF))


@device
def _put_chord(roots, j):
    store16(roots, _T * _BATCH + j, _chord(roots, j))


@device
def _put_parabola(roots, j, f):
    """Next place where the value at t is f: by the parabola t(f) through it and the ends, if that is in the bracket."""
    zero = splat16(_ZERO)
    t, fa, fb = _row(roots, _T, j), _row(roots, _FA, j), _row(roots, _FB, j)
    low = f * fa > zero
    first, last = select(low, t, zero), select(low, splat16(_ONE), t)
    # Lagrange's form at f = 0; the end at t = 0 adds nothing.
    guess = t * fa * fb / ((f - fa) * (f - fb)) + fa * f / ((fb - fa) * (fb - f))
    store16(roots, _TA * _BATCH + j, first)
    store16(roots, _TB * _BATCH + j, last)
    store16(roots, _T * _BATCH + j, select((guess >= first) & (guess <= last), guess, t))


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
def _evaluate(grid, work, count, padded):
    """Values at the places of a batch; where they are in the slots."""
    for j in range(0, padded, 16):
        t = _row(work.roots, _T, j)
        for axis in range(INPUTS):
            store16(work.slots, axis * padded + j, _place(work.roots, axis, j, t))
    values_on(grid.interpreters, work.leaf, _FIRST_ROW, count, work.data, work.slots, padded // 16)
    return (INPUTS - 1 + count) * padded


@device
def _bracket(grid, work, count, padded):
    """Narrow the brackets of a batch until all values are small."""
    for j in range(0, padded, 16):
        _put_chord(work.roots, j)
    for _ in range(_MOST_STEPS):
        result = _evaluate(grid, work, count, padded)
        open_lanes = np.int32(0)
        for j in range(0, padded, 16):
            open_lanes |= _narrow(work.roots, j, load16(work.slots, result + j))
            _put_chord(work.roots, j)
        if open_lanes == 0:
            break


@device
def _interpolate(grid, work, count, padded):
    """Places of a batch by parabolas."""
    for j in range(0, padded, 16):
        _put_chord(work.roots, j)
    result = _evaluate(grid, work, count, padded)
    for j in range(0, padded, 16):
        _put_parabola(work.roots, j, load16(work.slots, result + j))


@device
def _inward(roots, j):
    """Places along the edges, moved a little towards their inner ends."""
    zero, one, inward = splat16(_ZERO), splat16(_ONE), splat16(_INWARD)
    t = _row(roots, _T, j)
    return select(_row(roots, _FA, j) < zero, maximum(t - inward, zero), minimum(t + inward, one))


@device
def _finish(work, j, t, result):
    """A last step of Newton's from t, and unit normals (or 0); lanes where the step is short and within the bracket."""
    roots, slots = work.roots, work.slots
    f = load16(slots, result)
    gx, gy, gz = load16(slots, result + 16), load16(slots, result + 32), load16(slots, result + 48)
    slope = gx * _row(roots, _STEPS, j) + gy * _row(roots, _STEPS + 1, j) + gz * _row(roots, _STEPS + 2, j)
    before = _row(roots, _T, j)
    better = t - f / slope
    fits = (better >= _row(roots, _TA, j)) & (better <= _row(roots, _TB, j))
    store16(roots, _T * _BATCH + j, select(fits, better, before))
    square = gx * gx + gy * gy + gz * gz
    # Neither a vanishing gradient nor an endless one has a direction.
    known = (square > splat16(_TINY)) & (square < splat16(_ONE / _TINY))
    scale = select(known, splat16(_ONE) / square_root(square), splat16(_ZERO))
    store16(roots, _NORMALS * _BATCH + j, select(known, gx * scale, splat16(_ZERO)))
    store16(roots, (_NORMALS + 1) * _BATCH + j, select(known, gy * scale, splat16(_ZERO)))
    store16(roots, (_NORMALS + 2) * _BATCH + j, select(known, gz * scale, splat16(_ZERO)))
    return bits(fits & (absolute(better - before) <= splat16(_LONGEST)))


@device
def _add_normals(grid, work, count, j):
    """Gradients at sixteen crossings of a batch, the last step to their places, and their normals; which are good."""
    t = _inward(work.roots, j)
    for axis in range(INPUTS):
        store16(work.slots, axis * GRADIENT_SLOT, _place(work.roots, axis, j, t))
    gradients_on(grid.interpreters, work.leaf, _FIRST_ROW, count, work.data, work.slots)
    return _finish(work, j, t, (INPUTS - 1 + count) * GRADIENT_SLOT)


@device
def _write(work, lane, crossing, x0, y0, z0):
    """A crossing's place along its edge, its normal and its plane; whether it has a normal."""
    roots, corner = work.roots, np.int64(work.corners[crossing])
    axis, t = corner >> 12, np.float64(roots[_T * _BATCH + lane])
    u, v, w = (
        roots[_NORMALS * _BATCH + lane],
        roots[(_NORMALS + 1) * _BATCH + lane],
        roots[(_NORMALS + 2) * _BATCH + lane],
    )
    x = np.float64(x0 + (corner & 15)) + (t if axis == 0 else _NOTHING)
    y = np.float64(y0 + (corner >> 4 & 15)) + (t if axis == 1 else _NOTHING)
    z = np.float64(z0 + (corner >> 8 & 15)) + (t if axis == 2 else _NOTHING)
    at = CROSSING * crossing
    work.crossings[at] = roots[_T * _BATCH + lane]
    work.crossings[at + 1], work.crossings[at + 2], work.crossings[at + 3] = u, v, w
    put_plane(work.planes[crossing], x, y, z, np.float64(u), np.float64(v), np.float64(w))
    return u * u + v * v + w * w > _HALF


@device
def _find_batch(grid, work, count, begin, size, late, again, x0, y0, z0):
    """Find the crossings of a batch; adds those that are not good to the list of the late ones, unless it is that.

    Returns the length of the list, and whether all have normals.
    """
    padded = (size + 15) // 16 * 16
    _load_edges(work, begin, size, padded)
    if again == _AGAIN:
        _bracket(grid, work, count, padded)
    else:
        _interpolate(grid, work, count, padded)
    known = True
    for j in range(0, padded, 16):
        good = _add_normals(grid, work, count, j)
        for lane in range(j, min(j + 16, size)):
            crossing = np.int64(work.pending[begin + lane])
            known &= _write(work, lane, crossing, x0, y0, z0)
            if good >> np.int32(lane - j) & 1 == 0 and again == _AT_FIRST:
                work.late[late] = np.int32(crossing)
                late += 1
    return late, known


@device
def _find_chords(work, crossings, x0, y0, z0):
    for row in range(_NORMALS * _BATCH, (_NORMALS + INPUTS) * _BATCH, 16):
        store16(work.roots, row, splat16(_ZERO))
    for begin in range(0, crossings, _BATCH):
        size = min(np.int64(_BATCH), crossings - begin)
        padded = (size + 15) // 16 * 16
        _load_edges(work, begin, size, padded)
        for j in range(0, padded, 16):
            _put_chord(work.roots, j)
        for lane in range(size):
            _write(work, lane, begin + lane, x0, y0, z0)


@exact_apart
def find_roots(grid, work, count, crossings, x0, y0, z0):
    """Places, normals and planes of the crossings listed in `work.starts`; the block lies at (x0, y0, z0) in its brick.
    Returns whether some have no normal.

    For surface nets places are those of linear interpolation, and normals are 0.
    """
    for crossing in range(crossings):
        work.pending[crossing] = np.int32(crossing)
    if grid.sharp == 0:
        _find_chords(work, crossings, x0, y0, z0)
        return True
    late = np.int64(0)
    all_known = True
    for begin in range(0, crossings, _BATCH):
        size = min(np.int64(_BATCH), crossings - begin)
        late, known = _find_batch(grid, work, count, begin, size, late, _AT_FIRST, x0, y0, z0)
        all_known &= known
    for entry in range(late):
        work.pending[entry] = work.late[entry]
    for begin in range(0, late, _BATCH):
        size = min(np.int64(_BATCH), late - begin)
        _, known = _find_batch(grid, work, count, begin, size, late, _AGAIN, x0, y0, z0)
        all_known &= known
    return not all_known
