"""`Field`: a signed distance field in space, negative inside, as users hold it."""

from __future__ import annotations

from typing import Any, ClassVar, Self

import attrs

from isophote.shapes.field.operations import Operations
from isophote.shapes.field.place import Along, Rotate

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
