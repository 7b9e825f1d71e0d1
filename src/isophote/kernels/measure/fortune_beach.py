"""The beach line of Fortune's sweep: arcs in a list from left to right, and in chunks that are searched by halving.

Arcs are linked to their neighbours. An arc above a site is looked for near the one that came last at about the same x;
where that is too far, by halving: stretches of at most `CHUNK` arcs are chunks, whose first arcs stand in a directory.
So to find one takes few steps mostly, and at worst a logarithmic number; to insert or remove one takes a few, and
seldom moves part of the directory.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import exact_device
from isophote.kernels.measure.fortune_circles import is_ahead
from isophote.kernels.measure.fortune_state import (
    ARC,
    ARCS,
    CHUNK,
    CHUNKS,
    DIRECTORY,
    EDGES,
    FREE,
    FREE_ARC,
    FREE_CHUNK,
    FREE_EDGE,
    IN_CHUNK,
    LEFT,
    OWNER,
    RIGHT,
    X,
    Y,
)

# Doubles of an arc.
_PLACE = ARC // 2
# As far along the list is walked from a hint before all arcs are searched.
_FAR = np.int64(12)

__all__ = [
    "append_arc",
    "arc_number",
    "arc_place",
    "find_arc",
    "free_edge",
    "insert_behind",
    "new_arc",
    "new_edge",
    "remove_arc",
]


@exact_device
def arc_number(s, arc, which):
    """One of the numbers of an arc."""
    return np.int64(s.arcs[ARC * arc + which])


@exact_device
def arc_place(s, arc):
    """The site of an arc."""
    return s.places[_PLACE * arc + X], s.places[_PLACE * arc + Y]


@exact_device
def new_arc(s, site):
    """An arc of a site, not on the beach line yet."""
    arc = s.counts[FREE_ARC]
    if arc >= 0:
        s.counts[FREE_ARC] = arc_number(s, arc, LEFT)
    else:
        arc = s.counts[ARCS]
        s.counts[ARCS] = arc + 1
    s.arcs[ARC * arc + OWNER] = site
    s.places[_PLACE * arc + X], s.places[_PLACE * arc + Y] = s.sites[2 * site], s.sites[2 * site + 1]
    return arc


@exact_device
def new_edge(s, side):
    """An edge with this on its lower side."""
    edge = s.counts[FREE_EDGE]
    if edge >= 0:
        s.counts[FREE_EDGE] = s.sides[edge]
    else:
        edge = s.counts[EDGES]
        s.counts[EDGES] = edge + 1
    s.sides[edge] = side
    return edge


@exact_device
def free_edge(s, edge):
    """Give back an edge that is finished."""
    s.sides[edge] = s.counts[FREE_EDGE]
    s.counts[FREE_EDGE] = edge


@exact_device
def _is_left(s, b, x, y):
    """Whether (x, y), on the sweep line, lies to the left of the breakpoint between arc b and the arc before it."""
    a = arc_number(s, b, LEFT)
    ax, ay = arc_place(s, a)
    bx, by = arc_place(s, b)
    # The younger parabola is the narrower one, ahead between two breakpoints. Its site tells which of them this is.
    if ay < by and x >= bx:
        return False
    if ay > by and x <= ax:
        return True
    return is_ahead(ax, ay, bx, by, x, y)


@exact_device
def _hint(s, x):
    """Where the hint for an x is kept."""
    at = (x - s.frame[0]) * s.frame[1]
    return np.int64(at) if at > 0 else np.int64(0)


@exact_device
def find_arc(s, x, y):
    """The arc above (x, y), on the sweep line: near the hint, or else by halving."""
    arc = np.int64(s.hints[_hint(s, x)])
    if arc < 0 or arc_number(s, arc, OWNER) == FREE:
        return _search(s, x, y)
    steps = np.int64(0)
    if arc_number(s, arc, LEFT) >= 0 and _is_left(s, arc, x, y):
        while steps < _FAR:
            arc = arc_number(s, arc, LEFT)
            if arc_number(s, arc, LEFT) < 0 or not _is_left(s, arc, x, y):
                return arc
            steps += 1
        return _search(s, x, y)
    while steps < _FAR:
        following = arc_number(s, arc, RIGHT)
        if following < 0 or _is_left(s, following, x, y):
            return arc
        arc = following
        steps += 1
    return _search(s, x, y)


@exact_device
def _search(s, x, y):
    """The arc above (x, y): by halving the directory, and then from arc to arc of a chunk."""
    low, high = np.int64(0), s.counts[DIRECTORY]
    while high - low > 1:
        middle = (low + high) >> 1
        if _is_left(s, np.int64(s.firsts[s.directory[middle]]), x, y):
            high = middle
        else:
            low = middle
    arc = np.int64(s.firsts[s.directory[low]])
    while True:
        following = arc_number(s, arc, RIGHT)
        if following < 0 or _is_left(s, following, x, y):
            return arc
        arc = following


@exact_device
def _new_chunk(s, place, first):
    """A chunk from an arc on, still without any, entered in the directory at a place."""
    chunk = s.counts[FREE_CHUNK]
    if chunk >= 0:
        s.counts[FREE_CHUNK] = s.sizes[chunk]
    else:
        chunk = s.counts[CHUNKS]
        s.counts[CHUNKS] = chunk + 1
    for i in range(s.counts[DIRECTORY], place, -1):
        s.directory[i] = s.directory[i - 1]
    s.directory[place] = chunk
    s.counts[DIRECTORY] += 1
    s.firsts[chunk], s.sizes[chunk] = first, 0
    return chunk


@exact_device
def _halve(s, chunk):
    """Move the right half of a chunk to a new one behind it."""
    size = s.sizes[chunk]
    kept = size >> 1
    arc = np.int64(s.firsts[chunk])
    for _ in range(kept):
        arc = arc_number(s, arc, RIGHT)
    other = _new_chunk(s, _place_in_directory(s, chunk) + 1, arc)
    for _ in range(size - kept):
        s.arcs[ARC * arc + IN_CHUNK] = other
        arc = arc_number(s, arc, RIGHT)
    s.sizes[other], s.sizes[chunk] = size - kept, kept


@exact_device
def _place_in_directory(s, chunk):
    place = np.int64(0)
    while s.directory[place] != chunk:
        place += 1
    return place


@exact_device
def append_arc(s, last, arc):
    """Put an arc at the right end of the beach line, behind `last` (-1: it is the first)."""
    place = s.counts[DIRECTORY] - 1
    if place < 0 or s.sizes[s.directory[place]] == CHUNK:
        place += 1
        _new_chunk(s, place, arc)
    chunk = np.int64(s.directory[place])
    s.sizes[chunk] += 1
    s.arcs[ARC * arc + IN_CHUNK] = chunk
    s.arcs[ARC * arc + LEFT], s.arcs[ARC * arc + RIGHT] = last, np.int64(-1)
    if last >= 0:
        s.arcs[ARC * last + RIGHT] = arc


@exact_device
def insert_behind(s, arc, first, second):
    """Put two arcs to the right of an arc."""
    chunk = arc_number(s, arc, IN_CHUNK)
    s.arcs[ARC * first + IN_CHUNK] = s.arcs[ARC * second + IN_CHUNK] = chunk
    s.hints[_hint(s, s.places[_PLACE * first + X])] = first
    after = arc_number(s, arc, RIGHT)
    s.arcs[ARC * arc + RIGHT], s.arcs[ARC * first + LEFT] = first, arc
    s.arcs[ARC * first + RIGHT], s.arcs[ARC * second + LEFT] = second, first
    s.arcs[ARC * second + RIGHT] = after
    if after >= 0:
        s.arcs[ARC * after + LEFT] = second
    s.sizes[chunk] += 2
    if s.sizes[chunk] > CHUNK:
        _halve(s, chunk)


@exact_device
def remove_arc(s, arc):
    """Take an arc that has neighbours off the beach line, and give it back."""
    chunk = arc_number(s, arc, IN_CHUNK)
    left, right = arc_number(s, arc, LEFT), arc_number(s, arc, RIGHT)
    s.arcs[ARC * left + RIGHT], s.arcs[ARC * right + LEFT] = right, left
    s.sizes[chunk] -= 1
    if s.sizes[chunk] == 0:
        _drop_chunk(s, chunk)
    elif s.firsts[chunk] == arc:
        s.firsts[chunk] = right
    hint = _hint(s, s.places[_PLACE * arc + X])
    if s.hints[hint] == arc:
        s.hints[hint] = left
    s.arcs[ARC * arc + OWNER] = FREE
    s.arcs[ARC * arc + LEFT] = s.counts[FREE_ARC]
    s.counts[FREE_ARC] = arc


@exact_device
def _drop_chunk(s, chunk):
    place = _place_in_directory(s, chunk)
    s.counts[DIRECTORY] -= 1
    for i in range(place, s.counts[DIRECTORY]):
        s.directory[i] = s.directory[i + 1]
    s.sizes[chunk] = s.counts[FREE_CHUNK]
    s.counts[FREE_CHUNK] = chunk
