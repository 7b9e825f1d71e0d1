"""Primitives in the plane with exact distances; sizes are full lengths.

Source of most distances: Quílez, "2D distance functions", derived anew here where a comment says so.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any, ClassVar

import attrs
import numpy as np

from isophote.errors import GeometryError
from isophote.shapes.field.data import OutlineData
from isophote.shapes.field.expression import Point, Value
from isophote.shapes.field.form import Box, Form, number_spelled
from isophote.shapes.field.functions import (
    absolute,
    clip,
    cos,
    length,
    maximum,
    select,
    sin,
)
from isophote.shapes.field.joins import rounded
from isophote.shapes.field.numbers import (
    Vector,
    any_number,
    highest,
    lowest,
    not_negative_number,
    positive_number,
    positive_vector,
    vector_of,
    whole_number,
)
from isophote.shapes.field.outline import line_arcs, outline_data

__all__ = ["Arc", "Circle", "FlatForm", "OutlineForm", "Polygon", "Rectangle", "Segment", "Star", "segment_distance"]


class FlatForm(Form):
    """A form in the plane; it does not look at the point's z."""

    dimension: ClassVar[int] = 2


def segment_distance(p: Point, a: tuple[Any, Any], b: tuple[Any, Any]) -> Value:
    """Distance to the line segment from a to b: to the point of it that the projection, held within it, names."""
    ex, ey = b[0] - a[0], b[1] - a[1]
    dx, dy = p.x - a[0], p.y - a[1]
    part = clip((dx * ex + dy * ey) / (ex * ex + ey * ey), 0.0, 1.0)
    return p.bounded(length(dx - part * ex, dy - part * ey), 1.0)


@attrs.frozen(repr=False)
class Circle(FlatForm):
    """A disk: |p| − r."""

    radius: float = positive_number()

    is_edgeless = True

    def expression(self, p: Point) -> Value:
        return p.bounded(length(p.x, p.y) - p.number(self.radius), 1.0)

    @property
    def bounds(self) -> Box:
        return np.array([[-self.radius] * 2, [self.radius] * 2])

    def spelled(self) -> str:
        return f"circle({number_spelled(self.radius)})"


@attrs.frozen(repr=False)
class Rectangle(FlatForm):
    """A rectangle with corners rounded by `radius`: |max(q, 0)| + min(max(q), 0) − r for q = |p| − size / 2 + r."""

    size: Vector = positive_vector(2)
    radius: float = not_negative_number(default=0.0)

    def __attrs_post_init__(self) -> None:
        most = min(map(lowest, self.size)) / 2
        if highest(self.radius) > most:
            raise GeometryError(
                f"rectangle: radius must not be above half of the shorter side, {most!r}, but is {self.radius!r}"
            )

    @property
    def is_square(self) -> bool:  # type: ignore[override]
        return self.radius == 0

    @property
    def is_smooth(self) -> bool:  # type: ignore[override]
        return self.radius == 0

    def expression(self, p: Point) -> Value:
        return p.bounded(rounded(self._sides(p), p.number(self.radius)), 1.0)

    def faces(self, p: Point) -> list[Value]:
        return self._sides(p) if self.radius == 0 else [self.expression(p)]

    def _sides(self, p: Point) -> list[Value]:
        return [absolute(c) - p.number(s) * 0.5 for c, s in zip(p.coordinates, self.size, strict=False)]

    @property
    def bounds(self) -> Box:
        half = np.array(self.size) / 2
        return np.stack([-half, half])

    def spelled(self) -> str:
        size = number_spelled(self.size[0] if repr(self.size[0]) == repr(self.size[1]) else self.size)
        if self.radius == 0:
            return f"rectangle({size})"
        return f"rounded_rectangle({size}, {number_spelled(self.radius)})"


@attrs.frozen(repr=False)
class Segment(FlatForm):
    """All within `radius` of the line segment from `start` to `end`."""

    start: Vector = vector_of(2)
    end: Vector = vector_of(2)
    radius: float = positive_number()

    is_edgeless = True

    def __attrs_post_init__(self) -> None:
        if self.start == self.end:
            raise GeometryError(f"segment: start and end are both {self.start}; use a circle for a dot")

    def expression(self, p: Point) -> Value:
        a, b = ((p.number(x), p.number(y)) for x, y in (self.start, self.end))
        return p.bounded(segment_distance(p, a, b) - p.number(self.radius), 1.0)

    @property
    def bounds(self) -> Box:
        ends = np.array([self.start, self.end])
        return np.stack([ends.min(axis=0) - self.radius, ends.max(axis=0) + self.radius])

    def spelled(self) -> str:
        return f"segment({', '.join(map(number_spelled, (self.start, self.end, self.radius)))})"


@attrs.frozen(repr=False)
class Arc(FlatForm):
    """All within `thickness` / 2 of the part of a circle from the angle `start` to the angle `end`, anticlockwise."""

    radius: float = positive_number()
    thickness: float = positive_number()
    start: float = any_number(default=0.0)
    end: float = any_number(default=math.tau)

    is_edgeless = True

    def __attrs_post_init__(self) -> None:
        least, most = lowest(self.end) - highest(self.start), highest(self.end) - lowest(self.start)
        if not 0 < least <= most <= math.tau * (1 + 1e-12):
            raise GeometryError(
                f"arc: end must be above start, by 2π at most, but they are {self.start!r} and {self.end!r}"
            )

    def expression(self, p: Point) -> Value:
        """In a frame whose x axis halves the arc, mirrored: the circle within the angle, the arc's end beyond it."""
        radius, half = p.number(self.radius), (p.number(self.end) - p.number(self.start)) * 0.5
        thick = p.number(self.thickness) * 0.5
        if lowest(self.end) - highest(self.start) >= math.tau:
            return p.bounded(absolute(length(p.x, p.y) - radius) - thick, 1.0)
        middle = (p.number(self.end) + p.number(self.start)) * 0.5
        c, s = cos(middle), sin(middle)
        x, y = p.x * c + p.y * s, absolute(p.y * c - p.x * s)
        ex, ey = cos(half), sin(half)
        # The sine of the point's angle less `half`, which lies within (−π, π): below zero within the arc's angle.
        beyond = y * ex - x * ey
        ring = absolute(length(x, y) - radius)
        cap = length(x - radius * ex, y - radius * ey)
        return p.bounded(select(beyond, ring, cap) - thick, 1.0)

    @property
    def bounds(self) -> Box:
        quarters = np.arange(math.ceil(self.start / (math.pi / 2)), math.floor(self.end / (math.pi / 2)) + 1)
        angles = np.concatenate([[self.start, self.end], quarters * (math.pi / 2)])
        points = self.radius * np.column_stack([np.cos(angles), np.sin(angles)])
        return np.stack([points.min(axis=0), points.max(axis=0)]) + np.array([[-0.5], [0.5]]) * self.thickness

    def spelled(self) -> str:
        return f"arc({', '.join(map(number_spelled, (self.radius, self.thickness, self.start, self.end)))})"


@attrs.frozen(repr=False)
class Star(FlatForm):
    """A star with `points` tips at `radius`, the first up, and as many notches at `inner`."""

    points: int = whole_number(2, 10_000)
    radius: float = positive_number()
    inner: float = positive_number()

    def __attrs_post_init__(self) -> None:
        if highest(self.inner) > lowest(self.radius):
            raise GeometryError(f"star: inner must not be above radius, {self.radius!r}, but is {self.inner!r}")

    def expression(self, p: Point) -> Value:
        """The plane is folded along mirrors of the star until all lies in half a sector, from +y to the first notch's
        direction; there the outline is one line, from the tip to the notch. What is nearest to a point lies in the same
        half sector, for its mirror image is no nearer. Angles from +y are halved with each fold, from π down to
        π / points, so that few are needed; no fold changes a distance."""
        half, sectors = math.pi / self.points, self.points
        x, y = absolute(p.x), p.y
        while sectors > 1:
            sectors = (sectors + 1) // 2
            c, s = math.cos(sectors * half), math.sin(sectors * half)
            beyond = maximum(x * (2 * c) - y * (2 * s), 0.0)
            x, y = p.bounded(x - beyond * c, 1.0), p.bounded(y + beyond * s, 1.0)
        q = p.moved(x, y, p.z)
        radius, inner = p.number(self.radius), p.number(self.inner)
        tip, notch = (p.number(0.0), radius), (inner * math.sin(half), inner * math.cos(half))
        side = (q.x - tip[0]) * (notch[1] - tip[1]) - (q.y - tip[1]) * (notch[0] - tip[0])
        distance = segment_distance(q, tip, notch)
        return p.bounded(select(side, distance, -distance), 1.0)

    @property
    def bounds(self) -> Box:
        angles = np.arange(2 * self.points) * (math.pi / self.points)
        reach = np.where(np.arange(2 * self.points) % 2 == 0, self.radius, self.inner)
        corners = np.column_stack([reach * np.sin(angles), reach * np.cos(angles)])
        return np.stack([corners.min(axis=0), corners.max(axis=0)])

    def spelled(self) -> str:
        return f"star({self.points}, {number_spelled(self.radius)}, {number_spelled(self.inner)})"


def _loops(value: Any) -> tuple[tuple[Vector, ...], ...]:
    """One outline of points, or several, as tuples of tuples."""
    try:
        first = value[0]
        nested = np.ndim(first[0]) > 0
        loops = tuple(np.asarray(loop, np.float64) for loop in (value if nested else [value]))
    except (TypeError, ValueError, IndexError, KeyError) as error:
        raise GeometryError(f"polygon: it takes points (n, 2), or a list of such outlines: {error}") from error
    for number, loop in enumerate(loops):
        if loop.ndim != 2 or loop.shape[1] != 2 or len(loop) < 3:
            raise GeometryError(f"polygon: outline {number} must be points (n, 2), n ≥ 3, but has shape {loop.shape}")
        finite = np.isfinite(loop).all(axis=1)
        if not finite.all():
            bad = int(np.argmin(finite))
            raise GeometryError(f"polygon: point {bad} of outline {number} is not finite: {loop[bad].tolist()}")
        if np.abs(loop).max() > 1e18:
            raise GeometryError(f"polygon: outline {number} has coordinates beyond 1e18")
    return tuple(tuple(tuple(point) for point in loop.tolist()) for loop in loops)


@lru_cache(maxsize=256)
def _polygon_data(loops: tuple[tuple[Vector, ...], ...]) -> OutlineData:
    return outline_data([line_arcs(np.array(loop)) for loop in loops], "polygon")


class OutlineForm(FlatForm):
    """A form with its outline as a table."""

    @property
    def data(self) -> OutlineData:
        """The outline; the same object for equal forms."""
        raise NotImplementedError

    def expression(self, p: Point) -> Value:
        return p.bounded(p.graph.apply("OUTLINE", p.x, p.y, constant=self.data), 1.0)

    @property
    def bounds(self) -> Box:
        return self.data.bounds


@attrs.frozen(repr=False)
class Polygon(OutlineForm):
    """What closed outlines wind round; they may cross and touch themselves and each other."""

    loops: tuple[tuple[Vector, ...], ...] = attrs.field(converter=_loops)

    def __attrs_post_init__(self) -> None:
        _polygon_data(self.loops)

    @property
    def data(self) -> OutlineData:
        return _polygon_data(self.loops)

    def spelled(self) -> str:
        return f"polygon({number_spelled(self.loops[0] if len(self.loops) == 1 else self.loops)})"
