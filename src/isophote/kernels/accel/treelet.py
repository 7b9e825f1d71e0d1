"""Rays through trees of planes, three levels at a step: what kd-trees (kd_entry.py) and BSP trees (bsp_entry.py) share.

A node of either is a treelet: seven planes, each of which parts what the one above it leaves, and the eight children
between them (kernels/base/simd_sides.py tells their lanes). Where there are fewer planes, the places of those that are
missing are +inf, and what is undivided is the lowest of the children that it would have. One word a child:

    code ≥ 0    the number of another treelet
    code < 0    a leaf: −1 − code = first · 32 + count, `count` (1 to 31) triangles in blocks from number `first` on,
                or with count 0 the row `first` of `leaves`: first block, triangles

A step cuts the ray's interval at all seven planes at once (Wald: "Realtime Ray Tracing and Interactive Global
Illumination", 2004, section 7.2, tells how at one). Intervals of two sides overlap by the ray's slack (spread.py), so
nothing slips between them. Children with an interval are visited from near to far; those that wait lie on a stack
of frames, one for each treelet on the way down:

    words 0–7 where each child's interval begins, 8–15 where it ends, 16 the treelet, 17 bits of the children that wait,
    18 bits of the planes whose upper side the ray comes to first, 19 the treelet's level
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from isophote.kernels.accel.contract import STACK
from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import (
    load_float,
    load_int,
    lowest_bit,
    maximum,
    minimum,
    select,
    splat8,
    store8,
    store_int,
)
from isophote.kernels.base.simd_sides import by_fourths, by_halves, by_whole, lanes_of

__all__ = ["NOWHERE", "Near", "Place", "bottom_of", "intervals", "leaf_at", "near_sides", "next_waiting", "step_down"]

_ENDS, _NODE, _WAITING, _FALLING, _LEVEL = np.int64(8), np.int64(16), np.int64(17), np.int64(18), np.int64(19)
# Frames fill two cache lines. The deepest trees (8 + 1.3 log2 n levels, for 2^28 triangles) take 44 of them at most,
# which fit before the mailbox of things.py.
_FRAME, _ALIGNED, _STACK = np.int64(32), np.int64(15), np.int64(STACK)
_COUNT, _COUNT_BITS = np.int64(31), np.int64(5)
_ZERO, _ENDLESS = np.int64(0), np.float32(np.inf)
# Bits: children 0, 2, 4 and 6; planes 1 and 5 moved to 0 and 4; from children 0 and 1 to 2 and 3, as those of 4 to 7;
# plane 3, and the children on its sides.
_EVENS, _LOWER_PAIRS, _FOURTH_AND_FIRST, _PAIR = np.int64(0x55), np.int64(0x33), np.int64(0x11), np.int64(9)
_MIDDLE, _LOWER_HALF, _UPPER_HALF = np.int64(8), np.int64(0x0F), np.int64(0xF0)
# Beside codes of children: the ray is at its end.
NOWHERE = np.int64(1) << np.int64(32)


class Place(NamedTuple):
    """What comes next: the code of a treelet or leaf, or NOWHERE, its level, the ray's interval in it, and the top of
    the stack."""

    code: int
    level: int
    enter: float
    leave: float
    top: int


@device
def bottom_of(ray):
    """The word of the ray at an address where its stack begins: frames fill whole cache lines."""
    return _STACK + (-((ray >> 2) + _STACK) & _ALIGNED)


class Near(NamedTuple):
    """Bits of the children on the side of their planes where the ray is first: of planes 0, 2, 4, 6; 1, 5; and 3."""

    fourths: int
    halves: int
    whole: int


@device
def near_sides(falling):
    """The `Near` of a ray that comes to the upper sides of the planes in `falling`, bits, first."""
    return Near(
        _EVENS + (falling & _EVENS),
        _LOWER_PAIRS + _PAIR * ((falling >> 1) & _FOURTH_AND_FIRST),
        _UPPER_HALF if falling & _MIDDLE != 0 else _LOWER_HALF,
    )


@device
def intervals(soonest, latest, near, place):
    """The ray's intervals in a treelet's children, where they begin and end. It meets the planes between `soonest` and
    `latest`; where these are no numbers, nothing is cut."""
    whole, halves, fourths = lanes_of(near.whole), lanes_of(near.halves), lanes_of(near.fourths)
    always, never = splat8(-_ENDLESS), splat8(_ENDLESS)
    # What a side does not cut is put in place before it is compared: comparisons wait for each other, this does not.
    enter = maximum(
        maximum(select(halves, always, by_halves(soonest)), select(fourths, always, by_fourths(soonest))),
        maximum(select(whole, always, by_whole(soonest)), splat8(place.enter)),
    )
    leave = minimum(
        minimum(select(halves, by_halves(latest), never), select(fourths, by_fourths(latest), never)),
        minimum(select(whole, by_whole(latest), never), splat8(place.leave)),
    )
    return enter, leave


@device
def _first_of(waiting, near):
    """Which of the children in `waiting`, bits of which there is one, the ray comes to first, as a bit."""
    there = waiting & near.whole
    waiting = there if there != 0 else waiting
    there = waiting & near.halves
    waiting = there if there != 0 else waiting
    there = waiting & near.fourths
    return there if there != 0 else waiting


@device
def step_down(nodes, codes, words, place, falling, near, entered, enter, leave):
    """From a treelet to the first of the children that the ray enters, of which there is one; the others wait. `codes`
    is the word of the first child's code."""
    top = place.top
    first = _first_of(entered, near)
    k, rest = np.int64(lowest_bit(np.int32(first))), entered ^ first
    store8(words, top, enter)
    store8(words, top + _ENDS, leave)
    store_int(words, top + _NODE, np.int32(place.code))
    store_int(words, top + _WAITING, np.int32(rest))
    store_int(words, top + _FALLING, np.int32(falling))
    store_int(words, top + _LEVEL, np.int32(place.level))
    code, begin, until = (
        np.int64(load_int(nodes, codes + k)),
        load_float(words, top + k),
        load_float(words, top + _ENDS + k),
    )
    return Place(code, place.level + 1, begin, until, top + (_FRAME if rest != 0 else _ZERO))


@device
def next_waiting(nodes, size, codes, words, bottom, top, limit):
    """The next on the stack whose interval begins before `limit`; treelets are `size` words long, codes begin at word
    `codes` of each."""
    while top > bottom:
        frame = top - _FRAME
        waiting = np.int64(load_int(words, frame + _WAITING))
        first = _first_of(waiting, near_sides(np.int64(load_int(words, frame + _FALLING))))
        k, rest = np.int64(lowest_bit(np.int32(first))), waiting ^ first
        store_int(words, frame + _WAITING, np.int32(rest))
        top = frame + (_FRAME if rest != 0 else _ZERO)
        begin = load_float(words, frame + k)
        if begin <= limit:
            number, level = np.int64(load_int(words, frame + _NODE)), np.int64(load_int(words, frame + _LEVEL))
            code = np.int64(load_int(nodes, number * size + codes + k))
            return Place(code, level + 1, begin, load_float(words, frame + _ENDS + k), top)
    return Place(NOWHERE, _ZERO, limit, limit, top)


@device
def leaf_at(leaves, code):
    """The first block of a leaf, and its number of triangles."""
    first, count = (-1 - code) >> _COUNT_BITS, (-1 - code) & _COUNT
    if count == 0:
        return np.int64(load_int(leaves, 2 * first)), np.int64(load_int(leaves, 2 * first + 1))
    return first, count
