"""Quadratic Bézier arcs in the plane: nearest points and winding numbers, in double precision.

An arc is a row (x0, y0, x1, y1, x2, y2) of B(t) = (1 − t)² p0 + 2t(1 − t) p1 + t² p2; a line has the middle of its
ends as control point. Arcs here are monotone in x and in y, so that their ends are the corners of their boxes.
"""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

__all__ = ["Nearest", "arc_points", "arc_slopes", "nearest_on_arcs", "nearest_parameters", "winding_numbers"]

Floats: TypeAlias = npt.NDArray[np.float64]
Ints: TypeAlias = npt.NDArray[np.int64]

# Pairs of points and arcs that are looked at in one step: some tens of megabytes.
_PAIRS = 1 << 20
_MOST_STEPS = 80
# Points whose winding numbers are counted in one step.
_ROWS = 256


class Nearest(NamedTuple):
    """For each point the distance to the nearest arc, the arc's number and the parameter of its nearest point."""

    distance: Floats
    arc: Ints
    parameter: Floats


def arc_points(arcs: Floats, t: Floats) -> tuple[Floats, Floats]:
    """x and y of B(t), row by row."""
    x0, y0, x1, y1, x2, y2 = arcs.T
    s = 1 - t
    return s * s * x0 + 2 * s * t * x1 + t * t * x2, s * s * y0 + 2 * s * t * y1 + t * t * y2


def arc_slopes(arcs: Floats, t: Floats) -> tuple[Floats, Floats]:
    """x and y of B′(t) / 2, row by row."""
    x0, y0, x1, y1, x2, y2 = arcs.T
    return (1 - t) * (x1 - x0) + t * (x2 - x1), (1 - t) * (y1 - y0) + t * (y2 - y1)


def nearest_parameters(arcs: Floats, x: Floats, y: Floats) -> Floats:
    """The t in [0, 1] at which B(t) of arc i is nearest to the point (x[i], y[i]).

    The distance is least where g(t) = (B(t) − p) · B′(t) / 2, a cubic, rises through zero. Between the roots of g′, of
    which there are at most two, g is monotone: each piece is searched by Newton's steps, halved where they leave it.
    Closed forms of the cubic's roots lose half of the digits where two roots are close.
    """
    x0, y0, x1, y1, x2, y2 = arcs.T
    ex, ey, fx, fy = x0 - x, y0 - y, x1 - x0, y1 - y0
    hx, hy = x0 - 2 * x1 + x2, y0 - 2 * y1 + y2
    g0, g1 = ex * fx + ey * fy, 2 * (fx * fx + fy * fy) + ex * hx + ey * hy
    g2, g3 = 3 * (fx * hx + fy * hy), hx * hx + hy * hy
    turns = np.sort(_roots(3 * g3, g2, g1), axis=0)
    low = np.stack([np.zeros_like(x), turns[0], turns[1]])
    high = np.stack([turns[0], turns[1], np.ones_like(x)])
    inner = _rising_root(g0, g1, g2, g3, low, high)
    tried = np.concatenate([np.zeros((1, len(x))), inner, np.ones((1, len(x)))])
    squares = (ex + tried * (2 * fx + tried * hx)) ** 2 + (ey + tried * (2 * fy + tried * hy)) ** 2
    best: Floats = np.take_along_axis(tried, squares.argmin(axis=0)[None], axis=0)[0]
    return best


def _roots(a: Floats, b: Floats, c: Floats) -> Floats:
    """(2, n): roots of a t² + 2 b t + c, brought into [0, 1]; 0 where there are none."""
    with np.errstate(all="ignore"):
        q = -(b + np.copysign(np.sqrt(np.maximum(b * b - a * c, 0.0)), b))
        roots = np.stack([q / a, c / q])
    return np.clip(np.nan_to_num(roots, nan=0.0, posinf=1.0, neginf=0.0), 0.0, 1.0)


def _rising_root(g0: Floats, g1: Floats, g2: Floats, g3: Floats, low: Floats, high: Floats) -> Floats:
    """Roots of the cubic g between `low` and `high`, where it is monotone; an end where it does not rise through 0."""

    def cubic(t: Floats) -> Floats:
        value: Floats = g0 + t * (g1 + t * (g2 + t * g3))
        return value

    rises = (cubic(low) <= 0) & (cubic(high) >= 0)
    high = np.where(rises, high, low)
    t = (low + high) / 2
    for _ in range(_MOST_STEPS):
        value = cubic(t)
        low, high = np.where(value <= 0, t, low), np.where(value >= 0, t, high)
        with np.errstate(all="ignore"):
            step = t - value / (g1 + t * (2 * g2 + t * 3 * g3))
        after = np.where((step > low) & (step < high), step, (low + high) / 2)
        moved = np.abs(after - t).max(initial=0.0)
        t = after
        if moved < 1e-16:
            break
    return t


def nearest_on_arcs(arcs: Floats, x: Floats, y: Floats) -> Nearest:
    """The nearest arc to each point, among those whose boxes are not farther than an end of another arc."""
    steps = [_nearest(arcs, x[part], y[part]) for part in _parts(len(x), len(arcs))]
    return Nearest(*(np.concatenate([step[k] for step in steps]) for k in range(3)))


def _parts(points: int, arcs: int) -> list[slice]:
    step = max(_PAIRS // max(arcs, 1), 1)
    return [slice(first, first + step) for first in range(0, max(points, 1), step)]


def _nearest(arcs: Floats, x: Floats, y: Floats) -> tuple[Floats, Ints, Floats]:
    ends = ((arcs[:, None, k] - x) ** 2 + (arcs[:, None, k + 1] - y) ** 2 for k in (0, 4))
    reach = np.minimum(*ends).min(axis=0)
    low, high = np.minimum(arcs[:, :2], arcs[:, 4:])[:, None], np.maximum(arcs[:, :2], arcs[:, 4:])[:, None]
    dx = np.maximum(np.maximum(low[..., 0] - x, x - high[..., 0]), 0.0)
    dy = np.maximum(np.maximum(low[..., 1] - y, y - high[..., 1]), 0.0)
    point, arc = np.nonzero((dx * dx + dy * dy <= reach * (1 + 1e-12)).T)
    rows = arcs[arc]
    t = nearest_parameters(rows, x[point], y[point])
    px, py = arc_points(rows, t)
    squares = (px - x[point]) ** 2 + (py - y[point]) ** 2
    order = np.lexsort((squares, point))
    chosen = order[np.searchsorted(point[order], np.arange(len(x)))]
    return np.sqrt(squares[chosen]), arc[chosen], t[chosen]


def winding_numbers(arcs: Floats, x: Floats, y: Floats) -> Ints:
    """How often the closed outlines go round each point, anticlockwise.

    Upward arcs right of the point count 1, downward ones −1. An arc holds its lower end and not its upper one, so that
    each arc's end is counted once.
    """
    low, high = np.minimum(arcs[:, 1], arcs[:, 5]), np.maximum(arcs[:, 1], arcs[:, 5])
    order = np.argsort(y, kind="stable")
    numbers = np.zeros(len(y), np.int64)
    # Points at about one height are asked together: few arcs reach over it.
    for first in range(0, len(y), _ROWS):
        some = order[first : first + _ROWS]
        reached = arcs[(low <= y[some[-1]]) & (high >= y[some[0]])]
        numbers[some] = _winding(reached, x[some], y[some])
    return numbers


def _winding(arcs: Floats, x: Floats, y: Floats) -> Ints:
    y0, y2 = arcs[:, 1, None], arcs[:, 5, None]
    crossing = (y0 <= y) != (y2 <= y)
    right = crossing & (x < np.minimum(arcs[:, 0], arcs[:, 4])[:, None])
    unclear = crossing & ~right & (x <= np.maximum(arcs[:, 0], arcs[:, 4])[:, None])
    arc, point = np.nonzero(unclear)
    right[arc, point] = _crosses_right(arcs[arc], x[point], y[point])
    upward = np.where(y2 > y0, 1, -1)
    total: Ints = (right * upward).sum(axis=0)
    return total


def _crosses_right(arcs: Floats, x: Floats, y: Floats) -> npt.NDArray[np.bool_]:
    """Whether an arc that is monotone in y, and reaches over the height y, has x(t) > x there."""
    # From the lower end on, whichever way the arc runs: those that run along each other cross at the very same place.
    arcs = np.where((arcs[:, 5] < arcs[:, 1])[:, None], arcs[:, [4, 5, 2, 3, 0, 1]], arcs)
    y0, y1, y2 = arcs[:, 1], arcs[:, 3], arcs[:, 5]
    a, b, c = y0 - 2 * y1 + y2, y1 - y0, y0 - y
    with np.errstate(all="ignore"):
        t = -c / (b + np.sqrt(np.maximum(b * b - a * c, 0.0)))
    t = np.clip(np.nan_to_num(t), 0.0, 1.0)
    s = 1 - t
    return s * s * arcs[:, 0] + 2 * s * t * arcs[:, 2] + t * t * arcs[:, 4] > x
