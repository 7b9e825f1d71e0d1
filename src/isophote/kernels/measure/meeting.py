"""Whether two triangles of a mesh meet anywhere but in the vertices and the edge that they share, exactly.

Triangles are closed sets, and are given by the numbers of their vertices, where one place has one number. Two of them
meet where an edge of one meets the other; so everything is decided by the sides on which points lie of planes and, in
a plane, of lines (Guigue, Devillers: "Fast and Robust Triangle-Triangle Overlap Test Using Orientation Predicates",
2003). Triangles without area are what they are as sets: segments or points.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import exact_apart, exact_device
from isophote.kernels.base.predicates import orient2d, orient3d

__all__ = ["is_flat", "triangles_meet"]

_MINUS, _NONE, _PLUS = np.int64(-1), np.int64(0), np.int64(1)


# --- sides ----------------------------------------------------------------------------------------


@exact_device
def _plane_side(v, a, b, c, d):
    """The side of the plane through a, b, c on which d lies."""
    return orient3d(
        v[a, 0], v[a, 1], v[a, 2], v[b, 0], v[b, 1], v[b, 2], v[c, 0], v[c, 1], v[c, 2], v[d, 0], v[d, 1], v[d, 2]
    )  # fmt: skip


@exact_device
def _line_side(v, axis, a, b, c):
    """The side of the line through a and b on which c lies, all seen along an axis."""
    i, j = (axis + 1) % 3, (axis + 2) % 3
    return orient2d(v[a, i], v[a, j], v[b, i], v[b, j], v[c, i], v[c, j])


@exact_apart
def _open_axis(v, a, b, c):
    """An axis along which a, b, c are not seen on one line; -1 if they lie on one."""
    for axis in range(3):
        if _line_side(v, axis, a, b, c) != 0:
            return np.int64(axis)
    return _MINUS


@exact_device
def _before(v, a, b):
    """Whether a comes before b by x, then y, then z: on a line, the order along it."""
    for axis in range(3):
        if v[a, axis] != v[b, axis]:
            return v[a, axis] < v[b, axis]
    return False


@exact_device
def _between(v, a, b, c):
    """Whether c, on a line with a and b, lies between them or at one of them."""
    if _before(v, b, a):
        a, b = b, a
    return not _before(v, c, a) and not _before(v, b, c)


# --- segments -------------------------------------------------------------------------------------


@exact_device
def _segments_meet(v, axis, p, q, r, s):
    """Whether two segments of one plane meet, seen along an axis that the plane does not hold."""
    from_pq, to_pq = _line_side(v, axis, p, q, r), _line_side(v, axis, p, q, s)
    from_rs, to_rs = _line_side(v, axis, r, s, p), _line_side(v, axis, r, s, q)
    if from_pq * to_pq < 0 and from_rs * to_rs < 0:
        return True
    return (
        (from_pq == 0 and _between(v, p, q, r))
        or (to_pq == 0 and _between(v, p, q, s))
        or (from_rs == 0 and _between(v, r, s, p))
        or (to_rs == 0 and _between(v, r, s, q))
    )


@exact_device
def _agree(a, b, c):
    """Whether no two of three signs are opposite."""
    return min(a, min(b, c)) >= 0 or max(a, max(b, c)) <= 0


@exact_device
def _segment_meets(v, p, q, a, b, c):
    """Whether the segment from p to q meets the triangle a, b, c, which has an area."""
    start, end = _plane_side(v, a, b, c, p), _plane_side(v, a, b, c, q)
    if start * end > 0:
        return False
    if start != 0 or end != 0:
        return _agree(_plane_side(v, p, q, a, b), _plane_side(v, p, q, b, c), _plane_side(v, p, q, c, a))
    axis = _open_axis(v, a, b, c)
    if _agree(_line_side(v, axis, a, b, p), _line_side(v, axis, b, c, p), _line_side(v, axis, c, a, p)):
        return True
    for _ in range(3):
        if _segments_meet(v, axis, p, q, a, b):
            return True
        a, b, c = b, c, a
    return False


# --- triangles with an area -----------------------------------------------------------------------


@exact_device
def _meet_beside_edge(v, a, b, c, d):
    """Triangles a, b, c and a, b, d."""
    if _plane_side(v, a, b, c, d) != 0:
        return False
    axis = _open_axis(v, a, b, c)
    return _line_side(v, axis, a, b, c) == _line_side(v, axis, a, b, d)


@exact_device
def _meet_beside_vertex(v, a, b, c, d, e):
    """Triangles a, b, c and a, d, e. A ray from a that lies in both leaves one of them through its far edge."""
    if _plane_side(v, a, b, c, d) * _plane_side(v, a, b, c, e) > 0:
        return False
    return _segment_meets(v, b, c, a, d, e) or _segment_meets(v, d, e, a, b, c)


@exact_device
def _all_aside(v, a, b, c, d, e, f):
    """Whether d, e, f lie strictly on one side of the plane of a, b, c."""
    side = _plane_side(v, a, b, c, d)
    return side != 0 and _plane_side(v, a, b, c, e) == side and _plane_side(v, a, b, c, f) == side


@exact_device
def _meet_apart(v, a, b, c, d, e, f):
    """Triangles a, b, c and d, e, f."""
    if _all_aside(v, a, b, c, d, e, f) or _all_aside(v, d, e, f, a, b, c):
        return False
    for _ in range(3):
        if _segment_meets(v, a, b, d, e, f) or _segment_meets(v, d, e, a, b, c):
            return True
        a, b, c, d, e, f = b, c, a, e, f, d
    return False


# --- triangles without area -----------------------------------------------------------------------


@exact_device
def is_flat(v, a, b, c):
    """Whether a triangle has no area."""
    return _open_axis(v, a, b, c) < 0


@exact_device
def _ends(v, a, b, c):
    """The ends of the segment that a triangle without area is."""
    low = b if _before(v, b, a) else a
    high = a if _before(v, b, a) else b
    if _before(v, c, low):
        low = c
    if _before(v, high, c):
        high = c
    return low, high


@exact_device
def _runs_into(v, a, p, d, e):
    """Whether the segment from a to p has more than a in common with the triangle a, d, e."""
    if p == a or _plane_side(v, a, d, e, p) != 0:
        return False
    axis = _open_axis(v, a, d, e)
    front = _line_side(v, axis, a, d, e)
    return _line_side(v, axis, a, d, p) * front >= 0 and _line_side(v, axis, a, p, e) * front >= 0


@exact_apart
def _lines_meet(v, p, q, r, s, shared, first, last):
    """Segments p to q and r to s, each given in order, that share `shared` numbered points from `first` to `last`."""
    if _open_axis(v, p, q, r) < 0 and _open_axis(v, p, q, s) < 0 and _open_axis(v, r, s, p) < 0:
        low = r if _before(v, p, r) else p
        high = s if _before(v, s, q) else q
        if _before(v, high, low):
            return False
        return shared == 0 or _before(v, low, first) or _before(v, last, high)
    if shared > 0 or _plane_side(v, p, q, r, s) != 0:
        return False
    axis = max(max(_open_axis(v, p, q, r), _open_axis(v, p, q, s)), _open_axis(v, r, s, p))
    return _segments_meet(v, axis, p, q, r, s)


@exact_device
def _flat_meets(v, t, s, shared, first, last, flat_too):
    """Triangle t without area and triangle s, which has none either if `flat_too`; both share `shared` vertices."""
    low, high = _ends(v, t[0], t[1], t[2])
    if flat_too:
        other_low, other_high = _ends(v, s[0], s[1], s[2])
        return _lines_meet(v, low, high, other_low, other_high, shared, first, last)
    if shared == 0:
        return _segment_meets(v, low, high, s[0], s[1], s[2])
    if shared > 1:
        return False
    a, d, e = s
    while a != first:
        a, d, e = d, e, a
    return _runs_into(v, a, low, d, e) or _runs_into(v, a, high, d, e)


# --- all pairs ------------------------------------------------------------------------------------


@exact_device
def _shares(a, s):
    return a == s[0] or a == s[1] or a == s[2]


@exact_apart
def _flat_pair(v, t, s, t_flat, s_flat):
    shared, first, last = _NONE, t[0], t[0]
    for k in range(3):
        a = t[k]
        if not _shares(a, s) or (k > 0 and a == t[0]) or (k > 1 and a == t[1]):
            continue
        first = a if shared == 0 or _before(v, a, first) else first
        last = a if shared == 0 or _before(v, last, a) else last
        shared += 1
    if t_flat:
        return _flat_meets(v, t, s, shared, first, last, s_flat)
    return _flat_meets(v, s, t, shared, first, last, t_flat)


@exact_device
def triangles_meet(v, t, s, t_flat, s_flat):
    """Whether triangles t and s, three rows of `v` (n, 3) each, meet anywhere but in what they share.

    `t_flat`, `s_flat`: whether they have no area.
    """
    if t_flat or s_flat:
        return _flat_pair(v, t, s, t_flat, s_flat)
    a, b, c = t
    d, e, f = s
    shared = np.int64(_shares(a, s)) + np.int64(_shares(b, s)) + np.int64(_shares(c, s))
    if shared == 0:
        return _meet_apart(v, a, b, c, d, e, f)
    if shared == 3:
        return True
    # What they share comes first, or, of an edge, what they do not share comes last.
    if shared == 1:
        while not _shares(a, s):
            a, b, c = b, c, a
        while d != a:
            d, e, f = e, f, d
        return _meet_beside_vertex(v, a, b, c, e, f)
    while _shares(c, s):
        a, b, c = b, c, a
    while _shares(f, t):
        d, e, f = e, f, d
    return _meet_beside_edge(v, a, b, c, f)
