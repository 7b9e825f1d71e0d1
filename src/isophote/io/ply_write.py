"""Writing PLY: every attribute kept, in text or in either byte order, without a loss."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, Literal, TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.errors import FileError
from isophote.io.dropped import warn_dropped
from isophote.io.files import StrPath
from isophote.io.ply_header import type_name
from isophote.io.ply_read import CORNER_PREFIX
from isophote.io.vertex_colour import as_exact_bytes
from isophote.shapes.mesh import Attribute, Mesh

__all__ = ["encode_ply"]

Array = npt.NDArray[Any]
Endian: TypeAlias = Literal["little", "big"]

_COLUMNS = {
    ("normal", 3): ("nx", "ny", "nz"),
    ("uv", 2): ("s", "t"),
    ("colour", 3): ("red", "green", "blue"),
    ("colour", 4): ("red", "green", "blue", "alpha"),
}


@attrs.frozen(eq=False)
class _Column:
    """A property: one value a row, or, with `sizes`, that many."""

    name: str
    values: Array
    sizes: npt.NDArray[np.int64] | None = None

    @property
    def code(self) -> str:
        return self.values.dtype.str[1:]

    @property
    def count_code(self) -> str:
        assert self.sizes is not None
        return "u1" if self.sizes.max(initial=0) <= 255 else "u4"

    @property
    def declaration(self) -> str:
        if self.sizes is None:
            return f"property {type_name(self.code)} {self.name}"
        return f"property list {type_name(self.count_code)} {type_name(self.code)} {self.name}"


def encode_ply(mesh: Mesh, path: StrPath, *, binary: bool = True, endian: Endian = "little") -> bytes:
    """The bytes of a PLY file; `path` is for messages.

    Vertices are `float` where that loses nothing, else `double`; attributes keep their type. Colours that
    come from 8 bits are written as the same 8 bits, all others as linear floating values. Attributes at
    corners are lists of the faces: "uv" as `texcoord`, others as `corner_NAME`. Labels have no place in
    PLY. Raises `FileError` for attributes that PLY cannot name or hold.
    """
    if endian not in ("little", "big"):
        raise FileError(path, f'endian is "little" or "big", but was given as {endian!r}')
    warn_dropped(mesh, path, "PLY", attributes=mesh.attributes, labels=())
    vertex, face = _columns(path, mesh)
    for columns in (vertex, face):
        _check_names(path, columns)
    encoding = f"binary_{endian}_endian" if binary else "ascii"
    lines = ["ply", f"format {encoding} 1.0", "comment Isophote", f"element vertex {len(mesh.vertices)}"]
    lines += [column.declaration for column in vertex]
    lines += [f"element face {mesh.face_count}", *(column.declaration for column in face), "end_header", ""]
    counts = ((vertex, len(mesh.vertices)), (face, mesh.face_count))
    if not binary:
        return "\n".join(lines).encode() + b"".join(_text(columns) for columns, _ in counts)
    order = "<" if endian == "little" else ">"
    return "\n".join(lines).encode() + b"".join(_packed(columns, count, order) for columns, count in counts)


def _columns(path: StrPath, mesh: Mesh) -> tuple[list[_Column], list[_Column]]:
    with np.errstate(over="ignore"):
        short = mesh.vertices.astype(np.float32)
    points: Array = short if np.array_equal(short, mesh.vertices) else mesh.vertices
    vertex = [_Column(name, points[:, i]) for i, name in enumerate("xyz")]
    face = [_Column("vertex_indices", mesh.indices, mesh.face_sizes)]
    row = np.repeat(np.arange(mesh.face_count), mesh.face_sizes)
    for name, attribute in mesh.attributes.items():
        values = _storable(path, name, attribute.values)
        if attribute.indices is None:
            vertex += _scalars(name, values)
        elif len(values) == mesh.face_count and np.array_equal(attribute.indices, row):
            face += _scalars(name, values)
        else:
            face.append(_at_corners(name, values, attribute, mesh))
    return vertex, face


def _storable(path: StrPath, name: str, values: Array) -> Array:
    """The same values in a type that PLY has."""
    if values.dtype.kind == "b":
        return values.astype(np.uint8)
    if values.dtype.kind in "iu" and values.dtype.itemsize == 8:
        limits = np.iinfo(np.int32)
        if values.size == 0 or (values.min() >= limits.min and values.max() <= limits.max):
            return values.astype(np.int32)
        if np.abs(values.astype(np.float64)).max() < 2.0**53:
            return values.astype(np.float64)
    elif values.dtype.kind in "iu":
        return values
    elif values.dtype.kind == "f" and values.dtype.itemsize <= 8:
        return values.astype(np.float32) if values.dtype.itemsize == 2 else values
    raise FileError(path, f'attribute "{name}" is {values.dtype}, which PLY cannot hold; convert it to float64')


def _scalars(name: str, values: Array) -> list[_Column]:
    width = values.shape[1]
    if name == "colour" and (coded := as_exact_bytes(values)) is not None:
        values = coded
    single = (name,) if width == 1 else tuple(f"{name}_{i}" for i in range(width))
    return [_Column(column, values[:, i]) for i, column in enumerate(_COLUMNS.get((name, width), single))]


def _at_corners(name: str, values: Array, attribute: Attribute, mesh: Mesh) -> _Column:
    """A list of the faces: the values of every corner, NaN where it has none."""
    assert attribute.indices is not None
    missing = attribute.indices < 0
    if missing.any() and values.dtype.kind != "f":
        values = values.astype(np.float64)
    spread = values[np.where(missing, 0, attribute.indices)] if len(values) else np.zeros((len(missing), 1))
    if missing.any():
        spread[missing] = np.nan
    own = "texcoord" if (name, values.shape[1]) == ("uv", 2) else CORNER_PREFIX + name
    return _Column(own, spread.reshape(-1), mesh.face_sizes * spread.shape[1])


def _check_names(path: StrPath, columns: Iterable[_Column]) -> None:
    seen: set[str] = set()
    for name in (column.name for column in columns):
        if not name.isascii() or not name.isprintable() or len(name.split()) != 1 or " " in name:
            raise FileError(path, f"PLY cannot hold an attribute named {name!r}: use one word of ASCII letters")
        if name in seen:
            raise FileError(path, f'two attributes would be the PLY property "{name}"; rename one of them')
        seen.add(name)


def _text(columns: list[_Column]) -> bytes:
    return "".join(" ".join(row) + "\n" for row in zip(*map(_words, columns), strict=True)).encode()


def _words(column: _Column) -> list[str]:
    """Each row as text; `repr` of a number is the shortest text that gives it back."""
    words = list(map(repr, column.values.tolist()))
    if column.sizes is None:
        return words
    ends = np.cumsum(column.sizes).tolist()
    sizes = column.sizes.tolist()
    return [" ".join([str(n), *words[end - n : end]]) for n, end in zip(sizes, ends, strict=True)]


def _packed(columns: list[_Column], count: int, order: str) -> bytes:
    """The rows of a table, one after another."""
    parts: list[tuple[Array, npt.NDArray[np.int64] | None]] = []
    for column in columns:
        if column.sizes is not None:
            parts.append((column.sizes.astype(order + column.count_code), None))
        parts.append((column.values.astype(order + column.code), column.sizes))
    widths = [(values.itemsize * (1 if sizes is None else sizes)) for values, sizes in parts]
    begins = [np.zeros(count, np.int64)]
    for width in widths:
        begins.append(begins[-1] + width)
    starts = np.concatenate([np.zeros(1, np.int64), np.cumsum(begins[-1])])
    packed = np.empty(int(starts[-1]), np.uint8)
    for (values, sizes), begin in zip(parts, begins[:-1], strict=True):
        raw = np.ascontiguousarray(values).view(np.uint8).reshape(len(values), values.itemsize)
        _scatter(packed, raw, starts[:-1] + begin, sizes)
    return packed.tobytes()


def _scatter(packed: Array, raw: Array, places: Array, sizes: npt.NDArray[np.int64] | None) -> None:
    """Put the bytes of each value, rows of `raw`, where they belong: `sizes` values in a row at each place."""
    if sizes is not None:
        within = np.arange(len(raw)) - np.repeat(np.cumsum(sizes) - sizes, sizes)
        places = np.repeat(places, sizes) + within * raw.shape[1]
    for byte in range(raw.shape[1]):
        packed[places + byte] = raw[:, byte]
