"""Delaunay triangulations of points of the plane, on all processors, the same whatever their number."""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.analysis.crew import pieces, run
from isophote.kernels.measure import delaunay2d, spatial_order
from isophote.kernels.measure.edges import EDGE, FREE, FRESH, FRESH_END, HEAD, SUBDIVISION, TAIL

__all__ = ["Triangles", "TrianglesInOrder", "triangulate_in_order", "triangulate_plane"]

FloatArray: TypeAlias = npt.NDArray[np.float64]
IntArray: TypeAlias = npt.NDArray[np.int32]

# Parts of fewer points are triangulated at once, by one thread.
_GRAIN = 65536
_EDGES_A_POINT = 3


class Triangles(NamedTuple):
    """`corners` and `neighbours`, (m, 3) int32; `hull`, (h,) int32; `representative`, (n,) int32."""

    corners: IntArray
    neighbours: IntArray
    hull: IntArray
    representative: IntArray


class _Order(NamedTuple):
    """Distinct points in order, flat; their numbers; ranks of cuts; for each point the first that equals it."""

    points: FloatArray
    names: IntArray
    cuts: IntArray
    same_as: IntArray


class _Part(NamedTuple):
    """A range of points: its triangulation, and its unused edges."""

    root: int
    free: npt.NDArray[np.int64]


class TrianglesInOrder(NamedTuple):
    """Triangles of distinct `sites` (m, 2), which are points in an order in which neighbours are near each other.

    `corners` are numbers of sites; `names` (m,) are the sites' numbers as points, which `hull` is told in.
    """

    sites: FloatArray
    names: IntArray
    corners: IntArray
    neighbours: IntArray
    hull: IntArray
    representative: IntArray


def triangulate_plane(points: FloatArray) -> Triangles:
    """The Delaunay triangulation of finite points (n, 2)."""
    order = _sorted(points)
    return Triangles(*_triangulated(order, order.names), order.same_as)


def triangulate_in_order(points: FloatArray) -> TrianglesInOrder:
    """The Delaunay triangulation of finite points (n, 2), as it lies in memory."""
    order = _sorted(points)
    found = _triangulated(order, np.arange(len(order.names), dtype=np.int32))
    return TrianglesInOrder(order.points.reshape(-1, 2), order.names, *found, order.same_as)


def _triangulated(order: _Order, names: IntArray) -> tuple[IntArray, IntArray, IntArray]:
    """Corners by these names, neighbours, and the points on the hull."""
    count = len(order.names)
    if count < 2:
        empty = np.empty((0, 3), np.int32)
        return empty, empty.copy(), order.names
    edges = np.empty(_EDGES_A_POINT * EDGE * count, np.int32)
    whole = _divide(order, edges, 0, count)
    around = np.empty(2 * count, np.int32)
    around = around[: delaunay2d.mark_outside(edges, whole.root, around)]
    corners, neighbours = _faces(edges, names)
    hull = around[::-1] if len(corners) else _chain(around)
    return corners, neighbours, order.names[hull]


def _sorted(points: FloatArray) -> _Order:
    flat = np.ascontiguousarray(points).reshape(-1)
    count = len(flat) // 2
    same_as = np.arange(count, dtype=np.int32)
    ordered, names, cuts = np.empty(2 * count), np.empty(count, np.int32), np.zeros(count, np.int32)
    if count == 0:
        return _Order(ordered, names, cuts, same_as)
    bounds = np.array([points[:, 0].min(), points[:, 0].max(), points[:, 1].min(), points[:, 1].max()])
    keys, spare = np.empty(count, np.uint64), np.empty(count, np.uint64)
    run(spatial_order.first_keys, [(flat, *piece, bounds, keys) for piece in pieces(count, _GRAIN)])
    spatial_order.sort_keys(keys, spare)
    spatial_order.refine_cells(flat, spare, cuts, same_as, 0, count)
    distinct = spatial_order.take_distinct(flat, spare, cuts, same_as, ordered, names)
    return _Order(ordered[: 2 * distinct], names[:distinct], cuts[:distinct], same_as)


def _divide(order: _Order, edges: IntArray, begin: int, end: int) -> _Part:
    """Divide a range at its coarsest cuts, triangulate the parts side by side, and merge them."""
    ranges, cuts = _ranges(order.cuts, begin, end)
    largest_first = sorted(ranges, key=lambda part: part[0] - part[1])
    jobs = [(order, edges, *part) for part in largest_first]
    starts = [part[0] for part in largest_first]
    parts: dict[int, _Part] = dict(zip(starts, run(_triangulate, jobs), strict=True))
    for cut in reversed(cuts):
        a, b = parts[cut.begin], parts[cut.at]
        rank = int(order.cuts[cut.at])
        plane = SUBDIVISION.pack(points=order.points, cuts=order.cuts, edges=edges, free=a.free, other_free=b.free)
        root = int(delaunay2d.merge_parts(plane.words, a.root, b.root, rank))
        parts[cut.begin] = _Part(root, a.free)
    return parts[begin]


class _Cut(NamedTuple):
    """Where a range that starts at `begin` is divided."""

    begin: int
    at: int


def _ranges(ranks: IntArray, begin: int, end: int) -> tuple[list[tuple[int, int]], list[_Cut]]:
    """Ranges of at most `_GRAIN` points, and the cuts between them, those of a range before those of its parts."""
    ranges, cuts, pending = [], [], [(begin, end)]
    while pending:
        low, high = pending.pop()
        if high - low <= _GRAIN:
            ranges.append((low, high))
            continue
        cut = _Cut(low, int(spatial_order.least_cut(ranks, low, high)))
        cuts.append(cut)
        pending += [(low, cut.at), (cut.at, high)]
    return ranges, cuts


def _triangulate(order: _Order, edges: IntArray, begin: int, end: int) -> _Part:
    free = np.empty(FREE, np.int64)
    free[HEAD] = free[TAIL] = -1
    free[FRESH], free[FRESH_END] = _EDGES_A_POINT * begin, _EDGES_A_POINT * end
    plane = SUBDIVISION.pack(points=order.points, cuts=order.cuts, edges=edges, free=free, other_free=free)
    root = delaunay2d.triangulate_part(plane.words, begin, end)
    return _Part(int(root), free)


def _faces(edges: IntArray, names: IntArray) -> tuple[IntArray, IntArray]:
    """Corners and neighbours of all triangles, in the order of their lowest half-edges."""
    ranges = list(pieces(2 * _EDGES_A_POINT * len(names), 6 * _GRAIN))
    lists = run(_listed, [(edges, *piece) for piece in ranges])
    starts = np.cumsum([0, *map(len, lists)]).tolist()
    corners, neighbours = np.empty((starts[-1], 3), np.int32), np.empty((starts[-1], 3), np.int32)
    parts = list(zip(lists, starts[:-1], strict=True))
    run(delaunay2d.number_faces, [(edges, names, firsts, corners, start) for firsts, start in parts])
    run(delaunay2d.link_faces, [(edges, firsts, neighbours, start) for firsts, start in parts])
    return corners, neighbours


def _listed(edges: IntArray, begin: int, end: int) -> IntArray:
    firsts = np.empty(end - begin, np.int32)
    return firsts[: delaunay2d.list_faces(edges, begin, end, firsts)]


def _chain(around: IntArray) -> IntArray:
    """Points on a line from end to end, of a walk there and back that starts anywhere."""
    count = len(around) // 2 + 1
    ends = np.flatnonzero(np.roll(around, 1) == np.roll(around, -1))
    return np.roll(around, -int(ends[0]))[:count]
