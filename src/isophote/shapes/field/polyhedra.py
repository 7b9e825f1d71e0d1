"""Solid primitives with flat faces, with exact distances: folded by their mirrors until one face is left."""

from __future__ import annotations

import math

import attrs
import numpy as np

from isophote.shapes.field.expression import Point, Value
from isophote.shapes.field.field import Field
from isophote.shapes.field.form import Box, Form, number_spelled
from isophote.shapes.field.functions import absolute, clip, length, maximum, minimum, select, sqrt
from isophote.shapes.field.joins import corner, largest, least
from isophote.shapes.field.numbers import optional_number, positive_number, whole_number

__all__ = ["Octahedron", "Prism", "Pyramid", "octahedron", "prism", "pyramid"]


@attrs.frozen(repr=False)
class Prism(Form):
    """A regular prism along y, endless without height: `sides` corners at `radius` from the axis, one of them at +x.

    Derived here. Mirrors through the axis at multiples of π / sides bring the point into the wedge between a corner
    and the middle of a face: each mirror halves the multiples that are left, and moves points no faster than they do.
    There the polygon's distance is that to one line, or to the corner beyond its end.
    """

    sides: int = whole_number(3, 10_000)
    radius: float = positive_number()
    height: float | None = optional_number()

    is_square = True

    def _folded(self, p: Point) -> tuple[Value, Value]:
        """(x, z) of the point's mirror image between the angles 0 and π / sides."""
        step = math.pi / self.sides
        x, z = p.x, absolute(p.z)
        left = self.sides
        while left > 1:
            left = (left + 1) // 2
            nx, nz = -math.sin(left * step), math.cos(left * step)
            above = maximum(x * nx + z * nz, 0.0) * 2.0
            x, z = p.bounded(x - above * nx, 1.0), p.bounded(z - above * nz, 1.0)
        return x, z

    def _side(self, p: Point) -> Value:
        step = math.pi / self.sides
        x, z = self._folded(p)
        radius, c, s = p.number(self.radius), math.cos(step), math.sin(step)
        face = p.bounded(x * c + z * s - radius * c, 1.0)
        beyond = p.bounded(x * s - z * c - radius * s, 1.0)
        outside = length(maximum(face, 0.0), maximum(beyond, 0.0))
        return p.bounded(outside + minimum(face, 0.0), 1.0)

    def faces(self, p: Point) -> list[Value]:
        side = self._side(p)
        return [side] if self.height is None else [side, absolute(p.y) - p.number(self.height) * 0.5]

    def expression(self, p: Point) -> Value:
        faces = self.faces(p)
        return faces[0] if len(faces) == 1 else p.bounded(corner(faces), 1.0)

    @property
    def bounds(self) -> Box:
        angles = np.arange(self.sides) * (2 * math.pi / self.sides)
        x, z = self.radius * np.cos(angles), self.radius * np.sin(angles)
        half = math.inf if self.height is None else self.height / 2
        return np.array([[x.min(), -half, z.min()], [x.max(), half, z.max()]])

    def spelled(self) -> str:
        height = "" if self.height is None else f", {number_spelled(self.height)}"
        return f"prism({self.sides}, {number_spelled(self.radius)}{height})"


@attrs.frozen(repr=False)
class Pyramid(Form):
    """A pyramid on a square of side `base` at y = −height / 2, with its tip at y = height / 2.

    Derived here. Folded to x ≥ z ≥ 0, one face is left, with the tip and a corner of the base. Inside, a face or the
    base is nearest. Outside it is the base, the edge from the tip to the corner, or, where the foot of the
    perpendicular is in the triangle, the face.
    """

    base: float = positive_number()
    height: float = positive_number()

    def _folded(self, p: Point) -> tuple[Value, Value]:
        x, z = absolute(p.x), absolute(p.z)
        return maximum(x, z), minimum(x, z)

    def _sides(self, p: Point) -> tuple[Value, Value]:
        """Distances to the planes of the face and of the base."""
        half, height = p.number(self.base) * 0.5, p.number(self.height)
        x, _ = self._folded(p)
        slant = sqrt(half * half + height * height)
        face = (x * height + (p.y - height * 0.5) * half) / slant
        return p.bounded(face, 1.0), -p.y - height * 0.5

    def faces(self, p: Point) -> list[Value]:
        half, height = p.number(self.base) * 0.5, p.number(self.height)
        slant = sqrt(half * half + height * height)
        drop = (p.y - height * 0.5) * half
        sides = [p.bounded((absolute(c) * height + drop) / slant, 1.0) for c in (p.x, p.z)]
        return [*sides, -p.y - height * 0.5]

    def expression(self, p: Point) -> Value:
        half, height = p.number(self.base) * 0.5, p.number(self.height)
        x, z = self._folded(p)
        face, below = self._sides(p)
        inside = maximum(face, below)
        to_base = length(maximum(x - half, 0.0), below, maximum(z - half, 0.0))
        # From the tip down: the edge runs along (half, −height, half), the face along (half, −height, 0).
        drop = height * 0.5 - p.y
        edge = clip(((x + z) * half + drop * height) / (half * half * 2.0 + height * height), 0.0, 1.0)
        to_edge = length(x - edge * half, drop - edge * height, z - edge * half)
        down = (x * half + drop * height) / (half * half + height * height)
        beyond = largest([z - down * half, (down - 1.0) * half])
        to_face = select(beyond, absolute(face), to_edge)
        return p.bounded(select(inside, inside, least([to_base, to_edge, to_face])), 1.0)

    @property
    def bounds(self) -> Box:
        corner = np.array([self.base, self.height, self.base]) / 2
        return np.stack([-corner, corner])

    def spelled(self) -> str:
        return f"pyramid({number_spelled(self.base)}, {number_spelled(self.height)})"


@attrs.frozen(repr=False)
class Octahedron(Form):
    """An octahedron with its corners at `radius` along the axes.

    Derived here. With coordinates folded and sorted, x ≥ y ≥ z ≥ 0, one face is left: (x + y + z − r) / √3 is the
    distance where the foot of the perpendicular has z ≥ 0, that is where 2 z − x − y + r ≥ 0, and inside;
    elsewhere the edge in the plane z = 0 is nearest.
    """

    radius: float = positive_number()

    def faces(self, p: Point) -> list[Value]:
        x, y, z = (absolute(c) for c in p.coordinates)
        radius = p.number(self.radius)
        total = x + y + z - radius
        # The neighbours of the face in the folded octant: across its three edges one coordinate changes its sign.
        root = math.sqrt(1 / 3)
        return [p.bounded(v * root, 1.0) for v in (total, *(total - c * 2.0 for c in (x, y, z)))]

    def expression(self, p: Point) -> Value:
        x, y, z = (absolute(c) for c in p.coordinates)
        x, y = maximum(x, y), minimum(x, y)
        y, z = maximum(y, z), minimum(y, z)
        x, y = maximum(x, y), minimum(x, y)
        radius = p.number(self.radius)
        face = p.bounded((x + y + z - radius) * math.sqrt(1 / 3), 1.0)
        along = clip((x - y + radius) * 0.5, 0.0, radius)
        edge = length(x - along, y - radius + along, z)
        return p.bounded(select(z * 2.0 - x - y + radius, edge, face), 1.0)

    @property
    def bounds(self) -> Box:
        return np.array([[-self.radius] * 3, [self.radius] * 3])

    def spelled(self) -> str:
        return f"octahedron({number_spelled(self.radius)})"


def prism(sides: int, radius: float, height: float | None = None) -> Field:
    """A regular prism along y about the origin: corners at `radius`, one at +x; endless without a height. Exact."""
    return Field(Prism(sides, radius, height))


def pyramid(base: float, height: float) -> Field:
    """A pyramid on a square of side `base`, from y = −height / 2 to its tip at height / 2. Exact."""
    return Field(Pyramid(base, height))


def octahedron(radius: float) -> Field:
    """A regular octahedron about the origin with its corners at `radius` along the axes. Exact."""
    return Field(Octahedron(radius))
