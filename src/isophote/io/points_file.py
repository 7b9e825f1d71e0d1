"""Points of the plane from text files: x and y a line."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import numpy.typing as npt

from isophote.errors import FileError
from isophote.io.files import StrPath
from isophote.io.source import read_source

__all__ = ["read_points"]

_GAPS = re.compile(r"[,;\s]+")


def read_points(path: StrPath) -> npt.NDArray[np.float64]:
    """(n, 2) float64: the first two numbers of each line, parted by commas, semicolons or blanks.

    Empty lines, lines that begin with #, and a first line of names are passed over. Raises `FileError` for other lines,
    with their number, and for numbers that are not finite.
    """
    try:
        text = read_source(Path(path)).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise FileError(path, "is no text; it needs x, y a line") from error
    rows: list[tuple[float, float]] = []
    for number, line in enumerate(text.splitlines(), 1):
        words = _GAPS.split(line.strip())
        if words == [""] or words[0].startswith("#"):
            continue
        try:
            rows.append((float(words[0]), float(words[1])))
        except (ValueError, IndexError):
            if number == 1 and not _is_number(words[0]):
                continue
            raise FileError(path, f"needs two numbers, x and y, but is {line[:60]!r}", f"line {number}") from None
        if not np.isfinite(rows[-1]).all():
            raise FileError(path, f"has a number that is not finite: {line[:60]!r}", f"line {number}")
    return np.array(rows, np.float64).reshape(-1, 2)


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True
