"""`Field`: a signed distance field in space, negative inside, as users hold it."""

from __future__ import annotations

from typing import Any, ClassVar, Self

import attrs
import numpy as np

from isophote.errors import GeometryError
from isophote.shapes.field.deform import Bend, Taper, Twist
from isophote.shapes.field.operations import Operations
from isophote.shapes.field.place import Along, Rotate
from isophote.shapes.field.ring import RepeatAround

__all__ = ["Field"]


@attrs.frozen(repr=False, slots=False)
class Field(Operations):
    """A signed distance field in space; operators and methods return new ones."""

    dimension: ClassVar[int] = 3

    def rotate(self, axis: Any, angle: float) -> Self:
        """Turned by `angle` radians about an axis through the origin, a letter or a vector; right-handed."""
        return self._with(Rotate(self.form, axis, angle))

    def along(self, axis: Any) -> Self:
        """Turned so that what stands along +y lies along `axis`, a letter or a vector."""
        return self._with(Along(self.form, axis))

    def repeat_around(self, axis: str, count: int) -> Self:
        """`count` copies about an axis ("x", "y" or "z"), evenly round, the first where this is.

        Neighbours of a point's sector are looked at, so that a distance stays one where copies are apart.
        """
        return self._with(RepeatAround(self.form, axis, count))

    def twist(self, rate: float) -> Self:
        """Turned about y by `rate` · y radians: right-handed, `rate` in radians a metre."""
        return self._with(Twist(self.form, rate))

    def bend(self, curvature: float) -> Self:
        """Bent so that the y axis becomes a circle of `curvature` (1 / radius) about a middle on +x, −x below 0.

        Lengths along the axis stay. Raises `GeometryError` where it is endless along x or y, or runs into itself.
        """
        return self._with(Bend(self.form, curvature))

    def taper(self, factor: float, start: float | None = None, end: float | None = None) -> Self:
        """The section across y scaled, by 1 up to y = `start` and by `factor` from y = `end`, linearly between.

        Without them, from the least to the greatest y of the bounds.
        """
        low, high = self.bounds[:, 1].tolist()
        if not np.isfinite([low if start is None else 0.0, high if end is None else 0.0]).all():
            raise GeometryError("taper: the field is endless along y; give start and end")
        return self._with(Taper(self.form, factor, low if start is None else start, high if end is None else end))
