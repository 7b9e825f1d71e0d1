"""How a kd-tree lies in memory, and the words that it is built from: nodes of one plane, and events.

Rays go through treelets of seven planes (treelet.py), which fill TREELET words, a cache line:

    words 0–6    positions of the planes
    word 7       bits 0–6: planes across y, 8–14: planes across z, 16–23: children that there are; bit 30 is set, so
                 that the word is a float of common size beside the planes
    words 8–15   codes of children, int32

While it is built, a node has one plane and fills NODE words, its children lie side by side, at an even number `child`
(the lower side) and the next:

    inner   position of the plane (float32), child · 4 + axis (int32)
    leaf    first block (int32), triangles · 4 + LEAF (int32)

An event is one end of a triangle's extent along an axis, in the order in which a sweep meets them: from the high bit,
32 bits of position, 2 bits of kind, 30 bits of the triangle's number.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import as_float, load_int, store_float
from isophote.kernels.base.table import FLOAT, FLOATS, INTS, Table

__all__ = [
    "ACROSS_Z",
    "AXES",
    "CODES",
    "COMMON",
    "END",
    "KD",
    "LEAF",
    "NODE",
    "PLANAR",
    "PRESENT",
    "START",
    "TREELET",
    "event",
    "event_kind",
    "event_place",
    "event_triangle",
]

NODE = 2
LEAF = 3
TREELET, AXES, CODES = 16, 7, 8
ACROSS_Z, PRESENT, COMMON = 8, 16, 1 << 30

# `nodes`: treelets as above; `leaves` of two words (treelet.py); `bounds` (6,): least and greatest corner; `reach`: the
# largest coordinate's size.
KD = Table("Kd", nodes=FLOATS, leaves=INTS, bounds=FLOATS, reach=FLOAT)

END, PLANAR, START = 0, 1, 2
_KIND, _PLACE = np.uint64(30), np.uint64(32)
_TRIANGLE, _KINDS = np.uint64((1 << 30) - 1), np.uint64(3)
_SIGN, _ALL = np.uint32(0x80000000), np.uint32(0xFFFFFFFF)


@device
def event(place, kind, triangle, word):
    """The event at a float32 place; `word` is an array of one float32 to work in. Words ascend as places do."""
    store_float(word, 0, np.float32(place) + np.float32(0))
    bits = np.uint32(load_int(word, 0))
    ordered = np.uint32(bits ^ (_ALL if bits >= _SIGN else _SIGN))
    return (np.uint64(ordered) << _PLACE) | (np.uint64(kind) << _KIND) | np.uint64(triangle)


@device
def event_place(key):
    """The place of an event, float32."""
    ordered = np.uint32(key >> _PLACE)
    bits = np.uint32(ordered ^ (_SIGN if ordered >= _SIGN else _ALL))
    return as_float(np.int32(bits))


@device
def event_kind(key):
    """END, PLANAR or START."""
    return np.int64((key >> _KIND) & _KINDS)


@device
def event_triangle(key):
    """Number of an event's triangle."""
    return np.int64(key & _TRIANGLE)
