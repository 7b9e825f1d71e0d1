"""Other things than triangles in an accelerator: primitives, fields, instances, known by boxes and a test of their own.

An accelerator that is built over boxes (accel/things.py) has blocks as over triangles, in which the three corners of a
lane span the box of a thing, and the lane's number is the thing's. It is asked by an entry like `closest`:

    things(tables, blocks, ray, test, subject, any)    code of the nearest thing at 0 < t < limit, or −1

`test` is the address of an entry that tests the ray against one thing, and `subject` whatever that wants to know:

    test(subject, ray, thing)    code of what the ray meets of a thing at 0 < t < its limit, or −1

A code is 0 or more. A test that meets something leaves t in the ray's LIMIT, and may leave weights; it keeps the ray's
words from STACK on as they are. Where `any` is not 0, the first code that a test gives will do.

A leaf's boxes are tested four at a time before any thing is, and of those that are entered the nearest comes first. A
thing that stands in several leaves is tested once, but for what a mailbox of 64 places forgets.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from isophote.kernels.accel.contract import (
    LIMIT,
    PRIMITIVES,
    RAY_WORDS,
    WEIGHT1,
    WEIGHT2,
    Nearest,
    closest_in_blocks,
    ray_at,
    ray_direction,
    ray_origin,
    set_ray,
)
from isophote.kernels.accel.layout import BLOCK, LANES, NUMBER
from isophote.kernels.accel.spread import spread_of
from isophote.kernels.base.entry import call_entry, element_address
from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import (
    bits,
    lane,
    load4,
    load_float,
    load_int,
    lowest_bit,
    maximum,
    minimum,
    splat4,
    store_int,
)
from isophote.kernels.base.table import FLOATS, INT, Table

__all__ = ["BOXES", "Things", "ask_boxes", "closest_in_leaf", "enough", "test_thing", "tested_in_leaf", "things_of"]

# An accelerator over boxes: addresses of its entry for things, of the test of one, and of its tables, and its blocks.
# The first is 0 where there is none.
BOXES = Table("Boxes", things=INT, test=INT, tables=INT, blocks=FLOATS)

_ZERO, _SHIFT = np.float32(0), np.int64(2)
_CORNER = 3 * LANES
# The mailbox fills the end of the ray's words, which no accelerator comes to.
_BOXES = np.int64(64)
_MAILBOX = np.int64(RAY_WORDS - 64)
_NOTHING, _FIRST = np.int32(-1), np.int64(0)


class Things(NamedTuple):
    """How things are tested: the address of the test and its subject, whether any of them will do; the ray's address,
    and the ray made ready for boxes: origin, 1/d, and how much distances are uncertain, on each axis."""

    test: int
    subject: int
    any: bool
    ray: int
    ox: float
    oy: float
    oz: float
    ix: float
    iy: float
    iz: float
    sx: float
    sy: float
    sz: float


@device
def ask_boxes(boxes, subject, origin, direction, limit, any_will_do, ray_address):
    """(t, code) of what a ray meets first in an accelerator over boxes, or of anything where `any_will_do` is not 0;
    code −1 for nothing. The words of a ray at `ray_address` are for the accelerator."""
    words = ray_at(ray_address)
    set_ray(words, origin, direction, limit)
    blocks = element_address(boxes.blocks, _FIRST)
    code = call_entry(boxes.things, (boxes.tables, blocks, ray_address, boxes.test, subject, any_will_do))
    return load_float(words, LIMIT), code


@device
def things_of(ray_address, words, reach, test, subject, any_will_do):
    """The `Things` of a ray, whose mailbox becomes empty; no box's coordinate exceeds `reach`."""
    for k in range(_BOXES):
        store_int(words, _MAILBOX + k, _NOTHING)
    spread = spread_of(ray_origin(words), ray_direction(words), reach)
    o, i, s = spread.origin, spread.inverse, spread.slack
    return Things(
        test,
        subject,
        any_will_do != 0,
        ray_address,
        splat4(o.x),
        splat4(o.y),
        splat4(o.z),
        splat4(i.x),
        splat4(i.y),
        splat4(i.z),
        splat4(s.x),
        splat4(s.y),
        splat4(s.z),
    )


@device
def _planes(blocks, at, origin, inverse, slack):
    """Where the ray enters and leaves the boxes of a block between their planes across one axis."""
    a, b, c = load4(blocks, at), load4(blocks, at + _CORNER), load4(blocks, at + 2 * _CORNER)
    low = (minimum(a, minimum(b, c)) - origin) * inverse
    high = (maximum(a, maximum(b, c)) - origin) * inverse
    return minimum(low, high) - slack, maximum(low, high) + slack


@device
def _entered(blocks, block, things, limit):
    """(bits, distances): which boxes of a block the ray enters before `limit`, and where."""
    at = block * BLOCK
    x0, x1 = _planes(blocks, at, things.ox, things.ix, things.sx)
    y0, y1 = _planes(blocks, at + LANES, things.oy, things.iy, things.sy)
    z0, z1 = _planes(blocks, at + 2 * LANES, things.oz, things.iz, things.sz)
    near = maximum(maximum(x0, y0), maximum(z0, splat4(_ZERO)))
    return bits(near <= minimum(minimum(x1, y1), minimum(z1, splat4(limit)))), near


@device
def _nearest_of(entered, near):
    """The lane of the nearest of the boxes entered, at least one."""
    found = lowest_bit(entered)
    entered &= entered - np.int32(1)
    while entered != 0:
        k = lowest_bit(entered)
        entered &= entered - np.int32(1)
        if lane(near, k) < lane(near, found):
            found = k
    return found


@device
def _known(thing, words):
    """Whether the ray was tested against a thing lately; it is from now on."""
    box = _MAILBOX + (np.int64(thing) & (_BOXES - 1))
    known = load_int(words, box) == thing
    store_int(words, box, thing)
    return known


@device
def test_thing(thing, things, nearest, words):
    """`nearest`, or what the ray meets of a thing, which is counted as tested."""
    store_int(words, PRIMITIVES, load_int(words, PRIMITIVES) + np.int32(1))
    code = call_entry(things.test, (things.subject, things.ray, np.int64(thing)))
    if code < 0:
        return nearest
    return Nearest(load_float(words, LIMIT), load_float(words, WEIGHT1), load_float(words, WEIGHT2), code)


@device
def enough(things, nearest):
    """Whether what is found will do; not where triangles are asked for, and `things` is None."""
    if things is None:
        return False
    return things.any and nearest.slot >= 0


@device
def tested_in_leaf(count, things):
    """How many a leaf adds to what the ray was tested against, beside what is counted at each test."""
    if things is None:
        return count
    return np.int64(0)


@device
def _closest_in_boxes(blocks, first, count, things, nearest, words):
    for block in range(first, first + ((count + (LANES - 1)) >> _SHIFT)):
        entered, near = _entered(blocks, block, things, nearest.t)
        while entered != 0:
            k = _nearest_of(entered, near)
            entered &= ~(np.int32(1) << k)
            if lane(near, k) > nearest.t:
                break
            thing = load_int(blocks, block * BLOCK + NUMBER + np.int64(k))
            if thing >= 0 and not _known(thing, words):
                nearest = test_thing(thing, things, nearest, words)
                if enough(things, nearest):
                    return nearest
    return nearest


@device
def closest_in_leaf(blocks, first, count, sheared, things, nearest, words):
    """`nearest`, or what is nearer in the blocks from number `first` on, which hold `count` triangles where `things`
    is None, and as many things otherwise."""
    if things is None:
        return closest_in_blocks(blocks, first, count, sheared, nearest, words)
    return _closest_in_boxes(blocks, first, count, things, nearest, words)
