"""Forms made thicker, hollow, longer, or with their edges finished."""

from __future__ import annotations

import attrs
import numpy as np

from isophote.errors import GeometryError
from isophote.shapes.field.expression import Graph, Point, Value
from isophote.shapes.field.form import Box, Exactness, Form, grown, number_spelled
from isophote.shapes.field.functions import maximum, minimum
from isophote.shapes.field.numbers import Vector, any_number, not_negative_vector, positive_number
from isophote.shapes.field.place import Placed

__all__ = ["Altered", "Elongate", "Finished", "Offset", "Shell"]


@attrs.frozen(repr=False)
class Altered(Form):
    """One form whose value is changed, not its point."""

    form: Form

    is_tight = False

    @property
    def dimension(self) -> int:  # type: ignore[override]
        return self.form.dimension

    @property
    def exactness(self) -> Exactness:  # type: ignore[override]
        """Where the surface moves, parts of it meet, and what was nearest may be gone."""
        return min(self.form.exactness, Exactness.BOUND)

    @property
    def bounds(self) -> Box:
        return self.bounds_at(0.0)


@attrs.frozen(repr=False)
class Offset(Altered):
    """A form whose surface is moved outwards by `distance`, inwards where it is negative: f − distance.

    Outwards from an exact field, the values outside stay exact, and convex edges become round.
    """

    distance: float = any_number()

    def expression(self, p: Point) -> Value:
        return self.form.expression(p) - p.number(self.distance)

    def bounds_at(self, level: float) -> Box:
        inner = self.form.bounds_at(max(level + self.distance, 0.0))
        if self.distance >= 0 or self.form.exactness is not Exactness.EXACT:
            return inner
        # What is deeper than so much in an exact field is as far from its bounds.
        by = min(level + self.distance, 0.0)
        with np.errstate(invalid="ignore"):
            middle = np.nan_to_num(inner.mean(axis=0), nan=0.0)
        smaller = grown(inner, by)
        return np.stack([np.minimum(smaller[0], middle), np.maximum(smaller[1], middle)])

    def spelled(self) -> str:
        return f"{self.form.spelled()}.offset({number_spelled(self.distance)})"


@attrs.frozen(repr=False)
class Shell(Altered):
    """The surface of a form, made `thickness` thick, half of it on either side: |f| − thickness / 2."""

    thickness: float = positive_number()

    def expression(self, p: Point) -> Value:
        return abs(self.form.expression(p)) - p.number(self.thickness) * 0.5

    def bounds_at(self, level: float) -> Box:
        return self.form.bounds_at(max(level, 0.0) + self.thickness / 2)

    def spelled(self) -> str:
        return f"{self.form.spelled()}.shell({number_spelled(self.thickness)})"


@attrs.frozen(repr=False)
class Finished(Altered):
    """A form with its edges rounded or chamfered, without growing.

    Faces f, g, … whose largest is the form's value inside meet in its edges. Rounded by r: |max(f + r, 0)| +
    min(max(f + r), 0) − r, the corner of faces moved inwards and then offset, which is exact where faces are square.
    Chamfered by c: the largest of the faces and of (f + g + c) / √2 for each two.
    """

    size: float = positive_number()
    style: str = attrs.field(default="round", validator=attrs.validators.in_(("round", "chamfer")))

    def __attrs_post_init__(self) -> None:
        most = float(np.diff(self.form.bounds, axis=0).min()) / 2
        if self.style == "round" and self.size > most:
            raise GeometryError(
                f"round: radius must not be above half of the least extent, {most:g}, but is {self.size!r}"
            )
        # Raises where edges are not known.
        self.expression(Graph().point)

    @property
    def name(self) -> str:
        return self.style

    @property
    def exactness(self) -> Exactness:  # type: ignore[override]
        if self.style == "round" and self.form.is_square and self.form.is_smooth:
            return self.form.exactness
        return super().exactness

    def expression(self, p: Point) -> Value:
        return self.form.finished(p, self.style, p.number(self.size))

    def bounds_at(self, level: float) -> Box:
        return self.form.bounds_at(level)

    def spelled(self) -> str:
        return f"{self.form.spelled()}.{self.style}({number_spelled(self.size)})"


@attrs.frozen(repr=False)
class Elongate(Placed):
    """A form cut through the origin, across each axis, and pulled apart by `length`: f(p − clip(p, ±length / 2)).

    The new coordinates move no faster than the point does, so the Lipschitz constant stays. Source: Quílez,
    "distance functions", elongation.
    """

    length: Vector = not_negative_vector()

    title = "elongate"
    is_square = False

    def __attrs_post_init__(self) -> None:
        if not any(self.length):
            raise GeometryError("elongate: length is 0 along every axis; give one above 0")

    @property
    def exactness(self) -> Exactness:  # type: ignore[override]
        return min(self.form.exactness, Exactness.BOUND)

    def inside(self, p: Point) -> Point:
        parts = p.coordinates
        for axis, size in enumerate(self.length):
            if size > 0:
                half = p.number(size) * 0.5
                # c − clip(c, ±half), written so that intervals stay narrow.
                c = parts[axis]
                parts[axis] = p.bounded(maximum(c - half, 0.0) + minimum(c + half, 0.0), 1.0)
        return p.moved(parts[0], parts[1], parts[2])

    @property
    def is_tight(self) -> bool:  # type: ignore[override]
        return False

    def bounds_at(self, level: float) -> Box:
        half = np.array(self.length) / 2
        box = self.form.bounds_at(level)
        return np.stack([box[0] + np.where(box[0] > 0, half, -half), box[1] + np.where(box[1] < 0, -half, half)])

    def spelled(self) -> str:
        return f"{self.form.spelled()}.elongate({number_spelled(self.length)})"
