"""Numbers and points that shapes are made of, checked, with messages that name the shape and the field."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.errors import GeometryError

__all__ = ["finite_points", "frozen", "positive"]

Floats: TypeAlias = npt.NDArray[np.float64]


def frozen(array: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """The array, read-only from now on."""
    array.flags.writeable = False
    return array


def finite_points(name: str, values: npt.ArrayLike, width: int, least: int = 1) -> Floats:
    """A copy of finite points (n, `width`), `least` or more. Raises `GeometryError` for others, `name` first."""
    try:
        points = np.array(values, np.float64)
    except (TypeError, ValueError) as error:
        raise GeometryError(f"{name} must be numbers of shape (n, {width}): {error}") from None
    if points.ndim != 2 or points.shape[1] != width or len(points) < least:
        raise GeometryError(f"{name} must have shape (n, {width}) with n ≥ {least}, but have {points.shape}")
    finite = np.isfinite(points).all(axis=1)
    if not finite.all():
        bad = int(np.argmin(finite))
        raise GeometryError(f"{name}: number {bad} is not finite: {points[bad].tolist()}")
    return points


def positive(shape: str) -> Callable[[Any, attrs.Attribute[Any], Any], None]:
    """A validator for finite numbers above 0."""

    def check(instance: Any, attribute: attrs.Attribute[Any], value: Any) -> None:
        if not isinstance(value, float) or not np.isfinite(value) or value <= 0:
            raise GeometryError(f"{shape}: {attribute.name} must be a finite number above 0, but is {value!r}")

    return check
