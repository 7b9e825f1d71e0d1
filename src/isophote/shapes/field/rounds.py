"""Round solid primitives about +Y, with exact distances.

They are profiles in the plane of the distance ρ = |(x, z)| from the axis and of y. Source of most: Quílez, "distance
functions"; derived anew here where a comment says so.
"""

from __future__ import annotations

import math

import attrs
import numpy as np

from isophote.errors import GeometryError
from isophote.shapes.field.expression import Point, Value
from isophote.shapes.field.field import Field
from isophote.shapes.field.form import Box, Exactness, Form, number_spelled
from isophote.shapes.field.functions import absolute, clip, cos, length, maximum, minimum, select, sin, sqrt
from isophote.shapes.field.joins import corner
from isophote.shapes.field.numbers import not_negative_number, optional_number, positive_number

__all__ = [
    "CappedTorus",
    "Capsule",
    "Cone",
    "Cylinder",
    "Link",
    "RoundedCone",
    "Torus",
    "capped_torus",
    "capsule",
    "cone",
    "cylinder",
    "link",
    "rounded_cone",
    "torus",
]


def _upright(radius: float, height: float) -> Box:
    corner = np.array([radius, height / 2, radius])
    return np.stack([-corner, corner])


@attrs.frozen(repr=False)
class Cylinder(Form):
    """A cylinder along y, endless where `height` is None: the corner of ρ − r and |y| − h / 2."""

    radius: float = positive_number()
    height: float | None = optional_number()

    is_square = True
    is_smooth = True

    def expression(self, p: Point) -> Value:
        faces = self.faces(p)
        return p.bounded(faces[0] if len(faces) == 1 else corner(faces), 1.0)

    def faces(self, p: Point) -> list[Value]:
        side = p.bounded(length(p.x, p.z) - p.number(self.radius), 1.0)
        return [side] if self.height is None else [side, absolute(p.y) - p.number(self.height) * 0.5]

    @property
    def bounds(self) -> Box:
        return _upright(self.radius, math.inf if self.height is None else self.height)

    def spelled(self) -> str:
        height = "" if self.height is None else f", {number_spelled(self.height)}"
        return f"cylinder({number_spelled(self.radius)}{height})"


@attrs.frozen(repr=False)
class RoundedCone(Form):
    """The hull of a ball at the bottom and one at the top: the least of |p − (0, s, 0)| − r(s) over the balls between.

    Derived here. With r(s) falling by b for each unit of s, the derivative by s is zero where (y − s) / |p − (0, s, 0)|
    = b, which is at s = y − ρ b / √(1 − b²); |p − (0, s, 0)| − r(s) is convex in s, so s is clipped to the ends.
    """

    radius: float = positive_number()
    top: float = positive_number()
    height: float = positive_number()

    title = "rounded_cone"

    is_edgeless = True

    def __attrs_post_init__(self) -> None:
        least = 2 * max(self.radius, self.top)
        if self.height <= least:
            raise GeometryError(
                f"rounded_cone: height must be above twice the larger radius, {least!r}, but is {self.height!r}; "
                "it is the full length, with both round ends"
            )

    def expression(self, p: Point) -> Value:
        radius, top, half = p.number(self.radius), p.number(self.top), p.number(self.height) * 0.5
        low, high = radius - half, half - top
        lean = (radius - top) / (high - low)
        rho = length(p.x, p.z)
        s = clip(p.y - rho * (lean / sqrt(1.0 - lean * lean)), low, high)
        return p.bounded(length(rho, p.y - s) + (s - low) * lean - radius, 1.0)

    @property
    def bounds(self) -> Box:
        return _upright(max(self.radius, self.top), self.height)

    def spelled(self) -> str:
        return f"rounded_cone({', '.join(map(number_spelled, (self.radius, self.top, self.height)))})"


@attrs.frozen(repr=False)
class Capsule(Form):
    """All within `radius` of a line segment along y: |p − nearest point of the segment| − r."""

    radius: float = positive_number()
    height: float = positive_number()

    is_edgeless = True

    def __attrs_post_init__(self) -> None:
        if self.height < 2 * self.radius:
            raise GeometryError(
                f"capsule: height must not be below twice the radius, {2 * self.radius!r}, but is {self.height!r}; "
                "it is the full length, with both round ends"
            )

    def expression(self, p: Point) -> Value:
        reach = p.number(self.height) * 0.5 - p.number(self.radius)
        beyond = maximum(absolute(p.y) - reach, 0.0)
        return p.bounded(length(p.x, beyond, p.z) - p.number(self.radius), 1.0)

    @property
    def bounds(self) -> Box:
        return _upright(self.radius, self.height)

    def spelled(self) -> str:
        return f"capsule({number_spelled(self.radius)}, {number_spelled(self.height)})"


@attrs.frozen(repr=False)
class Cone(Form):
    """A cone, or with a `top` above 0 a part of one, from y = −height / 2 with `radius` to y = height / 2.

    Inside, the largest of the distances to the lids' planes and to the side's line; outside, the less of the distances
    to the nearer lid and to the segment of the side.
    """

    radius: float = positive_number()
    height: float = positive_number()
    top: float = not_negative_number(default=0.0)

    def _parts(self, p: Point) -> tuple[Value, Value, Value, Value, Value]:
        """ρ, half the height, both radii, and the length of the side."""
        radius, top, height = p.number(self.radius), p.number(self.top), p.number(self.height)
        fall = radius - top
        return length(p.x, p.z), height * 0.5, radius, top, sqrt(fall * fall + height * height)

    def faces(self, p: Point) -> list[Value]:
        rho, half, radius, top, slant = self._parts(p)
        side = ((rho - radius) * (half * 2.0) + (p.y + half) * (radius - top)) / slant
        return [p.bounded(side, 1.0), absolute(p.y) - half]

    def expression(self, p: Point) -> Value:
        rho, half, radius, top, slant = self._parts(p)
        side, lid = self.faces(p)
        inside = maximum(side, lid)
        to_lid = length(maximum(rho - select(p.y, radius, top), 0.0), lid)
        fall, height = radius - top, half * 2.0
        along = clip(((radius - rho) * fall + (p.y + half) * height) / (slant * slant), 0.0, 1.0)
        to_side = length(rho - radius + along * fall, p.y + half - along * height)
        return p.bounded(select(inside, inside, minimum(to_lid, to_side)), 1.0)

    @property
    def bounds(self) -> Box:
        return _upright(max(self.radius, self.top), self.height)

    def spelled(self) -> str:
        top = "" if type(self.top) is float and self.top == 0 else f", {number_spelled(self.top)}"
        return f"cone({number_spelled(self.radius)}, {number_spelled(self.height)}{top})"


@attrs.frozen(repr=False)
class Torus(Form):
    """All within `tube` of a circle of `radius` about y: |(ρ − R, y)| − r.

    Where the tube is thicker than the ring the surface crosses itself, and values within are bounds.
    """

    radius: float = positive_number()
    tube: float = positive_number()

    is_edgeless = True

    @property
    def exactness(self) -> Exactness:  # type: ignore[override]
        return Exactness.EXACT if self.tube <= self.radius else Exactness.BOUND

    def expression(self, p: Point) -> Value:
        ring = p.bounded(length(p.x, p.z) - p.number(self.radius), 1.0)
        return p.bounded(length(ring, p.y) - p.number(self.tube), 1.0)

    @property
    def bounds(self) -> Box:
        return self.bounds_at(0.0)

    def bounds_at(self, level: float) -> Box:
        return _upright(self.radius + self.tube + level, 2 * (self.tube + level))

    def spelled(self) -> str:
        return f"torus({number_spelled(self.radius)}, {number_spelled(self.tube)})"


@attrs.frozen(repr=False)
class CappedTorus(Form):
    """A part of a torus, `angle` long, half of it on either side of +x, with round ends.

    Within the angle the distance is the torus's; beyond it, that to the nearer end of the arc. The side is told by the
    sine of the difference of the angles, x sin a − |z| cos a for half an angle of a.
    """

    radius: float = positive_number()
    tube: float = positive_number()
    angle: float = positive_number()

    title = "capped_torus"

    is_edgeless = True

    def __attrs_post_init__(self) -> None:
        if self.angle > math.tau:
            raise GeometryError(f"capped_torus: angle must not be above 2π, but is {self.angle!r}; torus is the whole")

    @property
    def exactness(self) -> Exactness:  # type: ignore[override]
        gap = self.radius * math.sin(self.angle / 2) if self.angle > math.pi else math.inf
        return Exactness.EXACT if self.tube <= min(self.radius, gap) else Exactness.BOUND

    def expression(self, p: Point) -> Value:
        radius, tube, half = p.number(self.radius), p.number(self.tube), p.number(self.angle) * 0.5
        c, s, z = cos(half), sin(half), absolute(p.z)
        ring = length(p.bounded(length(p.x, p.z) - radius, 1.0), p.y)
        end = length(p.x - radius * c, p.y, z - radius * s)
        return p.bounded(select(z * c - p.x * s, ring, end) - tube, 1.0)

    @property
    def bounds(self) -> Box:
        return self.bounds_at(0.0)

    def bounds_at(self, level: float) -> Box:
        half, tube = self.angle / 2, self.tube + level
        across = self.radius * (math.sin(half) if half < math.pi / 2 else 1.0)
        back = self.radius * math.cos(half)
        return np.array([[back - tube, -tube, -across - tube], [self.radius + tube, tube, across + tube]])

    def spelled(self) -> str:
        return f"capped_torus({', '.join(map(number_spelled, (self.radius, self.tube, self.angle)))})"


@attrs.frozen(repr=False)
class Link(Form):
    """A link of a chain in the plane z = 0: a torus about z, cut and pulled apart along y."""

    radius: float = positive_number()
    tube: float = positive_number()
    height: float = positive_number()

    is_edgeless = True

    def __attrs_post_init__(self) -> None:
        least = 2 * (self.radius + self.tube)
        if self.height < least:
            raise GeometryError(
                f"link: height must not be below twice the sum of radius and tube, {least!r}, but is {self.height!r}; "
                "it is the full length"
            )

    @property
    def exactness(self) -> Exactness:  # type: ignore[override]
        return Exactness.EXACT if self.tube <= self.radius else Exactness.BOUND

    def expression(self, p: Point) -> Value:
        radius, tube = p.number(self.radius), p.number(self.tube)
        beyond = maximum(absolute(p.y) - (p.number(self.height) * 0.5 - radius - tube), 0.0)
        ring = p.bounded(length(p.x, beyond) - radius, 1.0)
        return p.bounded(length(ring, p.z) - tube, 1.0)

    @property
    def bounds(self) -> Box:
        return self.bounds_at(0.0)

    def bounds_at(self, level: float) -> Box:
        corner = np.array([self.radius + self.tube, self.height / 2, self.tube]) + level
        return np.stack([-corner, corner])

    def spelled(self) -> str:
        return f"link({', '.join(map(number_spelled, (self.radius, self.tube, self.height)))})"


def cylinder(radius: float, height: float | None = None) -> Field:
    """A cylinder along y about the origin, endless without a height. Exact."""
    return Field(Cylinder(radius, height))


def rounded_cone(radius: float, top: float, height: float) -> Field:
    """The hull of a ball of `radius` at the bottom and one of radius `top` above it, `height` long in all. Exact."""
    return Field(RoundedCone(radius, top, height))


def capsule(radius: float, height: float) -> Field:
    """A cylinder along y with half balls for ends, `height` long in all, about the origin. Exact."""
    return Field(Capsule(radius, height))


def cone(radius: float, height: float, top: float = 0.0) -> Field:
    """A cone about y with `radius` at y = −height / 2 and its tip, or a lid of radius `top`, at height / 2. Exact."""
    return Field(Cone(radius, height, top))


def torus(radius: float, tube: float) -> Field:
    """A ring about y: all within `tube` of a circle of `radius`. Exact where the tube is not above the radius."""
    return Field(Torus(radius, tube))


def capped_torus(radius: float, tube: float, angle: float) -> Field:
    """A part of a ring about y, `angle` radians long, half of it on either side of +x, with round ends.

    Exact where neither the tube nor the ends run into each other.
    """
    return Field(CappedTorus(radius, tube, angle))


def link(radius: float, tube: float, height: float) -> Field:
    """A link of a chain in the plane z = 0, `height` long in all, with ends bent to `radius`, `tube` thick. Exact."""
    return Field(Link(radius, tube, height))
