"""The medial axis of a polygon, traced from node to node.

A node is the middle of a ball that touches the boundary in two places or more. Between two places that follow each
other around it, a branch leaves the node: the path of balls that touch the sites there. It ends where one of the two
sites ends, and the next one along the boundary takes over, or where a third one is as near. That is found from far to
near: as long as some edge is nearer than the two sites at the end of the path, the path is cut where it becomes so.

Branches start at the vertices at which the inside is narrower than a half-plane, where balls have no radius, and at
every node that is found.
"""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.base.jit import device, kernel
from isophote.kernels.base.table import DOUBLE_BOXES, INT_ROWS, INTS, LONGS, Table
from isophote.kernels.measure.medial_paths import leaving, path, path_x, path_y, polished, site_distance
from isophote.kernels.measure.medial_sites import POLYGON, along, contacts, edge_distance, nearest_edge

__all__ = ["BALLS", "BRANCHES", "FAULTS", "LEFT", "NODE", "RIGHT", "TRACE", "TWIN", "trace"]

# Numbers of a branch: its node, the sites to its right and left, and the branch that comes back along it, -1 for none.
NODE, RIGHT, LEFT, TWIN = range(4)
BALLS, BRANCHES, FAULTS = range(3)
_NOBODY = np.int64(-1)
_HALVINGS = 60
_MOST_CONTACTS = 64
_CHECKS = 6
_TAU = 2 * math.pi

# balls      (v, 3) x, y, radius, flat in rows;  branch (b, 4);  course (b, 2) directions in which branches leave
# first      (v + 1,) the first branch of each node
# slots      a hash table of nodes by place
# counts     how many balls, branches, and branches without an end
TRACE = Table("Trace", balls=DOUBLE_BOXES, branch=INT_ROWS, course=DOUBLE_BOXES, first=INTS, slots=INTS, counts=LONGS)

_open_polygon, _open_trace = POLYGON.open, TRACE.open


@device
def _cell(value, size):
    return np.int64(math.floor(value / size))


@device
def _slot(t, cx, cy):
    mixed = np.uint64(cx) * np.uint64(0x9E3779B97F4A7C15) ^ np.uint64(cy) * np.uint64(0xC2B2AE3D27D4EB4F)
    mixed ^= mixed >> np.uint64(29)
    mixed *= np.uint64(0xBF58476D1CE4E5B9)
    return np.int64(mixed >> np.uint64(20)) & (t.slots.rows - 1)


@device
def _known_node(t, x, y, tolerance):
    """The node at a place, -1 if there is none yet."""
    size = 4 * tolerance
    cx, cy = _cell(x, size), _cell(y, size)
    for j in range(-1, 2):
        for i in range(-1, 2):
            slot = _slot(t, cx + i, cy + j)
            while t.slots[slot] >= 0:
                node = np.int64(t.slots[slot])
                if abs(t.balls[node, 0] - x) <= tolerance and abs(t.balls[node, 1] - y) <= tolerance:
                    return node
                slot = (slot + 1) & (t.slots.rows - 1)
    return _NOBODY


@device
def _new_node(t, x, y, radius, tolerance):
    node = t.counts[BALLS]
    t.counts[BALLS] = node + 1
    t.balls[node, 0], t.balls[node, 1], t.balls[node, 2] = x, y, radius
    t.first[node] = t.counts[BRANCHES]
    size = 4 * tolerance
    slot = _slot(t, _cell(x, size), _cell(y, size))
    while t.slots[slot] >= 0:
        slot = (slot + 1) & (t.slots.rows - 1)
    t.slots[slot] = node
    return node


@device
def _add_branch(t, node, right, left, wx, wy):
    branch = t.counts[BRANCHES]
    t.counts[BRANCHES] = branch + 1
    t.branch[branch, NODE], t.branch[branch, RIGHT], t.branch[branch, LEFT] = node, right, left
    t.branch[branch, TWIN] = _NOBODY
    t.course[branch, 0], t.course[branch, 1] = wx, wy
    t.first[node + 1] = branch + 1


@device
def _place(p, edge, x, y, tolerance):
    """The place at which a ball touches an edge: the edge, or n + v for its end v, if the foot is there.

    -1 where the foot is beyond an end, at which the next edge is nearer.
    """
    n = p.lengths.rows
    u = along(p, edge, x, y)
    if u <= tolerance:
        before = np.int64(p.before[edge])
        hidden = u < -tolerance and along(p, before, x, y) < p.lengths[before] - tolerance
        return _NOBODY if hidden else n + edge
    if u >= p.lengths[edge] - tolerance:
        after = np.int64(p.after[edge])
        hidden = u > p.lengths[edge] + tolerance and along(p, after, x, y) > tolerance
        return _NOBODY if hidden else n + after
    return edge


@device
def _site_towards(p, place, x, y, wx, wy, tolerance):
    """The site that a ball at (x, y), which touches a place, touches when it moves along w."""
    n = p.lengths.rows
    if place < n:
        return place
    after = place - n
    before = np.int64(p.before[after])
    dx, dy = p.directions[2 * after], p.directions[2 * after + 1]
    if abs(along(p, after, x, y)) <= tolerance and wx * dx + wy * dy > 0:
        return after
    dx, dy = p.directions[2 * before], p.directions[2 * before + 1]
    if abs(along(p, before, x, y) - p.lengths[before]) <= tolerance and wx * dx + wy * dy < 0:
        return before
    return place


@device
def _angle_of(p, place, x, y):
    n = p.lengths.rows
    if place < n:
        return math.atan2(-p.directions[2 * place], p.directions[2 * place + 1])
    v = place - n
    return math.atan2(p.starts[2 * v + 1] - y, p.starts[2 * v] - x)


@device
def _sorted_places(p, x, y, radius, tolerance, stack, places, angles):
    """Places at which a ball touches the boundary, each once, by angle; returns how many."""
    found = contacts(p, x, y, radius + tolerance, stack, places)
    count = 0
    for i in range(found):
        place = _place(p, places[i], x, y, tolerance)
        angle = _angle_of(p, place, x, y)
        at = count
        known = place < 0
        for k in range(count):
            known = known or places[k] == place
        if known:
            continue
        while at > 0 and angles[at - 1] > angle:
            places[at], angles[at] = places[at - 1], angles[at - 1]
            at -= 1
        places[at], angles[at] = place, angle
        count += 1
    return count


@device
def _open_node(p, t, x, y, radius, tolerance, stack, places, angles):
    """A node with all its branches, which are still to be traced."""
    node = _new_node(t, x, y, radius, tolerance)
    t.first[node + 1] = t.first[node]
    count = _sorted_places(p, x, y, radius, tolerance, stack, places, angles)
    if count < 2:
        return node
    for i in range(count):
        j = i + 1 if i + 1 < count else 0
        wide = angles[j] - angles[i]
        middle = angles[i] + (wide if j > 0 else wide + _TAU) / 2
        wx, wy = math.cos(middle), math.sin(middle)
        right = _site_towards(p, places[i], x, y, wx, wy, tolerance)
        left = _site_towards(p, places[j], x, y, wx, wy, tolerance)
        _add_branch(t, node, right, left, wx, wy)
    return node


@device
def _site_at(p, edge, x, y):
    """The site that is nearest on an edge with its ends."""
    n = p.lengths.rows
    u = along(p, edge, x, y)
    if u <= 0:
        return n + edge
    if u >= p.lengths[edge]:
        return n + np.int64(p.after[edge])
    return edge


@device
def _excess(p, site, edge, c, t):
    """How much farther a path at t is from an edge with its ends than from its own site."""
    x, y = path_x(c, t), path_y(c, t)
    return edge_distance(p, edge, x, y) - site_distance(p, site, x, y)


@device
def _cut(p, site, edge, c, end, least):
    """Where, before `end`, at which it is nearer, an edge becomes as near; `end` where it is so from the start."""
    low, high = 0.0, end
    if _excess(p, site, edge, c, low) <= least:
        low = end / 2
        while low > least and _excess(p, site, edge, c, low) <= 0:
            high, low = low, low / 2
        if low <= least:
            return end
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        if _excess(p, site, edge, c, middle) > 0:
            low = middle
        else:
            high = middle
    return high


@device
def _end_of(p, a, b, c, limit, tolerance, checks, stack):
    """(t, third): where a path between sites a and b ends, and a third site there, -1 where one of both ends."""
    end = min(leaving(p, a, c, tolerance), leaving(p, b, c, tolerance))
    third = _NOBODY
    if end > limit:
        end = limit
    step = np.int64(0)
    while step <= checks:
        # The end itself, then places between, where islands could be in the way.
        part = end if step == 0 else end * step / (checks + 1)
        x, y = path_x(c, part), path_y(c, part)
        edge, _ = nearest_edge(p, x, y, site_distance(p, a, x, y) - tolerance / 8, stack)
        cut = _cut(p, a, edge, c, part, tolerance) if edge >= 0 else part
        if cut < part:
            end, step = cut, np.int64(0)
            third = _site_at(p, edge, path_x(c, end), path_y(c, end))
        else:
            step += 1
    return end, third


@device
def _join(p, t, branch, node, x, y, tolerance):
    """Let a branch end at the branch of a node that comes back along it; returns whether there is one."""
    right, left = t.branch[branch, RIGHT], t.branch[branch, LEFT]
    for back in range(t.first[node], t.first[node + 1]):
        if (
            t.branch[back, RIGHT] == left
            and t.branch[back, LEFT] == right
            and t.branch[back, TWIN] < 0
            and back != branch
        ):
            t.branch[back, TWIN], t.branch[branch, TWIN] = branch, back
            return True
    return False


@device
def _follow(p, t, branch, limit, tolerance, checks, stack, places, angles):
    """Trace a branch to the node at its end; returns whether it arrived."""
    node = np.int64(t.branch[branch, NODE])
    a, b = np.int64(t.branch[branch, RIGHT]), np.int64(t.branch[branch, LEFT])
    c = path(p, a, b, t.balls[node, 0], t.balls[node, 1], t.course[branch, 0], t.course[branch, 1])
    end, third = _end_of(p, a, b, c, limit, tolerance, checks, stack)
    x, y = path_x(c, end), path_y(c, end)
    if third >= 0:
        x, y = polished(p, a, b, third, x, y)
    goal = _known_node(t, x, y, tolerance)
    if goal < 0:
        goal = _open_node(p, t, x, y, abs(site_distance(p, a, x, y)), tolerance, stack, places, angles)
    return _join(p, t, branch, goal, x, y, tolerance)


@kernel
def trace(polygon, table, tolerance, limit, checks):
    """Trace the medial axis of a `POLYGON` into a `TRACE`, by the words of both.

    Points within `tolerance` are one. `limit` is longer than any branch. At `checks` places along each branch it is
    looked whether another site is nearer, for polygons with holes.
    """
    p, t = _open_polygon(polygon), _open_trace(table)
    n = p.lengths.rows
    stack, places, angles = np.empty(256, np.int64), np.empty(_MOST_CONTACTS, np.int64), np.empty(_MOST_CONTACTS)
    for v in range(n):
        if p.reflex[v] == 0:
            node = _new_node(t, p.starts[2 * v], p.starts[2 * v + 1], 0.0, tolerance)
            b = np.int64(p.before[v])
            # Inwards: to the left of both edges where the vertex is flat, between them where it is sharp.
            wx = p.directions[2 * v] - p.directions[2 * b] - p.directions[2 * v + 1] - p.directions[2 * b + 1]
            wy = p.directions[2 * v + 1] - p.directions[2 * b + 1] + p.directions[2 * v] + p.directions[2 * b]
            _add_branch(t, node, v, b, wx, wy)
    branch = np.int64(0)
    while branch < t.counts[BRANCHES]:
        if t.counts[BRANCHES] + _MOST_CONTACTS > t.branch.rows or t.counts[BALLS] + 2 > t.balls.rows:
            t.counts[FAULTS] += 1
            return
        if t.branch[branch, TWIN] < 0 and not _follow(p, t, branch, limit, tolerance, checks, stack, places, angles):
            t.counts[FAULTS] += 1
        branch += 1
