"""Reading STL, binary and text: triangles as they are stored, none welded to another.

Stored normals are not kept: they say nothing that the order of the corners does not, and are zero or wrong
in many files.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from isophote.errors import FileError
from isophote.io.ascii import NotANumberError, Positions, is_blank, line_number, numbers, quoted, word_starts
from isophote.io.checks import check_points, no_faces
from isophote.io.files import StrPath
from isophote.shapes.mesh import FaceLabels, Mesh

__all__ = ["read_stl"]

_HEAD = 84  # 80 bytes of text and the number of triangles
_FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
# The words of one facet; None stands for a number.
_WORDS: tuple[bytes | None, ...] = (
    *(b"facet", b"normal", None, None, None),
    *(b"outer", b"loop"),
    *(b"vertex", None, None, None) * 3,
    *(b"endloop", b"endfacet"),
)
# With these letters no number begins, not even "nan" or "inf".
_INITIALS = np.frombuffer(b"feov", np.uint8)
_COORDINATES = [8, 9, 10, 12, 13, 14, 16, 17, 18]


def read_stl(path: StrPath, data: bytes) -> Mesh:
    """A mesh of m triangles with vertices (3m, 3) from the bytes of an STL file; `path` is for messages.

    Text or binary is told by the content, since binary files too may begin with "solid". Solids of a text
    that have a name, or are several, become the labels "group".
    """
    if len(data) >= _HEAD:
        count = int.from_bytes(data[80:_HEAD], "little")
        if len(data) == _HEAD + count * _FACET.itemsize:
            return _read_binary(path, data, count)
    if _is_text(data):
        return _read_text(path, data)
    if len(data) < _HEAD:
        raise FileError(path, f"is no STL file: {len(data)} bytes are too few for a binary one, and it is no text")
    needed = _HEAD + count * _FACET.itemsize
    if needed > len(data):
        reason = f"{count:,} triangles are declared, which take {needed:,} bytes; the file is cut short or no STL"
        raise FileError(path, reason, f"byte {len(data)}")
    return _read_binary(path, data, count)


def _is_text(data: bytes) -> bool:
    head = data[:1024]
    return head.lstrip()[:5].lower() == b"solid" and b"\0" not in head


def _read_binary(path: StrPath, data: bytes, count: int) -> Mesh:
    if count == 0:
        raise no_faces(path, 0)
    facets = np.frombuffer(data, _FACET, count, _HEAD)
    points = facets["corners"].reshape(-1, 3).astype(np.float64)
    check_points(path, points, lambda i: f"triangle {i // 3}, byte {_HEAD + i // 3 * _FACET.itemsize}")
    return Mesh(points, np.arange(len(points)).reshape(-1, 3))


def _read_text(path: StrPath, data: bytes) -> Mesh:
    text = np.frombuffer(data, np.uint8).copy()
    names: list[str] = []
    begins: list[int] = []
    for start, end in _solid_lines(data):
        text[start:end] = 32
        if data[start : start + 1] in b"sS":
            names.append(data[start + 5 : end].strip().decode("utf-8", "replace"))
            begins.append(start)
    starts = word_starts(text)
    count = len(starts) // len(_WORDS)
    _check_words(path, data, text, starts)
    if count == 0:
        raise no_faces(path, 0)
    places = starts.reshape(count, len(_WORDS))
    points = _coordinates(path, data, text, places)
    check_points(path, points, lambda i: f"line {line_number(data, int(places[i // 3, 8 + 4 * (i % 3)]))}")
    labels = {}
    if len(names) > 1 or any(names):
        index = np.searchsorted(np.array(begins), places[:, 0]) - 1
        labels["group"] = FaceLabels(tuple(names), index)
    return Mesh(points, np.arange(3 * count).reshape(-1, 3), labels=labels)


def _solid_lines(data: bytes) -> Iterator[tuple[int, int]]:
    """Where the lines that begin with "solid" or "endsolid" begin and end."""
    lower = data.lower().replace(b"\r", b"\n")
    at = lower.find(b"solid")
    while at >= 0:
        start = at - 3 if lower[max(at - 3, 0) : at] == b"end" else at
        end = lower.find(b"\n", at)
        end = end if end >= 0 else len(data)
        before = lower[max(start - 200, 0) : start].rstrip(b" \t\v\f")
        if (not before or before[-1:] == b"\n") and not data[at + 5 : at + 6].strip():
            yield start, end
        at = lower.find(b"solid", end)


def _check_words(path: StrPath, data: bytes, text: npt.NDArray[np.uint8], starts: Positions) -> None:
    """Refuse a text in which the words of whole facets do not follow each other."""
    padded = np.concatenate([text, np.full(16, 32, np.uint8)])
    first = len(starts)
    for column, word in enumerate(_WORDS):
        places = starts[column :: len(_WORDS)]
        if word is None:
            right = ~np.isin(padded[places] | 0x20, _INITIALS)
        else:
            right = is_blank(padded[places + len(word)])
            for i, letter in enumerate(word):
                right &= padded[places + i] | 0x20 == letter  # in lower case
        if not right.all():
            first = min(first, int(np.argmin(right)) * len(_WORDS) + column)
    if first == len(starts) and first % len(_WORDS) == 0:
        return
    expected = _WORDS[first % len(_WORDS)]
    wanted = f'"{expected.decode()}"' if expected else "a number"
    if first == len(starts):
        where = f"line {line_number(data, len(data))}"
        raise FileError(path, f"the text ends where {wanted} is due; the file is cut short", where)
    place = int(starts[first])
    raise FileError(path, f"{quoted(data, place)} where {wanted} is due", f"line {line_number(data, place)}")


def _coordinates(path: StrPath, data: bytes, text: npt.NDArray[np.uint8], places: Positions) -> npt.NDArray[np.float64]:
    """(3m, 3): the numbers after each "vertex", all other words being blanked out."""
    kept = np.zeros(len(text), np.int8)
    for first in (8, 12, 16):
        kept[places[:, first]] = 1
        kept[places[:, first + 3]] = -1
    only = np.where(np.cumsum(kept, dtype=np.int8) > 0, text, np.uint8(32))
    starts = places[:, _COORDINATES].reshape(-1)
    try:
        values = numbers(only.tobytes(), starts, "float")
    except NotANumberError as error:
        place = int(starts[error.word])
        where = f"line {line_number(data, place)}"
        raise FileError(path, f"{quoted(data, place)} is not a number", where) from error
    return np.asarray(values.reshape(-1, 3), np.float64)
