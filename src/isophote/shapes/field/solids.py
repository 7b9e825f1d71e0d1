"""Solid primitives with exact distances; sizes are full lengths, round ones stand along +Y.

Source of most distances: Quílez, "distance functions", derived anew here where a comment says so.
"""

from __future__ import annotations

from typing import Any

import attrs
import numpy as np

from isophote.errors import GeometryError
from isophote.shapes.field.expression import Point, Value
from isophote.shapes.field.field import Field
from isophote.shapes.field.form import Box, Exactness, Form, grown, number_spelled
from isophote.shapes.field.functions import absolute, length, maximum
from isophote.shapes.field.joins import corner, largest, least
from isophote.shapes.field.numbers import (
    Axis,
    Vector,
    any_number,
    axis_of,
    highest,
    lowest,
    not_negative_number,
    positive_number,
    positive_vector,
    unit_axis,
)

__all__ = [
    "BoxForm",
    "Ellipsoid",
    "Frame",
    "Plane",
    "RoundedBox",
    "Slab",
    "Sphere",
    "box",
    "ellipsoid",
    "frame",
    "plane",
    "rounded_box",
    "slab",
    "sphere",
]


def _faces(p: Point, size: Vector) -> list[Value]:
    """|p| − size / 2, axis by axis."""
    return [absolute(c) - p.number(s) * 0.5 for c, s in zip(p.coordinates, size, strict=True)]


def _about_origin(size: Vector) -> Box:
    half = np.array(size) / 2
    return np.stack([-half, half])


def _size_spelled(size: Vector) -> str:
    return number_spelled(size[0] if len(set(map(repr, size))) == 1 else size)


@attrs.frozen(repr=False)
class Sphere(Form):
    """A ball: |p| − r."""

    radius: float = positive_number()

    is_edgeless = True

    def expression(self, p: Point) -> Value:
        return p.bounded(length(p.x, p.y, p.z) - p.number(self.radius), 1.0)

    @property
    def bounds(self) -> Box:
        return np.array([[-self.radius] * 3, [self.radius] * 3])

    def spelled(self) -> str:
        return f"sphere({number_spelled(self.radius)})"


@attrs.frozen(repr=False)
class Ellipsoid(Form):
    """An ellipsoid with half axes r: max((|p / r| − 1) · min r, |p| − max r).

    A bound: |p / r| has a slope of at most 1 / min r, and the ball of the longest half axis holds the ellipsoid, so
    that both values have Lipschitz constant 1. (Quotients such as |p / r| (|p / r| − 1) / |p / r²| are nearer to
    the distance at the surface, but have no Lipschitz constant at the middle.)
    """

    radii: Vector = positive_vector(3)
    exactness = Exactness.BOUND

    is_edgeless = True

    def expression(self, p: Point) -> Value:
        radii = [p.number(r) for r in self.radii]
        reach = length(*(c / r for c, r in zip(p.coordinates, radii, strict=True)))
        # A parameter for the shortest may, moved, be above another radius.
        shortest = min(self.radii, key=lowest)
        inner = p.bounded((reach - 1.0) * p.number(shortest), highest(shortest) / lowest(shortest))
        ball = p.bounded(length(p.x, p.y, p.z), 1.0) - largest(radii)
        return maximum(inner, ball)

    @property
    def bounds(self) -> Box:
        return self.bounds_at(0.0)

    def bounds_at(self, level: float) -> Box:
        radii = np.array(self.radii)
        inner = radii * (1 + level / radii.min())
        reach = np.minimum(inner, radii.max() + level) if level > 0 else radii
        return np.stack([-reach, reach])

    def spelled(self) -> str:
        return f"ellipsoid({_size_spelled(self.radii)})"


@attrs.frozen(repr=False)
class BoxForm(Form):
    """A box: |max(q, 0)| outside and max q inside, for q = |p| − size / 2."""

    size: Vector = positive_vector(3)

    title = "box"
    is_square = True
    is_smooth = True

    def expression(self, p: Point) -> Value:
        return p.bounded(corner(_faces(p, self.size)), 1.0)

    def faces(self, p: Point) -> list[Value]:
        return _faces(p, self.size)

    @property
    def bounds(self) -> Box:
        return _about_origin(self.size)

    def spelled(self) -> str:
        return f"box({_size_spelled(self.size)})"


@attrs.frozen(repr=False)
class RoundedBox(Form):
    """A box with edges and corners rounded by `radius`: the box of size − 2 radius, less the radius."""

    size: Vector = positive_vector(3)
    radius: float = not_negative_number()

    title = "rounded_box"

    is_edgeless = True

    def __attrs_post_init__(self) -> None:
        most = min(self.size) / 2
        if self.radius > most:
            raise GeometryError(
                f"rounded_box: radius must not be above half of the shortest side, {most!r}, but is {self.radius!r}"
            )

    def expression(self, p: Point) -> Value:
        radius = p.number(self.radius)
        return p.bounded(corner([face + radius for face in _faces(p, self.size)]) - radius, 1.0)

    @property
    def bounds(self) -> Box:
        return _about_origin(self.size)

    def spelled(self) -> str:
        return f"rounded_box({_size_spelled(self.size)}, {number_spelled(self.radius)})"


@attrs.frozen(repr=False)
class Frame(Form):
    """The twelve edges of a box as square bars, `thickness` thick.

    Derived here. With depths d = size / 2 − |p| below the faces, outside it is the least distance to the bars along
    x, y and z. Inside, what is not frame is nearest beyond a face, at d, or within two faces' openings, at
    |max(t − d_i, 0), max(t − d_j, 0)|.
    """

    size: Vector = positive_vector(3)
    thickness: float = positive_number()

    def __attrs_post_init__(self) -> None:
        if self.thickness >= min(self.size) / 2:
            raise GeometryError(
                f"frame: thickness must be below half of the shortest side, {min(self.size) / 2!r}, but is "
                f"{self.thickness!r}; a box has no openings"
            )

    def expression(self, p: Point) -> Value:
        thick = p.number(self.thickness)
        beyond = [maximum(face, 0.0) for face in _faces(p, self.size)]
        # How far a coordinate is from the bars that run across its axis.
        across = [absolute(face + thick * 0.5) - thick * 0.5 for face in _faces(p, self.size)]
        away = [maximum(c, 0.0) for c in across]
        bars = [length(*(beyond[j] if i == j else away[j] for j in range(3))) for i in range(3)]
        depths = [-face for face in _faces(p, self.size)]
        left = [maximum(thick - d, 0.0) for d in depths]
        openings = [length(left[i], left[j]) for i, j in ((0, 1), (1, 2), (2, 0))]
        return p.bounded(least(bars) - maximum(least([*depths, *openings]), 0.0), 1.0)

    @property
    def bounds(self) -> Box:
        return _about_origin(self.size)

    def spelled(self) -> str:
        return f"frame({_size_spelled(self.size)}, {number_spelled(self.thickness)})"


@attrs.frozen(repr=False)
class Plane(Form):
    """Half of space, solid below a plane: n · p − height, for a unit normal n."""

    normal: Axis = axis_of(default="y")
    height: float = any_number(default=0.0)

    is_edgeless = True

    def expression(self, p: Point) -> Value:
        parts = [c * n for c, n in zip(p.coordinates, unit_axis(self.normal), strict=True)]
        return p.bounded(parts[0] + parts[1] + parts[2] - p.number(self.height), 1.0)

    @property
    def bounds(self) -> Box:
        box = np.array([[-np.inf] * 3, [np.inf] * 3])
        normal = np.array(unit_axis(self.normal))
        axis = int(np.abs(normal).argmax())
        if np.abs(normal).sum() == 1:
            box[1 if normal[axis] > 0 else 0, axis] = self.height * normal[axis]
        return box

    def spelled(self) -> str:
        normal = repr(self.normal) if isinstance(self.normal, str) else number_spelled(self.normal)
        height = "" if type(self.height) is float and self.height == 0 else f", {number_spelled(self.height)}"
        return "plane()" if (self.normal, height) == ("y", "") else f"plane({normal}{height})"


@attrs.frozen(repr=False)
class Slab(Form):
    """All between two planes across y, `thickness` apart: |y| − thickness / 2."""

    thickness: float = positive_number()

    is_edgeless = True

    def expression(self, p: Point) -> Value:
        return p.bounded(absolute(p.y) - p.number(self.thickness) * 0.5, 1.0)

    @property
    def bounds(self) -> Box:
        return grown(np.array([[-np.inf, 0.0, -np.inf], [np.inf, 0.0, np.inf]]), self.thickness / 2)

    def spelled(self) -> str:
        return f"slab({number_spelled(self.thickness)})"


def sphere(radius: float = 1.0) -> Field:
    """A ball about the origin. Exact."""
    return Field(Sphere(radius))


def ellipsoid(radii: Any) -> Field:
    """An ellipsoid about the origin with half axes `radii` along x, y and z. A bound, exact at its middle."""
    return Field(Ellipsoid(radii))


def box(size: Any = 1.0) -> Field:
    """A box about the origin, with full edge lengths `size`: three numbers, or one for all. Exact."""
    return Field(BoxForm(size))


def rounded_box(size: Any, radius: float) -> Field:
    """A box about the origin, with full lengths `size` and edges rounded by `radius`, which is within them. Exact."""
    return Field(RoundedBox(size, radius))


def frame(size: Any, thickness: float) -> Field:
    """The twelve edges of a box with full lengths `size`, as bars with square ends, `thickness` thick. Exact."""
    return Field(Frame(size, thickness))


def plane(normal: Any = "y", height: float = 0.0) -> Field:
    """The ground: solid below y = 0, or below the plane across `normal` (a letter or a vector) at `height`. Exact."""
    return Field(Plane(normal, height))


def slab(thickness: float) -> Field:
    """All between two endless planes across y, `thickness` apart, about y = 0. Exact."""
    return Field(Slab(thickness))
