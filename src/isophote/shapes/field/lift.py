"""Solids from forms in the plane: extruded along z, turned about y."""

from __future__ import annotations

import attrs
import numpy as np

from isophote.errors import GeometryError
from isophote.shapes.field.expression import Point, Value
from isophote.shapes.field.form import Box, Exactness, Form, number_spelled
from isophote.shapes.field.functions import absolute, length
from isophote.shapes.field.joins import corner
from isophote.shapes.field.numbers import any_number, positive_number
from isophote.shapes.field.slope import own_slope

__all__ = ["Extrude", "Revolve"]


@attrs.frozen(repr=False)
class Extrude(Form):
    """A form in the plane z = 0, drawn out along z by half of `height` both ways.

    With the form's value f and w = |z| − height / 2: |(max(f, 0), max(w, 0))| + min(max(f, w), 0). Where f is a
    distance, this is one too: the solid is the product of the form and an interval, f and w are the distances within
    each factor, and the nearest point outside is the nearest in both; inside, a wall or a lid is nearest.

    Its slope is at most that of f or 1, whichever is more: f depends on x and y alone and w on z alone, so that outside
    the gradient is (a ∇f, b ∇w) with a² + b² = 1.
    """

    form: Form
    height: float = positive_number()

    @property
    def exactness(self) -> Exactness:  # type: ignore[override]
        return self.form.exactness

    @property
    def is_tight(self) -> bool:  # type: ignore[override]
        return self.form.is_tight

    @property
    def is_square(self) -> bool:  # type: ignore[override]
        """Walls stand upright on the lids; among themselves they must meet so too."""
        one_wall = type(self.form).faces is Form.faces and self.form.exactness is Exactness.EXACT
        return one_wall or self.form.is_square

    @property
    def is_smooth(self) -> bool:  # type: ignore[override]
        return self.form.is_smooth

    def expression(self, p: Point) -> Value:
        value = corner([self.form.expression(p), self._lids(p)])
        return p.bounded(value, max(own_slope(self.form, p), 1.0))

    def faces(self, p: Point) -> list[Value]:
        return [*self.form.faces(p), self._lids(p)]

    def _lids(self, p: Point) -> Value:
        return absolute(p.z) - p.number(self.height) * 0.5

    @property
    def bounds(self) -> Box:
        return self.bounds_at(0.0)

    def bounds_at(self, level: float) -> Box:
        half = self.height / 2 + max(level, 0.0)
        return np.column_stack([self.form.bounds_at(level), [-half, half]])

    def spelled(self) -> str:
        return f"{self.form.spelled()}.extrude({number_spelled(self.height)})"


@attrs.frozen(repr=False)
class Revolve(Form):
    """A form in the plane, moved by `offset` along x and turned about the y axis; what lies left of it is left out.

    The value is the form's at (√(x² + z²) − offset, y), a map that brings no two points farther apart, so that slopes
    grow no steeper. It is a distance where the form is one and nothing of it lies left of the axis: the nearest point
    of the solid then lies in the half plane of the point itself. Otherwise what was left out may be nearer.
    """

    form: Form
    offset: float = any_number(default=0.0)

    def __attrs_post_init__(self) -> None:
        right = float(self.form.bounds[1, 0]) + self.offset
        if not right > 0:
            raise GeometryError(
                f"revolve: nothing of the form lies right of the axis, for it ends at x = {right!r}; give offset="
            )

    @property
    def exactness(self) -> Exactness:  # type: ignore[override]
        clear = float(self.form.bounds[0, 0]) + self.offset >= 0
        return self.form.exactness if clear else min(self.form.exactness, Exactness.BOUND)

    def expression(self, p: Point) -> Value:
        reach = p.bounded(length(p.x, p.z), 1.0)
        q = p.moved(reach - p.number(self.offset), p.y, 0.0)
        return p.bounded(self.form.expression(q), own_slope(self.form, q))

    @property
    def is_tight(self) -> bool:  # type: ignore[override]
        return self.form.is_tight

    @property
    def bounds(self) -> Box:
        return self.bounds_at(0.0)

    def bounds_at(self, level: float) -> Box:
        (_, low), (right, high) = self.form.bounds_at(level)
        reach = right + self.offset
        return np.array([[-reach, low, -reach], [reach, high, reach]])

    def spelled(self) -> str:
        offset = f"offset={number_spelled(self.offset)}" if self.offset != 0 else ""
        return f"{self.form.spelled()}.revolve({offset})"
