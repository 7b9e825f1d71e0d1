"""Fields of forms: numbers and vectors, checked, with messages that name the shape and the field."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, TypeAlias

import attrs
import numpy as np

from isophote.errors import GeometryError
from isophote.shapes.field.expression import Parameter

__all__ = ["Vector", "any_number", "not_negative_number", "positive_number", "positive_vector", "vector_of"]

Vector: TypeAlias = tuple[float, ...]


def _as_number(value: Any) -> Any:
    if isinstance(value, (Parameter, str | bytes)):
        return value
    try:
        return float(value)
    except (TypeError, ValueError):
        return value


def _as_vector(value: Any) -> Any:
    if isinstance(value, str | bytes):
        return value
    try:
        return tuple(_as_number(v) for v in value)
    except TypeError:
        return value


def _checked(wanted: str, holds: Callable[[Any], bool]) -> Callable[[Any, attrs.Attribute[Any], Any], None]:
    def check(instance: Any, attribute: attrs.Attribute[Any], value: Any) -> None:
        if not holds(value):
            shape = type(instance).__name__.lower()
            raise GeometryError(f"{shape}: {attribute.name} must be {wanted}, but is {value!r}")

    return check


def _is_finite(value: Any) -> bool:
    return isinstance(value, float) and math.isfinite(value)


def any_number(**options: Any) -> Any:
    """A finite number."""
    check = _checked("a finite number", _is_finite)
    return attrs.field(converter=_as_number, validator=check, **options)


def positive_number(**options: Any) -> Any:
    """A finite number above 0."""
    check = _checked("a finite number above 0", lambda v: _is_finite(v) and v > 0)
    return attrs.field(converter=_as_number, validator=check, **options)


def not_negative_number(**options: Any) -> Any:
    """A finite number, 0 or above."""
    check = _checked("a finite number, 0 or above", lambda v: _is_finite(v) and v >= 0)
    return attrs.field(converter=_as_number, validator=check, **options)


def vector_of(count: int, **options: Any) -> Any:
    """`count` finite numbers."""
    check = _checked(
        f"{count} finite numbers", lambda v: isinstance(v, tuple) and len(v) == count and all(map(_is_finite, v))
    )
    return attrs.field(converter=_as_vector, validator=check, **options)


def positive_vector(count: int, **options: Any) -> Any:
    """`count` finite numbers above 0, or one for all."""

    def convert(value: Any) -> Any:
        return (_as_number(value),) * count if np.ndim(value) == 0 else _as_vector(value)

    check = _checked(
        f"{count} finite numbers above 0, or one for all",
        lambda v: isinstance(v, tuple) and len(v) == count and all(_is_finite(n) and n > 0 for n in v),
    )
    return attrs.field(converter=convert, validator=check, **options)
