"""A text of statements, one a line, that begin with a keyword: found and sorted as arrays."""

from __future__ import annotations

import re
from typing import Any, Literal

import attrs
import numpy as np
import numpy.typing as npt

from isophote.errors import FileError
from isophote.io.ascii import (
    NotANumberError,
    Positions,
    blank_comments,
    is_blank,
    line_number,
    numbers,
    quoted,
    word_starts,
)
from isophote.io.files import StrPath

__all__ = ["Rows", "Statements"]

_BOM = b"\xef\xbb\xbf"
_CONTINUATION = re.compile(rb"\\[ \t]*(\r\n|\n|\r)")
_BLANK = np.uint8(32)


@attrs.frozen(eq=False)
class Rows:
    """What stands after the keyword of chosen statements: `text` with `words[i]` words from the `i`-th."""

    lines: Positions
    text: npt.NDArray[np.uint8]
    words: npt.NDArray[np.intp]


@attrs.frozen(eq=False)
class Statements:
    """The lines of a text that are not blank.

    `text` is `data` with comments and line ends after a backslash overwritten by blanks, so that places are
    the same in both. Line `i` has the words `first[i]` to `first[i + 1]`; word `k` begins at `starts[k]`.
    """

    path: StrPath
    data: bytes
    text: npt.NDArray[np.uint8]
    starts: Positions
    first: Positions

    @classmethod
    def of(cls, path: StrPath, data: bytes) -> Statements:
        text = np.frombuffer(data, np.uint8)
        if data.startswith(_BOM):
            text = np.concatenate([np.full(3, _BLANK), text[3:]])
        if b"\n" not in data:
            text = np.where(text == 13, np.uint8(10), text)
        text = blank_comments(text)
        if b"\\" in data:
            text = text.copy()
            for match in _CONTINUATION.finditer(text.tobytes()):
                text[match.start() : match.end()] = _BLANK
        starts = word_starts(text)
        line = np.searchsorted(np.flatnonzero(text == 10), starts)
        first = np.append(np.flatnonzero(np.diff(line, prepend=-1)), len(starts))
        return cls(path, data, text, starts, first)

    def beginning(self, keyword: bytes) -> Positions:
        """The lines whose first word is `keyword`."""
        places = self.starts[self.first[:-1]]
        padded = np.concatenate([self.text, np.full(len(keyword) + 1, _BLANK)])
        found = is_blank(padded[places + len(keyword)])
        for i, letter in enumerate(keyword):
            found &= padded[places + i] == letter
        return np.flatnonzero(found)

    def rest(self, line: int) -> str:
        """What stands after the first word of a line, without the white space around it."""
        words = self.starts[self.first[line] : self.first[line + 1]]
        if len(words) < 2:
            return ""
        end = self.starts[self.first[line + 1]] if self.first[line + 1] < len(self.starts) else len(self.text)
        raw = self.text[words[1] : end].tobytes().strip()
        try:
            return raw.decode()
        except UnicodeDecodeError:
            return raw.decode("latin-1")

    def rows(self, lines: Positions) -> Rows:
        """What stands after the first word of many lines."""
        chosen = np.zeros(len(self.first) - 1, bool)
        chosen[lines] = True
        begins = self.starts[self.first[:-1]]
        spans = np.diff(begins, append=len(self.text))
        at = begins[0] if len(begins) else 0
        kept = np.repeat(chosen, spans)
        places = begins[lines] - at
        kept[places] = False
        # Keywords of numbers have one letter or two; the white space after them stays.
        second = begins[lines] + 1
        second = second[second < len(self.text)]
        kept[second[~is_blank(self.text[second])] - at] = False
        return Rows(lines, self.text[at:][kept], np.diff(self.first)[lines] - 1)

    def place(self, line: int) -> str:
        """The line in words."""
        return f"line {line_number(self.data, int(self.starts[self.first[line]]))}"

    def error(self, line: int, reason: str) -> FileError:
        """An error in this line."""
        return FileError(self.path, reason, self.place(line))

    def numbers(self, rows: Rows, kind: Literal["float", "int"]) -> npt.NDArray[Any]:
        """All numbers of the rows, one after another. Raises `FileError` for a word that is none."""
        text = rows.text.tobytes()
        starts = word_starts(rows.text)
        try:
            return numbers(text, starts, kind)
        except NotANumberError as error:
            row = int(np.searchsorted(np.cumsum(rows.words), error.word, side="right"))
            wanted = "a number" if kind == "float" else "a whole number"
            word = quoted(text, int(starts[error.word]))
            raise self.error(int(rows.lines[row]), f"{word} is not {wanted}") from error
