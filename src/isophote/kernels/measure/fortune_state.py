"""The state of Fortune's sweep: flat arrays, which compiled functions advance and Python reads as well."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from numba import types

from isophote.kernels.base.table import INTS, LONGS, Packed, Table, ViewType

__all__ = [
    "ARC",
    "ARCS",
    "BUCKET",
    "CHUNK",
    "CHUNKS",
    "CIRCLES",
    "DIRECTORY",
    "EDGE",
    "EDGES",
    "FREE",
    "FREE_ARC",
    "FREE_CHUNK",
    "FREE_EDGE",
    "FREE_WAITING",
    "HEAP",
    "IN_CHUNK",
    "LEFT",
    "NEW_ARC",
    "NOTHING",
    "OUTSIDE",
    "OWNER",
    "RIGHT",
    "SITE",
    "STAMP",
    "SWEEP",
    "TRIANGLES",
    "WAITING",
    "Sweep",
    "X",
    "Y",
    "new_sweep",
]

# Where counts are kept in `counts`: the next site; how many arcs, edges, chunks and waiting events were ever in use,
# and the first of each that is free again; rows of the heap and of the directory; the bucket whose events are in the
# heap; triangles; the arc that came last; circle events.
SITE, ARCS, EDGES, CHUNKS, WAITING, FREE_ARC, FREE_EDGE, FREE_CHUNK, FREE_WAITING = range(9)
HEAP, DIRECTORY, BUCKET, TRIANGLES, NEW_ARC, CIRCLES = range(9, 15)
_COUNTS = 15
# Numbers of an arc, `ARC` in all: its site; its neighbours on the beach line, -1 for none (free arcs are linked by the
# left one); the edge that the breakpoint to its right draws; a stamp, which changes when its circle event is no more
# valid; the chunk that it is in. Behind them, as doubles, are the coordinates of its site. All fill a cache line.
OWNER, LEFT, RIGHT, EDGE, STAMP, IN_CHUNK = range(6)
X, Y = 4, 5
ARC = 16
_LINE = 64
# Arcs in one chunk, at most.
CHUNK = 32
# The site of an arc that is not on the beach line.
FREE = np.int32(-1)
# Of an edge without a triangle on its lower side: there is none yet, or there will be none.
NOTHING, OUTSIDE = np.int32(-1), np.int32(-2)
# Events that one site and its circles can add.
_EVENTS_A_SITE = 6

# Hints for each root of the number of sites: one for three arcs or so, of sites spread evenly. The arc that came last
# is a better hint than one nearby that came long ago.
_HINTS = 0.6

_DOUBLES = ViewType(types.float64, 1)

# sites        (2 n,) coordinates, by y and then by x
# arcs         (2 n + 2, ARC) numbers, flat; places: the same memory as doubles
# firsts       (c,) of each chunk of arcs the one on the left; sizes: how many; directory: chunks from left to right
# hints        (h,) for each part of the sites' width, of the same width, an arc that is or was near, -1 for none
# frame        the least x, parts for each unit of x; the least y, and buckets for each unit of y
# times        (6 n,) when the next circle events are, as a heap; events: arcs in the lower half, stamps in the upper
# buckets      (b,) for each part of the sites' height, of the same height, the first of the events that wait there, -1
#              for none; all later ones wait in the last
# waiting      (6 n,) such events; due: when they are; behind: the next one of the same bucket
# sides        (2 n + 2,) of edges: 3 t + k for side k of the triangle t below, or NOTHING or OUTSIDE
# triangles    (2 n, 3) corners, flat; neighbours: triangles across the sides opposite them, -1 for none
SWEEP = Table(
    "Sweep",
    sites=_DOUBLES,
    arcs=INTS,
    places=_DOUBLES,
    firsts=INTS,
    sizes=INTS,
    directory=INTS,
    hints=INTS,
    frame=_DOUBLES,
    times=_DOUBLES,
    events=LONGS,
    buckets=INTS,
    waiting=LONGS,
    due=_DOUBLES,
    behind=INTS,
    sides=INTS,
    triangles=INTS,
    neighbours=INTS,
    counts=LONGS,
)


class Sweep(NamedTuple):
    """A sweep: its table, and those of its arrays that Python reads."""

    table: Packed
    triangles: npt.NDArray[np.int32]
    neighbours: npt.NDArray[np.int32]
    counts: npt.NDArray[np.int64]


def new_sweep(sites: npt.NDArray[np.float64]) -> Sweep:
    """The state before the first event, for distinct sites (n, 2) by y and then by x."""
    count = len(sites)
    arcs = 2 * count + 2
    # A chunk is halved when it is full, so each has seen half as many new arcs as it can hold.
    chunks = 4 * count // CHUNK + 4
    hints = int(_HINTS * count**0.5) + 1

    def numbers(size: int) -> npt.NDArray[np.int32]:
        return np.empty(size, np.int32)

    counts = np.zeros(_COUNTS, np.int64)
    counts[[FREE_ARC, FREE_EDGE, FREE_CHUNK, FREE_WAITING, NEW_ARC]] = -1
    arc_memory = _lines(arcs)
    table = SWEEP.pack(
        sites=np.ascontiguousarray(sites, np.float64).reshape(-1),
        arcs=arc_memory.view(np.int32),
        places=arc_memory,
        firsts=numbers(chunks),
        sizes=numbers(chunks),
        directory=numbers(chunks),
        hints=np.full(hints, -1, np.int32),
        frame=np.array([*_parts(sites[:, 0], hints), *_parts(sites[:, 1], count)]),
        times=np.empty(_EVENTS_A_SITE * count),
        events=np.empty(_EVENTS_A_SITE * count, np.int64),
        buckets=np.full(count + 1, -1, np.int32),
        waiting=np.empty(_EVENTS_A_SITE * count, np.int64),
        due=np.empty(_EVENTS_A_SITE * count),
        behind=numbers(_EVENTS_A_SITE * count),
        sides=numbers(arcs),
        triangles=numbers(6 * count),
        neighbours=numbers(6 * count),
        counts=counts,
    )
    own = table.arrays
    return Sweep(table, own["triangles"].reshape(-1, 3), own["neighbours"].reshape(-1, 3), counts)


def _lines(count: int) -> npt.NDArray[np.float64]:
    """Zeros that fill so many lines of the cache."""
    memory = np.zeros((count + 1) * _LINE, np.uint8)
    first = -memory.ctypes.data % _LINE
    return memory[first : first + count * _LINE].view(np.float64)


def _parts(along: npt.NDArray[np.float64], count: int) -> tuple[float, float]:
    """The least of coordinates, and what turns the distance from it into a number below `count`."""
    low, high = along.min(initial=np.inf), along.max(initial=-np.inf)
    with np.errstate(all="ignore"):
        factor = (count - 1) / (high - low)
    return float(low), float(factor) if np.isfinite(factor) else 0.0
