"""JSON values that know where they stand, so that every complaint names the place."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from typing import Any, NoReturn

import attrs

from isophote.errors import FileError
from isophote.io.files import StrPath

__all__ = ["Field", "parse_json"]

_LARGEST_INTEGER = 2**53


@attrs.frozen
class Field:
    """A JSON object at `place` of the file `path`; every getter raises `FileError` for a value of another kind."""

    path: StrPath
    value: dict[str, Any]
    place: str = ""

    def fail(self, reason: str, key: str = "") -> NoReturn:
        """Raise a `FileError` that names this object, or one of its keys."""
        raise FileError(self.path, reason, self._at(key) if key else self.place)

    def _at(self, key: str) -> str:
        return f"{self.place}.{key}" if self.place else key

    def __contains__(self, key: str) -> bool:
        return key in self.value

    def text(self, key: str) -> str | None:
        """A string, or None where there is none."""
        value = self.value.get(key)
        if value is not None and not isinstance(value, str):
            self.fail("must be a string", key)
        return value

    def flag(self, key: str) -> bool:
        """True or False; False where there is neither."""
        value = self.value.get(key, False)
        if not isinstance(value, bool):
            self.fail("must be true or false", key)
        return value

    def number(self, key: str, default: float) -> float:
        """A finite number."""
        value = self.value.get(key, default)
        if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < 1e300:
            self.fail("must be a finite number", key)
        return float(value)

    def integer(self, key: str, default: int | None = None) -> int:
        """A whole number, 0 or above."""
        value = self.value.get(key, default)
        if isinstance(value, float) and value.is_integer():
            value = int(value)
        if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value <= _LARGEST_INTEGER:
            self.fail("is missing" if value is None else "must be a whole number, 0 or above", key)
        return value

    def numbers(self, key: str, count: int, default: tuple[float, ...]) -> tuple[float, ...]:
        """`count` finite numbers."""
        value = self.value.get(key, default)
        if not isinstance(value, list | tuple) or len(value) != count or not all(map(_is_number, value)):
            self.fail(f"must be {count} finite numbers", key)
        return tuple(float(v) for v in value)

    def child(self, key: str) -> Field | None:
        """An object, or None where there is none."""
        value = self.value.get(key)
        if value is None:
            return None
        if not isinstance(value, dict):
            self.fail("must be an object", key)
        return Field(self.path, value, self._at(key))

    def extension(self, name: str) -> Field | None:
        """The object of an extension, or None."""
        extensions = self.child("extensions")
        return None if extensions is None else extensions.child(name)

    def array(self, key: str) -> list[Any]:
        """A list, empty where there is none."""
        value = self.value.get(key, [])
        if not isinstance(value, list):
            self.fail("must be a list", key)
        return value

    def children(self, key: str) -> Iterator[Field]:
        """The objects of a list."""
        for index in range(len(self.array(key))):
            yield self.entry(key, index)

    def entry(self, key: str, index: int) -> Field:
        """One object of a list. Raises `FileError` where the list has no such entry."""
        entries = self.array(key)
        if not 0 <= index < len(entries):
            self.fail(f"there is no {key}[{index}]; the file has {len(entries)} {key}")
        if not isinstance(entries[index], dict):
            self.fail("must be an object", f"{key}[{index}]")
        return Field(self.path, entries[index], self._at(f"{key}[{index}]"))

    def indices(self, key: str) -> list[int]:
        """A list of whole numbers, 0 or above."""
        values = self.array(key)
        if not all(isinstance(v, int) and not isinstance(v, bool) and v >= 0 for v in values):
            self.fail("must be a list of whole numbers, 0 or above", key)
        return values


def _is_number(value: Any) -> bool:
    return (
        isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < 1e300 and math.isfinite(value)
    )


def parse_json(path: StrPath, data: bytes) -> Field:
    """The object that JSON text holds. Raises `FileError` for anything else."""
    try:
        value = json.loads(data, parse_constant=_refuse_constant)
    except json.JSONDecodeError as error:
        raise FileError(
            path, f"its JSON is broken: {error.msg}", f"line {error.lineno}, column {error.colno}"
        ) from error
    except (ValueError, RecursionError) as error:
        raise FileError(path, f"its JSON is broken: {error}") from error
    if not isinstance(value, dict):
        raise FileError(path, "its JSON must be an object")
    return Field(path, value)


def _refuse_constant(name: str) -> NoReturn:
    raise ValueError(f"{name} is no number in JSON")
