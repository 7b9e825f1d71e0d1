"""One column of what a user's function of places gives."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias

import attrs
import numpy as np

from isophote.shapes.field.expression import Point, Value
from isophote.shapes.field.form import Box, Exactness, Form
from isophote.shapes.field.symbols import Columns

__all__ = ["FunctionPart"]

Function: TypeAlias = Callable[[Any], Any]


@attrs.frozen(repr=False, slots=False)
class FunctionPart(Form):
    """Column `part` of a NumPy function of points (n, 3) that gives (n, k), or what it gives where that is (n,).

    An expression, not a shape: it is nowhere bounded, and its slopes are not known. Writing it fails for functions that
    use more than what has an expression (symbols.py).
    """

    function: Function
    part: int = 0
    exactness = Exactness.BOUND
    title = "formula"

    @property
    def bounds(self) -> Box:
        return np.array([[-np.inf] * 3, [np.inf] * 3])

    def expression(self, p: Point) -> Value:
        result = self.function(Columns(p[:3], False))
        if not isinstance(result, Columns):
            raise TypeError("the function does not give numbers for each point")
        column = result.parts[self.part]
        return column if isinstance(column, Value) else p.number(column)
