"""The header of a PLY file: which elements follow, with which properties of which types.

Source: Greg Turk, The PLY Polygon File Format (1994).
"""

from __future__ import annotations

from typing import Literal, TypeAlias

import attrs

from isophote.errors import FileError
from isophote.io.ascii import line_number
from isophote.io.files import StrPath

__all__ = ["Element", "Encoding", "Header", "Property", "parse_header", "type_name"]

Encoding: TypeAlias = Literal["ascii", "little", "big"]

_ENCODINGS: dict[str, Encoding] = {
    "ascii": "ascii",
    "binary_little_endian": "little",
    "binary_big_endian": "big",
}

# Turk's names and the sized ones that came later, each with NumPy's code.
_TYPES = {
    "char": "i1",
    "int8": "i1",
    "uchar": "u1",
    "uint8": "u1",
    "short": "i2",
    "int16": "i2",
    "ushort": "u2",
    "uint16": "u2",
    "int": "i4",
    "int32": "i4",
    "uint": "u4",
    "uint32": "u4",
    "float": "f4",
    "float32": "f4",
    "double": "f8",
    "float64": "f8",
}
_NAMES = {code: name for name, code in reversed(_TYPES.items())}

_LONGEST_COUNT = 18  # digits; more would not fit into 64 bits, and no file is as long


def type_name(code: str) -> str:
    """Turk's name of the type that NumPy calls `code`: "float" for "f4"."""
    return _NAMES[code]


@attrs.frozen
class Property:
    """A column: `type` is NumPy's code; `count_type` that of the length where each row holds a list."""

    name: str
    type: str
    count_type: str | None = None


@attrs.frozen
class Element:
    """A table: `count` rows of `properties`."""

    name: str
    count: int
    properties: tuple[Property, ...]

    @property
    def has_lists(self) -> bool:
        return any(p.count_type for p in self.properties)

    @property
    def has_floats(self) -> bool:
        return any(p.type[0] == "f" for p in self.properties)


@attrs.frozen
class Header:
    """What the header says; the tables begin at byte `size`."""

    encoding: Encoding
    elements: tuple[Element, ...]
    size: int


def parse_header(path: StrPath, data: bytes) -> Header:
    """Read the header. Raises `FileError`, with the line, where it is no PLY header or contradicts itself."""
    return _Parser(path, data).parse()


class _Parser:
    def __init__(self, path: StrPath, data: bytes) -> None:
        self.path = path
        self.data = data
        self.line_start = 0
        self.encoding: Encoding | None = None
        self.tables: list[tuple[str, int, dict[str, Property]]] = []

    def fail(self, reason: str) -> FileError:
        return FileError(self.path, reason, f"line {line_number(self.data, self.line_start)}")

    def parse(self) -> Header:
        data = self.data
        if data[:3] != b"ply" or data[3:4] not in (b"\n", b"\r"):
            raise FileError(self.path, 'is not a PLY file: it does not begin with the line "ply"', "line 1")
        # The first line shows how all of them end; a binary table may begin with any byte.
        newline = b"\r\n" if data[3:5] == b"\r\n" else data[3:4]
        while True:
            self.line_start = data.find(newline, self.line_start) + len(newline)
            end = data.find(newline, self.line_start)
            line = data[self.line_start : end if end >= 0 else len(data)]
            if line.strip() == b"end_header":
                return self.header(end + len(newline) if end >= 0 else len(data))
            if end < 0:
                raise self.fail('the header does not end with "end_header"; the file is cut short or damaged')
            self.statement(line[:10_000].decode("latin-1").split())

    def header(self, size: int) -> Header:
        if self.encoding is None:
            raise self.fail('the header has no "format" line')
        elements = tuple(Element(name, count, tuple(columns.values())) for name, count, columns in self.tables)
        return Header(self.encoding, elements, size)

    def statement(self, words: list[str]) -> None:
        match words:
            case [] | ["comment" | "obj_info", *_]:
                return
            case ["format", name, _]:
                if name not in _ENCODINGS:
                    raise self.fail(f'the format is "{name[:40]}"; known are {", ".join(_ENCODINGS)}')
                self.encoding = _ENCODINGS[name]
            case ["element", name, count]:
                self.element(name, count)
            case ["property", "list", count_type, item_type, name]:
                self.column(Property(name, self.code(item_type), self.count_code(count_type)))
            case ["property", item_type, name]:
                self.column(Property(name, self.code(item_type)))
            case _:
                raise self.fail(f'"{" ".join(words)[:60]}" is no statement of a PLY header')

    def element(self, name: str, count: str) -> None:
        if not (count.isascii() and count.isdigit() and len(count) <= _LONGEST_COUNT):
            raise self.fail(f'the number of rows of "{name[:40]}" is "{count[:40]}"')
        if any(name == table[0] for table in self.tables):
            raise self.fail(f'there are two elements "{name[:40]}"')
        self.tables.append((name, int(count), {}))

    def column(self, column: Property) -> None:
        if not self.tables:
            raise self.fail("a property comes before the first element")
        name, _, columns = self.tables[-1]
        if column.name in columns:
            raise self.fail(f'element "{name[:40]}" has two properties "{column.name[:40]}"')
        columns[column.name] = column

    def code(self, name: str) -> str:
        if name not in _TYPES:
            raise self.fail(f'"{name[:40]}" is no type of a PLY property')
        return _TYPES[name]

    def count_code(self, name: str) -> str:
        code = self.code(name)
        if code[0] == "f":
            raise self.fail(f"the length of a list must be a whole number, but is {name}")
        return code
