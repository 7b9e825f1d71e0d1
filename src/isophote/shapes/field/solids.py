"""Solid primitives with exact distances; sizes are full lengths, round ones stand along +Y.

Source of most distances: Quílez, "distance functions", derived anew here where a comment says so.
"""

from __future__ import annotations

import attrs
import numpy as np

from isophote.shapes.field.expression import Point, Value
from isophote.shapes.field.form import Box, Form, number_spelled
from isophote.shapes.field.functions import absolute, length, maximum, minimum
from isophote.shapes.field.numbers import Vector, positive_number, positive_vector

__all__ = ["BoxForm", "Cylinder", "Sphere"]


@attrs.frozen(repr=False)
class Sphere(Form):
    """A ball: |p| − r."""

    radius: float = positive_number()

    def expression(self, p: Point) -> Value:
        return p.bounded(length(p.x, p.y, p.z) - p.number(self.radius), 1.0)

    @property
    def bounds(self) -> Box:
        return np.array([[-self.radius] * 3, [self.radius] * 3])

    def spelled(self) -> str:
        return f"sphere({number_spelled(self.radius)})"


@attrs.frozen(repr=False)
class BoxForm(Form):
    """A box: length of max(q, 0) outside and max(q) inside, for q = |p| − size / 2."""

    size: Vector = positive_vector(3)

    def expression(self, p: Point) -> Value:
        q = [absolute(c) - p.number(s) * 0.5 for c, s in zip(p[:3], self.size, strict=True)]
        outside = length(*(maximum(c, 0.0) for c in q))
        inside = minimum(maximum(maximum(q[0], q[1]), q[2]), 0.0)
        return p.bounded(outside + inside, 1.0)

    @property
    def bounds(self) -> Box:
        half = np.array(self.size) / 2
        return np.stack([-half, half])

    def spelled(self) -> str:
        same = len(set(self.size)) == 1
        return f"box({number_spelled(self.size[0] if same else self.size)})"


@attrs.frozen(repr=False)
class Cylinder(Form):
    """A cylinder along y, endless where `height` is None."""

    radius: float = positive_number()
    height: float | None = attrs.field(default=None)

    def expression(self, p: Point) -> Value:
        side = length(p.x, p.z) - p.number(self.radius)
        if self.height is None:
            return p.bounded(side, 1.0)
        cap = absolute(p.y) - p.number(self.height) * 0.5
        outside = length(maximum(side, 0.0), maximum(cap, 0.0))
        return p.bounded(outside + minimum(maximum(side, cap), 0.0), 1.0)

    @property
    def bounds(self) -> Box:
        half = np.inf if self.height is None else self.height / 2
        corner = np.array([self.radius, half, self.radius])
        return np.stack([-corner, corner])

    def spelled(self) -> str:
        height = "" if self.height is None else f", {number_spelled(self.height)}"
        return f"cylinder({number_spelled(self.radius)}{height})"
