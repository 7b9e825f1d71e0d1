"""Reading PLY: text and both byte orders, any layout, every column kept."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from isophote.errors import FileError
from isophote.io.checks import check_faces, check_points, no_faces
from isophote.io.files import StrPath
from isophote.io.ply_header import parse_header
from isophote.io.ply_tables import Lists, Table, read_tables
from isophote.io.vertex_colour import from_integers
from isophote.shapes.mesh import Attribute, Mesh

__all__ = ["CORNER_PREFIX", "FACE_PREFIX", "read_ply"]

Array = npt.NDArray[Any]

CORNER_PREFIX = "corner_"
FACE_PREFIX = "face_"

_FACE_LISTS = ("vertex_indices", "vertex_index")
# Columns that are one attribute together, under the names that programs have given them.
_GROUPS: tuple[tuple[str, tuple[tuple[str, ...], ...]], ...] = (
    ("normal", (("nx", "ny", "nz"),)),
    ("uv", (("s", "t"), ("u", "v"), ("texture_u", "texture_v"))),
    ("colour", (("red", "green", "blue", "alpha"), ("red", "green", "blue"), ("r", "g", "b", "a"), ("r", "g", "b"))),
)
_NUMBERED = re.compile(r"(.+)_(0|[1-9][0-9]{0,5})")


def read_ply(path: StrPath, data: bytes) -> Mesh:
    """A mesh from the bytes of a PLY file; `path` is for messages.

    Vertex columns become attributes: nx ny nz "normal", s t "uv", red green blue alpha "colour" (8 and 16
    bits sRGB-coded, floating ones linear), name_0 name_1 … one attribute "name", all others under their
    own name and in their type. Face columns become attributes with one row for each face, and lists of
    the faces attributes at corners ("texcoord" is "uv").
    """
    header = parse_header(path, data)
    tables = read_tables(path, header, data)
    if "vertex" not in tables:
        known = ", ".join(f'"{name[:40]}"' for name in list(tables)[:10]) or "none"
        raise FileError(path, f'there is no element "vertex"; the elements are: {known}')
    vertex, face = tables["vertex"], tables.get("face")
    points = _points(path, vertex)
    if face is None or face.count == 0:
        if "tristrips" in tables:
            raise FileError(path, "the faces are triangle strips, which are not read; export triangles instead")
        raise no_faces(path, vertex.count)
    name, corners = _corners(path, face)
    check_points(path, points, vertex.place)
    check_faces(path, len(points), corners.values, corners.offsets, face.place)
    typed = {k: _typed(path, vertex, k) for k in vertex.columns if k not in ("x", "y", "z")}
    columns = {k: c for k, c in typed.items() if isinstance(c, np.ndarray)}
    attributes = {k: Attribute(values) for k, values in _grouped(columns).items()}
    attributes |= _face_attributes(
        {k: _typed(path, face, k) for k in face.columns if k != name}, corners.offsets, frozenset(attributes)
    )
    return Mesh.from_polygons(points, corners.values.astype(np.int32), corners.offsets, attributes=attributes)


def _points(path: StrPath, vertex: Table) -> npt.NDArray[np.float64]:
    axes = [vertex.columns.get(axis) for axis in ("x", "y", "z")]
    found = [axis for axis in axes if isinstance(axis, np.ndarray)]
    if len(found) < 3:
        known = ", ".join(f'"{name[:40]}"' for name in list(vertex.columns)[:10]) or "none"
        raise FileError(path, f'element "vertex" needs the properties x, y and z, but has: {known}')
    return np.stack(found, axis=1).astype(np.float64)


def _corners(path: StrPath, face: Table) -> tuple[str, Lists]:
    for name in _FACE_LISTS:
        lists = face.columns.get(name)
        if isinstance(lists, Lists):
            whole = lists.values if lists.values.dtype.kind != "f" else _whole(path, face, name, lists)
            return name, Lists(whole.astype(np.int64), lists.offsets)
    raise FileError(path, 'element "face" needs a list "vertex_indices" (or "vertex_index") of its corners')


def _whole(path: StrPath, face: Table, name: str, lists: Lists) -> Array:
    """Vertex numbers that stand among floating values: whole, and small enough to be converted."""
    wrong = ~((np.abs(lists.values) < 2.0**53) & (lists.values == np.floor(lists.values)))
    if wrong.any():
        bad = int(np.argmax(wrong))
        row = int(np.searchsorted(lists.offsets, bad, side="right")) - 1
        reason = f'"{name}" of face {row} holds {lists.values[bad]}, which is no vertex number'
        raise FileError(path, reason, face.place(row))
    return lists.values


def _typed(path: StrPath, table: Table, name: str) -> Array | Lists:
    """A column in the type that the header declares."""
    column = table.columns[name]
    code = next(p.type for p in table.element.properties if p.name == name)
    if isinstance(column, Lists):
        rows = np.repeat(np.arange(table.count), np.diff(column.offsets))
        return Lists(_cast(path, table, name, column.values, code, rows), column.offsets)
    return _cast(path, table, name, column, code, None)


def _cast(path: StrPath, table: Table, name: str, values: Array, code: str, rows: Array | None) -> Array:
    if values.dtype == np.dtype(code):
        return values
    if code[0] != "f":
        limits = np.iinfo(code)
        wrong = ~((values >= limits.min) & (values <= limits.max))
        if wrong.any():
            bad = int(np.argmax(wrong))
            row = bad if rows is None else int(rows[bad])
            reason = f'"{name[:40]}" in row {row} of "{table.element.name}" is {values[bad]}, beyond its type'
            raise FileError(path, f"{reason} ({limits.min} to {limits.max})", table.place(row))
    with np.errstate(over="ignore"):
        return values.astype(code)


def _grouped(columns: Mapping[str, Array]) -> dict[str, Array]:
    """Columns put together to attributes (k, d)."""
    left = dict(columns)
    attributes: dict[str, Array] = {}
    for attribute, spellings in _GROUPS:
        for names in spellings:
            if attribute not in attributes and all(name in left for name in names):
                values = np.stack([left.pop(name) for name in names], axis=1)
                attributes[attribute] = _linear(values) if attribute == "colour" else values
    for base, count in _numbered(left).items():
        attributes[base] = np.stack([left.pop(f"{base}_{i}") for i in range(count)], axis=1)
    return attributes | {name: values[:, None] for name, values in left.items() if name not in attributes}


def _numbered(names: Mapping[str, Array]) -> dict[str, int]:
    """The stems of name_0, name_1 … without a gap, and how many there are of each."""
    found: dict[str, list[int]] = {}
    for name in names:
        if match := _NUMBERED.fullmatch(name):
            found.setdefault(match[1], []).append(int(match[2]))
    complete = {stem: len(n) for stem, n in found.items() if len(n) > 1 and sorted(n) == list(range(len(n)))}
    return {stem: count for stem, count in complete.items() if stem not in names}


def _linear(colour: Array) -> Array:
    return from_integers(colour) if colour.dtype.kind == "u" else colour.astype(np.float32)


def _face_attributes(
    columns: Mapping[str, Array | Lists], offsets: npt.NDArray[np.int64], taken: frozenset[str]
) -> dict[str, Attribute]:
    sizes = np.diff(offsets)
    attributes: dict[str, Attribute] = {}
    for name, column in columns.items():
        if isinstance(column, Lists) and (found := _at_corners(column, sizes)) is not None:
            own = "uv" if name == "texcoord" else name.removeprefix(CORNER_PREFIX)
            attributes[_free(own, (*taken, *attributes))] = found
    scalars = {name: column for name, column in columns.items() if isinstance(column, np.ndarray)}
    row = np.repeat(np.arange(len(sizes)), sizes)
    for name, values in _grouped(scalars).items():
        attributes[_free(name, (*taken, *attributes))] = Attribute(values, row)
    return attributes


def _free(name: str, taken: Sequence[str]) -> str:
    """A face column may have the name of a vertex column."""
    while name in taken:
        name = FACE_PREFIX + name
    return name


def _at_corners(lists: Lists, sizes: npt.NDArray[np.int64]) -> Attribute | None:
    """The attribute whose values a list of each face holds, d for each corner; None if it is something else.

    A face without values, and a corner whose values are all NaN, has none.
    """
    lengths = np.diff(lists.offsets)
    full = lengths > 0
    if not full.any():
        return None
    first = int(np.argmax(full))
    width = int(lengths[first] // sizes[first])
    if width == 0 or (lengths[full] != width * sizes[full]).any():
        return None
    values = lists.values.reshape(-1, width)
    index = np.full(int(sizes.sum()), -1)
    index[np.repeat(full, sizes)] = np.arange(len(values))
    if values.dtype.kind == "f":
        missing = np.isnan(values).all(axis=1)
        index[np.repeat(full, sizes)] = np.where(missing, -1, np.arange(len(values)))
    return Attribute(values, index)
