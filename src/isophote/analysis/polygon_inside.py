"""Inside, outside and boundary of polygons in the plane."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.analysis.crew import pieces, run
from isophote.analysis.predicates import orient2d
from isophote.errors import GeometryError
from isophote.kernels.measure.polygon_winding import fill_strips, polygon_windings

__all__ = ["point_in_convex_polygon", "point_in_polygon"]

Rule: TypeAlias = Literal["nonzero", "evenodd", "positive", "negative"]
Points: TypeAlias = npt.NDArray[np.float64]

_RULES = ("nonzero", "evenodd", "positive", "negative")
_A_JOB = 16_384
# Places in all lists of strips together, for each edge.
_LISTED = 6


def point_in_polygon(
    polygons: npt.ArrayLike | Sequence[Any], points: npt.ArrayLike, rule: Rule = "nonzero"
) -> npt.NDArray[np.int8]:
    """(n,) int8: 1 for `points`, (n, 2), inside of `polygons`, 0 on their boundary, -1 outside.

    `polygons` is a ring, (k, 2), a list of rings (outlines and holes), or a list of such lists; each ring is closed by
    itself, may cross itself, and may repeat its first point. `rule` says which winding numbers are inside: "nonzero",
    "evenodd" (the odd ones, whatever the direction of holes), "positive" (counterclockwise) or "negative". The boundary
    is every point of every ring. Exact for all doubles. Raises `GeometryError` for coordinates that are not finite,
    wrong shapes, or another rule.
    """
    if rule not in _RULES:
        raise GeometryError(f"rule must be one of {', '.join(_RULES)}, not {rule!r}")
    query = _coordinates(points, "points")
    edges = _edges(polygons)
    numbers, on = np.zeros(len(query), np.int64), np.zeros(len(query), np.uint8)
    if len(edges):
        strips = _strips(edges)
        run(polygon_windings, [(edges, *strips, query, *p, numbers, on) for p in pieces(len(query), _A_JOB)])
    inside = {"nonzero": numbers != 0, "evenodd": numbers % 2 != 0, "positive": numbers > 0, "negative": numbers < 0}
    return np.where(on != 0, 0, np.where(inside[rule], 1, -1)).astype(np.int8)


def point_in_convex_polygon(polygon: npt.ArrayLike, points: npt.ArrayLike) -> npt.NDArray[np.int8]:
    """(n,) int8: 1 for `points`, (n, 2), inside of a convex `polygon`, (k, 2), 0 on its boundary, -1 outside.

    By half-planes: a point is inside that lies to the left of every edge, counterclockwise, or to the right of every
    edge. Exact for all doubles, and the same answer as `point_in_polygon`. Raises `GeometryError` for polygons that are
    not convex, go round more than once or have no area, coordinates that are not finite, and wrong shapes.
    """
    query, ring = _coordinates(points, "points"), _coordinates(polygon, "polygon")
    edges = np.roll(ring, -1, axis=0) - ring
    ring = ring[(edges != 0).any(axis=1)]
    before, after = np.roll(ring, 1, axis=0), np.roll(ring, -1, axis=0)
    turns = orient2d(before, ring, after) if len(ring) else np.zeros(0, np.int8)
    way = int(turns[np.flatnonzero(turns)[0]]) if turns.any() else 0
    if way == 0:
        raise GeometryError("polygon has no area: its corners lie on a line")
    if (turns == -way).any():
        raise GeometryError(f"polygon is not convex at corner {int(np.argmax(turns == -way))}; take point_in_polygon")
    if _goes_back(ring, turns) or abs(_turnings(ring)) != 1:
        raise GeometryError("polygon is not convex: it goes back on itself, or round more than once")
    sides = np.ones(len(query), np.int8)
    for start, end in zip(ring, after, strict=True):
        np.minimum(sides, way * orient2d(start, end, query), out=sides)
    return sides


def _goes_back(ring: Points, turns: npt.NDArray[np.int8]) -> bool:
    """Whether an edge goes back along the one before."""
    before, after = ring - np.roll(ring, 1, axis=0), np.roll(ring, -1, axis=0) - ring
    return bool(((turns == 0) & ((np.sign(before) * np.sign(after)) < 0).any(axis=1)).any())


def _turnings(ring: Points) -> int:
    """How often the edges of a ring that turns one way only go round: changes from downward to upward and back."""
    rise = np.roll(ring, -1, axis=0) - ring
    upward = np.where(rise[:, 1] != 0, rise[:, 1] > 0, rise[:, 0] > 0)
    return int((upward != np.roll(upward, 1)).sum()) // 2


def _coordinates(values: npt.ArrayLike, what: str) -> Points:
    try:
        # Writeable: for arrays that are not, kernels would be compiled once more.
        given = np.require(values, np.float64, ["C", "W"])
    except (TypeError, ValueError) as error:
        raise GeometryError(f"{what} must be numbers of shape (n, 2): {error}") from error
    if given.shape in ((2,), (0,)):
        given = given.reshape(-1, 2)
    if given.ndim != 2 or given.shape[1] != 2:
        raise GeometryError(f"{what} must have shape (n, 2), but have {given.shape}")
    finite = np.isfinite(given).all(axis=1)
    if not finite.all():
        raise GeometryError(f"{what}: number {int(np.argmin(finite))} is not finite")
    return given


def _edges(polygons: npt.ArrayLike | Sequence[Any]) -> Points:
    """(k, 4): starts and ends of the edges of all rings."""
    rings = [_coordinates(ring, f"ring {k}") for k, ring in enumerate(_rings(polygons))]
    edges = [np.column_stack([ring, np.roll(ring, -1, axis=0)]) for ring in rings if len(ring)]
    return np.ascontiguousarray(np.concatenate(edges)) if edges else np.empty((0, 4))


def _rings(polygons: Any) -> list[Any]:
    """The rings in lists of lists of rings, however deep."""
    if len(polygons) == 0:
        return []
    first = polygons[0]
    if np.ndim(first) == 1 and len(first) == 2 and np.ndim(first[0]) == 0:
        return [polygons]
    if not hasattr(first, "__len__"):
        raise GeometryError("polygons must be a ring, (k, 2), or lists of rings")
    return [ring for part in polygons for ring in _rings(part)]


def _strips(edges: Points) -> tuple[float, float, int, npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """Half the least y, strips for a unit of half of y, how many there are, and the edges by strips."""
    low, high = np.minimum(edges[:, 1], edges[:, 3]) * 0.5, np.maximum(edges[:, 1], edges[:, 3]) * 0.5
    least, height = float(low.min()), float(high.max() - low.min())
    spans = float(((high - low) / height).sum()) if height > 0 else 0.0
    # An edge has a place in one strip, and in one more for each border that it crosses.
    count = int(min(len(edges), (_LISTED - 1) * len(edges) / spans)) if spans > 0 else 1
    count = max(count, 1)
    with np.errstate(over="ignore", divide="ignore"):
        across = float(np.float64(count) / height) if height > 0 else 0.0
    if not np.isfinite(across):
        across, count = 0.0, 1
    firsts = np.zeros(count + 1, np.int64)
    fill_strips(edges, least, across, count, firsts, np.empty(0, np.int64))
    listed = np.empty(int(firsts[-1]), np.int64)
    fill_strips(edges, least, across, count, firsts, listed)
    return least, across, count, firsts, listed
