"""Where outlines cross and overlap: arcs cut there, and which of the pieces are boundary."""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.shapes.field.arcs import arc_points, arc_slopes, nearest_parameters, winding_numbers

__all__ = ["Cuts", "cut_arcs", "find_cuts", "sides_of", "split_monotone"]

Floats: TypeAlias = npt.NDArray[np.float64]
Ints: TypeAlias = npt.NDArray[np.int64]

# Arcs count as meeting within this part of the largest coordinate: what single precision may move their ends by.
_PART = 2.0**-21
# Halvings of both arcs before Newton's steps, and the steps.
_HALVINGS, _STEPS = 14, 4
# Where arcs run along each other more pairs of their pieces meet than can be told apart.
_MOST_PAIRS = 1 << 19
_ROWS = 1 << 21


class Cuts(NamedTuple):
    """Arcs to be cut: their numbers, parameters, and the points (n, 2) where the pieces are to meet."""

    arc: Ints
    parameter: Floats
    point: Floats


def _between(arcs: Floats, low: Floats, high: Floats) -> Floats:
    """The part of each arc from one parameter to another: the quadratic's blossom gives the control points."""
    parts = []
    for s, t in ((low, low), (low, high), (high, high)):
        for k in (0, 1):
            first = (1 - s) * arcs[:, k] + s * arcs[:, k + 2]
            second = (1 - s) * arcs[:, k + 2] + s * arcs[:, k + 4]
            parts.append((1 - t) * first + t * second)
    return np.column_stack(parts)


def split_monotone(arcs: Floats) -> tuple[Floats, Ints]:
    """Arcs cut where they turn back in x or y, and the number of the arc that each comes from."""
    cuts = []
    for k in (0, 1):
        rise, bend = arcs[:, k + 2] - arcs[:, k], arcs[:, k] - 2 * arcs[:, k + 2] + arcs[:, k + 4]
        with np.errstate(all="ignore"):
            t = -rise / bend
        turning = np.flatnonzero((t > 0) & (t < 1) & (rise * (arcs[:, k + 4] - arcs[:, k + 2]) < 0))
        x, y = arc_points(arcs[turning], t[turning])
        cuts.append(Cuts(turning, t[turning], np.column_stack([x, y])))
    pieces, origin = cut_arcs(arcs, Cuts(*(np.concatenate(parts) for parts in zip(*cuts, strict=True))))
    # A control point beyond the ends is there by rounding alone.
    low, high = np.minimum(pieces[:, :2], pieces[:, 4:]), np.maximum(pieces[:, :2], pieces[:, 4:])
    pieces[:, 2:4] = np.clip(pieces[:, 2:4], low, high)
    return pieces, origin


def cut_arcs(arcs: Floats, cuts: Cuts) -> tuple[Floats, Ints]:
    """Arcs cut at the given places, in order, and the number of the arc that each piece comes from."""
    order = np.lexsort((cuts.parameter, cuts.arc))
    arc, t, point = cuts.arc[order], cuts.parameter[order], cuts.point[order]
    new = np.ones(len(arc), bool)
    new[1:] = (arc[1:] != arc[:-1]) | (t[1:] > t[:-1])
    arc, t, point = arc[new], t[new], point[new]
    count = np.bincount(arc, minlength=len(arcs)) + 1
    origin = np.repeat(np.arange(len(arcs)), count)
    first = np.cumsum(count) - count
    low, high = np.zeros(len(origin)), np.ones(len(origin))
    start, end = arcs[origin, :2], arcs[origin, 4:]
    # The k-th cut of all ends one piece; the cuts before it, and the arcs before its own, end others.
    place = np.arange(len(arc)) + arc
    high[place], low[place + 1] = t, t
    end[place], start[place + 1] = point, point
    pieces = _between(arcs[origin], low, high)
    whole = np.zeros(len(origin), bool)
    whole[first] = count == 1
    pieces[whole] = arcs[origin[whole]]
    pieces[:, :2], pieces[:, 4:] = start, end
    kept = (pieces[:, :2] != pieces[:, 4:]).any(axis=1)
    return pieces[kept], origin[kept]


def find_cuts(arcs: Floats, where: str = "crossings") -> Cuts:
    """Where monotone arcs cross one another, or (`where` "ends") hold an end of another one."""
    tolerance = _PART * float(np.abs(arcs).max())
    first, second = _meeting_boxes(arcs, tolerance)
    if where == "ends":
        return _ends_on_arcs(arcs, first, second, tolerance)
    ends = np.sort(np.stack([_keys(arcs[:, :2]), _keys(arcs[:, 4:])]), axis=0)
    same = (ends[:, first] == ends[:, second]).all(axis=0)
    return _crossings(arcs, first[~same], second[~same])


def _keys(points: Floats) -> npt.NDArray[np.complex128]:
    keys: npt.NDArray[np.complex128] = points[:, 0] + 1j * points[:, 1]
    return keys


def _meeting_boxes(arcs: Floats, slack: float) -> tuple[Ints, Ints]:
    """Pairs of arcs whose boxes meet, the first with the lower left side."""
    low, high = np.minimum(arcs[:, :2], arcs[:, 4:]) - slack, np.maximum(arcs[:, :2], arcs[:, 4:]) + slack
    order = np.argsort(low[:, 0], kind="stable")
    last = np.searchsorted(low[order, 0], high[order, 0], side="right")
    count = last - np.arange(len(arcs)) - 1
    pairs: list[tuple[Ints, Ints]] = []
    for begin, end in _chunks(count):
        i = np.repeat(np.arange(begin, end), count[begin:end])
        j = np.arange(len(i)) - np.repeat(np.cumsum(count[begin:end]) - count[begin:end], count[begin:end]) + i + 1
        a, b = order[i], order[j]
        meet = (low[a, 1] <= high[b, 1]) & (low[b, 1] <= high[a, 1])
        pairs.append((a[meet], b[meet]))
    return np.concatenate([a for a, _ in pairs]), np.concatenate([b for _, b in pairs])


def _chunks(count: Ints) -> list[tuple[int, int]]:
    """Runs of rows with about so many pairs each."""
    group = np.cumsum(count) // _ROWS
    starts = np.flatnonzero(np.diff(group, prepend=-1))
    return list(zip(starts.tolist(), [*starts[1:].tolist(), len(count)], strict=True))


def _ends_on_arcs(arcs: Floats, first: Ints, second: Ints, tolerance: float) -> Cuts:
    arc = np.concatenate([first, second])
    other = np.concatenate([second, first])
    # Outlines are closed: an arc's end is the next one's start.
    point = arcs[other, :2]
    t = nearest_parameters(arcs[arc], point[:, 0], point[:, 1])
    x, y = arc_points(arcs[arc], t)
    near = np.hypot(x - point[:, 0], y - point[:, 1]) <= tolerance
    apart = np.minimum(np.abs(arcs[arc, :2] - point).max(axis=1), np.abs(arcs[arc, 4:] - point).max(axis=1))
    inside = near & (t > 0) & (t < 1) & (apart > tolerance)
    return Cuts(arc[inside], t[inside], point[inside])


def _crossings(arcs: Floats, a: Ints, b: Ints) -> Cuts:
    """Crossings of pairs of arcs: halves of both as long as their boxes meet, then Newton's steps."""
    size = 1.0
    s, t = np.zeros(len(a)), np.zeros(len(a))
    for _ in range(_HALVINGS):
        size /= 2
        s, t = (np.concatenate([s, s, s + size, s + size]), np.concatenate([t, t + size, t, t + size]))
        a, b = np.tile(a, 4), np.tile(b, 4)
        meet = _boxes_meet(arcs[a], s, arcs[b], t, size)
        a, b, s, t = a[meet], b[meet], s[meet], t[meet]
        if len(a) > _MOST_PAIRS:
            break
    s, t = _newton(arcs, a, b, s + size / 2, t + size / 2)
    (px, py), (qx, qy) = arc_points(arcs[a], s), arc_points(arcs[b], t)
    tolerance = _PART * float(np.abs(arcs).max())
    found = (np.hypot(px - qx, py - qy) <= tolerance) & (s >= 0) & (s <= 1) & (t >= 0) & (t <= 1)
    a, b, s, t = a[found], b[found], s[found], t[found]
    point = np.column_stack([(px + qx) / 2, (py + qy) / 2])[found]
    # Neighbouring pieces find the same crossing.
    key = np.column_stack([a, b, np.rint(s * 2**20), np.rint(t * 2**20)])
    _, once = np.unique(key, axis=0, return_index=True)
    a, b, s, t, point = a[once], b[once], s[once], t[once], point[once]
    within_a = _within(arcs[a], s, point, tolerance)
    within_b = _within(arcs[b], t, point, tolerance)
    return Cuts(
        np.concatenate([a[within_a], b[within_b]]),
        np.concatenate([s[within_a], t[within_b]]),
        np.concatenate([point[within_a], point[within_b]]),
    )


def _within(arcs: Floats, t: Floats, point: Floats, tolerance: float) -> npt.NDArray[np.bool_]:
    """Whether a point of an arc is apart from both of its ends."""
    apart = np.minimum(np.abs(arcs[:, :2] - point).max(axis=1), np.abs(arcs[:, 4:] - point).max(axis=1))
    within: npt.NDArray[np.bool_] = (t > 0) & (t < 1) & (apart > tolerance)
    return within


def _boxes_meet(a: Floats, s: Floats, b: Floats, t: Floats, size: float) -> npt.NDArray[np.bool_]:
    (ax0, ay0), (ax1, ay1) = arc_points(a, s), arc_points(a, s + size)
    (bx0, by0), (bx1, by1) = arc_points(b, t), arc_points(b, t + size)
    meet: npt.NDArray[np.bool_] = (
        (np.minimum(ax0, ax1) <= np.maximum(bx0, bx1))
        & (np.minimum(bx0, bx1) <= np.maximum(ax0, ax1))
        & (np.minimum(ay0, ay1) <= np.maximum(by0, by1))
        & (np.minimum(by0, by1) <= np.maximum(ay0, ay1))
    )
    return meet


def _newton(arcs: Floats, a: Ints, b: Ints, s: Floats, t: Floats) -> tuple[Floats, Floats]:
    """Steps toward A(s) = B(t), of no more than a few pieces' lengths in all."""
    start_s, start_t, reach = s, t, 4 * 2.0**-_HALVINGS
    for _ in range(_STEPS):
        (px, py), (qx, qy) = arc_points(arcs[a], s), arc_points(arcs[b], t)
        (ux, uy), (vx, vy) = arc_slopes(arcs[a], s), arc_slopes(arcs[b], t)
        dx, dy = qx - px, qy - py
        with np.errstate(all="ignore"):
            area = 2 * (ux * vy - uy * vx)
            ds, dt = (dx * vy - dy * vx) / area, (dx * uy - dy * ux) / area
        s = np.clip(s + np.nan_to_num(ds, posinf=0, neginf=0), start_s - reach, start_s + reach)
        t = np.clip(t + np.nan_to_num(dt, posinf=0, neginf=0), start_t - reach, start_t + reach)
    return np.clip(s, 0, 1), np.clip(t, 0, 1)


def sides_of(arcs: Floats, group: Ints) -> npt.NDArray[np.int8]:
    """(n,) int8 for arcs of closed outlines: 1 where the inside is on the left only, −1 on the right only, else 0.

    Arcs of one `group` (n,), which are known to have the same on their sides, are asked for by the longest of them.
    """
    length = np.hypot(arcs[:, 4] - arcs[:, 0], arcs[:, 5] - arcs[:, 1])
    order = np.lexsort((-length, group))
    numbers, first = np.unique(group[order], return_index=True)
    chosen = order[first]
    rows, half = arcs[chosen], np.full(len(chosen), 0.5)
    (x, y), (tx, ty) = arc_points(rows, half), arc_slopes(rows, half)
    step = 2 * _PART * float(np.abs(arcs).max()) / np.hypot(tx, ty)
    left = winding_numbers(arcs, x - step * ty, y + step * tx) != 0
    right = winding_numbers(arcs, x + step * ty, y - step * tx) != 0
    sides = left.astype(np.int8) - right.astype(np.int8)
    result: npt.NDArray[np.int8] = sides[np.searchsorted(numbers, group)].astype(np.int8)
    return result
