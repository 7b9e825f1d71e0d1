"""Stars of vertices: the corners at each vertex, the edges that leave it, and the fans that its faces form.

A corner is a place in a mesh's flat list of vertex numbers, and also the half-edge from there to the face's next
corner. At a vertex v, corner number i of its star has two slots: 2 i for the half-edge that leaves v, 2 i + 1 for the
one that comes in. Slots with the same vertex at their other end are one undirected edge. Where exactly two slots meet,
the faces are neighbours, and `across` holds for each slot the other one; BOUNDARY and CROWDED mark slots without a
neighbour. A walk from slot to slot across edges and faces gives the fans: the connected parts of the star.

Edges are found by packing (other end, slot) into one 64-bit word and sorting the words of each star, so that the whole
is a radix sort whose first digit is the vertex. Faces must not name a vertex twice. Triangles need no tables
`following` and `preceding` of the next and the previous corner; these are then empty.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import device, kernel
from isophote.kernels.measure.sort_words import sort_words

__all__ = [
    "AT_BOUNDARY",
    "BOUNDARY",
    "CROWDED",
    "EDGE_BOUNDARY",
    "EDGE_CROWDED",
    "EDGE_TURNED",
    "INSIDE",
    "OPPOSED",
    "SINGULAR",
    "TURNED",
    "UNUSED",
    "count_corners",
    "fill_stars",
    "first_places",
    "label_fans",
    "look_closer",
    "scratch_size",
    "survey",
    "write_twins",
]

# Slots and half-edges without a neighbour: at an edge of one face, and at one of three or more.
BOUNDARY = np.int32(-1)
CROWDED = np.int32(-2)
# And where the two faces run along the edge the same way, if these shall be no neighbours.
OPPOSED = np.int32(-3)

# What a vertex is: one closed fan, one open fan that ends at the boundary, anything else; and a further bit where two
# faces at one of its edges run the same way along it.
UNUSED = np.uint8(0)
INSIDE = np.uint8(1)
AT_BOUNDARY = np.uint8(2)
SINGULAR = np.uint8(3)
TURNED = np.uint8(4)

# What the edge of a half-edge is, where it is not an edge of two faces that run along it in opposite directions.
EDGE_BOUNDARY = np.uint8(1)
EDGE_CROWDED = np.uint8(2)
EDGE_TURNED = np.uint8(3)

# Stars up to this size are tried as one closed fan first, which needs no sorting.
_SMALL = 16
_LOW = np.uint64(0xFFFFFFFF)
_HALF = np.uint64(32)


def scratch_size(largest: int) -> int:
    """Words of scratch for stars of up to `largest` corners: two runs of keys, and the slots across."""
    return 5 * largest


@kernel
def count_corners(indices, begin, end, counts):
    """Add to `counts`, (vertices,), the corners `begin` to `end`."""
    for c in range(begin, end):
        counts[indices[c]] += 1


@kernel
def first_places(counts, starts):
    """Turn the counts of each run of corners, (runs, vertices), into the places where each run's corners go.

    `starts`, (vertices + 1,), gets the first place of each vertex. Returns the largest number of corners at one.
    """
    place = np.int32(0)
    largest = np.int32(0)
    for v in range(counts.shape[1]):
        starts[v] = place
        for run in range(counts.shape[0]):
            count = counts[run, v]
            counts[run, v] = place
            place += count
        largest = max(largest, place - starts[v])
    starts[counts.shape[1]] = place
    return largest


@kernel
def fill_stars(indices, begin, end, places, star):
    """Put the corners `begin` to `end` into the stars of their vertices."""
    for c in range(begin, end):
        v = indices[c]
        star[places[v]] = c
        places[v] += 1


@device
def _next(c, following):
    if len(following):
        return np.int64(following[c])
    return c - 2 if c % 3 == 2 else c + 1


@device
def _previous(c, preceding):
    if len(preceding):
        return np.int64(preceding[c])
    return c + 2 if c % 3 == 0 else c - 1


@device
def _slots(indices, following, preceding, star, keys, spare):
    """The sorted words (other end, slot) of the star `star`, a list of corners."""
    for i in range(len(star)):
        c = np.int64(star[i])
        ahead = np.uint64(indices[_next(c, following)])
        behind = np.uint64(indices[_previous(c, preceding)])
        keys[2 * i] = (ahead << _HALF) | np.uint64(2 * i)
        keys[2 * i + 1] = (behind << _HALF) | np.uint64(2 * i + 1)
    sort_words(keys, spare, 2 * len(star))


@device
def _run_end(keys, first, count):
    """Where the run of slots with one other end stops that starts at `first`."""
    end = first + 1
    while end < count and keys[end] >> _HALF == keys[first] >> _HALF:
        end += 1
    return end


@device
def _match(keys, across, count):
    """Fill `across` from sorted slots: (edges at the vertex, worst kind of slot: 0, BOUNDARY or CROWDED, turned)."""
    edges = 0
    worst = np.int32(0)
    turned = False
    first = 0
    while first < count:
        end = _run_end(keys, first, count)
        if end - first == 2:
            one, other = np.int64(keys[first] & _LOW), np.int64(keys[first + 1] & _LOW)
            across[one], across[other] = other, one
            turned |= (one ^ other) & 1 == 0
        else:
            lone = BOUNDARY if end - first == 1 else CROWDED
            worst = min(worst, lone)
            for i in range(first, end):
                across[np.int64(keys[i] & _LOW)] = lone
        edges += 1
        first = end
    return edges, worst, turned


@device
def _walk(across, slot, fan, fans):
    """Mark the corners from `slot` on, away from it, with a fan's number: (corners, the slot at the end).

    `fans` is -1 where no fan has been. The last slot is one without a neighbour, or `slot` itself for a closed fan.
    """
    corners = 0
    while True:
        fans[slot >> 1] = fan
        corners += 1
        slot ^= 1
        beyond = np.int64(across[slot])
        if beyond < 0 or fans[beyond >> 1] >= 0:
            return corners, slot
        slot = beyond


@device
def _is_closed_fan(indices, following, preceding, star, ahead, behind):
    """Whether a small star is one closed fan whose faces all turn the same way.

    If the walk that goes from each corner to the first one that leaves for where it came from passes all corners, no
    two of them leave for the same vertex: an edge of three faces cannot hide.
    """
    count = len(star)
    for i in range(count):
        c = np.int64(star[i])
        ahead[i] = indices[_next(c, following)]
        behind[i] = indices[_previous(c, preceding)]
    i = 0
    for step in range(1, count + 1):
        wanted = behind[i]
        i = 0
        while i < count and ahead[i] != wanted:
            i += 1
        if i == count:
            return False
        if i == 0:
            return step == count
    return False


@kernel
def survey(indices, following, preceding, starts, star, first, last, scratch, degree, kind):
    """Degree and kind of the vertices `first` to `last`; `scratch` is uint64, of `scratch_size`.

    `degree` gets the number of edges at each vertex. A star that is not one closed fan of faces that turn alike is
    sorted and walked.
    """
    size = len(scratch) // 5
    keys, spare = scratch[: 2 * size], scratch[2 * size : 4 * size]
    across = scratch[4 * size :].view(np.int32)
    # The same memory: a star is walked only after it was sorted.
    fans = spare.view(np.int32)
    for v in range(first, last):
        corners = star[starts[v] : starts[v + 1]]
        count = len(corners)
        if count == 0:
            degree[v] = 0
            kind[v] = UNUSED
            continue
        if count <= _SMALL and _is_closed_fan(indices, following, preceding, corners, across[:size], across[size:]):
            degree[v] = count
            kind[v] = INSIDE
            continue
        _slots(indices, following, preceding, corners, keys, spare)
        edges, worst, turned = _match(keys, across, 2 * count)
        degree[v] = edges
        kind[v] = _kind(across, fans, count, worst) | (TURNED if turned else UNUSED)


@device
def _kind(across, fans, count, worst):
    """INSIDE, AT_BOUNDARY or SINGULAR."""
    if worst == CROWDED:
        return SINGULAR
    begin = 0
    if worst == BOUNDARY:
        while across[begin] != BOUNDARY:
            begin += 1
    fans[:count] = -1
    corners, _ = _walk(across, begin, 0, fans)
    if corners < count:
        return SINGULAR
    return AT_BOUNDARY if worst == BOUNDARY else INSIDE


@device
def _half_edge(star, preceding, slot):
    c = np.int64(star[slot >> 1])
    return c if slot & 1 == 0 else _previous(c, preceding)


@device
def _find_fans(across, fans, count, ends):
    """Number the fans of a star, open ones first: (fans, open ones).

    The open fan number i runs from slot `ends[2 i]` to slot `ends[2 i + 1]`; `ends` may be empty.
    """
    fans[:count] = -1
    found = 0
    for slot in range(2 * count):
        if across[slot] < 0 and fans[slot >> 1] < 0:
            _, end = _walk(across, slot, found, fans)
            if len(ends):
                ends[2 * found] = slot
                ends[2 * found + 1] = end
            found += 1
    open_fans = found
    for i in range(count):
        if fans[i] < 0:
            _walk(across, 2 * i, found, fans)
            found += 1
    return found, open_fans


@kernel
def look_closer(indices, following, preceding, starts, star, chosen, places, first, last, scratch, edge_kind, ends):
    """What is special at the vertices `chosen[first:last]`.

    `edge_kind` gets the kinds of the half-edges at them. `ends`, filled with -1 before, gets from `2 places[i]` on a
    pair for each open fan of vertex i: twice the half-edge at its begin, plus 1 where this comes in, and the same of
    the half-edge at its end.
    """
    size = len(scratch) // 5
    keys, spare = scratch[: 2 * size], scratch[2 * size : 4 * size]
    across = scratch[4 * size :].view(np.int32)
    fans = spare.view(np.int32)
    for i in range(first, last):
        v = chosen[i]
        corners = star[starts[v] : starts[v + 1]]
        count = len(corners)
        _slots(indices, following, preceding, corners, keys, spare)
        _match(keys, across, 2 * count)
        for slot in range(2 * count):
            beyond = np.int64(across[slot])
            if beyond < 0:
                edge_kind[_half_edge(corners, preceding, slot)] = EDGE_BOUNDARY if beyond == -1 else EDGE_CROWDED
            elif (beyond ^ slot) & 1 == 0:
                edge_kind[_half_edge(corners, preceding, slot)] = EDGE_TURNED
        mine = ends[2 * places[i] : 2 * places[i + 1]]
        _, open_fans = _find_fans(across, fans, count, mine)
        for k in range(2 * open_fans):
            slot = np.int64(mine[k])
            mine[k] = 2 * _half_edge(corners, preceding, slot) + (slot & 1)


@kernel
def label_fans(indices, following, preceding, starts, star, chosen, first, last, scratch, fan, fan_count):
    """Number the fans at the vertices `chosen[first:last]`.

    Each corner's number goes to `fan`, how many there are at a vertex to `fan_count`.
    """
    size = len(scratch) // 5
    keys, spare = scratch[: 2 * size], scratch[2 * size : 4 * size]
    across = scratch[4 * size :].view(np.int32)
    fans = spare.view(np.int32)
    for i in range(first, last):
        v = chosen[i]
        corners = star[starts[v] : starts[v + 1]]
        count = len(corners)
        _slots(indices, following, preceding, corners, keys, spare)
        _match(keys, across, 2 * count)
        fan_count[i], _ = _find_fans(across, fans, count, fans[:0])
        for k in range(count):
            fan[corners[k]] = fans[k]


@kernel
def write_twins(indices, following, preceding, starts, star, first, last, scratch, opposed, twin):
    """Write into `twin` the half-edge on the other side of each edge of the vertices `first` to `last`.

    Or BOUNDARY, CROWDED and, with `opposed`, OPPOSED. Each edge is written from its end with the smaller number.
    """
    size = len(scratch) // 5
    keys, spare = scratch[: 2 * size], scratch[2 * size : 4 * size]
    for v in range(first, last):
        corners = star[starts[v] : starts[v + 1]]
        count = 2 * len(corners)
        _slots(indices, following, preceding, corners, keys, spare)
        begin = 0
        while begin < count:
            end = _run_end(keys, begin, count)
            if keys[begin] >> _HALF > np.uint64(v):
                one = _half_edge(corners, preceding, np.int64(keys[begin] & _LOW))
                if end - begin == 2:
                    other = _half_edge(corners, preceding, np.int64(keys[begin + 1] & _LOW))
                    if opposed and indices[one] == indices[other]:
                        twin[one], twin[other] = OPPOSED, OPPOSED
                    else:
                        twin[one], twin[other] = other, one
                else:
                    for i in range(begin, end):
                        lone = BOUNDARY if end - begin == 1 else CROWDED
                        twin[_half_edge(corners, preceding, np.int64(keys[i] & _LOW))] = lone
            begin = end
