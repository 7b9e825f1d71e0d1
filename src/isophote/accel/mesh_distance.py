"""Triangle meshes made ready for closest points, distances and winding numbers: kernels/measure/mesh_distance.py."""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.accel.tree import build_triangles
from isophote.errors import GeometryError
from isophote.kernels.accel.layout import BLOCK, LANES, NUMBER
from isophote.kernels.base.table import Packed
from isophote.kernels.measure.mesh_distance import MESH_DISTANCE, RIM_GROUP, RIM_LANES
from isophote.kernels.measure.rim_walk import follow_edges

__all__ = ["MeshDistance", "build_mesh_distance", "rim_of"]

Points: TypeAlias = npt.NDArray[np.float64]
Corners: TypeAlias = npt.NDArray[np.int32]
Indices: TypeAlias = npt.NDArray[np.int64]


class MeshDistance(NamedTuple):
    """A mesh as kernels ask it: the table, the power of two from the mesh's units to its frame, and whether every edge
    is met as often in one direction as in the other."""

    table: Packed
    scale: float
    closed: bool


def build_mesh_distance(positions: npt.ArrayLike, triangles: npt.ArrayLike, threads: int | None = None) -> MeshDistance:
    """The table of `triangles`, (m, 3) int32 rows of `positions`, (n, 3) float64.

    The same bits come out for any number of `threads` (all cores if None). Raises `GeometryError` where a position is
    not finite or too large to be doubled, a triangle names a position that is not there, or there are no triangles.
    """
    points = np.ascontiguousarray(positions, np.float64)
    corners = np.ascontiguousarray(triangles, np.int32)
    if points.ndim != 2 or points.shape[1] != 3 or corners.ndim != 2 or corners.shape[1] != 3:
        raise GeometryError(f"positions and triangles must be (n, 3), but are {points.shape} and {corners.shape}")
    if len(corners) == 0:
        raise GeometryError("there is no distance from a mesh without triangles")
    if corners.min() < 0 or corners.max() >= len(points):
        raise GeometryError(f"triangles name positions outside 0 to {len(points) - 1}")
    used = np.zeros(len(points), bool)
    used[corners] = True
    points = np.where(used[:, None], points, points[corners[0, 0]])
    scale = _scale(points)
    points = points * scale
    middle = (points.min(axis=0) + points.max(axis=0)) * 0.5
    tree = build_triangles((points - middle).astype(np.float32), corners, threads)
    numbers = np.maximum(tree.blocks.view(np.int32).reshape(-1, BLOCK)[:, NUMBER : NUMBER + LANES].reshape(-1), 0)
    rim = rim_of(points, corners)
    table = MESH_DISTANCE.pack(
        nodes=tree.nodes,
        blocks=tree.blocks,
        corners=points[corners[numbers]].reshape(-1, 9),
        frame=np.array([[*middle, scale]]),
        rim=rim,
        closed=rim.shape[1] == 0,
    )
    return MeshDistance(table, scale, rim.shape[1] == 0)


def _scale(points: Points) -> float:
    """The power of two that brings the points' extent to between 1 and 2, and what is far from 0 not beyond 2^500."""
    if not np.isfinite(points).all():
        raise GeometryError("positions must be finite")
    extent = np.ptp(points * 0.5, axis=0).max()
    most = np.abs(points).max()
    exponent = np.frexp(extent if extent > 0 else max(most, 1.0))[1]
    exponent = min(max(int(exponent), int(np.frexp(most)[1]) - 500, -1000), 1000)
    return float(np.ldexp(1.0, -exponent))


def rim_of(points: Points, triangles: Corners) -> Points:
    """(4, k): the boundary of a mesh as directed edges, laid out for `rim_angle`.

    An edge is there as often as triangles run along it in one direction more than in the other; a closed and oriented
    mesh has none. Vertices at one place are one vertex.
    """
    start, end, count = _chain(triangles)
    if len(start) == 0:
        return np.empty((4, 0))
    chosen = np.unique(np.concatenate([start, end]))
    _, first, same = np.unique(points[chosen] + 0.0, axis=0, return_index=True, return_inverse=True)
    number = np.arange(len(points))
    number[chosen] = chosen[first[same.reshape(-1)]]
    start, end, count = _cancel(number[start], number[end], count)
    if len(start) == 0:
        return np.empty((4, 0))
    return _in_lanes(points, *_walked(np.repeat(start, count), np.repeat(end, count)))


def _walked(start: Indices, end: Indices) -> tuple[Indices, Indices]:
    """Edges in an order in which most begin where the one before ends."""
    order = np.argsort(start, kind="stable")
    start, end = start[order], end[order]
    vertices, first = np.unique(start, return_index=True)
    starts, ends = np.empty(len(start), np.int64), np.empty(len(start), np.int64)
    heads = np.searchsorted(vertices, end)
    follow_edges(np.append(first, len(start)), heads, first.copy(), starts, ends)
    return vertices[starts], vertices[ends]


def _in_lanes(points: Points, start: Indices, end: Indices) -> Points:
    """The rim of kernels/measure/rim.py, of edges of which most begin where the one before ends."""
    count = len(start)
    each = -(-count // RIM_LANES)
    lane = np.arange(count) // each
    # An edge adds its end, and before it its start where that is not there yet.
    new = np.append(True, start[1:] != end[:-1])
    new[::each] = True
    place = np.cumsum(1 + new)
    place -= (place - 1 - new)[lane * each] + 1
    steps = -(-int(place.max()) // RIM_GROUP) * RIM_GROUP + 1
    rim = np.empty((4, steps, RIM_LANES))
    rim[:3], rim[3] = points[start[0]][:, None, None], -1
    rim[:3, place[new] - 1, lane[new]] = points[start[new]].T
    rim[:3, place, lane] = points[end].T
    rim[3, place, lane] = 1
    return rim.reshape(4, -1)


def _chain(triangles: Corners) -> tuple[Indices, Indices, Indices]:
    """Starts and ends of the edges whose directions do not cancel, and how often each is there."""
    corners = triangles.astype(np.int64)
    start, end = corners.reshape(-1), np.roll(corners, -1, axis=1).reshape(-1)
    return _cancel(start, end, np.ones(len(start), np.int64))


def _cancel(start: Indices, end: Indices, count: Indices) -> tuple[Indices, Indices, Indices]:
    """Edges (start < end, or turned round) whose counts do not add up to nothing."""
    low, high = np.minimum(start, end), np.maximum(start, end)
    size = int(high.max()) + 1 if len(high) else 1
    keys = low * size + high
    order = np.argsort(keys, kind="stable")
    keys = keys[order]
    signed = np.where(start < end, count, np.where(start > end, -count, 0))[order]
    first = np.flatnonzero(np.diff(keys, prepend=-1))
    total = np.add.reduceat(signed, first) if len(first) else signed
    kept = np.flatnonzero(total)
    low, high = np.divmod(keys[first[kept]], size)
    forward = total[kept] > 0
    return np.where(forward, low, high), np.where(forward, high, low), np.abs(total[kept])
