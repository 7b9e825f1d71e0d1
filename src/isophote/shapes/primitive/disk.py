"""Flat disks."""

from __future__ import annotations

from typing import Any

import attrs
import numpy as np

from isophote.shapes.primitive.checks import positive
from isophote.shapes.primitive.extent import box_around
from isophote.shapes.primitive.primitive import Matrix, Primitive, upright

__all__ = ["Disk"]


def _as_float(value: Any) -> Any:
    try:
        return float(value)
    except (TypeError, ValueError):
        return value


@attrs.frozen
class Disk:
    """A flat disk about the origin in the plane y = 0, x² + z² ≤ radius², whose normal is +y.

    A surface without thickness. Texture coordinates run along x and −z, 0 to 1 across the disk. Raises `GeometryError`
    unless the radius is finite and above 0.
    """

    radius: float = attrs.field(default=1.0, converter=_as_float, validator=positive("Disk"))

    @property
    def primitive(self) -> Primitive:
        """What rays meet."""
        return Primitive("disk", upright(self.radius, self.radius), np.zeros(0))

    @property
    def bounds(self) -> Matrix:
        """(2, 3): the least box."""
        return box_around(self.primitive)
