"""The tables of a PLY file: columns and lists of any layout, from text and from both byte orders."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from os import fspath
from typing import Any, Protocol

import attrs
import numpy as np
import numpy.typing as npt

from isophote.errors import FileError, IsophoteWarning
from isophote.io.ascii import NotANumberError, Positions, line_number, numbers, quoted, word_starts
from isophote.io.files import StrPath
from isophote.io.ply_header import Element, Header, Property

__all__ = ["Lists", "Table", "read_tables"]

Array = npt.NDArray[Any]

_LONGEST_LIST = 2.0**53  # beyond any file, and still a whole number in a double


@attrs.frozen(eq=False)
class Lists:
    """A column of lists: row `i` has `values[offsets[i]:offsets[i + 1]]`."""

    values: Array
    offsets: npt.NDArray[np.int64]


@attrs.frozen(eq=False)
class Table:
    """An element that was read: columns by name, and where each row lies in the file, for messages.

    Values from a text are float64 or int64, whatever the header declares.
    """

    element: Element
    columns: Mapping[str, Array | Lists]
    rows: Positions | range
    cells: Cells

    @property
    def count(self) -> int:
        return self.element.count

    def place(self, row: int) -> str:
        """Where row `row` is in the file."""
        return self.cells.place(int(self.rows[row]))


class Cells(Protocol):
    """A run of stored values. Positions count bytes in a binary file and words in a text."""

    path: StrPath
    size: int

    def width(self, code: str) -> int:
        """How far a value of this type reaches."""
        ...

    def one(self, position: int, code: str) -> float:
        """The value at one position."""
        ...

    def grid(self, start: int, stride: int, rows: int, width: int, code: str) -> Array:
        """(rows, width): `width` values in a row, at `start` and every `stride` after it."""
        ...

    def gather(self, positions: Positions, code: str) -> Array:
        """The values at many positions."""
        ...

    def place(self, position: int) -> str:
        """The position in words."""
        ...

    def ended(self, element: str, row: int) -> FileError:
        """The error that the data end within a row."""
        ...


class _Binary:
    def __init__(self, path: StrPath, data: bytes, start: int, order: str) -> None:
        self.path, self.order, self.start = path, order, start
        self.bytes = np.frombuffer(data, np.uint8)[start:]
        self.size = len(self.bytes)

    def width(self, code: str) -> int:
        return int(code[1])

    def one(self, position: int, code: str) -> float:
        raw = self.bytes[position : position + int(code[1])]
        value: float = raw.view(self.order + code)[0].item()
        return value

    def grid(self, start: int, stride: int, rows: int, width: int, code: str) -> Array:
        dtype = np.dtype(self.order + code)
        if rows == 0 or width == 0:
            return np.zeros((rows, width), code)
        view: Array = np.ndarray((rows, width), dtype, self.bytes, start, (stride, dtype.itemsize))
        return view.astype(code)

    def gather(self, positions: Positions, code: str) -> Array:
        raw = self.bytes[positions[:, None] + np.arange(int(code[1]))]
        values: Array = raw.view(self.order + code)[:, 0].astype(code)
        return values

    def place(self, position: int) -> str:
        return f"byte {self.start + position}"

    def ended(self, element: str, row: int) -> FileError:
        where = f"byte {self.start + self.size}"
        return FileError(self.path, f'the data end within row {row} of "{element}"; the file is cut short', where)


class _Text:
    """Words that are numbers; after the last one that is, the run ends, and `ended` says why."""

    def __init__(self, path: StrPath, data: bytes, starts: Positions, whole: bool) -> None:
        self.path, self.data, self.starts = path, data, starts
        self.values = self._parse("int" if whole else "float")
        if whole and len(self.values) < len(starts):
            self.values = self._parse("float")
        self.size = len(self.values)

    def _parse(self, kind: Any) -> Array:
        starts, count = self.starts, len(self.starts)
        if count == 0:
            return np.zeros(0)
        first = int(starts[0])
        try:
            return numbers(self.data[first:], starts - first, kind)
        except NotANumberError as error:
            count = error.word
        end = int(starts[count])
        return numbers(self.data[first:end], starts[:count] - first, kind)

    def width(self, code: str) -> int:
        return 1

    def one(self, position: int, code: str) -> float:
        value: float = self.values[position].item()
        return value

    def grid(self, start: int, stride: int, rows: int, width: int, code: str) -> Array:
        if rows == 0 or width == 0:
            return np.zeros((rows, width), self.values.dtype)
        size = self.values.itemsize
        return np.ndarray((rows, width), self.values.dtype, self.values, start * size, (stride * size, size))

    def gather(self, positions: Positions, code: str) -> Array:
        return self.values[positions]

    def place(self, position: int) -> str:
        return f"line {line_number(self.data, int(self.starts[position]))}"

    def ended(self, element: str, row: int) -> FileError:
        if self.size < len(self.starts):
            word = quoted(self.data, int(self.starts[self.size]))
            return FileError(self.path, f'{word} in row {row} of "{element}" is not a number', self.place(self.size))
        where = f"line {line_number(self.data, len(self.data))}"
        return FileError(self.path, f'the text ends within row {row} of "{element}"; the file is cut short', where)


def read_tables(path: StrPath, header: Header, data: bytes) -> dict[str, Table]:
    """Every element by its name. Nothing is allocated before the bytes for it are known to be there."""
    if header.encoding == "ascii":
        return _read_text(path, header, data)
    cells = _Binary(path, data, header.size, "<" if header.encoding == "little" else ">")
    tables, position = {}, 0
    for element in header.elements:
        tables[element.name], position = _read_table(element, cells, position)
    return tables


def _read_text(path: StrPath, header: Header, data: bytes) -> dict[str, Table]:
    """Each row stands on a line of its own, as it should, or, where that fails, the words follow each other."""
    text = np.frombuffer(data, np.uint8)[header.size :]
    starts = word_starts(text) + header.size
    newline = 10 if b"\n" in data else 13
    line = np.searchsorted(np.flatnonzero(text == newline) + header.size, starts)
    lines = np.append(np.flatnonzero(np.diff(line, prepend=-1)), len(starts))
    if sum(element.count for element in header.elements if element.properties) >= len(lines):
        return _read_stream(path, header, data, starts)
    try:
        return _read_lines(path, header, data, starts, lines)
    except FileError as error:
        try:
            return _read_stream(path, header, data, starts)
        except FileError:
            raise error from None


def _read_lines(path: StrPath, header: Header, data: bytes, starts: Positions, lines: Positions) -> dict[str, Table]:
    """`lines` are the numbers of the words that begin a line, and of the one after the last."""
    tables: dict[str, Table] = {}
    line = 0
    for element in header.elements:
        if element.count == 0 or not element.properties:
            tables[element.name] = _empty(element, _Text(path, data, starts[:0], True))
            continue
        rows = lines[line : line + element.count + 1]
        line += element.count
        words = starts[rows[0] : rows[-1]]
        end = int(starts[rows[-1]]) if rows[-1] < len(starts) else len(data)
        cells = _Text(path, data[:end], words, not element.has_floats)
        rows = rows - rows[0]
        tables[element.name] = _read_rows(element, cells, rows[:-1], rows[1:])
    return tables


def _read_stream(path: StrPath, header: Header, data: bytes, starts: Positions) -> dict[str, Table]:
    tables: dict[str, Table] = {}
    first = 0
    for number, element in enumerate(header.elements):
        if element.has_lists:
            # How far lists reach shows only when they are read: this and all that follows is one run.
            rest = header.elements[number:]
            cells = _Text(path, data, starts[first:], not any(e.has_floats for e in rest))
            position = 0
            for other in rest:
                tables[other.name], position = _read_table(other, cells, position)
            return tables
        last = min(first + element.count * len(element.properties), len(starts))
        end = int(starts[last]) if last < len(starts) else len(data)
        cells = _Text(path, data[:end], starts[first:last], not element.has_floats)
        tables[element.name], _ = _read_table(element, cells, 0)
        first = last
    return tables


def _empty(element: Element, cells: Cells) -> Table:
    return Table(element, {p.name: _nothing(p, element.count) for p in element.properties}, range(0), cells)


def _read_table(element: Element, cells: Cells, start: int) -> tuple[Table, int]:
    """The rows that begin at `start`, and where the next element does."""
    if element.count == 0 or not element.properties:
        return _empty(element, cells), start
    lengths = _first_lengths(element, cells, start)
    stride = _row_width(element, cells, lengths)
    if element.count <= (cells.size - start) // stride:
        read = _read_equal_rows(element, cells, start, stride, lengths)
        if read is not None:
            rows = range(start, start + stride * element.count, stride)
            return Table(element, read, rows, cells), start + stride * element.count
    elif not element.has_lists:
        raise cells.ended(element.name, (cells.size - start) // stride)
    places = _walk(element, cells, start)
    return _read_rows(element, cells, places[:-1], places[1:]), int(places[-1])


def _nothing(column: Property, count: int) -> Array | Lists:
    return Lists(np.zeros(0, column.type), np.zeros(count + 1, np.int64)) if column.count_type else np.zeros(count)


def _length(element: Element, cells: Cells, row: int, position: int, code: str) -> int:
    """The length of the list at `position`, whose values must lie within the data."""
    after = position + cells.width(code)
    if after > cells.size:
        raise cells.ended(element.name, row)
    value = cells.one(position, code)
    if not (0 <= value < _LONGEST_LIST and value == int(value)):
        reason = f'the length of a list in row {row} of "{element.name}" is {value}'
        raise FileError(cells.path, reason, cells.place(position))
    return int(value)


def _first_lengths(element: Element, cells: Cells, start: int) -> list[int]:
    """How long each list of the first row is."""
    lengths, position = [], start
    for p in element.properties:
        length = 1
        if p.count_type:
            length = _length(element, cells, 0, position, p.count_type)
            lengths.append(length)
            position += cells.width(p.count_type)
        position += length * cells.width(p.type)
    return lengths


def _row_width(element: Element, cells: Cells, lengths: list[int]) -> int:
    left = iter(lengths)
    width = 0
    for p in element.properties:
        width += cells.width(p.type) * (next(left) if p.count_type else 1)
        width += cells.width(p.count_type) if p.count_type else 0
    return width


def _read_equal_rows(
    element: Element, cells: Cells, start: int, stride: int, lengths: list[int]
) -> dict[str, Array | Lists] | None:
    """The columns, if all rows have lists as long as the first row's; else None."""
    columns: dict[str, Array | Lists] = {}
    count, position, left = element.count, start, iter(lengths)
    for p in element.properties:
        if p.count_type is None:
            columns[p.name] = cells.grid(position, stride, count, 1, p.type)[:, 0]
            position += cells.width(p.type)
            continue
        length = next(left)
        if (cells.grid(position, stride, count, 1, p.count_type) != length).any():
            return None
        position += cells.width(p.count_type)
        values = cells.grid(position, stride, count, length, p.type).reshape(-1)
        columns[p.name] = Lists(values, np.arange(count + 1, dtype=np.int64) * length)
        position += length * cells.width(p.type)
    return columns


def _walk(element: Element, cells: Cells, start: int) -> Positions:
    """Where each row begins, found by the lengths of its lists, and where the last one ends."""
    rows = [start]
    position = start
    for row in range(element.count):
        for p in element.properties:
            if p.count_type:
                length = _length(element, cells, row, position, p.count_type)
                position += cells.width(p.count_type) + length * cells.width(p.type)
            else:
                position += cells.width(p.type)
        if position > cells.size:
            raise cells.ended(element.name, row)
        rows.append(position)
    return np.array(rows, np.intp)


def _read_rows(element: Element, cells: Cells, rows: Positions, ends: Positions) -> Table:
    """The columns of rows whose places are known; words beyond a row's columns are left out, with a warning."""
    columns: dict[str, Array | Lists] = {}
    position = rows
    for p in element.properties:
        _check_within(element, cells, rows, position + cells.width(p.count_type or p.type), ends)
        if p.count_type is None:
            columns[p.name] = cells.gather(position, p.type)
            position = position + cells.width(p.type)
            continue
        given = cells.gather(position, p.count_type)
        position = position + cells.width(p.count_type)
        room = (ends - position) // cells.width(p.type)
        fits = (given >= 0) & (given <= room) & (given == np.floor(given))
        if not fits.all():
            bad = int(np.argmin(fits))
            reason = (
                f'"{p.name[:40]}" in row {bad} of "{element.name}" is a list of {given[bad]}, but {room[bad]} follow'
            )
            raise FileError(cells.path, reason, cells.place(int(rows[bad])))
        sizes = given.astype(np.int64)
        _check_within(element, cells, rows, position + sizes * cells.width(p.type), ends)
        offsets = np.concatenate([np.zeros(1, np.int64), np.cumsum(sizes)])
        within = np.arange(offsets[-1]) - np.repeat(offsets[:-1], sizes)
        places = np.repeat(position, sizes) + within * cells.width(p.type)
        columns[p.name] = Lists(cells.gather(places, p.type), offsets)
        position = position + sizes * cells.width(p.type)
    if (position != ends).any():
        first = int(np.argmax(position != ends))
        warnings.warn(
            f'{fspath(cells.path)}, {cells.place(int(rows[first]))}: row {first} of "{element.name}" holds more than '
            "the header declares; what is left over is not read",
            IsophoteWarning,
            stacklevel=6,
        )
    return Table(element, columns, rows, cells)


def _check_within(element: Element, cells: Cells, rows: Positions, after: Positions, ends: Positions) -> None:
    over = (after > ends) | (after > cells.size)
    if over.any():
        if (after > cells.size).any():
            raise cells.ended(element.name, int(np.searchsorted(rows, cells.size, side="right")) - 1)
        bad = int(np.argmax(over))
        reason = f'row {bad} of "{element.name}" is shorter than the header declares; the file is damaged'
        raise FileError(cells.path, reason, cells.place(int(rows[bad])))
