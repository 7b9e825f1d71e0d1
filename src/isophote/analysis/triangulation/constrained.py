"""Constrained Delaunay triangulations: given segments are sides, and tell inside from outside."""

from __future__ import annotations

from fractions import Fraction
from typing import Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.analysis.predicates import orient2d
from isophote.analysis.triangulation.plane import Triangles
from isophote.analysis.triangulation.working import Working
from isophote.errors import GeometryError
from isophote.kernels.measure import constrain

__all__ = ["Crossings", "constrain_triangles", "enclosed"]

FloatArray: TypeAlias = npt.NDArray[np.float64]
IntArray: TypeAlias = npt.NDArray[np.int32]
Crossings: TypeAlias = Literal["error", "split"]

# Crossings are split this many times the number of constraints squared and more, before rounding is blamed.
_MOST_SPLITS = 1000


class _Constraints:
    """Constraints in the order of insertion; those that were split are gone, and their parts follow."""

    def __init__(self, edges: IntArray) -> None:
        self.edges = edges
        self.given = np.arange(len(edges))

    def replace(self, number: int, parts: list[tuple[int, int]]) -> None:
        """Put parts, without those of length 0, behind all, in place of a constraint."""
        kept = np.array([part for part in parts if part[0] != part[1]], np.int32).reshape(-1, 2)
        self.edges = np.concatenate([self.edges, kept])
        self.given = np.concatenate([self.given, np.full(len(kept), self.given[number])])
        # Of no length, it is passed over.
        self.edges[number] = self.edges[number, 0]

    def along(self, points: FloatArray, a: int, b: int) -> list[int]:
        """Numbers of the constraints that hold the segment between two points."""
        start, end = points[self.edges[:, 0]], points[self.edges[:, 1]]
        least, greatest = np.minimum(start, end), np.maximum(start, end)
        holds = self.edges[:, 0] != self.edges[:, 1]
        for p in (points[a], points[b]):
            holds &= (orient2d(start, end, p) == 0) & (p >= least).all(axis=1) & (p <= greatest).all(axis=1)
        return np.flatnonzero(holds).tolist()


def constrain_triangles(
    points: FloatArray, found: Triangles, edges: IntArray, crossings: Crossings
) -> tuple[Working, IntArray, IntArray]:
    """The constrained triangulation, winding numbers, and the first of the points that equal each, new points too.

    `edges`, (k, 2), are numbers of points. Raises `GeometryError` where two cross in a point that is neither's end, if
    `crossings` is "error"; else such points are added.
    """
    working = Working(points, found.corners, found.neighbours, np.zeros_like(found.corners))
    working.grow(len(points) + 16)
    constraints = _Constraints(found.representative[edges])
    sides = np.empty((3 * len(found.corners) + 64, 2), np.int32)
    state = np.array([0, -1, -1, -1], np.int64)
    splits = 0
    while True:
        own = working.points, working.corners, working.neighbours, working.fixed, working.at
        if constrain.insert_constraints(*own, constraints.edges, sides, np.empty_like(sides), state):
            break
        if crossings == "error":
            raise _crossing(points, edges, constraints, working, state)
        splits += 1
        if splits > _MOST_SPLITS + len(edges) ** 2:
            raise GeometryError("constraints cross ever again after their crossings were rounded; move them apart")
        _split(constraints, working, state)
        if len(sides) < 3 * working.triangle_count:
            sides = np.empty((6 * working.triangle_count, 2), np.int32)
    if splits:
        working.flip_all()
    winding, closed = working.winding(constraints.edges)
    if not closed:
        winding = enclosed(working).astype(np.int32)
    added = np.arange(len(points), working.point_count, dtype=np.int32)
    return working, winding, np.concatenate([found.representative, added])


def enclosed(working: Working) -> npt.NDArray[np.bool_]:
    """Which triangles the fixed sides keep from the outside."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    count = working.triangle_count
    neighbours, fixed = working.neighbours[:count], working.fixed[:count]
    triangle, side = np.nonzero(fixed == 0)
    to = neighbours[triangle, side]
    # The outside is one more.
    to = np.where(to < 0, count, to)
    graph = coo_array((np.ones(len(to), np.int8), (triangle, to)), shape=(count + 1, count + 1))
    _, piece = connected_components(graph, directed=False)
    inner: npt.NDArray[np.bool_] = piece[:count] != piece[count]
    return inner


def _crossing(
    points: FloatArray, edges: IntArray, constraints: _Constraints, working: Working, state: npt.NDArray[np.int64]
) -> GeometryError:
    first = int(constraints.given[state[constrain.NEXT]])
    along = constraints.along(working.points, int(state[constrain.SIDE_START]), int(state[constrain.SIDE_END]))
    second = int(constraints.given[along[0]])
    names = [f"number {k}, from point {edges[k, 0]} to {edges[k, 1]}" for k in sorted((first, second))]
    x, y = _meeting(*(points[v] for k in (first, second) for v in edges[k]))
    return GeometryError(
        f'constraints cross at ({x:.6g}, {y:.6g}): {names[0]}, and {names[1]}; move them, or give crossings="split"'
    )


def _meeting(a: FloatArray, b: FloatArray, c: FloatArray, d: FloatArray) -> tuple[float, float]:
    """Where the lines a b and c d meet, rounded once."""
    (ax, ay), (bx, by), (cx, cy), (dx, dy) = ([Fraction(float(x)) for x in p] for p in (a, b, c, d))
    part = ((cx - ax) * (dy - cy) - (cy - ay) * (dx - cx)) / ((bx - ax) * (dy - cy) - (by - ay) * (dx - cx))
    return float(ax + part * (bx - ax)), float(ay + part * (by - ay))


def _split(constraints: _Constraints, working: Working, state: npt.NDArray[np.int64]) -> None:
    """Put a point where the next constraint crosses a fixed side, and part both there."""
    number, a = int(state[constrain.NEXT]), int(state[constrain.FROM])
    p, q = int(state[constrain.SIDE_START]), int(state[constrain.SIDE_END])
    start, end = (int(v) for v in constraints.edges[number])
    x, y = _meeting(*(working.points[v] for v in (a, end, p, q)))
    across = constraints.along(working.points, p, q)
    working.unfix(p, q)
    v = working.insert_point(x, y, p)
    if v < 0:
        raise GeometryError(
            f"the crossing ({x!r}, {y!r}) of constraints cannot be rounded to a point between their ends"
        )
    for k in across:
        c, d = (int(w) for w in constraints.edges[k])
        forward = (
            np.abs(working.points[c] - working.points[p]).sum() < np.abs(working.points[c] - working.points[q]).sum()
        )
        near, far = (p, q) if forward else (q, p)
        constraints.replace(k, [(c, near), (near, v), (v, far), (far, d)])
    constraints.replace(number, [(start, a), (a, v), (v, end)])
    state[constrain.FROM] = -1
