"""Numbers in text, as arrays: words found and converted without a Python loop over lines.

Text stays bytes and keeps its length while it is cleaned (comments are overwritten by blanks), so that a
position in the cleaned text is the position in the file, and its line number can be told.
"""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
import numpy.typing as npt

__all__ = [
    "NotANumberError",
    "Positions",
    "blank_comments",
    "is_blank",
    "line_number",
    "numbers",
    "quoted",
    "word_starts",
]

Bytes = npt.NDArray[np.uint8]
Positions = npt.NDArray[np.intp]

_NEWLINE, _BLANK, _HASH = 10, 32, 35

_BLANKS = np.zeros(256, bool)
_BLANKS[np.frombuffer(b" \t\n\v\f\r", np.uint8)] = True


class NotANumberError(ValueError):
    """Word number `word` of a text is not a number."""

    def __init__(self, word: int) -> None:
        self.word = word
        super().__init__(f"word {word} is not a number")


def is_blank(text: Bytes) -> npt.NDArray[np.bool_]:
    """Which bytes are white space: blank, tab, line feed, vertical tab, form feed, carriage return."""
    blank: npt.NDArray[np.bool_] = _BLANKS[text]
    return blank


def word_starts(text: Bytes) -> Positions:
    """Where each run of bytes that are not white space begins."""
    solid = ~is_blank(text)
    solid[1:] &= ~solid[:-1]
    return np.flatnonzero(solid)


def blank_comments(text: Bytes) -> Bytes:
    """`text` with everything from a "#" that begins a word to the end of its line overwritten by blanks."""
    marks = np.flatnonzero(text == _HASH)
    if len(marks) == 0:
        return text
    marks = marks[(marks == 0) | _BLANKS[text[marks - 1]]]
    ends = np.append(np.flatnonzero(text == _NEWLINE), len(text))
    depth = np.zeros(len(text) + 1, np.int32)
    np.add.at(depth, marks, 1)
    np.subtract.at(depth, ends[np.searchsorted(ends, marks)], 1)
    return np.where(np.cumsum(depth[:-1]) > 0, np.uint8(_BLANK), text)


def numbers(text: bytes, starts: Positions, kind: Literal["float", "int"]) -> npt.NDArray[Any]:
    """The words of `text`, which begin at `starts`, as float64 or int64.

    A float is the double nearest to the decimal text, as `float()` gives it. Raises `NotANumberError` for the
    first word that is none.
    """
    dtype = np.float64 if kind == "float" else np.int64
    values = _parse(text, len(starts), dtype)
    if values is None:
        raise NotANumberError(_first_bad(text, starts, dtype))
    return values


def _parse(text: bytes, count: int, dtype: type[Any]) -> npt.NDArray[Any] | None:
    if count == 0:
        return np.zeros(0, dtype)
    # At a word that is no number NumPy before 2.4 stops with a mere warning, and where that is the end of
    # the last word nothing would be missing; the 0 after it then is.
    try:
        values = np.fromstring(text + b" 0", dtype, sep=" ")
    except (ValueError, DeprecationWarning):
        return None
    return values[:-1] if len(values) == count + 1 else None


def _first_bad(text: bytes, starts: Positions, dtype: type[Any]) -> int:
    """The first word that does not parse, by halving: all words before `low` parse, one before `high` does not."""
    low, high = 0, len(starts)
    while high - low > 1:
        middle = (low + high) // 2
        if _parse(text[int(starts[low]) : int(starts[middle])], middle - low, dtype) is None:
            high = middle
        else:
            low = middle
    return low


def line_number(data: bytes, position: int) -> int:
    """The line, counted from 1, in which byte `position` lies."""
    newline = b"\n" if b"\n" in data else b"\r"
    return data.count(newline, 0, position) + 1


def quoted(data: bytes, start: int) -> str:
    """The word at `start` for an error message: in quotes, cut where it is long."""
    word = data[start : start + 200].split(None, 1)
    text = (word[0] if word else b"").decode("utf-8", "replace")
    text = "".join(c if c.isprintable() else "?" for c in text)
    return f'"{text[:40]}…"' if len(text) > 40 else f'"{text}"'
