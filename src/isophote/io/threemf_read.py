"""Reading 3MF: all objects of the build in their places as one mesh, with colours and names of materials."""

from __future__ import annotations

import io
import zipfile
import zlib
from pathlib import Path, PurePosixPath
from typing import NamedTuple
from xml.parsers import expat

import numpy as np
import numpy.typing as npt

from isophote.errors import FileError
from isophote.io.checks import check_faces, check_points, no_faces
from isophote.io.threemf_names import MODEL, MODEL_RELATION
from isophote.io.threemf_parse import Model, Object, Placed, parse_model
from isophote.io.vertex_colour import from_integers
from isophote.shapes.mesh import Attribute, FaceLabels, Mesh

__all__ = ["read_3mf"]

# What the archive may unpack to: models pack to a tenth or a twentieth.
_LARGEST_RATIO, _ALWAYS_ALLOWED = 200, 64 << 20
# Objects within objects, and triangles in all: a small file can ask for more than any memory holds.
_DEEPEST, _MOST_PLACED, _MOST_TRIANGLES = 32, 100_000, 1 << 27


class _Piece(NamedTuple):
    """An object of triangles in its place."""

    object: Object
    model: Model
    matrix: npt.NDArray[np.float64]


def read_3mf(path: Path, data: bytes) -> Mesh:
    """The mesh in a 3MF file: the objects of its build, each in its place, one after another.

    Lengths are those of the file, in its unit. Colours come as the attribute "colour" of the corners, base materials
    as the labels "material". Textures and other properties are passed over.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            models = _Models(path, archive, max(_ALWAYS_ALLOWED, _LARGEST_RATIO * len(data)))
            first = models.named(_model_name(models))
            pieces = [
                piece for placed in first.items for piece in _pieces(path, models, first, placed, np.eye(4)[:, :3], 0)
            ]
    except (zipfile.BadZipFile, zlib.error, NotImplementedError, EOFError, RuntimeError) as error:
        raise FileError(path, f"is not a whole 3MF package: {error}; export it again") from error
    return _merged(path, pieces)


class _Models:
    """The model parts of a package, parsed when first asked for."""

    def __init__(self, path: Path, archive: zipfile.ZipFile, room: int) -> None:
        self.path, self._archive, self._room = path, archive, room
        self._parsed: dict[str, Model] = {}
        self._placed = self._triangles = 0

    def count(self, triangles: int) -> None:
        """Count an object that is put in a place. Raises `FileError` where there are more than a model can mean."""
        self._placed += 1
        self._triangles += triangles
        if self._placed > _MOST_PLACED or self._triangles > _MOST_TRIANGLES:
            most = f"{_MOST_PLACED:,} times, or {_MOST_TRIANGLES:,} triangles in all"
            raise FileError(self.path, f"repeats its objects more than {most}; that is no model")

    def read(self, name: str) -> bytes:
        """The bytes of a part. Raises `FileError` where there is none, or they are too many."""
        try:
            with self._archive.open(name) as part:
                data = part.read(self._room + 1)
        except KeyError as error:
            raise FileError(self.path, f"the package has no part {name}; export it again") from error
        self._room -= len(data)
        if self._room < 0:
            raise FileError(self.path, "unpacks to far more than its size; if that is meant, pack it less tightly")
        return data

    def named(self, name: str) -> Model:
        """The model in a part."""
        name = name.lstrip("/")
        if name not in self._parsed:
            self._parsed[name] = parse_model(self.path, name, self.read(name))
        return self._parsed[name]


def _model_name(models: _Models) -> str:
    """The part that the package's relations name as its model."""
    found: list[str] = []

    def start(name: str, attributes: dict[str, str]) -> None:
        if name.rpartition(" ")[2] == "Relationship" and attributes.get("Type") == MODEL_RELATION:
            found.append(attributes.get("Target", MODEL))

    parser = expat.ParserCreate(namespace_separator=" ")
    parser.StartElementHandler = start
    try:
        parser.Parse(models.read("_rels/.rels"), True)
    except expat.ExpatError as error:
        raise FileError(models.path, f"the package's relations are broken: {error}", "_rels/.rels") from error
    return str(PurePosixPath(found[0])) if found else MODEL


def _pieces(
    path: Path, models: _Models, model: Model, placed: Placed, outer: npt.NDArray[np.float64], depth: int
) -> list[_Piece]:
    """The objects of triangles in a placed object, which may be made of others. Points are rows, times 4 × 3."""
    if depth > _DEEPEST:
        raise FileError(path, f"object {placed.object} lies in itself, or more than {_DEEPEST} objects deep")
    within = models.named(placed.part) if placed.part else model
    found = within.objects.get(placed.object)
    if found is None:
        raise FileError(path, f"there is no object {placed.object!r}; export the file again", placed.place)
    matrix = np.column_stack([placed.matrix, (0, 0, 0, 1)]) @ outer
    models.count(len(found.lines))
    pieces = [_Piece(found, within, matrix)] if found.lines else []
    for part in found.components:
        pieces += _pieces(path, models, within, part, matrix, depth + 1)
    return pieces


def _merged(path: Path, pieces: list[_Piece]) -> Mesh:
    points, faces = [], []
    colours = _Colours()
    materials = _Materials()
    count = 0
    for own, model, matrix in pieces:
        vertices = np.array(own.vertices, np.float64).reshape(-1, 3)
        triangles = np.array(own.triangles, np.int64).reshape(-1, 3)
        offsets = np.arange(len(triangles) + 1, dtype=np.int64) * 3

        def line(face: int, lines: list[int] = own.lines) -> str:
            return f"line {lines[face]}"

        check_faces(path, len(vertices), triangles.reshape(-1), offsets, line)
        if not np.isfinite(matrix).all():
            raise FileError(path, "a transform is not finite; export the file again")
        check_points(path, vertices, lambda vertex: f"vertex {vertex}")
        # A mirror turns triangles over.
        order = [0, 1, 2] if np.linalg.det(matrix[:3]) >= 0 else [0, 2, 1]
        points.append(vertices @ matrix[:3] + matrix[3])
        faces.append(triangles[:, order] + count)
        count += len(vertices)
        colours.add(own, model, order)
        materials.add(own, model)
    if not faces:
        raise no_faces(path, count)
    attributes = colours.attribute()
    return Mesh(np.concatenate(points), np.concatenate(faces), attributes=attributes, labels=materials.labels())


class _Colours:
    """Colours of corners, gathered over objects."""

    def __init__(self) -> None:
        self._values: list[npt.NDArray[np.uint8]] = []
        self._indices: list[npt.NDArray[np.int64]] = []
        self._count = 0

    def add(self, own: Object, model: Model, order: list[int]) -> None:
        starts: dict[str, int] = {}
        for name, group in model.colours.items():
            starts[name] = self._count
            self._values.append(np.array(group, np.uint8).reshape(-1, 4))
            self._count += len(group)
        rows = np.full((len(own.lines), 3), -1, np.int64)
        for row, (group_name, numbers) in zip(rows, own.properties, strict=True):
            if group_name in starts and max(numbers) < len(model.colours[group_name]) and min(numbers) >= 0:
                row[:] = [starts[group_name] + numbers[k] for k in order]
        self._indices.append(rows)

    def attribute(self) -> dict[str, Attribute]:
        indices = np.concatenate(self._indices).reshape(-1)
        if (indices < 0).all():
            return {}
        values = from_integers(np.concatenate(self._values))
        if (values[:, 3] == 1).all():
            values = values[:, :3]
        return {"colour": Attribute(values, indices)}


class _Materials:
    """Names of the faces' materials, gathered over objects."""

    def __init__(self) -> None:
        self._names: dict[str, int] = {}
        self._index: list[int] = []

    def add(self, own: Object, model: Model) -> None:
        for group_name, numbers in own.properties:
            names = model.materials.get(group_name, ())
            known = 0 <= numbers[0] < len(names)
            self._index.append(self._names.setdefault(names[numbers[0]], len(self._names)) if known else -1)

    def labels(self) -> dict[str, FaceLabels]:
        if not self._names:
            return {}
        return {"material": FaceLabels(tuple(self._names), np.array(self._index, np.int32))}
