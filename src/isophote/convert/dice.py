"""Triangles cut until all their edges are short."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.errors import GeometryError

__all__ = ["Diced", "dice", "weld_places"]

Doubles: TypeAlias = npt.NDArray[np.float64]
Longs: TypeAlias = npt.NDArray[np.int64]
# Lengths of the edges between two lists of points, (k, 3) each, in parts of what is allowed.
Measure: TypeAlias = Callable[[Doubles, Doubles], Doubles]

# Bytes that a triangle takes while it is cut, with its corners and their values, and half a vertex.
_BYTES = 400
_FAR_TOO_MANY = 8


class Diced(NamedTuple):
    """Triangles as (t, 3) numbers of `points` (n, 3), with `values` (t, 3, d) at their corners and the number of the
    triangle that each is part of."""

    points: Doubles
    triangles: Longs
    values: Doubles
    parent: Longs


class _Part(NamedTuple):
    triangles: Longs
    values: Doubles
    parent: Longs

    def take(self, rows: npt.NDArray[np.bool_]) -> _Part:
        return _Part(self.triangles[rows], self.values[rows], self.parent[rows])


def weld_places(points: Doubles, triangles: npt.NDArray[np.integer]) -> tuple[Doubles, Longs]:
    """(points, triangles) with one number for each place, so that nothing comes apart at seams."""
    places, numbers = np.unique(points + 0.0, axis=0, return_inverse=True)
    return places, numbers.reshape(-1)[triangles].astype(np.int64)


def dice(points: Doubles, triangles: Longs, values: Doubles, measure: Measure, most: int) -> Diced:
    """Halve all edges that are too long, and cut the triangles beside them, until none is left.

    An edge is halved by its length alone, so that triangles beside it agree and no crack opens; `values` (t, 3, d) at
    corners are blended. Raises `GeometryError` before there would be more than `most` triangles.
    """
    _check_estimate(points, triangles, measure, most)
    part, done = _Part(triangles, values, np.arange(len(triangles))), []
    while len(part.triangles):
        ends, edge_of = _edges(part.triangles, len(points))
        long = measure(points[ends[:, 0]], points[ends[:, 1]]) > 1.0
        split = long[edge_of]
        rest = np.asarray(split.any(axis=1), bool)
        done.append(part.take(~rest))
        if not rest.any():
            break
        finished = sum(len(piece.triangles) for piece in done)
        _check_count(finished + int((split[rest].sum(axis=1) + 1).sum()), most)
        middles = np.cumsum(long) - 1 + len(points)
        points = np.concatenate([points, (points[ends[long, 0]] + points[ends[long, 1]]) / 2])
        part = _cut(part.take(rest), points, middles[edge_of[rest]], split[rest])
    joined = _Part(*(np.concatenate(columns) for columns in zip(*done, strict=True)))
    order = np.argsort(joined.parent, kind="stable")
    return Diced(points, joined.triangles[order], joined.values[order], joined.parent[order])


def _check_estimate(points: Doubles, triangles: Longs, measure: Measure, most: int) -> None:
    """Refuse at once what is far too much, by the areas that the lengths of edges tell: none of what comes is larger
    than an equilateral triangle. Where lengths depend on the place this may be off, so only by far counts."""
    corners = points[triangles]
    a, b, c = (measure(corners[:, k], corners[:, (k + 1) % 3]) for k in range(3))
    half = (a + b + c) / 2
    area = np.sqrt(np.maximum(half * (half - a) * (half - b) * (half - c), 0)).sum()
    _check_count(int(min(area / (math.sqrt(3) / 4) / _FAR_TOO_MANY, 2.0**62)), most)


def _check_count(count: int, most: int) -> None:
    if count > most:
        raise GeometryError(
            f"displacement would need more than {most:,} triangles ({most * _BYTES / 2**30:.1f} GiB); give a longer "
            "edge, or more triangles"
        )


def _edges(triangles: Longs, count: int) -> tuple[Longs, Longs]:
    """Ends (e, 2) of all edges, the smaller number first, and the edge (t, 3) from each corner to the next."""
    following = np.roll(triangles, -1, axis=1)
    keys = np.minimum(triangles, following) * count + np.maximum(triangles, following)
    found, edge_of = np.unique(keys, return_inverse=True)
    return np.stack([found // count, found % count], axis=1), edge_of.reshape(-1, 3)


def _cut(part: _Part, points: Doubles, middles: Longs, split: npt.NDArray[np.bool_]) -> _Part:
    """Triangles cut at the middles of the edges that are split; of these, edge k goes from corner k to the next."""
    corners = np.concatenate([part.triangles, np.where(split, middles, 0)], axis=1)
    halved = (part.values + np.roll(part.values, -1, axis=1)) / 2
    values = np.concatenate([part.values, halved], axis=1)
    pieces = []
    for mask in range(1, 8):
        wanted = np.array([mask >> k & 1 for k in range(3)], bool)
        rows = np.flatnonzero((split == wanted).all(axis=1))
        for chosen, pattern in _patterns(wanted, corners, points, rows):
            pieces.append(
                _Part(
                    corners[chosen][:, pattern].reshape(-1, 3),
                    values[chosen][:, pattern].reshape(-1, 3, values.shape[2]),
                    np.repeat(part.parent[chosen], len(pattern)),
                )
            )
    return _Part(*(np.concatenate(columns) for columns in zip(*pieces, strict=True)))


def _patterns(
    wanted: npt.NDArray[np.bool_], corners: Longs, points: Doubles, rows: Longs
) -> list[tuple[Longs, npt.NDArray[np.int64]]]:
    """How triangles are cut whose edges are split as `wanted`: rows of them, and corners of each piece, of which 3 to 5
    are the middles of the edges from corners 0 to 2."""
    if wanted.all():
        return [(rows, np.array([(0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5)]))]
    if wanted.sum() == 1:
        a = int(np.argmax(wanted))
        b, c, m = (a + 1) % 3, (a + 2) % 3, 3 + a
        return [(rows, np.array([(a, m, c), (m, b, c)]))]
    a = int(np.argmin(wanted))
    b, c = (a + 1) % 3, (a + 2) % 3
    p, q = 3 + b, 3 + c
    # The shorter diagonal of what is left below the corner that is cut off.
    own = points[corners[rows]]
    first = np.linalg.norm(own[:, a] - own[:, p], axis=1) <= np.linalg.norm(own[:, b] - own[:, q], axis=1)
    return [
        (rows[first], np.array([(q, p, c), (a, b, p), (a, p, q)])),
        (rows[~first], np.array([(q, p, c), (a, b, q), (b, p, q)])),
    ]
