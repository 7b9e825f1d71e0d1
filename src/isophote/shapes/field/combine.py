"""Union, intersection and difference, hard and smooth."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import attrs
import numpy as np

from isophote.shapes.field.expression import Number, Point, Value
from isophote.shapes.field.form import Box, Exactness, Form, number_spelled
from isophote.shapes.field.functions import smooth_maximum, smooth_minimum
from isophote.shapes.field.numbers import not_negative_number

__all__ = ["Difference", "Intersection", "Union"]

_Join: TypeAlias = Callable[[Value, Value, Number], Value]


def _joined(values: list[Value], join: _Join, k: Number) -> Value:
    """All values joined in pairs, then pairs of pairs, so that the expression is flat, not a long chain."""
    while len(values) > 1:
        pairs = [join(a, b, k) for a, b in zip(values[::2], values[1::2], strict=False)]
        values = pairs + values[len(pairs) * 2 :]
    return values[0]


@attrs.frozen(repr=False)
class _Several(Form):
    parts: tuple[Form, ...]
    blend: float = not_negative_number(default=0.0)

    @property
    def dimension(self) -> int:  # type: ignore[override]
        return self.parts[0].dimension

    @property
    def exactness(self) -> Exactness:  # type: ignore[override]
        """Inside a union, and outside an intersection, the nearest surface may be one that is not there."""
        return min(Exactness.BOUND, *(part.exactness for part in self.parts))

    def _spelled(self, name: str, sign: str) -> str:
        if self.blend == 0:
            return "(" + f" {sign} ".join(part.spelled() for part in self.parts) + ")"
        return f"{name}({', '.join(p.spelled() for p in self.parts)}, blend={number_spelled(self.blend)})"


@attrs.frozen(repr=False)
class Union(_Several):
    """Least of the parts' values; smooth within `blend`, which adds at most blend / 4 a join."""

    def expression(self, p: Point) -> Value:
        return _joined([part.expression(p) for part in self.parts], smooth_minimum, p.number(self.blend))

    @property
    def bounds(self) -> Box:
        boxes = np.stack([part.bounds for part in self.parts])
        joins = int(np.ceil(np.log2(len(self.parts))))
        grown = self.blend / 4 * joins
        return np.stack([boxes[:, 0].min(axis=0) - grown, boxes[:, 1].max(axis=0) + grown])

    def spelled(self) -> str:
        return self._spelled("union", "|")


@attrs.frozen(repr=False)
class Intersection(_Several):
    """Largest of the parts' values; smooth within `blend`."""

    def expression(self, p: Point) -> Value:
        return _joined([part.expression(p) for part in self.parts], smooth_maximum, p.number(self.blend))

    @property
    def bounds(self) -> Box:
        boxes = np.stack([part.bounds for part in self.parts])
        low, high = boxes[:, 0].max(axis=0), boxes[:, 1].min(axis=0)
        return np.stack([low, np.maximum(low, high)])

    def spelled(self) -> str:
        return self._spelled("intersection", "&")


@attrs.frozen(repr=False)
class Difference(_Several):
    """The first part without the others: max(a, −b)."""

    def expression(self, p: Point) -> Value:
        first, *others = [part.expression(p) for part in self.parts]
        blend = p.number(self.blend)
        return smooth_maximum(first, -_joined(others, smooth_minimum, blend), blend)

    @property
    def bounds(self) -> Box:
        return self.parts[0].bounds

    def spelled(self) -> str:
        return self._spelled("difference", "-")
