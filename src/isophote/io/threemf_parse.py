"""The XML of a 3MF model: objects, groups of colours and materials, and what is to be built."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TypeAlias
from xml.parsers import expat

import attrs
import numpy as np
import numpy.typing as npt

from isophote.errors import FileError

__all__ = ["Model", "Object", "Placed", "parse_model"]

# The group that a triangle's properties are of ("" for none), and their numbers at its corners.
Properties: TypeAlias = tuple[str, tuple[int, int, int]]

_NO_PROPERTIES: Properties = ("", (-1, -1, -1))
_COLOUR = re.compile(r"#([0-9A-Fa-f]{6})([0-9A-Fa-f]{2})?")


@attrs.frozen(eq=False)
class Placed:
    """An object in its place: a 4 × 3 matrix that rows (x, y, z, 1) are multiplied by. `part` names another model."""

    object: str
    matrix: npt.NDArray[np.float64]
    part: str
    place: str


@attrs.define(eq=False)
class Object:
    """Triangles with their properties and lines in the file, or other objects."""

    inherited: Properties
    vertices: list[float] = attrs.field(factory=list)
    triangles: list[int] = attrs.field(factory=list)
    properties: list[Properties] = attrs.field(factory=list)
    lines: list[int] = attrs.field(factory=list)
    components: list[Placed] = attrs.field(factory=list)


@attrs.define(eq=False)
class Model:
    """What a model part holds, by the identifiers in it."""

    objects: dict[str, Object] = attrs.field(factory=dict)
    colours: dict[str, list[tuple[int, ...]]] = attrs.field(factory=dict)
    materials: dict[str, list[str]] = attrs.field(factory=dict)
    items: list[Placed] = attrs.field(factory=list)


def parse_model(path: Path, part: str, data: bytes) -> Model:
    """The model in the bytes of a part. Raises `FileError` with the part and the line."""
    return _Parser(path, part).parse(data)


class _Parser:
    def __init__(self, path: Path, part: str) -> None:
        self._path, self._part = path, part
        self._model = Model()
        self._object = Object(_NO_PROPERTIES)
        self._colours: list[tuple[int, ...]] = []
        self._materials: list[str] = []
        self._xml = expat.ParserCreate(namespace_separator=" ")
        self._xml.StartElementHandler = self._start
        self._xml.StartDoctypeDeclHandler = self._refuse_doctype

    def parse(self, data: bytes) -> Model:
        try:
            self._xml.Parse(data, True)
        except expat.ExpatError as error:
            raise FileError(self._path, f"the XML is broken: {error}; export the file again", self._place()) from error
        except KeyError as error:
            raise FileError(self._path, f"an element lacks its attribute {error}", self._place()) from error
        except ValueError as error:
            raise FileError(self._path, f"this is no number: {error}", self._place()) from error
        return self._model

    def _place(self) -> str:
        return f"{self._part}, line {self._xml.CurrentLineNumber}"

    def _refuse_doctype(self, *_: object) -> None:
        raise FileError(self._path, "3MF allows no document types, which can hide any amount of text", self._place())

    def _start(self, name: str, attributes: dict[str, str]) -> None:
        kind = name.rpartition(" ")[2]
        if kind == "vertex":
            self._object.vertices += (float(attributes["x"]), float(attributes["y"]), float(attributes["z"]))
        elif kind == "triangle":
            self._triangle(attributes)
        elif kind == "object":
            inherited = attributes.get("pid", ""), (int(attributes.get("pindex", 0)),) * 3
            self._object = self._model.objects[attributes["id"]] = Object(inherited)
        elif kind == "component":
            self._object.components.append(self._placed(attributes))
        elif kind == "item":
            self._model.items.append(self._placed(attributes))
        elif kind == "colorgroup":
            self._colours = self._model.colours[attributes["id"]] = []
        elif kind == "color":
            self._colours.append(self._colour(attributes["color"]))
        elif kind == "basematerials":
            self._materials = self._model.materials[attributes["id"]] = []
        elif kind == "base":
            self._materials.append(attributes["name"])

    def _triangle(self, attributes: dict[str, str]) -> None:
        own = self._object
        own.triangles += (int(attributes["v1"]), int(attributes["v2"]), int(attributes["v3"]))
        own.lines.append(self._xml.CurrentLineNumber)
        if "p1" not in attributes:
            own.properties.append(own.inherited)
            return
        first = int(attributes["p1"])
        numbers = first, int(attributes.get("p2", first)), int(attributes.get("p3", first))
        own.properties.append((attributes.get("pid", own.inherited[0]), numbers))

    def _placed(self, attributes: dict[str, str]) -> Placed:
        words = attributes.get("transform", "1 0 0 0 1 0 0 0 1 0 0 0").split()
        if len(words) != 12:
            raise FileError(self._path, f"a transform has 12 numbers, but this has {len(words)}", self._place())
        part = next((value for key, value in attributes.items() if key.endswith(" path")), "")
        matrix = np.array([float(word) for word in words]).reshape(4, 3)
        return Placed(attributes["objectid"], matrix, part, self._place())

    def _colour(self, text: str) -> tuple[int, ...]:
        found = _COLOUR.fullmatch(text.strip())
        if found is None:
            raise FileError(self._path, f"{text!r} is no colour; it should be like #RRGGBBAA", self._place())
        return tuple(bytes.fromhex(found[1] + (found[2] or "FF")))
