"""Reading Wavefront OBJ: polygons, corners with texture coordinates and normals, materials and groups.

Source: Wavefront, Advanced Visualizer manual, appendix B1. Curves, surfaces, lines, points, smoothing groups
and whatever else is no part of a polygon mesh are passed over.
"""

from __future__ import annotations

from typing import Any

import attrs
import numpy as np
import numpy.typing as npt

from isophote.io.ascii import NotANumberError, numbers, quoted, word_starts
from isophote.io.checks import check_faces, check_points, no_faces
from isophote.io.files import StrPath
from isophote.io.statements import Rows, Statements
from isophote.io.vertex_colour import from_display
from isophote.shapes.mesh import Attribute, FaceLabels, Mesh

__all__ = ["ObjFile", "parse_obj", "read_obj"]

Integers = npt.NDArray[np.int64]

_SLASH = 47
_NAMES = ("vertex", "texture coordinate", "normal")


@attrs.frozen
class ObjFile:
    """A mesh, and the text after each "mtllib": names of material files beside it."""

    mesh: Mesh
    libraries: tuple[str, ...]


def read_obj(path: StrPath, data: bytes) -> Mesh:
    """A mesh from the bytes of an OBJ file; see `parse_obj`."""
    return parse_obj(path, data).mesh


def parse_obj(path: StrPath, data: bytes) -> ObjFile:
    """A mesh and the names of its material files from the bytes of an OBJ file; `path` is for messages.

    "vt" becomes the attribute "uv" (k, 2), "vn" "normal" (k, 3), both at the corners, or at the vertices where
    the numbers are everywhere the same; numbers after the coordinates of "v" become "colour", read as
    sRGB-coded, 0 to 1. "usemtl" becomes the labels "material", "g" and "o", whichever came last, "group".
    """
    statements = Statements.of(path, data)
    vertices = statements.beginning(b"v")
    faces = statements.beginning(b"f")
    if len(faces) == 0:
        raise no_faces(path, len(vertices))
    points, colour = _vertices(statements, vertices)
    check_points(path, points, lambda i: statements.place(int(vertices[i])))
    tables = [vertices, statements.beginning(b"vt"), statements.beginning(b"vn")]
    rows = statements.rows(faces)
    offsets = np.concatenate([np.zeros(1, np.int64), np.cumsum(rows.words)])
    check_faces(path, len(points), np.zeros(0, np.int64), offsets, lambda i: statements.place(int(faces[i])))
    corners = _corners(statements, rows)
    index = [_resolved(statements, rows, corners[k], tables[k], k) for k in range(3)]
    uv = _values(statements, tables[1], 2, index[1], 1)
    normal = _values(statements, tables[2], 3, index[2], 3)
    found = {
        "normal": _attribute(normal, index[2], index[0], len(points)),
        "uv": _attribute(uv, index[1], index[0], len(points)),
        "colour": _colour(colour, index[0], len(points)),
    }
    material = _labels(statements, statements.beginning(b"usemtl"), faces)
    groups = np.sort(np.concatenate([statements.beginning(b"g"), statements.beginning(b"o")]))
    labels = {"material": material, "group": _labels(statements, groups, faces)}
    mesh = Mesh.from_polygons(
        points,
        index[0].astype(np.int32),
        offsets,
        attributes={name: a for name, a in found.items() if a is not None},
        labels={name: label for name, label in labels.items() if label is not None},
    )
    libraries = (statements.rest(int(line)) for line in statements.beginning(b"mtllib"))
    return ObjFile(mesh, tuple(name for name in libraries if name))


def _vertices(
    statements: Statements, lines: npt.NDArray[np.intp]
) -> tuple[npt.NDArray[np.float64], dict[int, npt.NDArray[Any]]]:
    """Positions, and for 3 and 4 channels the vertices that have such a colour and the colours themselves."""
    rows = statements.rows(lines)
    values = _padded(statements, rows, 3, 7)
    colours: dict[int, npt.NDArray[Any]] = {}
    if values.shape[1] > 4:
        colours = {3: np.flatnonzero(rows.words == 6), 4: np.flatnonzero(rows.words == 7)}
    return np.ascontiguousarray(values[:, :3]), {
        channels: np.column_stack([at, values[at, 3 : 3 + channels]]) for channels, at in colours.items() if len(at)
    }


def _padded(statements: Statements, rows: Rows, least: int, most: int) -> npt.NDArray[np.float64]:
    """(rows, widest) numbers, 0 where a row has fewer; no row may have fewer than `least`."""
    if len(rows.words) and rows.words.min() < least:
        line = int(rows.lines[int(np.argmax(rows.words < least))])
        raise statements.error(line, f"{least} numbers are due, but there are {int(rows.words.min())}")
    values = statements.numbers(rows, "float")
    widest = min(int(rows.words.max(initial=least)), most)
    if (rows.words == widest).all():
        return np.asarray(values.reshape(-1, widest), np.float64)
    begins = np.cumsum(rows.words) - rows.words
    padded = np.zeros((len(rows.words), widest))
    for column in range(widest):
        has = rows.words > column
        padded[has, column] = values[begins[has] + column]
    return padded


def _corners(statements: Statements, rows: Rows) -> tuple[Integers, Integers, Integers]:
    """The three numbers of each corner as they stand in the file, 0 where there is none."""
    slash = rows.text == _SLASH
    count = int(rows.words.sum())
    none = np.zeros(count, np.int64)
    if not slash.any():
        return statements.numbers(rows, "int"), none, none
    words = word_starts(rows.text)
    apart = np.where(slash, np.uint8(32), rows.text)
    starts = word_starts(apart)
    word = np.searchsorted(words, starts, side="right") - 1
    before = np.cumsum(slash, dtype=np.int32) - slash
    slot = before[starts] - before[words[word]]
    try:
        values = numbers(apart.tobytes(), starts, "int")
    except NotANumberError as error:
        raise _corner_error(statements, rows, words, int(word[error.word])) from error
    if slot.max(initial=0) > 2:
        raise _corner_error(statements, rows, words, int(word[int(np.argmax(slot > 2))]))
    corners = np.zeros((3, count), np.int64)
    corners[slot, word] = values
    return corners[0], corners[1], corners[2]


def _corner_error(statements: Statements, rows: Rows, words: npt.NDArray[np.intp], word: int) -> Exception:
    row = int(np.searchsorted(np.cumsum(rows.words), word, side="right"))
    text = quoted(rows.text.tobytes(), int(words[word]))
    return statements.error(int(rows.lines[row]), f"{text} is not a corner: v, v/vt, v//vn or v/vt/vn, whole numbers")


def _resolved(statements: Statements, rows: Rows, given: Integers, table: npt.NDArray[np.intp], kind: int) -> Integers:
    """Numbers counted from 0, -1 where there is none: n is the n-th of the file, -n the n-th before the face."""
    index = np.where(given > 0, given - 1, -1)
    if (given < 0).any():
        before = np.repeat(np.searchsorted(table, rows.lines), rows.words)
        index = np.where(given < 0, before + given, index)
    wrong = (index >= len(table)) | ((index < 0) & ((given != 0) | (kind == 0)))
    if wrong.any():
        corner = int(np.argmax(wrong))
        face = int(np.searchsorted(np.cumsum(rows.words), corner, side="right"))
        reason = f"face {face} names {_NAMES[kind]} {int(given[corner])}, but the file has {len(table):,}"
        raise statements.error(int(rows.lines[face]), f"{reason}, counted from 1 (or from -1 back)")
    return np.asarray(index, np.int64)


def _values(
    statements: Statements, lines: npt.NDArray[np.intp], width: int, index: Integers, least: int
) -> npt.NDArray[np.float64] | None:
    """The first `width` numbers of each line, if a corner uses any of them."""
    if (index < 0).all():
        return None
    values = _padded(statements, statements.rows(lines), least, width)[:, :width]
    return np.pad(values, ((0, 0), (0, width - values.shape[1])))


def _attribute(
    values: npt.NDArray[np.float64] | None, index: Integers, vertex: Integers, count: int
) -> Attribute | None:
    if values is None:
        return None
    same = len(values) == count and np.array_equal(index, vertex)
    return Attribute(values) if same else Attribute(values, index)


def _colour(coloured: dict[int, npt.NDArray[Any]], vertex: Integers, count: int) -> Attribute | None:
    """One colour for each vertex, or, where some vertices have none, for each corner that has; alpha 1 if absent."""
    if not coloured:
        return None
    width = 1 + max(coloured)
    padded = [np.pad(rows, ((0, 0), (0, width - rows.shape[1])), constant_values=1) for rows in coloured.values()]
    rows = np.concatenate(padded)
    row = np.full(count, -1)
    row[rows[:, 0].astype(np.int64)] = np.arange(len(rows))
    linear = from_display(rows[:, 1:])
    return Attribute(linear[row]) if len(rows) == count else Attribute(linear, row[vertex])


def _labels(statements: Statements, lines: npt.NDArray[np.intp], faces: npt.NDArray[np.intp]) -> FaceLabels | None:
    """For each face the name in the last of `lines` before it; a line without a name ends the name before."""
    names = [statements.rest(int(line)) for line in lines]
    numbered: dict[str, int] = {}
    number = np.array([-1, *(numbered.setdefault(name, len(numbered)) if name else -1 for name in names)])
    index = number[np.searchsorted(lines, faces)]
    used = np.unique(index[index >= 0])
    if len(used) == 0:
        return None
    known = list(numbered)
    index = np.where(index >= 0, np.searchsorted(used, index), -1)
    return FaceLabels(tuple(known[i] for i in used), index)
