"""Solids from forms in the plane: extruded along z, turned about y."""

from __future__ import annotations

import attrs
import numpy as np

from isophote.errors import GeometryError
from isophote.shapes.field.expression import Graph, Point, Value
from isophote.shapes.field.form import Box, Exactness, Form, number_spelled
from isophote.shapes.field.functions import absolute, length, maximum, minimum
from isophote.shapes.field.numbers import any_number, positive_number

__all__ = ["Extrude", "Revolve", "own_slope"]


def own_slope(form: Form, p: Point) -> float:
    """A Lipschitz constant of a form in its own space, where `p` may be; infinite where none is known."""
    if form.exactness is Exactness.EXACT:
        return 1.0
    low, high = np.array([[float(end) for end in interval] for interval in p.intervals()]).T
    graph = Graph(np.stack([low, high]))
    value = form.expression(graph.point)
    return graph.lipschitz()[value.id]


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

    def expression(self, p: Point) -> Value:
        f = self.form.expression(p)
        w = absolute(p.z) - p.number(self.height) * 0.5
        outside = length(maximum(f, 0.0), maximum(w, 0.0))
        value = outside + minimum(maximum(f, w), 0.0)
        return p.bounded(value, max(own_slope(self.form, p), 1.0))

    @property
    def bounds(self) -> Box:
        half = self.height / 2
        return np.column_stack([self.form.bounds, [-half, half]])

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
    def bounds(self) -> Box:
        (_, low), (right, high) = self.form.bounds
        reach = right + self.offset
        return np.array([[-reach, low, -reach], [reach, high, reach]])

    def spelled(self) -> str:
        offset = f"offset={number_spelled(self.offset)}" if self.offset != 0 else ""
        return f"{self.form.spelled()}.revolve({offset})"
