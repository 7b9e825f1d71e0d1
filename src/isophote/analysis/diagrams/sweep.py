"""Delaunay triangulations by Fortune's sweep, and signs of all their sides."""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.analysis.crew import pieces, run
from isophote.analysis.predicates import orient2d
from isophote.analysis.triangulation.plane import Triangles, triangulate_plane
from isophote.kernels.measure import diagram, flips, fortune
from isophote.kernels.measure.fortune_state import TRIANGLES, new_sweep

__all__ = ["Dual", "Ordered", "Sides", "divided", "in_order", "swept"]

FloatArray: TypeAlias = npt.NDArray[np.float64]
IntArray: TypeAlias = npt.NDArray[np.int32]

_GRAIN = 65536
_EVERYTHING = np.int64(2**62)


class Ordered(NamedTuple):
    """Distinct sites by y and then by x, (m, 2); their numbers; for each point the first that equals it."""

    sites: FloatArray
    names: IntArray
    representative: IntArray


class Sides(NamedTuple):
    """`signs` (m, 3) int8 of sides; how many are wrong; how many lie between four points on a circle."""

    signs: npt.NDArray[np.int8]
    wrong: int
    ties: int


class Dual(NamedTuple):
    """A Delaunay triangulation, the signs of its sides, and the middles (m, 2) of the circles of its triangles."""

    triangles: Triangles
    sides: Sides
    middles: FloatArray


def in_order(points: FloatArray) -> Ordered:
    """The sites of points (n, 2) in the order in which a sweep meets them."""
    order = np.argsort(points[:, 1])
    y = points[order, 1]
    if (y[1:] == y[:-1]).any():
        order = np.lexsort((points[:, 0], points[:, 1]))
    sites = points[order]
    new = np.ones(len(sites), np.bool_)
    np.logical_or(sites[1:, 0] != sites[:-1, 0], sites[1:, 1] != sites[:-1, 1], out=new[1:])
    names = order.astype(np.int32)
    representative = np.arange(len(points), dtype=np.int32)
    if not new.all():
        # Sorting by both coordinates keeps the order of equal points: the first of them is the least.
        representative[order] = names[np.flatnonzero(new)][np.cumsum(new) - 1]
        sites, names = sites[new], names[new]
    return Ordered(np.ascontiguousarray(scaled(sites)), names, representative)


def scaled(sites: FloatArray) -> FloatArray:
    """The sites times a power of two that makes them about 1, so that nothing overflows; if no place is lost by it."""
    greatest = np.abs(sites).max(initial=0.0)
    if greatest == 0 or 1e-30 < greatest < 1e30:
        return sites
    exponent = int(np.frexp(greatest)[1])
    scaled = np.ldexp(sites, -exponent)
    return scaled if (np.ldexp(scaled, exponent) == sites).all() else sites


def side_signs(points: FloatArray, corners: IntArray, neighbours: IntArray) -> Sides:
    """Whether the sides of triangles are right; `flips.side_signs` on all processors."""
    signs, flat = np.empty(corners.shape, np.int8), np.ascontiguousarray(points).reshape(-1)
    jobs = [(flat, corners, neighbours, *piece, signs) for piece in pieces(len(corners), _GRAIN)]
    counts = run(flips.side_signs, jobs)
    return Sides(signs, sum(wrong for wrong, _ in counts), sum(ties for _, ties in counts))


def divided(points: FloatArray) -> Dual:
    """The Delaunay triangulation of finite points (n, 2), by dividing and conquering."""
    found = triangulate_plane(points)
    sides = side_signs(points, found.corners, found.neighbours)
    return Dual(found, sides, _middles(points, scaled(points), found.corners))


def swept(points: FloatArray) -> Dual:
    """The Delaunay triangulation of finite points (n, 2), by Fortune's sweep; its sides are checked, and mended.

    Where coordinates span hundreds of binary places, moments of the sweep cannot be told apart in doubles, and what it
    finds may overlap; then the points are divided instead.
    """
    ordered = in_order(points)
    sweep = new_sweep(ordered.sites)
    fortune.advance(sweep.table.words, _EVERYTHING)
    count = int(sweep.counts[TRIANGLES])
    # Everything is done in the order of the sweep, in which neighbours are near each other in memory.
    corners, neighbours = sweep.triangles[:count], sweep.neighbours[:count]
    sides = side_signs(ordered.sites, corners, neighbours)
    if sides.wrong:
        flips.flip_wrong(ordered.sites.reshape(-1), corners, neighbours)
        sides = side_signs(ordered.sites, corners, neighbours)
    named = ordered.names[corners]
    hull = _hull(named, neighbours, ordered)
    if count and not _is_whole(points[hull], count, len(ordered.names)):
        return divided(points)
    found = Triangles(named, neighbours, hull, ordered.representative)
    return Dual(found, sides, _middles(points, ordered.sites, corners))


def _middles(points: FloatArray, sites: FloatArray, corners: IntArray) -> FloatArray:
    """Middles of circles through sites, which are points that may be scaled."""
    middles = np.empty((len(corners), 2))
    run(diagram.centres, [(sites, corners, *piece, middles) for piece in pieces(len(corners), _GRAIN)])
    greatest = np.abs(points).max(initial=0.0)
    if np.abs(sites).max(initial=0.0) == greatest:
        return middles
    with np.errstate(over="ignore"):
        return np.ldexp(middles, int(np.frexp(greatest)[1]))


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
    after = np.empty(len(ordered.representative), np.int32)
    first, count = diagram.hull_after(corners, neighbours, after)
    hull = np.empty(count, np.int32)
    diagram.follow(after, first, hull)
    return hull
