"""Rays and what describes shapes, as they are given: checked, in double precision, one row for each ray."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.errors import GeometryError

__all__ = ["checked_rays", "positive_numbers", "rows"]

Floats: TypeAlias = npt.NDArray[np.float64]


def checked_rays(origins: npt.ArrayLike, directions: npt.ArrayLike) -> tuple[Floats, Floats]:
    """Origins and directions, both (n, 3); one row may stand for all. Raises `GeometryError` for coordinates that are
    not finite, and directions that are zero."""
    o, d = rows("origins", origins, (3,)), rows("directions", directions, (3,))
    try:
        o, d = np.broadcast_arrays(o, d)
    except ValueError:
        raise GeometryError(f"{len(o)} origins and {len(d)} directions are not of one length") from None
    zero = ~d.any(axis=1)
    if zero.any():
        raise GeometryError(f"directions must not be zero, but number {int(np.argmax(zero))} is")
    return o, d


def rows(name: str, values: npt.ArrayLike, shape: tuple[int, ...], count: int | None = None) -> Floats:
    """(n, *shape) finite numbers; one alone counts as one row. With a `count`, one row or so many.

    Raises `GeometryError` for others.
    """
    try:
        array = np.array(values, np.float64)
    except (TypeError, ValueError) as error:
        raise GeometryError(f"{name} must be numbers of shape {_spelled(shape)}: {error}") from None
    if array.shape == shape:
        array = array[None]
    if array.shape[1:] != shape or array.ndim != 1 + len(shape):
        raise GeometryError(f"{name} must have shape {_spelled(shape)}, but have {np.shape(values)}")
    finite = np.isfinite(array).reshape(len(array), -1).all(axis=1)
    if not finite.all():
        raise GeometryError(f"{name} must be finite, but number {int(np.argmin(finite))} is not")
    if count is not None and len(array) not in (1, count):
        raise GeometryError(f"{name} must be one, or one for each of {count} rays, but are {len(array)}")
    return array


def positive_numbers(name: str, values: npt.ArrayLike, count: int) -> Floats:
    """One finite number above 0, or one for each ray. Raises `GeometryError` for others."""
    numbers = rows(name, values, (), count)
    if not (numbers > 0).all():
        raise GeometryError(f"{name} must be above 0, but is {numbers[int(np.argmin(numbers > 0))]!r}")
    return numbers


def _spelled(shape: tuple[int, ...]) -> str:
    return f"({', '.join(map(str, ('n', *shape)))}{',' if not shape else ''})"
