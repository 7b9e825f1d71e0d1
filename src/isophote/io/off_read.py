"""Reading OFF, with colours, normals and texture coordinates at the vertices and colours of the faces.

Source: Geomview 1.9 manual, section 4.2.5.
"""

from __future__ import annotations

import re
from typing import Any

import attrs
import numpy as np
import numpy.typing as npt

from isophote.errors import FileError
from isophote.io.ascii import NotANumberError, Positions, numbers, quoted
from isophote.io.checks import check_faces, check_points, no_faces
from isophote.io.files import StrPath
from isophote.io.statements import Statements
from isophote.io.vertex_colour import from_display
from isophote.shapes.mesh import Attribute, Mesh

__all__ = ["FACE_COLOUR", "read_off"]

Array = npt.NDArray[Any]

FACE_COLOUR = "face_colour"
_KIND = re.compile(rb"(ST)?(C)?(N)?(4)?(n)?OFF", re.IGNORECASE)
_LONGEST_COUNT = 18


@attrs.frozen
class _Head:
    """What the rows hold: `width` numbers without a colour; the first row begins at word `first`."""

    texture: bool
    colour: bool
    normal: bool
    vertices: int
    faces: int
    first: int

    @property
    def width(self) -> int:
        return 3 + 3 * self.normal + 2 * self.texture


def read_off(path: StrPath, data: bytes) -> Mesh:
    """A mesh from the bytes of an OFF file (also COFF, NOFF, STOFF and their mixtures); `path` is for messages.

    Colours, integers from 0 to 255 or numbers from 0 to 1, both sRGB-coded, become the attribute "colour"; those
    of faces too, or "face_colour" where the vertices have colours. Refused: binary OFF, four and n dimensions.
    """
    return _Reader(Statements.of(path, data)).mesh()


class _Reader:
    def __init__(self, statements: Statements) -> None:
        self.path = statements.path
        self.lines = statements
        self.starts = statements.starts

    def place(self, word: int) -> str:
        line = int(np.searchsorted(self.lines.first, word, side="right")) - 1
        return self.lines.place(min(max(line, 0), len(self.lines.first) - 2))

    def fail(self, word: int, reason: str) -> FileError:
        return FileError(self.path, reason, self.place(word))

    def word(self, number: int) -> bytes:
        if number >= len(self.starts):
            raise FileError(self.path, "the text ends within its first lines; the file is cut short or no OFF")
        start = int(self.starts[number])
        return self.lines.text[start : start + 40].tobytes().split(None, 1)[0]

    def head(self) -> _Head:
        first = self.word(0)
        kind = _KIND.fullmatch(first)
        if kind is None and not first.isdigit():
            shown = quoted(self.lines.data, int(self.starts[0]))
            raise self.fail(0, f'is no OFF file: it begins with {shown}, not with "OFF" or the number of vertices')
        if kind and (kind[4] or kind[5]):
            raise self.fail(0, f"{first.decode()} has other than three dimensions, which is not read")
        if kind and self.word(1).upper() == b"BINARY":
            raise self.fail(0, "binary OFF is not read; export it as text")
        at = 1 if kind else 0
        counts = []
        for number in (at, at + 1):
            word = self.word(number)
            if not (word.isdigit() and len(word) <= _LONGEST_COUNT):
                shown = quoted(self.lines.data, int(self.starts[number]))
                raise self.fail(number, f"{shown} where a number of vertices or faces is due")
            counts.append(int(word))
        # The number of edges, which nobody uses, is left out by some programs.
        line_end = int(self.lines.first[np.searchsorted(self.lines.first, at, side="right")])
        texture, colour, normal = (bool(kind and kind[k]) for k in (1, 2, 3))
        return _Head(texture, colour, normal, counts[0], counts[1], at + 2 if line_end == at + 2 else at + 3)

    def mesh(self) -> Mesh:
        head = self.head()
        if head.faces == 0:
            raise no_faces(self.path, head.vertices)
        left = len(self.starts) - head.first
        needed = head.vertices * head.width + head.faces
        if needed > left:
            declared = f"{head.vertices:,} vertices and {head.faces:,} faces are declared"
            raise self.fail(len(self.starts), f"{declared}, but only {left:,} numbers follow; the file is cut short")
        vertex, face = self.rows(head)
        values = self.numbers(int(vertex[0]), int(vertex[-1])).reshape(head.vertices, -1)
        check_points(self.path, values[:, :3], lambda i: self.place(int(vertex[i])))
        indices, offsets, sizes = self.corners(face)
        check_faces(self.path, head.vertices, indices, offsets, lambda i: self.place(int(face[i])))
        attributes = self.vertex_attributes(head, values, vertex)
        colour = self.face_colour(face, sizes)
        if colour is not None:
            attributes[FACE_COLOUR if "colour" in attributes else "colour"] = colour
        return Mesh.from_polygons(values[:, :3], indices.astype(np.int32), offsets, attributes=attributes)

    def rows(self, head: _Head) -> tuple[Positions, Positions]:
        """The words that begin the rows of vertices and of faces, each with the word after the last row."""
        first = self.lines.first
        line = int(np.searchsorted(first, head.first))
        if first[line] == head.first and len(first) - 1 - line >= head.vertices + head.faces:
            vertex = first[line : line + head.vertices + 1]
            widths = np.diff(vertex)
            if head.vertices == 0 or widths.min() == widths.max() >= head.width:
                return vertex, first[line + head.vertices : line + head.vertices + head.faces + 1]
        # Words that follow each other without regard to lines.
        width = head.width + 4 * head.colour
        vertex = head.first + np.arange(head.vertices + 1) * width
        if vertex[-1] > len(self.starts):
            raise self.fail(len(self.starts), "the text ends within the vertices; the file is cut short")
        return vertex, self.walk(int(vertex[-1]), head.faces)

    def walk(self, start: int, faces: int) -> Positions:
        sizes = self.numbers(start, len(self.starts)).tolist()
        rows, position = [0], 0
        for face in range(faces):
            if position >= len(sizes) or not 0 <= sizes[position] <= len(sizes) - position - 1:
                raise self.fail(start + position, f"the corners of face {face} are not all there")
            position += 1 + int(sizes[position])
            rows.append(position)
        return start + np.array(rows, np.intp)

    def numbers(self, first: int, last: int) -> Array:
        """Words `first` to `last` as float64."""
        if first >= last:
            return np.zeros(0)
        begin = int(self.starts[first])
        end = int(self.starts[last]) if last < len(self.starts) else len(self.lines.text)
        try:
            return numbers(self.lines.text[begin:end].tobytes(), self.starts[first:last] - begin, "float")
        except NotANumberError as error:
            word = first + error.word
            raise self.fail(word, f"{quoted(self.lines.data, int(self.starts[word]))} is not a number") from error

    def corners(self, face: Positions) -> tuple[Array, Array, Array]:
        values = self.numbers(int(face[0]), int(face[-1]))
        begins = face[:-1] - face[0]
        sizes = values[begins]
        room = np.diff(face) - 1
        wrong = ~((sizes >= 0) & (sizes <= room) & (sizes == np.floor(sizes)))
        if wrong.any():
            bad = int(np.argmax(wrong))
            reason = f"face {bad} declares {sizes[bad]:g} corners, but {int(room[bad])} numbers follow"
            raise self.fail(int(face[bad]), reason)
        sizes = sizes.astype(np.int64)
        offsets = np.concatenate([np.zeros(1, np.int64), np.cumsum(sizes)])
        within = np.arange(offsets[-1]) - np.repeat(offsets[:-1], sizes)
        given = values[np.repeat(begins + 1, sizes) + within]
        wrong = ~((np.abs(given) < 2.0**53) & (given == np.floor(given)))
        if wrong.any():
            bad = int(np.searchsorted(offsets, int(np.argmax(wrong)), side="right")) - 1
            raise self.fail(
                int(face[bad]), f"face {bad} names vertex {given[np.argmax(wrong)]}, which is no whole number"
            )
        return given.astype(np.int64), offsets, sizes

    def vertex_attributes(self, head: _Head, values: Array, vertex: Positions) -> dict[str, Attribute]:
        """In the order of the file: position, normal, colour, texture coordinates."""
        attributes: dict[str, Attribute] = {}
        at = 3
        if head.normal:
            attributes["normal"] = Attribute(values[:, 3:6].copy())
            at = 6
        extra = values.shape[1] - head.width
        if extra in (3, 4):
            words = (vertex[:-1, None] + at + np.arange(extra)).reshape(-1)
            attributes["colour"] = Attribute(self.colours(values[:, at : at + extra], words))
            at += extra
        elif extra:
            reason = (
                f"the rows of vertices hold {values.shape[1]} numbers; {head.width}, and 3 or 4 of a colour, are read"
            )
            raise self.fail(int(vertex[0]), reason)
        if head.texture:
            attributes["uv"] = Attribute(values[:, at : at + 2].copy())
        return attributes

    def face_colour(self, face: Positions, sizes: Array) -> Attribute | None:
        """Colours after the corners: three or four numbers; one, the place in a colour map, is passed over."""
        extra = np.diff(face) - 1 - sizes
        coloured = np.flatnonzero((extra == 3) | (extra == 4))
        if len(coloured) == 0:
            return None
        channels = int(extra[coloured].max())
        values = self.numbers(int(face[0]), int(face[-1]))
        begins = face[coloured] + 1 + sizes[coloured]
        places = begins[:, None] + np.arange(channels)
        has = np.arange(channels) < extra[coloured][:, None]
        picked = np.where(has, values[np.where(has, places, places[:, :1]) - face[0]], np.nan)
        linear = self.colours(picked, places[has])
        linear[~has] = 1
        row = np.full(len(sizes), -1)
        row[coloured] = np.arange(len(coloured))
        return Attribute(linear, np.repeat(row, sizes))

    def colours(self, values: Array, words: Positions) -> npt.NDArray[np.float32]:
        """Linear colours; where all `words` are written as integers they are counted to 255."""
        points = np.flatnonzero(np.isin(self.lines.text, np.frombuffer(b".eE", np.uint8)))
        floating = np.isin(np.searchsorted(self.starts, points, side="right") - 1, words).any()
        return from_display(values if floating else values / 255)
