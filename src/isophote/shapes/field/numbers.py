"""Fields of forms: numbers and vectors, checked, with messages that name the shape and the field."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, TypeAlias

import attrs
import numpy as np

from isophote.errors import GeometryError
from isophote.shapes.field.expression import Parameter

__all__ = [
    "Axis",
    "Vector",
    "any_number",
    "any_vector",
    "axis_of",
    "highest",
    "lowest",
    "not_negative_number",
    "not_negative_vector",
    "optional_number",
    "positive_number",
    "positive_vector",
    "scale_factor",
    "unit_axis",
    "vector_of",
    "whole_number",
]

Vector: TypeAlias = tuple[float, ...]
Axis: TypeAlias = str | Vector

_LETTERS = "xyz"


def _as_number(value: Any) -> Any:
    if isinstance(value, (Parameter, str | bytes)):
        return value
    try:
        return float(value)
    except (TypeError, ValueError, OverflowError):
        return value


def _as_vector(value: Any) -> Any:
    if isinstance(value, str | bytes):
        return value
    try:
        return tuple(_as_number(v) for v in value)
    except TypeError:
        return value


def _spread(value: Any) -> Any:
    """A number alone, or a vector."""
    return _as_number(value) if np.ndim(value) == 0 else _as_vector(value)


def _refuse(instance: Any, attribute: attrs.Attribute[Any], wanted: str, value: Any) -> GeometryError:
    return GeometryError(f"{instance.name}: {attribute.name} must be {wanted}, but is {value!r}")


def _checked(wanted: str, holds: Callable[[Any], bool]) -> Callable[[Any, attrs.Attribute[Any], Any], None]:
    def check(instance: Any, attribute: attrs.Attribute[Any], value: Any) -> None:
        if not holds(value):
            raise _refuse(instance, attribute, wanted, value)

    return check


def _is_finite(value: Any) -> bool:
    return isinstance(value, float) and math.isfinite(value)


def lowest(value: float) -> float:
    """The least that a number can be: the low end of a parameter's slider."""
    return value.low if isinstance(value, Parameter) else value


def highest(value: float) -> float:
    """The most that a number can be."""
    return value.high if isinstance(value, Parameter) else value


def _is_positive(value: Any) -> bool:
    return _is_finite(value) and lowest(value) > 0


def _is_not_negative(value: Any) -> bool:
    return _is_finite(value) and lowest(value) >= 0


def any_number(**options: Any) -> Any:
    """A finite number."""
    check = _checked("a finite number", _is_finite)
    return attrs.field(converter=_as_number, validator=check, **options)


def positive_number(**options: Any) -> Any:
    """A finite number above 0; of a parameter, all that it can be."""
    check = _checked("a finite number above 0", _is_positive)
    return attrs.field(converter=_as_number, validator=check, **options)


def not_negative_number(**options: Any) -> Any:
    """A finite number, 0 or above."""
    check = _checked("a finite number, 0 or above", _is_not_negative)
    return attrs.field(converter=_as_number, validator=check, **options)


def optional_number(**options: Any) -> Any:
    """None, or a finite number above 0."""
    check = _checked("a finite number above 0, or None for endless", lambda v: v is None or _is_positive(v))
    return attrs.field(
        converter=lambda v: None if v is None else _as_number(v), validator=check, default=None, **options
    )


def whole_number(least: int, most: int, **options: Any) -> Any:
    """A whole number from `least` to `most`."""

    def convert(value: Any) -> Any:
        return int(value) if isinstance(value, int | np.integer) and not isinstance(value, bool) else value

    check = _checked(f"a whole number from {least} to {most}", lambda v: type(v) is int and least <= v <= most)
    return attrs.field(converter=convert, validator=check, **options)


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
        lambda v: isinstance(v, tuple) and len(v) == count and all(map(_is_positive, v)),
    )
    return attrs.field(converter=convert, validator=check, **options)


def _for_each_axis(wanted: str, holds: Callable[[Any], bool], alone: bool, **options: Any) -> Any:
    """One number for each axis of `instance.form`; where `alone`, a single one will do."""

    def check(instance: Any, attribute: attrs.Attribute[Any], value: Any) -> None:
        count = instance.form.dimension
        fits = isinstance(value, tuple) and len(value) == count and all(map(holds, value))
        if not (fits or (alone and holds(value))):
            raise _refuse(instance, attribute, f"{count} {wanted}" + (", or one for all" if alone else ""), value)

    return attrs.field(converter=_spread, validator=check, **options)


def any_vector(**options: Any) -> Any:
    """One finite number for each axis of the form's space."""
    return _for_each_axis("finite numbers", _is_finite, False, **options)


def not_negative_vector(**options: Any) -> Any:
    """One finite number, 0 or above, for each axis of the form's space."""
    return _for_each_axis("finite numbers, 0 or above", _is_not_negative, False, **options)


def scale_factor(**options: Any) -> Any:
    """A finite number above 0, or one for each axis of the form's space."""
    return _for_each_axis("finite numbers above 0", _is_positive, True, **options)


def axis_of(**options: Any) -> Any:
    """A letter for an axis of the form's space, or a vector along one."""

    def check(instance: Any, attribute: attrs.Attribute[Any], value: Any) -> None:
        count = instance.form.dimension if hasattr(instance, "form") else 3
        letters = _LETTERS[:count]
        vector = isinstance(value, tuple) and len(value) == count and all(map(_is_finite, value)) and any(value)
        if not (vector or (isinstance(value, str) and len(value) == 1 and value in letters)):
            wanted = ", ".join(map(repr, letters)) + f" or {count} finite numbers that are not all 0"
            raise _refuse(instance, attribute, wanted, value)

    return attrs.field(converter=_as_vector, validator=check, **options)


def unit_axis(axis: Axis, dimension: int = 3) -> Vector:
    """The unit vector along an axis."""
    if isinstance(axis, str):
        return tuple(float(letter == axis) for letter in _LETTERS[:dimension])
    vector = np.array(axis, float) / np.abs(axis).max()
    return tuple((vector / np.linalg.norm(vector)).tolist())
