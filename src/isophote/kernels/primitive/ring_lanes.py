"""Sixteen rays against a torus: as ring.py finds crossings, all rays taking Newton's steps together.

The line is gone through in three pieces, between which the quartic has its inflections. Where a piece has no root, a
ray waits for the next one; what is still open after so many steps, as with rays that graze, is found by itself.
"""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.base.doubles import doubles_at
from isophote.kernels.base.entry import entry
from isophote.kernels.base.jit import device, exact_inline
from isophote.kernels.primitive import layout
from isophote.kernels.primitive.lanes import BLOCK_DOUBLES, HIGH, LANES, OWN, PART, T, U, V, W, X, Y, Z, chosen
from isophote.kernels.primitive.ring import cross_ring

__all__ = ["meet_rings"]

_ONE, _DOUBLE, _FAR = np.int64(1), np.int64(8), math.inf
# Rows of their own: the quartic's A, B, C; where the line begins, ends and has its second inflection, 1 where it begins
# inside; where the steps stand, may go to, their direction, and the quartic's sign; what is known; t where s is 0, and
# lengths a t.
_A, _B, _C, _START, _END, _BEND, _INSIDE, _S, _STOP, _WAY, _SIGN, _STATE, _NEAREST, _SPEED = (
    OWN + np.int64(LANES * row) for row in range(14)
)
_RUNNING, _FOUND, _OPEN, _MISSED, _LEFT = 0.0, 1.0, 2.0, 3.0, 4.0
# So many steps for a piece; five to eight are enough for nearly all rays.
_STEPS = 8
_LAST_STEP = 2.0**-26


@exact_inline
def _set_up(block, i, tube):
    """The quartic of one ray and where it begins and ends: see ring.cross_ring."""
    x, y, z, u, v, w = block[X + i], block[Y + i], block[Z + i], block[U + i], block[V + i], block[W + i]
    a = u * u + v * v + w * w
    nearest = -(x * u + y * v + z * w) / a
    x, y, z = x + nearest * u, y + nearest * v, z + nearest * w
    rho2, speed = x * x + z * z, math.sqrt(a)
    reach2 = (1.0 + tube) * (1.0 + tube) - (rho2 + y * y)
    half = math.sqrt(chosen(reach2 > 0.0, reach2, 0.0))
    v = v / speed
    inverse = 1.0 / v
    low, high = (-tube - y) * inverse, (tube - y) * inverse
    # Of level rays these are infinite: on one side where they run between the planes, else both before or behind.
    near, far = chosen(inverse > 0.0, low, high), chosen(inverse > 0.0, high, low)
    start, end = chosen(near > -half, near, -half), chosen(far < half, far, half)
    behind = -nearest * speed
    begun = behind > start
    start = chosen(begun, behind, start)
    rho, g = math.sqrt(rho2), rho2 + y * y + 1.0 - tube * tube
    across = y * y - tube * tube
    fa, fb = 2.0 * g - 4.0 * (1.0 - v * v), 8.0 * y * v
    fc = ((rho - 1.0) * (rho - 1.0) + across) * ((rho + 1.0) * (rho + 1.0) + across)
    s2 = start * start
    inside = begun & (s2 * (s2 + fa) + (fb * start + fc) < 0.0)
    block[_A + i], block[_B + i], block[_C + i] = fa, fb, fc
    block[_START + i], block[_END + i] = start, end
    # Without inflections all is the last piece.
    block[_BEND + i] = chosen(fa < 0.0, math.sqrt(chosen(fa < 0.0, -fa * (1.0 / 6.0), 0.0)), -_FAR)
    block[_INSIDE + i] = chosen(inside, 1.0, 0.0)
    missed = (reach2 < 0.0) | (start > end)
    block[_STATE + i] = chosen(missed, _MISSED, _OPEN)
    block[_NEAREST + i], block[_SPEED + i] = nearest, speed


@exact_inline
def _begin_piece(block, i, piece):
    """Where the steps of one ray begin within piece 0, 1 or 2, if it waits for it and has one: as ring._cross_piece."""
    a, b, c, bend = block[_A + i], block[_B + i], block[_C + i], block[_BEND + i]
    after = chosen(piece == 0, -_FAR, chosen(piece == 1, -bend, bend))
    before = chosen(piece == 0, -bend, chosen(piece == 1, bend, _FAR))
    first, last = block[_START + i], block[_END + i]
    start, end = chosen(first > after, first, after), chosen(last < before, last, before)
    sign, inside = chosen(piece == 1, -1.0, 1.0), block[_INSIDE + i] != 0.0
    s2 = end * end
    there = sign * (s2 * (s2 + a) + (b * end + c)) > 0.0
    forward = inside == (piece == 1)
    state, stands = block[_STATE + i], block[_S + i]
    runs = (state == _OPEN) & (start < end) & (forward | there)
    block[_S + i] = chosen(runs, chosen(forward, start, end), stands)
    block[_STOP + i] = chosen(forward, end, start)
    block[_WAY + i], block[_SIGN + i] = chosen(forward, 1.0, -1.0), sign
    # What did not come to an end in a piece is found by itself.
    block[_STATE + i] = chosen(runs, _RUNNING, chosen(state == _RUNNING, _LEFT, state))


@exact_inline
def _step(block, i):
    """One of Newton's steps of a ray, if it runs."""
    a, b, c, s, way, sign = (
        block[_A + i],
        block[_B + i],
        block[_C + i],
        block[_S + i],
        block[_WAY + i],
        block[_SIGN + i],
    )
    s2 = s * s
    value, slope = sign * (s2 * (s2 + a) + (b * s + c)), sign * way * (s * (4.0 * s2 + 2.0 * a) + b)
    step = -value / slope
    n = s + way * step
    none = (slope >= 0.0) | ((block[_STOP + i] - n) * way < 0.0)
    close = step <= _LAST_STEP * (1.0 + abs(n))
    before = block[_STATE + i]
    running = before == _RUNNING
    after = chosen(value <= 0.0, _FOUND, chosen(none, _OPEN, chosen(close, _FOUND, _RUNNING)))
    block[_S + i] = chosen(running & (value > 0.0) & (not none), n, s)
    block[_STATE + i] = chosen(running, after, before)


@exact_inline
def _count(block, lanes, state):
    """How many rays are in a state."""
    count = np.int64(0)
    for i in range(lanes):
        count += np.int64(block[_STATE + i] == state)
    return count


@device
def _find(block, line, i, tube):
    """The first crossing of one ray by itself."""
    for k in range(6):
        line[k] = block[LANES * k + i]
    line[layout.LOW], line[layout.HIGH], line[layout.MOST] = 0.0, block[HIGH + i], 1.0
    block[T + i] = line[layout.FOUND] if cross_ring(line, tube) > 0 else _FAR


@entry
def meet_rings(own, block_address, lanes):
    """The first crossings of sixteen rays."""
    block, tube = doubles_at(block_address, BLOCK_DOUBLES), doubles_at(own, _ONE)[0]
    line = doubles_at(block_address + _DOUBLE * BLOCK_DOUBLES, np.int64(layout.WORDS))
    for i in range(lanes):
        _set_up(block, i, tube)
    for piece in range(3):
        for i in range(lanes):
            _begin_piece(block, i, piece)
        for _ in range(_STEPS):
            for i in range(lanes):
                _step(block, i)
            if _count(block, lanes, _RUNNING) == 0:
                break
        if _count(block, lanes, _OPEN) == 0:
            break
    for i in range(lanes):
        t = block[_NEAREST + i] + block[_S + i] / block[_SPEED + i]
        met = (block[_STATE + i] == _FOUND) & (t > 0.0) & (t < block[HIGH + i])
        block[T + i], block[PART + i] = chosen(met, t, _FAR), 0.0
    for i in range(lanes):
        state = block[_STATE + i]
        # Thick tubes have an inner surface that does not count.
        by_itself = (state == _RUNNING) | (state == _LEFT)
        if by_itself or (tube > 1.0 and state != _MISSED):
            _find(block, line, i, tube)
    return np.int64(0)
