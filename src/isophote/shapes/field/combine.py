"""Union, intersection and difference: sharp, or with blended, rounded or chamfered edges."""

from __future__ import annotations

from typing import Any

import attrs
import numpy as np

from isophote.errors import GeometryError
from isophote.shapes.field.expression import Point, Value
from isophote.shapes.field.form import Box, Exactness, Form, number_spelled
from isophote.shapes.field.joins import STYLES, joined, reach_of, united
from isophote.shapes.field.numbers import not_negative_number

__all__ = ["Difference", "Intersection", "Union", "combined"]

# Boxes of so many parts are looked at in pairs, to see whether the parts are apart.
_MOST_APART = 512


def _parts(instance: Any, attribute: attrs.Attribute[Any], parts: tuple[Form, ...]) -> None:
    title = instance.title
    if not parts:
        raise GeometryError(f"{title}: it has no parts; give one field or more")
    if len({part.dimension for part in parts}) > 1:
        raise GeometryError(
            f"{title}: fields in the plane and in space cannot be combined; extrude or revolve those in the plane first"
        )


@attrs.frozen(repr=False)
class _Several(Form):
    parts: tuple[Form, ...] = attrs.field(validator=_parts)
    blend: float = not_negative_number(default=0.0)
    round: float = not_negative_number(default=0.0)
    chamfer: float = not_negative_number(default=0.0)

    sign = ""

    def __attrs_post_init__(self) -> None:
        if sum(getattr(self, style) > 0 for style in STYLES) > 1:
            raise GeometryError(
                f"{self.title}: blend, round and chamfer exclude each other, but are "
                f"{self.blend!r}, {self.round!r} and {self.chamfer!r}; leave all but one at 0"
            )

    @property
    def dimension(self) -> int:  # type: ignore[override]
        return self.parts[0].dimension

    @property
    def style(self) -> str:
        """The style of the edges."""
        return next((style for style in STYLES if getattr(self, style) > 0), "blend")

    @property
    def size(self) -> float:
        """The size of the edges, 0 where sharp."""
        size: float = getattr(self, self.style)
        return size

    @property
    def exactness(self) -> Exactness:  # type: ignore[override]
        """Inside a union, and outside an intersection, the nearest surface may be one that is not there."""
        if len(self.parts) == 1:
            return self.parts[0].exactness
        return min(Exactness.BOUND, *(part.exactness for part in self.parts))

    def spelled(self) -> str:
        parts = [part.spelled() for part in self.parts]
        if self.size == 0 and len(parts) > 1:
            return "(" + f" {self.sign} ".join(parts) + ")"
        edges = "" if self.size == 0 else f", {self.style}={number_spelled(self.size)}"
        return f"{self.title}({', '.join(parts)}{edges})"


def combined(kind: type[_Several], parts: tuple[Form, ...], **edges: Any) -> _Several:
    """Parts put together; sharp ones of the same kind that come first become parts of the new one."""
    form = kind(parts, **edges)
    if form.size != 0:
        return form
    flat: list[Form] = []
    for number, part in enumerate(parts):
        same = type(part) is kind and isinstance(part, _Several) and part.size == 0
        flat.extend(part.parts if same and (number == 0 or kind is not Difference) else [part])  # type: ignore[attr-defined]
    return kind(tuple(flat))


@attrs.frozen(repr=False)
class Union(_Several):
    """Least of the parts' values: min(a, b); smooth, rounded or chamfered where it is asked for.

    Smooth: min(a, b) − h² blend / 4 with h = max(blend − |a − b|, 0) / blend, equal to the minimum where the values
    differ by `blend` or more, and with slopes between the parts'. Source: Quílez, "smooth minimum".
    """

    title = "union"
    sign = "|"

    def expression(self, p: Point) -> Value:
        return united([part.expression(p) for part in self.parts], self.style, p.number(self.size))

    def finished(self, p: Point, style: str, size: Value) -> Value:
        parts = [part.finished(p, style, size) for part in self.parts]
        return united(parts, self.style, p.number(self.size))

    @property
    def exactness(self) -> Exactness:  # type: ignore[override]
        """Exact where sharp and all parts, exact, are apart: then who is inside one sees no other's surface there."""
        worst = min(part.exactness for part in self.parts)
        is_exact = worst is Exactness.EXACT and self.size == 0 and self._are_apart()
        return worst if is_exact else min(worst, Exactness.BOUND)

    def _are_apart(self) -> bool:
        if len(self.parts) > _MOST_APART:
            return False
        boxes = np.stack([part.bounds for part in self.parts])
        meet = ((boxes[:, None, 0] <= boxes[None, :, 1]) & (boxes[None, :, 0] <= boxes[:, None, 1])).all(axis=2)
        return int(meet.sum()) == len(self.parts)

    @property
    def is_tight(self) -> bool:  # type: ignore[override]
        return self.size == 0 and all(part.is_tight for part in self.parts)

    @property
    def bounds(self) -> Box:
        return self.bounds_at(0.0)

    def bounds_at(self, level: float) -> Box:
        for _ in range(int(np.ceil(np.log2(len(self.parts)))) if self.size > 0 else 0):
            level = reach_of(self.style, self.size, level)
        boxes = np.stack([part.bounds_at(level) for part in self.parts])
        return np.stack([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)])


@attrs.frozen(repr=False)
class Intersection(_Several):
    """Largest of the parts' values: max(a, b); smooth, rounded or chamfered where it is asked for."""

    title = "intersection"
    sign = "&"
    is_tight = False

    def expression(self, p: Point) -> Value:
        return joined([part.expression(p) for part in self.parts], self.style, p.number(self.size))

    def faces(self, p: Point) -> list[Value]:
        if self.size > 0:
            return [self.expression(p)]
        return [face for part in self.parts for face in part.faces(p)]

    @property
    def bounds(self) -> Box:
        return self.bounds_at(0.0)

    def bounds_at(self, level: float) -> Box:
        boxes = np.stack([part.bounds_at(level) for part in self.parts])
        low, high = boxes[:, 0].max(axis=0), boxes[:, 1].min(axis=0)
        return np.stack([low, np.maximum(low, high)])


@attrs.frozen(repr=False)
class Difference(_Several):
    """The first part without the others: max(a, −b); smooth, rounded or chamfered where it is asked for."""

    title = "difference"
    sign = "-"
    is_tight = False

    def _solid(self, p: Point) -> list[Value]:
        """Nothing, or one value: what is outside the parts that are taken away."""
        others = [part.expression(p) for part in self.parts[1:]]
        return [-united(others, self.style, p.number(self.size))] if others else []

    def expression(self, p: Point) -> Value:
        return joined([self.parts[0].expression(p), *self._solid(p)], self.style, p.number(self.size))

    def faces(self, p: Point) -> list[Value]:
        if self.size > 0:
            return [self.expression(p)]
        return [*self.parts[0].faces(p), *self._solid(p)]

    @property
    def bounds(self) -> Box:
        return self.parts[0].bounds

    def bounds_at(self, level: float) -> Box:
        return self.parts[0].bounds_at(level)
