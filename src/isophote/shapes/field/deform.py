"""Deformations that change over the body: twist, bend, taper, displacement.

Each maps the point into the form's own space. The map's Lipschitz constant, the largest singular value of its
derivative, is bounded over the region that the expression is written for.
"""

from __future__ import annotations

import math
from functools import cached_property

import attrs
import numpy as np

from isophote.errors import GeometryError
from isophote.shapes.field.alter import Altered
from isophote.shapes.field.expression import Point, Value
from isophote.shapes.field.form import Box, Form, number_spelled
from isophote.shapes.field.functions import absolute, arctan2, clip, cos, length, maximum, sin
from isophote.shapes.field.joins import least
from isophote.shapes.field.numbers import any_number, highest, lowest, positive_number
from isophote.shapes.field.slope import largest_value, most, own_slope

__all__ = ["Bend", "Displace", "Taper", "Twist"]


def _sheared(side: float, shear: float, along: float) -> float:
    """Largest singular value of [[side, shear], [0, along]]."""
    total = side * side + shear * shear + along * along
    return math.sqrt((total + math.sqrt(max(total * total - 4 * (side * along) ** 2, 0.0))) / 2)


@attrs.frozen(repr=False)
class Twist(Altered):
    """A form turned about y by `rate` · y: the point goes back by that angle.

    The derivative is a turn after 1 + t yᵀ, with t across y and |t| = |rate| ρ, whose largest singular value is
    (τ + √(τ² + 4)) / 2 for τ = |rate| ρ.
    """

    rate: float = any_number()

    def expression(self, p: Point) -> Value:
        rate = p.number(self.rate)
        stretch = _sheared(1.0, most(rate) * math.hypot(most(p.x), most(p.z)), 1.0)
        angle = p.y * rate
        c, s = cos(angle), sin(angle)
        return self.form.expression(p.moved(p.x * c - p.z * s, p.y, p.x * s + p.z * c, stretch))

    def bounds_at(self, level: float) -> Box:
        box = self.form.bounds_at(level)
        reach = float(np.hypot(*np.abs(box[:, [0, 2]]).max(axis=0)))
        return np.array([[-reach, box[0, 1], -reach], [reach, box[1, 1], reach]])

    def spelled(self) -> str:
        return f"{self.form.spelled()}.twist({number_spelled(self.rate)})"


@attrs.frozen(repr=False)
class Bend(Altered):
    """A form bent so that its y axis becomes a circle of curvature κ, with its middle at 1 / κ on the x axis.

    About that middle, at the distance ρ and the angle θ, the point goes to x = 1 / κ − ρ, y = θ / κ, which moves
    1 / (κ ρ) times as fast along the circle. The form ends at the angle Y κ < π and at the distance ρ₀ > 0, and
    the value is max(ρ₀ − ρ, min(ρ, 2 π / κ − Y − |y|, max(f, |y| − Y))): nearer to the middle than ρ₀ / 2, where the
    map has no bound, it is ρ₀ − ρ, and where angles jump from π to −π it is the same on both sides.
    """

    curvature: float = any_number()

    def __attrs_post_init__(self) -> None:
        low, high = lowest(self.curvature), highest(self.curvature)
        if low <= 0 <= high:
            raise GeometryError(f"bend: curvature must not be 0, but is {self.curvature!r}; leave the bend out")
        box = self._box
        if not np.isfinite(box[:, :2]).all():
            raise GeometryError("bend: the form is endless along x or y; intersect it with a box first")
        worst = max(-low, high)
        inner, reach = float(box[1, 0]), float(np.abs(box[:, 1]).max())
        if inner * worst >= 1 or reach * worst >= math.pi:
            raise GeometryError(
                f"bend: with the curvature {self.curvature!r} a form up to {inner:g} from the axis towards the middle "
                f"of the circle, and {reach:g} along it, runs into itself; its curvature must be below "
                f"{min(1 / max(inner, 1e-300), math.pi / reach):g}"
            )

    def _sign(self) -> float:
        return 1.0 if self.curvature > 0 else -1.0

    @cached_property
    def _box(self) -> Box:
        return self._inner(0.0)

    def _inner(self, level: float) -> Box:
        """The form's bounds at a level, with x towards the middle of the circle."""
        box = self.form.bounds_at(level).copy()
        if self._sign() < 0:
            box[:, 0] = -box[::-1, 0]
        return box

    def expression(self, p: Point) -> Value:
        sign, box = self._sign(), self._box
        radius = 1.0 / (p.number(self.curvature) * sign)
        u = radius - p.x * sign
        rho = p.bounded(length(u, p.y), 1.0)
        angle = arctan2(p.y, u)
        inner, reach = radius - max(float(box[1, 0]), 0.0), float(np.abs(box[:, 1]).max())
        nearest = float(p.graph.interval(rho.id)[0])
        low, high = p.graph.interval(angle.id)
        cut = float(high - low) > 2 * math.pi - 1e-6
        stretch = math.inf if cut or nearest <= 0 else max(1.0, most(radius) / nearest)
        q = p.moved((radius - rho) * sign, angle * radius, p.z, stretch)
        away = absolute(q.y)
        part = maximum(self.form.expression(q), away - reach)
        value = maximum(inner - rho, least([rho, radius * (2 * math.pi) - reach - away, part]))
        closest = max(nearest, float(p.graph.interval(inner.id)[0]) / 2)
        return p.bounded(value, max(1.0, own_slope(self.form, q)) * max(1.0, most(radius) / closest))

    def bounds_at(self, level: float) -> Box:
        box, radius = self._inner(level), 1 / abs(float(self.curvature))
        reach = np.abs(self._box[:, 1]).max()
        nearest = radius - max(float(self._box[1, 0]), 0.0)
        if level > 0 and (level >= nearest / 2 or level >= math.pi * radius - reach or not np.isfinite(box).all()):
            return np.array([[-np.inf] * 3, [np.inf] * 3])
        near, far = max(radius - float(box[1, 0]), 0.0), radius - float(box[0, 0])
        start, end = np.clip(box[:, 1], -reach - level, reach + level) / radius
        angles = np.array([start, end, *(turn for turn in (-math.pi / 2, 0.0, math.pi / 2) if start < turn < end)])
        places = np.multiply.outer([near, far], np.stack([np.cos(angles), np.sin(angles)]))
        low, high = places.min(axis=(0, 2)), places.max(axis=(0, 2))
        x = np.sort(self._sign() * (radius - np.array([high[0], low[0]])))
        return np.array([[x[0], low[1], box[0, 2]], [x[1], high[1], box[1, 2]]])

    def spelled(self) -> str:
        return f"{self.form.spelled()}.bend({number_spelled(self.curvature)})"


@attrs.frozen(repr=False)
class Taper(Altered):
    """A form whose section across y is scaled by s(y), 1 up to y = `start` and `factor` from y = `end`, linear between.

    The value is f(x / s, y, z / s) · s. With the form's own distance ρ from the axis, the derivative of the map, times
    s, is a turn of [[1, −ρ s′], [0, s]], and the factor s adds |f s′|.
    """

    factor: float = positive_number()
    start: float = any_number()
    end: float = any_number()

    def __attrs_post_init__(self) -> None:
        if highest(self.start) >= lowest(self.end):
            raise GeometryError(f"taper: end must be above start, but they are {self.end!r} and {self.start!r}")

    def expression(self, p: Point) -> Value:
        start, slope = p.number(self.start), (p.number(self.factor) - 1.0) / (p.number(self.end) - p.number(self.start))
        scale = clip(p.y - start, 0.0, p.number(self.end) - start) * slope + 1.0
        low, high = (float(end) for end in p.graph.interval(scale.id))
        x, z = p.x / scale, p.z / scale
        shear = most(slope) * math.hypot(most(x), most(z))
        # What the form claims is of the map alone; the value has the factor s.
        q = p.moved(x, p.y, z, _sheared(1 / low, shear / low, 1.0) if low > 0 else math.inf)
        inner = self.form.expression(q)
        largest = min(most(inner), largest_value(self.form, q))
        claim = own_slope(self.form, q) * _sheared(1.0, shear, high) + largest * most(slope)
        return p.bounded(inner * scale, claim)

    def bounds_at(self, level: float) -> Box:
        factors = np.array([1.0, float(self.factor)])
        box = self.form.bounds_at(level / factors.min())
        wide = np.multiply.outer(factors, box)
        out = np.array([wide.min(axis=(0, 1)), wide.max(axis=(0, 1))])
        out[:, 1] = box[:, 1]
        return out

    def spelled(self) -> str:
        return f"{self.form.spelled()}.taper({', '.join(map(number_spelled, (self.factor, self.start, self.end)))})"


@attrs.frozen(repr=False)
class Displace(Altered):
    """A form whose surface is moved outwards by `amplitude` times the value of another, held within ±1.

    f − amplitude · clip(g, −1, 1), whose Lipschitz constant is at most that of f and amplitude times that of g.
    """

    by: Form = attrs.field()
    amplitude: float = any_number()

    def __attrs_post_init__(self) -> None:
        if self.form.dimension != self.by.dimension:
            raise GeometryError("displace: one of both fields is in the plane, the other in space; they must be alike")

    def expression(self, p: Point) -> Value:
        return self.form.expression(p) - clip(self.by.expression(p), -1.0, 1.0) * p.number(self.amplitude)

    def bounds_at(self, level: float) -> Box:
        return self.form.bounds_at(max(level, 0.0) + max(abs(lowest(self.amplitude)), abs(highest(self.amplitude))))

    def spelled(self) -> str:
        return f"{self.form.spelled()}.displace({self.by.spelled()}, {number_spelled(self.amplitude)})"
