"""Refinement of triangulations of the plane to angles and areas."""

from __future__ import annotations

import warnings
from math import inf, pi, radians, sin
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.analysis.arrays import read_only
from isophote.analysis.triangulation.lifted import boundary_cycle
from isophote.analysis.triangulation.result import Delaunay, WindingRule
from isophote.analysis.triangulation.working import Working, longer
from isophote.errors import GeometryError, IsophoteWarning
from isophote.kernels.measure import refine

__all__ = ["refine_triangulation"]

FloatArray: TypeAlias = npt.NDArray[np.float64]
IntArray: TypeAlias = npt.NDArray[np.int32]
BoolArray: TypeAlias = npt.NDArray[np.bool_]

_LARGEST_ANGLE = 40.0
_QUEUE = 16384


def refine_triangulation(
    triangulation: Delaunay,
    min_angle_degrees: float = 20.0,
    max_area: float | None = None,
    *,
    rule: WindingRule = "nonzero",
    max_points: int | None = None,
) -> Delaunay:
    """A triangulation with more points, whose triangles inside the constraints have no small angle and no large area.

    What lies inside is told by `rule`, or is all there is where nothing is constrained. The outer boundary stays, and
    constraints become chains of sides. Up to 20.7° an end is certain, and it nearly always comes up to 33°. Angles
    between constraints that were smaller stay as they are, and so do triangles with a shortest side across such a
    corner. Stops at `max_points` (by default, a million and a hundred
    for each given point), or where sides become too short to split, and warns if that leaves triangles as they are not
    wanted. Areas are in units of the points' squared. Ruppert 1995; Shewchuk 2002. Raises `GeometryError` for an angle
    outside 0 to 40, and an area that is not positive.
    """
    if not 0 <= min_angle_degrees <= _LARGEST_ANGLE:
        raise GeometryError(f"the least angle must be from 0 to {_LARGEST_ANGLE:g} degrees, not {min_angle_degrees}")
    if max_area is not None and not max_area > 0:
        raise GeometryError(f"the largest area must be positive, not {max_area}")
    if len(triangulation.triangles) == 0:
        return triangulation
    most = 1_000_000 + 100 * len(triangulation.points) if max_points is None else max_points
    inside = (
        triangulation.inside(rule) if triangulation.constrained.any() else np.ones(len(triangulation.triangles), bool)
    )
    refining = _Refining(triangulation, inside, sin(radians(min_angle_degrees)), inf if max_area is None else max_area)
    left = refining.run(most)
    if left:
        warnings.warn(f"some triangles are not as wanted: {left}", IsophoteWarning, stacklevel=2)
    return refining.result()


class _Refining:
    """A triangulation that is being refined, and what is still to be done about it."""

    def __init__(self, given: Delaunay, inside: BoolArray, least_sine: float, most_area: float) -> None:
        self.given = given
        self.wanted = least_sine, most_area
        fixed, self.segments, self.is_constraint = _segments(given)
        self.working = Working(given.points, given.triangles, given.neighbours, fixed)
        # Regions are 1 + the number of a winding number, negative where nothing is refined.
        self.windings, number = np.unique(given.winding, return_inverse=True)
        self.working.region[:] = np.where(inside, 1, -1) * (number + 1)
        self.lines = np.full(len(given.points), -1, np.int32)
        self.acute = _acute_corners(given.points, self.segments)
        self._make_room()

    def run(self, most_points: int) -> str:
        """Refine; returns why there is more to be done, or nothing."""
        working = self.working
        while True:
            before = working.point_count
            if self._queue_all() == 0:
                return ""
            self._empty_queues(most_points)
            if working.point_count >= most_points:
                return f"there are {most_points:,} points already" if self._queue_all() else ""
            if working.point_count == before:
                return "sides are too short to be split"

    def _queue_all(self) -> int:
        """Queue all that is to be done; how much that is."""
        working, state = self.working, self.working.state
        rows = 3 * working.triangle_count + _QUEUE
        self.sides, self.wanting = np.empty((rows, 5), np.int32), np.empty((rows, 5), np.int32)
        state[refine.SIDES_FIRST : refine.TRIANGLES_LAST + 1] = 0
        own = working.points, working.corners, working.fixed, working.region
        refine.queue_all(*own, self.segments, self.lines, self.sides, self.wanting, state, *self.wanted)
        return int(state[refine.SIDES_LAST] + state[refine.TRIANGLES_LAST])

    def _empty_queues(self, most_points: int) -> None:
        working = self.working
        while working.point_count < most_points:
            tables = self.segments, self.lines, self.acute, self.sides, self.wanting, working.state
            if refine.refine_queued(*working.arrays, *tables, *self.wanted, most_points):
                return
            self._make_room()

    def _make_room(self) -> None:
        working = self.working
        if working.point_count >= len(working.points) or working.triangle_count + 2 > len(working.corners):
            rows = 2 * working.point_count + 1024
            working.grow(rows)
            self.lines, self.acute = longer(self.lines, rows), longer(self.acute, rows)
        else:
            self.sides = self._longer_queue(self.sides, refine.SIDES_FIRST)
            self.wanting = self._longer_queue(self.wanting, refine.TRIANGLES_FIRST)

    def _longer_queue(self, queue: IntArray, first: int) -> IntArray:
        begin, end = (int(k) for k in self.working.state[first : first + 2])
        self.working.state[first : first + 2] = 0, end - begin
        return longer(queue[np.arange(begin, end) % len(queue)], 2 * len(queue))

    def result(self) -> Delaunay:
        """The triangulation as it is."""
        working = self.working
        points, count = working.point_count, working.triangle_count
        corners, neighbours = working.corners[:count].copy(), working.neighbours[:count].copy()
        representative = np.arange(points, dtype=np.int32)
        representative[: len(self.given.points)] = self.given.representative
        return Delaunay(
            read_only(working.points[:points].copy()),
            read_only(corners),
            read_only(neighbours),
            read_only(boundary_cycle(corners, neighbours)),
            read_only(representative),
            read_only(self.is_constraint[working.fixed[:count]]),
            read_only(self.windings[np.abs(working.region[:count]) - 1]),
        )


def _segments(given: Delaunay) -> tuple[IntArray, IntArray, BoolArray]:
    """Numbers, from 1 on, of the sides that are to stay; their ends; and which of them, 0 too, are constraints."""
    number = np.arange(len(given.triangles), dtype=np.int32)[:, None]
    first = (given.constrained | (given.neighbours < 0)) & (given.neighbours < number)
    triangle, side = np.nonzero(first)
    fixed = np.zeros(given.triangles.shape, np.int32)
    fixed[triangle, side] = np.arange(1, len(triangle) + 1)
    across = given.neighbours[triangle, side]
    for k in range(3):
        back = (across >= 0) & (given.neighbours[across, k] == triangle)
        fixed[across[back], k] = fixed[triangle[back], side[back]]
    ends = np.stack([given.triangles[triangle, (side + 1) % 3], given.triangles[triangle, (side + 2) % 3]], axis=1)
    return fixed, ends, np.concatenate([[False], given.constrained[triangle, side]])


def _acute_corners(points: FloatArray, segments: IntArray) -> BoolArray:
    """Points at which two segments meet at less than 60 degrees."""
    start, end = np.concatenate([segments, segments[:, ::-1]]).T
    way = np.arctan2(*(points[end] - points[start]).T[::-1])
    order = np.lexsort((way, start))
    start, way = start[order], way[order]
    same = start[1:] == start[:-1]
    narrow = (way[1:] - way[:-1] < pi / 3) & same
    firsts, lasts = np.flatnonzero(np.r_[True, ~same]), np.flatnonzero(np.r_[~same, True])
    around = (lasts > firsts) & (way[firsts] + 2 * pi - way[lasts] < pi / 3)
    acute = np.zeros(len(points), np.bool_)
    acute[start[1:][narrow]] = True
    acute[start[firsts[around]]] = True
    return acute
