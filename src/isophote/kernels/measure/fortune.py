"""Fortune's sweep: the Delaunay triangulation of points of the plane, the dual of their Voronoi diagram.

Fortune, "A Sweepline Algorithm for Voronoi Diagrams", 1987. The sweep line goes upwards. Below the beach line, which is
made of arcs of parabolas, it is known which site is nearest. At a site a new arc appears within another. At the top of
the circle through the sites of three arcs side by side the middle one vanishes, and the three sites are a triangle.
Circle events wait in lists, one for each part of the sites' height; those of the part where the sweep line is are in a
heap. One that is no more valid is known by the stamp of its arc.

Where a circle ends is rounded, so events within rounding of each other may be taken in the wrong order. Which arcs meet
at all is decided exactly, by `orient2d`, so that what comes out is a triangulation in any case; its sides are checked
with `incircle` afterwards, and mended by flips (`flips`).
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import exact_device, exact_kernel
from isophote.kernels.base.predicates import orient2d
from isophote.kernels.measure.fortune_beach import (
    append_arc,
    arc_number,
    arc_place,
    find_arc,
    free_edge,
    insert_behind,
    new_arc,
    new_edge,
    remove_arc,
)
from isophote.kernels.measure.fortune_circles import top
from isophote.kernels.measure.fortune_state import (
    ARC,
    BUCKET,
    CIRCLES,
    EDGE,
    FREE_WAITING,
    HEAP,
    LEFT,
    NEW_ARC,
    NOTHING,
    OUTSIDE,
    OWNER,
    RIGHT,
    SITE,
    STAMP,
    SWEEP,
    TRIANGLES,
    WAITING,
)

__all__ = ["advance", "owners"]

_NONE = np.int32(-1)
_STAMP_BITS = np.int64(32)
_open_sweep = SWEEP.open
_ARC_MASK = np.int64(0xFFFFFFFF)


@exact_device
def _rise(times, events, i, time, event):
    """Put an event into the hole at row i of the heap, or above it."""
    while i > 0:
        above = (i - 1) >> 1
        if times[above] <= time:
            break
        times[i], events[i] = times[above], events[above]
        i = above
    times[i], events[i] = time, event


@exact_device
def _push(s, time, event):
    """Put an event into the heap."""
    i = s.counts[HEAP]
    s.counts[HEAP] = i + 1
    _rise(s.times, s.events, i, time, event)


@exact_device
def _bucket(s, time):
    """The bucket that events of a time wait in."""
    at = (time - s.frame[2]) * s.frame[3]
    last = s.buckets.rows - 1
    return np.int64(at) if at < last else last


@exact_device
def _enter(s, time, arc):
    """Enter the event of an arc: into the heap, or the bucket where it is to wait."""
    event = (arc_number(s, arc, STAMP) << _STAMP_BITS) | np.int64(arc)
    bucket = _bucket(s, time)
    if bucket <= s.counts[BUCKET]:
        _push(s, time, event)
        return
    i = s.counts[FREE_WAITING]
    if i >= 0:
        s.counts[FREE_WAITING] = s.behind[i]
    else:
        i = s.counts[WAITING]
        s.counts[WAITING] = i + 1
    s.due[i], s.waiting[i] = time, event
    s.behind[i] = s.buckets[bucket]
    s.buckets[bucket] = i


@exact_device
def _next_bucket(s):
    """Put what is still valid of the events of the next bucket into the heap."""
    bucket = s.counts[BUCKET] + 1
    s.counts[BUCKET] = bucket
    i = np.int64(s.buckets[bucket])
    while i >= 0:
        event = s.waiting[i]
        if _is_valid(s, event):
            _push(s, s.due[i], event)
        following = np.int64(s.behind[i])
        s.behind[i] = s.counts[FREE_WAITING]
        s.counts[FREE_WAITING] = i
        i = following


@exact_device
def _pop(s):
    """Take the first event out of the heap.

    The hole sinks to the bottom, past the lesser of two children each time, and the last event rises from there, mostly
    not at all: so hardly a step depends on a comparison that cannot be foretold.
    """
    count = s.counts[HEAP] - 1
    s.counts[HEAP] = count
    # Fields are read anew after each store, which might have changed them; not so these.
    times, events = s.times, s.events
    i, child = np.int64(0), np.int64(1)
    while child + 1 < count:
        child += np.int64(times[child + 1] < times[child])
        times[i], events[i] = times[child], events[child]
        i, child = child, 2 * child + 1
    if child < count:
        times[i], events[i] = times[child], events[child]
        i = child
    _rise(times, events, i, times[count], events[count])


@exact_device
def _is_valid(s, event):
    return arc_number(s, event & _ARC_MASK, STAMP) == event >> _STAMP_BITS


@exact_device
def _has_circle(s, y):
    """Whether a valid event is due before the sweep line is higher than y; it is the first of the heap then."""
    last = _bucket(s, y)
    while True:
        while s.counts[HEAP] > 0:
            if _is_valid(s, s.events[0]):
                return s.times[0] <= y
            _pop(s)
        if s.counts[BUCKET] >= last:
            return False
        _next_bucket(s)


@exact_device
def _cancel(s, arc):
    """Make the event of an arc, if there is one, no more valid."""
    s.arcs[ARC * arc + STAMP] += 1


@exact_device
def _set_edge(s, arc, edge):
    s.arcs[ARC * arc + EDGE] = edge


@exact_device
def _expect_circle(s, b):
    """Enter the event at which an arc vanishes, if its neighbours close in on it."""
    a, c = arc_number(s, b, LEFT), arc_number(s, b, RIGHT)
    if a < 0 or c < 0:
        return
    ax, ay = arc_place(s, a)
    bx, by = arc_place(s, b)
    cx, cy = arc_place(s, c)
    if (ax != cx or ay != cy) and orient2d(ax, ay, bx, by, cx, cy) > 0:
        _enter(s, top(ax, ay, bx, by, cx, cy), b)


@exact_device
def _first_row(s):
    """Put all sites that share the least y side by side; their breakpoints come up from below."""
    last = np.int64(-1)
    site = s.counts[SITE]
    while 2 * site < s.sites.rows and s.sites[2 * site + 1] == s.sites[1]:
        arc = new_arc(s, site)
        append_arc(s, last, arc)
        if last >= 0:
            _set_edge(s, last, new_edge(s, OUTSIDE))
        last = arc
        site += 1
    s.counts[SITE] = site
    s.counts[NEW_ARC] = last


@exact_device
def _site_event(s):
    site = s.counts[SITE]
    s.counts[SITE] = site + 1
    above = find_arc(s, s.sites[2 * site], s.sites[2 * site + 1])
    _cancel(s, above)
    arc, rest = new_arc(s, site), new_arc(s, arc_number(s, above, OWNER))
    insert_behind(s, above, arc, rest)
    # Both breakpoints draw the same edge, in opposite directions.
    edge = new_edge(s, NOTHING)
    _set_edge(s, rest, arc_number(s, above, EDGE))
    _set_edge(s, above, edge)
    _set_edge(s, arc, edge)
    s.counts[NEW_ARC] = arc
    _expect_circle(s, above)
    _expect_circle(s, rest)


@exact_device
def _join(s, edge, triangle, k):
    """Make an edge side k of a triangle, on its upper side or the last free one."""
    other = s.sides[edge]
    s.neighbours[3 * triangle + k] = _NONE
    if other == NOTHING:
        s.sides[edge] = 3 * triangle + k
        return
    if other != OUTSIDE:
        s.neighbours[3 * triangle + k] = other // 3
        s.neighbours[other] = triangle
    free_edge(s, edge)


@exact_device
def _circle_event(s):
    arc = s.events[0] & _ARC_MASK
    _pop(s)
    a, c = arc_number(s, arc, LEFT), arc_number(s, arc, RIGHT)
    triangle = s.counts[TRIANGLES]
    s.counts[TRIANGLES] = triangle + 1
    s.counts[CIRCLES] += 1
    s.triangles[3 * triangle + 0] = arc_number(s, a, OWNER)
    s.triangles[3 * triangle + 1] = arc_number(s, arc, OWNER)
    s.triangles[3 * triangle + 2] = arc_number(s, c, OWNER)
    _join(s, arc_number(s, arc, EDGE), triangle, np.int64(0))
    _join(s, arc_number(s, a, EDGE), triangle, np.int64(2))
    s.neighbours[3 * triangle + 1] = _NONE
    _set_edge(s, a, new_edge(s, 3 * triangle + 1))
    _cancel(s, arc)
    _cancel(s, a)
    _cancel(s, c)
    remove_arc(s, arc)
    s.counts[NEW_ARC] = _NONE
    _expect_circle(s, a)
    _expect_circle(s, c)


@exact_kernel
def advance(table, events):
    """Take up to `events` events of a sweep, by the words of its table.

    Returns where the sweep line is then, NaN where no event was left.

    All sites that share the least y are one event.
    """
    s = _open_sweep(table)
    time = np.nan
    for _ in range(events):
        site = s.counts[SITE]
        y = s.sites[2 * site + 1] if 2 * site < s.sites.rows else np.inf
        if site > 0 and _has_circle(s, y):
            time = s.times[0]
            _circle_event(s)
        elif 2 * site < s.sites.rows:
            if site == 0:
                _first_row(s)
            else:
                _site_event(s)
            time = y
        else:
            return time
    return time


@exact_kernel
def owners(table, found):
    """Write the sites of the arcs of the beach line, from left to right; returns how many."""
    s = _open_sweep(table)
    count = 0
    arc = np.int64(s.firsts[s.directory[0]])
    while arc >= 0:
        found[count] = arc_number(s, arc, OWNER)
        count += 1
        arc = arc_number(s, arc, RIGHT)
    return count
