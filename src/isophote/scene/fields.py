"""What the fields of scene descriptions share: lenient converters, and validators that name the field.

Converters bring what was given to its plain form where they can and pass it on untouched where they
cannot, so that the validator, which knows the class and the field, writes the message.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from typing import Any, TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.errors import SceneError

__all__ = [
    "ArrayKey",
    "Vector",
    "VectorLike",
    "as_flag",
    "as_number",
    "as_optional_number",
    "as_pair",
    "as_vector",
    "finite",
    "fraction",
    "frozen_array",
    "instance_of",
    "non_negative",
    "non_zero",
    "one_of",
    "optional",
    "pair",
    "positive",
    "vector",
]

Vector: TypeAlias = tuple[float, float, float]
VectorLike: TypeAlias = Sequence[float] | npt.NDArray[Any]
Validator: TypeAlias = Callable[[Any, "attrs.Attribute[Any]", Any], None]


class ArrayKey:
    """Compares and hashes an array by its values, for fields of frozen classes."""

    __slots__ = ("_array",)

    def __init__(self, array: npt.NDArray[Any]) -> None:
        self._array = array

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, ArrayKey):
            return NotImplemented
        a, b = self._array, other._array
        return a is b or (a.dtype == b.dtype and np.array_equal(a, b))

    def __hash__(self) -> int:
        # Adding zero makes -0.0, which equals 0.0, hash like it. A large array hashes by a part of it.
        return hash((self._array.shape, (self._array.reshape(-1)[:64] + 0).tobytes()))


def frozen_array(array: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """A read-only view of an array."""
    view = array.view()
    view.flags.writeable = False
    return view


def _numbers(values: Any) -> Any:
    """The tuple of floats that `values` spells, or `values` itself where it spells none."""
    if isinstance(values, str | bytes) or not isinstance(values, Iterable):
        return values
    try:
        return tuple(float(value) for value in values)
    except (TypeError, ValueError):
        return values


def as_vector(value: VectorLike) -> Vector:
    """Three floats."""
    return _numbers(value)  # type: ignore[no-any-return]


def as_pair(value: Sequence[float]) -> tuple[float, float]:
    """Two floats."""
    return _numbers(value)  # type: ignore[no-any-return]


def as_number(value: float) -> float:
    """One float."""
    if isinstance(value, str | bytes):
        return value
    try:
        return float(value)
    except (TypeError, ValueError):
        return value


def as_optional_number(value: float | None) -> float | None:
    """One float, or None."""
    return None if value is None else as_number(value)


def as_flag(value: bool) -> bool:
    """True or False, from NumPy's booleans too."""
    return bool(value)


def _fail(instance: Any, attribute: attrs.Attribute[Any], wanted: str, value: Any) -> SceneError:
    return SceneError(f"{type(instance).__name__}: {attribute.name} must be {wanted}, but is {value!r}")


def _all_finite(value: Any, count: int) -> bool:
    return (
        isinstance(value, tuple)
        and len(value) == count
        and all(isinstance(v, float) and math.isfinite(v) for v in value)
    )


def vector(instance: Any, attribute: attrs.Attribute[Any], value: Any) -> None:
    """Three finite numbers."""
    if not _all_finite(value, 3):
        raise _fail(instance, attribute, "three finite numbers (x, y, z)", value)


def non_zero(instance: Any, attribute: attrs.Attribute[Any], value: Any) -> None:
    """Three finite numbers that are not all zero: a direction."""
    vector(instance, attribute, value)
    if not any(value):
        raise _fail(instance, attribute, "a direction, with a length above zero", value)


def pair(instance: Any, attribute: attrs.Attribute[Any], value: Any) -> None:
    """Two finite numbers."""
    if not _all_finite(value, 2):
        raise _fail(instance, attribute, "two finite numbers", value)


def _is_number(value: Any) -> bool:
    return isinstance(value, float) and math.isfinite(value)


def finite(instance: Any, attribute: attrs.Attribute[Any], value: Any) -> None:
    """A finite number."""
    if not _is_number(value):
        raise _fail(instance, attribute, "a finite number", value)


def positive(instance: Any, attribute: attrs.Attribute[Any], value: Any) -> None:
    """A finite number above zero."""
    if not (_is_number(value) and value > 0):
        raise _fail(instance, attribute, "a finite number above 0", value)


def non_negative(instance: Any, attribute: attrs.Attribute[Any], value: Any) -> None:
    """A finite number, zero or above."""
    if not (_is_number(value) and value >= 0):
        raise _fail(instance, attribute, "a finite number, 0 or above", value)


def fraction(instance: Any, attribute: attrs.Attribute[Any], value: Any) -> None:
    """A number from 0 to 1."""
    if not (_is_number(value) and 0 <= value <= 1):
        raise _fail(instance, attribute, "a number from 0 to 1", value)


def optional(validator: Validator) -> Validator:
    """None, or what `validator` accepts."""

    def check(instance: Any, attribute: attrs.Attribute[Any], value: Any) -> None:
        if value is not None:
            validator(instance, attribute, value)

    return check


def one_of(*choices: str) -> Validator:
    """One of these words."""

    def check(instance: Any, attribute: attrs.Attribute[Any], value: Any) -> None:
        if not isinstance(value, str) or value not in choices:
            raise _fail(instance, attribute, " or ".join(repr(choice) for choice in choices), value)

    return check


def instance_of(wanted: str, *kinds: type) -> Validator:
    """An instance of one of `kinds`; `wanted` says so in words."""

    def check(instance: Any, attribute: attrs.Attribute[Any], value: Any) -> None:
        if not isinstance(value, kinds):
            raise _fail(instance, attribute, wanted, value)

    return check
