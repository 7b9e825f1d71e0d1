"""Quadrics: where a polynomial of the second degree is not positive."""

from __future__ import annotations

from typing import Any

import attrs
import numpy as np
import numpy.typing as npt

from isophote.errors import GeometryError
from isophote.shapes.primitive.checks import frozen
from isophote.shapes.primitive.extent import box_around
from isophote.shapes.primitive.primitive import Matrix, Primitive

__all__ = ["Quadric"]

_COEFFICIENTS = 10


def _coefficients(value: npt.ArrayLike) -> tuple[float, ...]:
    try:
        numbers = np.array(value, np.float64)
    except (TypeError, ValueError) as error:
        raise GeometryError(f"Quadric: coefficients must be ten numbers: {error}") from None
    if numbers.shape != (_COEFFICIENTS,) or not np.isfinite(numbers).all():
        raise GeometryError(f"Quadric: coefficients must be ten finite numbers, but are {value!r}")
    if not numbers[:9].any():
        raise GeometryError("Quadric: all coefficients but the last are 0, so there is no surface")
    return tuple(numbers.tolist())


def _box(value: Any) -> tuple[tuple[float, ...], tuple[float, ...]]:
    try:
        box = np.array(value, np.float64)
    except (TypeError, ValueError) as error:
        raise GeometryError(f"Quadric: box must be two corners, (2, 3): {error}") from None
    if box.shape != (2, 3) or np.isnan(box).any():
        raise GeometryError(f"Quadric: box must be two corners, (2, 3), without NaN, but is {value!r}")
    if not (box[0] < box[1]).all():
        raise GeometryError(f"Quadric: box must have its greatest corner above its least one, but is {box.tolist()}")
    return tuple(box[0].tolist()), tuple(box[1].tolist())


@attrs.frozen
class Quadric:
    """All of `box`, (2, 3), where a polynomial of the second degree is not positive:

        a x² + b y² + c z² + d xy + e xz + f yz + g x + h y + i z + j ≤ 0

    for the ten `coefficients` a, b, …, j. The box may be infinite along any axis. Where the surface leaves the box, the
    box's faces close the solid; with `closed` False only the surface is there, and can be looked into.

    Texture coordinates: u, the angle about the upright line through the box's middle (the origin where the box is
    infinite), 0 to 1 from +x; v, the height in the box, 0 to 1, or y. Raises `GeometryError` for coefficients that are
    not finite or leave no surface, and boxes without extent.
    """

    coefficients: tuple[float, ...] = attrs.field(converter=_coefficients)
    box: tuple[tuple[float, ...], tuple[float, ...]] = attrs.field(default=((-1.0,) * 3, (1.0,) * 3), converter=_box)
    closed: bool = attrs.field(default=True, validator=attrs.validators.instance_of(bool))

    @property
    def primitive(self) -> Primitive:
        """What rays meet."""
        box = np.array(self.box)
        finite = np.isfinite(box).all(axis=0)
        middle = np.where(finite, np.where(finite, box, 0.0).mean(axis=0), 0.0)
        values = np.concatenate([self.coefficients, box[0], box[1], middle, [float(self.closed)]])
        return Primitive("quadric", np.eye(4), frozen(values))

    @property
    def bounds(self) -> Matrix:
        """(2, 3): the box, or, of ellipsoids, what of it they need."""
        return box_around(self.primitive)

    def __call__(self, points: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """(n,) the polynomial's values at `points` (n, 3): negative inside."""
        x, y, z = np.asarray(points, np.float64).T
        a, b, c, d, e, f, g, h, i, j = self.coefficients
        values: npt.NDArray[np.float64] = (
            a * x * x + b * y * y + c * z * z + d * x * y + e * x * z + f * y * z + g * x + h * y + i * z + j
        )
        return values
