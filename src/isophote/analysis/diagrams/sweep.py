"""Delaunay triangulations with their edges, by Fortune's sweep and by dividing and conquering."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.analysis.diagrams.dual import Dual, told
from isophote.analysis.diagrams.order import Ordered, in_order, scaled
from isophote.analysis.predicates import orient2d
from isophote.analysis.triangulation.plane import triangulate_in_order
from isophote.kernels.measure import diagram, flips, fortune
from isophote.kernels.measure.fortune_state import TRIANGLES, new_sweep

__all__ = ["divided", "swept"]

FloatArray: TypeAlias = npt.NDArray[np.float64]
IntArray: TypeAlias = npt.NDArray[np.int32]

_EVERYTHING = np.int64(2**62)


def divided(points: FloatArray) -> Dual:
    """The Delaunay triangulation of finite points (n, 2), by dividing and conquering."""
    found = triangulate_in_order(points)
    edges = told(scaled(found.sites), found.names, found.corners, found.neighbours)
    return Dual(found.names, found.corners, found.neighbours, found.hull, found.representative, edges)


def swept(points: FloatArray) -> Dual:
    """The Delaunay triangulation of finite points (n, 2), by Fortune's sweep; its sides are checked, and mended.

    Where coordinates span hundreds of binary places, moments of the sweep cannot be told apart in doubles, and what it
    finds may overlap; then the points are divided instead.
    """
    ordered = in_order(points)
    sweep = new_sweep(ordered.sites.places)
    fortune.advance(sweep.table.words, _EVERYTHING)
    count = int(sweep.counts[TRIANGLES])
    corners, neighbours = sweep.triangles[:count], sweep.neighbours[:count]
    edges = told(ordered.sites, ordered.names, corners, neighbours)
    if edges.wrong:
        flips.flip_wrong(ordered.sites.places.reshape(-1), corners, neighbours)
        edges = told(ordered.sites, ordered.names, corners, neighbours)
    hull = _hull(corners, neighbours, ordered)
    if count and not _is_whole(points[hull], count, len(ordered.names)):
        return divided(points)
    return Dual(ordered.names, corners, neighbours, hull, ordered.representative, edges)


def _is_whole(hull: FloatArray, triangles: int, points: int) -> bool:
    """Whether triangles that all turn to the left, and meet side by side, cover a convex polygon once."""
    before, after = np.roll(hull, 1, axis=0), np.roll(hull, -1, axis=0)
    rises = (after[:, 0] > hull[:, 0]) | ((after[:, 0] == hull[:, 0]) & (after[:, 1] > hull[:, 1]))
    once = int((rises != np.roll(rises, 1)).sum()) == 2
    return once and triangles == 2 * points - 2 - len(hull) and bool((orient2d(before, hull, after) >= 0).all())


def _hull(corners: IntArray, neighbours: IntArray, ordered: Ordered) -> IntArray:
    """Numbers of the points on the hull, counterclockwise, or of points on a line from end to end."""
    if len(corners) == 0:
        return ordered.names
    after = np.empty(len(ordered.names), np.int32)
    first, count = diagram.hull_after(corners, neighbours, after)
    hull = np.empty(count, np.int32)
    diagram.follow(after, first, hull)
    return ordered.names[hull]
