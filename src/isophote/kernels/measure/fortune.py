"""Fortune's sweep: the Delaunay triangulation of points of the plane, the dual of their Voronoi diagram.

Fortune, "A Sweepline Algorithm for Voronoi Diagrams", 1987. The sweep line goes upwards. Below the beach line, which is
made of arcs of parabolas, it is known which site is nearest. At a site a new arc appears within another. At the top of
the circle through the sites of three arcs side by side the middle one vanishes, and the three sites are a triangle.
Circle events wait in a heap; one that is no more valid is known by the stamp of its arc.

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
    CIRCLES,
    EDGE,
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
)

__all__ = ["advance"]

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
def _push(s, time, arc):
    i = s.counts[HEAP]
    s.counts[HEAP] = i + 1
    _rise(s.times, s.events, i, time, (arc_number(s, arc, STAMP) << _STAMP_BITS) | np.int64(arc))


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
def _drop_cancelled(s):
    """Take events that are no more valid off the front of the heap."""
    while s.counts[HEAP] > 0:
        event = s.events[0]
        if arc_number(s, event & _ARC_MASK, STAMP) == event >> _STAMP_BITS:
            return
        _pop(s)


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
    ax, ay, bx, by = s.places[2 * a], s.places[2 * a + 1], s.places[2 * b], s.places[2 * b + 1]
    cx, cy = s.places[2 * c], s.places[2 * c + 1]
    if (ax != cx or ay != cy) and orient2d(ax, ay, bx, by, cx, cy) > 0:
        _push(s, top(ax, ay, bx, by, cx, cy), b)


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
        _drop_cancelled(s)
        site = s.counts[SITE]
        if 2 * site < s.sites.rows:
            y = s.sites[2 * site + 1]
            if site == 0:
                _first_row(s)
                time = y
                continue
            if s.counts[HEAP] == 0 or s.times[0] > y:
                _site_event(s)
                time = y
                continue
        elif s.counts[HEAP] == 0:
            return time
        time = s.times[0]
        _circle_event(s)
    return time
