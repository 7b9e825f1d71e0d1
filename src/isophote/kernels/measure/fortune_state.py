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
    "Sweep",
    "new_sweep",
]

# Where counts are kept in `counts`: the next site; how many arcs, edges and chunks were ever in use, and the first of
# each that is free again; rows of the heap and of the directory; triangles; the arc that came last; circle events.
SITE, ARCS, EDGES, CHUNKS, FREE_ARC, FREE_EDGE, FREE_CHUNK, HEAP, DIRECTORY, TRIANGLES, NEW_ARC, CIRCLES = range(12)
# Numbers of an arc, `ARC` in all: its site; its neighbours on the beach line, -1 for none (free arcs are linked by the
# left one); the edge that the breakpoint to its right draws; a stamp, which changes when its circle event is no more
# valid; the chunk that it is in.
OWNER, LEFT, RIGHT, EDGE, STAMP, IN_CHUNK = range(6)
ARC = 8
# Arcs that stand side by side in one chunk, at most.
CHUNK = 32
# The site of an arc that is not on the beach line.
FREE = np.int32(-1)
# Of an edge without a triangle on its lower side: there is none yet, or there will be none.
NOTHING, OUTSIDE = np.int32(-1), np.int32(-2)
# Events that one site and its circles can add.
_EVENTS_A_SITE = 6

_HINTS = 2

_DOUBLES = ViewType(types.float64, 1)

# sites        (2 n,) coordinates, by y and then by x
# arcs         (2 n + 2, ARC) numbers, flat; places: the coordinates of the sites of arcs
# chunks       (c, CHUNK) arcs from left to right, flat; sizes: how many; directory: chunks from left to right
# hints        (h,) for each part of the sites' width, of the same width, an arc that is or was near, -1 for none;
#              frame: the least x, and parts for each unit of x
# times        (6 n,) when circle events are, as a heap; events: arcs in the lower half, stamps in the upper
# sides        (2 n + 2,) of edges: 3 t + k for side k of the triangle t below, or NOTHING or OUTSIDE
# triangles    (2 n, 3) corners, flat; neighbours: triangles across the sides opposite them, -1 for none
SWEEP = Table(
    "Sweep",
    sites=_DOUBLES,
    arcs=INTS,
    places=_DOUBLES,
    chunks=INTS,
    sizes=INTS,
    directory=INTS,
    hints=INTS,
    frame=_DOUBLES,
    times=_DOUBLES,
    events=LONGS,
    sides=INTS,
    triangles=INTS,
    neighbours=INTS,
    counts=LONGS,
)


class Sweep(NamedTuple):
    """A sweep: its table, and those of its arrays that Python reads."""

    table: Packed
    arcs: npt.NDArray[np.int32]
    chunks: npt.NDArray[np.int32]
    sizes: npt.NDArray[np.int32]
    directory: npt.NDArray[np.int32]
    triangles: npt.NDArray[np.int32]
    neighbours: npt.NDArray[np.int32]
    counts: npt.NDArray[np.int64]


def new_sweep(sites: npt.NDArray[np.float64]) -> Sweep:
    """The state before the first event, for distinct sites (n, 2) by y and then by x."""
    count = len(sites)
    arcs = 2 * count + 2
    # A chunk is halved when it is full, so each has seen half as many new arcs as it can hold.
    chunks = 4 * count // CHUNK + 4
    # About as many as there are arcs at a time.
    hints = int(_HINTS * count**0.5) + 1

    def numbers(size: int) -> npt.NDArray[np.int32]:
        return np.empty(size, np.int32)

    counts = np.zeros(12, np.int64)
    counts[[FREE_ARC, FREE_EDGE, FREE_CHUNK, NEW_ARC]] = -1
    table = SWEEP.pack(
        sites=np.ascontiguousarray(sites, np.float64).reshape(-1),
        arcs=np.zeros(ARC * arcs, np.int32),
        places=np.empty(2 * arcs),
        chunks=numbers(CHUNK * chunks),
        sizes=numbers(chunks),
        directory=numbers(chunks),
        hints=np.full(hints, -1, np.int32),
        frame=_frame(sites, hints),
        times=np.empty(_EVENTS_A_SITE * count),
        events=np.empty(_EVENTS_A_SITE * count, np.int64),
        sides=numbers(arcs),
        triangles=numbers(6 * count),
        neighbours=numbers(6 * count),
        counts=counts,
    )
    own = table.arrays
    return Sweep(
        table,
        own["arcs"].reshape(-1, ARC),
        own["chunks"].reshape(-1, CHUNK),
        own["sizes"],
        own["directory"],
        own["triangles"].reshape(-1, 3),
        own["neighbours"].reshape(-1, 3),
        counts,
    )


def _frame(sites: npt.NDArray[np.float64], hints: int) -> npt.NDArray[np.float64]:
    """What turns an x into the number of a hint."""
    low, high = sites[:, 0].min(initial=np.inf), sites[:, 0].max(initial=-np.inf)
    with np.errstate(all="ignore"):
        factor = (hints - 1) / (high - low)
    return np.array([low, factor if np.isfinite(factor) else 0.0])
