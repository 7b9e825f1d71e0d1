"""Forms that stand elsewhere: the inverse of the transform goes on the point."""

from __future__ import annotations

import attrs
import numpy as np

from isophote.shapes.field.expression import Point, Value
from isophote.shapes.field.form import Box, Exactness, Form, number_spelled
from isophote.shapes.field.numbers import Vector, vector_of

__all__ = ["Translate"]


@attrs.frozen(repr=False)
class Translate(Form):
    """A form moved by `offset`."""

    form: Form
    offset: Vector = vector_of(3)

    @property
    def exactness(self) -> Exactness:  # type: ignore[override]
        return self.form.exactness

    def expression(self, p: Point) -> Value:
        x, y, z = (c - p.number(o) for c, o in zip(p[:3], self.offset, strict=True))
        return self.form.expression(p.moved(x, y, z))

    @property
    def bounds(self) -> Box:
        box: Box = self.form.bounds + np.array(self.offset)
        return box

    def spelled(self) -> str:
        return f"{self.form.spelled()}.translate({number_spelled(self.offset)})"
