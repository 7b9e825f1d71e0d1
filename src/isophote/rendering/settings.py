"""What settings of methods may be: checks that say what is wrong with a value."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import Any, TypeAlias

import attrs
import numpy as np

from isophote.errors import RenderError

__all__ = ["Check", "one_of", "optional_positive", "optional_whole", "positive", "whole"]

Check: TypeAlias = Callable[[Any, "attrs.Attribute[Any]", Any], None]


def _refuse(method: Any, attribute: attrs.Attribute[Any], wanted: str, value: object) -> None:
    raise RenderError(f"{type(method).__name__}: {attribute.name} must be {wanted}, not {value!r}")


def whole(least: int, most: int) -> Check:
    """A whole number from `least` to `most`."""

    def check(method: Any, attribute: attrs.Attribute[Any], value: object) -> None:
        if isinstance(value, bool) or not isinstance(value, int | np.integer) or not least <= value <= most:
            _refuse(method, attribute, f"a whole number from {least} to {most:,}", value)

    return check


def optional_whole(least: int, most: int) -> Check:
    """A whole number from `least` to `most`, or None."""
    return attrs.validators.optional(whole(least, most))


def positive(method: Any, attribute: attrs.Attribute[Any], value: object) -> None:
    """A finite number above 0."""
    number = isinstance(value, int | float | np.number) and not isinstance(value, bool)
    if not number or not 0 < value < math.inf:  # type: ignore[operator]
        _refuse(method, attribute, "a number above 0", value)


def optional_positive(method: Any, attribute: attrs.Attribute[Any], value: object) -> None:
    """A finite number above 0, or None."""
    if value is None:
        return
    number = isinstance(value, int | float | np.number) and not isinstance(value, bool)
    if not number or not 0 < value < math.inf:  # type: ignore[operator]
        _refuse(method, attribute, "a number above 0, or None", value)


def one_of(names: Iterable[str]) -> Check:
    """One of the names."""
    known = tuple(names)

    def check(method: Any, attribute: attrs.Attribute[Any], value: object) -> None:
        if value not in known:
            _refuse(method, attribute, f"one of {', '.join(known)}", value)

    return check
