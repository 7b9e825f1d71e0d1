"""Delaunay triangulations of points of space."""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.kernels.measure import curve_order, delaunay3d, spanning

__all__ = ["Tetrahedra", "triangulate_space"]

FloatArray: TypeAlias = npt.NDArray[np.float64]
IntArray: TypeAlias = npt.NDArray[np.int32]

# In general position, tetrahedra a point, and those that a point makes way for.
_TETRAHEDRA_A_POINT = 8
_HOLE = 1024


class Tetrahedra(NamedTuple):
    """`corners` and `neighbours`, (m, 4) int32; `hull`, (h, 3) int32, from outside; `representative`, (n,) int32."""

    corners: IntArray
    neighbours: IntArray
    hull: IntArray
    representative: IntArray


def triangulate_space(points: FloatArray) -> Tetrahedra:
    """The Delaunay triangulation of finite points (n, 3); nothing but representatives where they lie in a plane."""
    order = insertion_order(points)
    ordered = np.ascontiguousarray(points[order])
    first = np.empty(4, np.int64)
    if spanning.spanning_points(ordered, first) < 4:
        flat = np.empty((0, 4), np.int32)
        return Tetrahedra(flat, flat.copy(), np.empty((0, 3), np.int32), same_points(points))
    tets, same_as = _insert_all(ordered.reshape(-1), first)
    names, representative = _names(order, same_as)
    return _finite(tets, names, representative)


def insertion_order(points: FloatArray) -> npt.NDArray[np.int64]:
    """Numbers of points in an order to insert them."""
    if len(points) == 0:
        return np.empty(0, np.int64)
    least, greatest = 0.5 * points.min(axis=0), 0.5 * points.max(axis=0)
    keys = np.empty(len(points), np.uint64)
    curve_order.insertion_keys(points, least, (greatest - least).max(), keys)
    return np.argsort(keys, kind="stable")


def same_points(points: FloatArray) -> IntArray:
    """For each point the first that equals it."""
    _, first, inverse = np.unique(points + 0.0, axis=0, return_index=True, return_inverse=True)
    return first[inverse.reshape(-1)].astype(np.int32)


def _insert_all(flat: FloatArray, first: npt.NDArray[np.int64]) -> tuple[IntArray, IntArray]:
    """Tetrahedra in use, (k, 8), those at infinity too, and the vertex that each point equals, itself if none."""
    count = len(flat) // 3
    capacity = _TETRAHEDRA_A_POINT * count + _HOLE
    tets = np.empty(capacity * delaunay3d.RECORD, np.int32)
    marks, free = np.zeros(capacity, np.int32), np.empty(capacity, np.int32)
    state = np.array([0, 0, 5, 0, 0], np.int64)
    heads = np.full(count, -1, np.int32)
    same_as = np.arange(count, dtype=np.int32)
    room = _HOLE
    delaunay3d.start(flat, tets, first)
    while True:
        hole, rim = np.empty(room, np.int32), np.empty(2 * room, np.int32)
        chains = np.empty((3 * room, 4), np.int32)
        if delaunay3d.insert_points(flat, tets, marks, free, state, heads, hole, rim, chains, same_as):
            break
        if capacity - state[delaunay3d.FRESH] + state[delaunay3d.FREE] < 2 * room:
            tets, marks, free = (np.concatenate([array, np.zeros_like(array)]) for array in (tets, marks, free))
            capacity *= 2
        else:
            room *= 2
    used = np.ones(int(state[delaunay3d.FRESH]), np.bool_)
    used[free[: state[delaunay3d.FREE]]] = False
    return _compacted(tets[: delaunay3d.RECORD * len(used)].reshape(-1, delaunay3d.RECORD), used), same_as


def _compacted(tets: IntArray, used: npt.NDArray[np.bool_]) -> IntArray:
    """The records in use, with links to their new numbers; -1 to those that are not."""
    number = np.full(len(used) + 1, -1, np.int32)
    number[:-1][used] = np.arange(np.count_nonzero(used), dtype=np.int32)
    kept = tets[used]
    kept[:, 4:] = number[kept[:, 4:]]
    return kept


def _names(order: npt.NDArray[np.int64], same_as: IntArray) -> tuple[IntArray, IntArray]:
    """The number of each vertex: the first of the points that equal it; and for each point that number."""
    names = order.astype(np.int32)
    np.minimum.at(names, same_as, order.astype(np.int32))
    representative = np.empty(len(order), np.int32)
    representative[order] = names[same_as]
    return names, representative


def _finite(tets: IntArray, names: IntArray, representative: IntArray) -> Tetrahedra:
    finite = tets[:, 3] >= 0
    # Seen from outside, faces of those at infinity go round the other way.
    hull = names[tets[~finite][:, [1, 0, 2]]]
    kept = _compacted(tets, finite)
    return Tetrahedra(names[kept[:, :4]], kept[:, 4:].copy(), hull, representative)
