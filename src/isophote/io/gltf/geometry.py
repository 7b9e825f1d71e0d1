"""Primitives of glTF meshes as `Mesh` values."""

from __future__ import annotations

import warnings
from os import fspath
from typing import Any, TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.errors import FileError, GeometryError, IsophoteWarning
from isophote.io.gltf.accessor import read_accessor
from isophote.io.gltf.document import Document
from isophote.io.gltf.field import Field
from isophote.shapes.mesh import Mesh

__all__ = ["UvMap", "read_primitive"]

Array: TypeAlias = npt.NDArray[Any]
Indices: TypeAlias = npt.NDArray[np.int64]

_POINTS_AND_LINES = ("points", "lines", "a line loop", "a line strip")
_TRIANGLES, _STRIP, _FAN = 4, 5, 6
# A mesh keeps positions as float64; triangles take three 32-bit and an offset of 64 bits.
_VERTEX_BYTES, _CORNER_BYTES = 24, 16


@attrs.frozen
class UvMap:
    """Which texture coordinates a material uses, and the affine map (2, 3), by rows, that it applies to them."""

    set: int = 0
    matrix: tuple[tuple[float, float, float], tuple[float, float, float]] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))

    @property
    def is_plain(self) -> bool:
        """Whether the coordinates are used as they are stored."""
        return self.matrix == ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))


def read_primitive(document: Document, field: Field, uv_map: UvMap) -> Mesh | None:
    """The triangles of one primitive, or None, with an `IsophoteWarning`, where it has none.

    Attributes "normal", "tangent", "uv" (with v turned upward) and "colour" are per vertex, as stored. Raises
    `FileError` for data that do not fit.
    """
    mode = field.integer("mode", _TRIANGLES)
    if mode < _TRIANGLES:
        _warn(field, f"{_POINTS_AND_LINES[mode]} cannot be rendered and are left out")
        return None
    if mode > _FAN:
        field.fail(f"must be 0 to 6, but is {mode}", "mode")
    attributes = field.child("attributes")
    if attributes is None or "POSITION" not in attributes:
        _warn(field, "has no positions and is left out")
        return None
    points = read_accessor(document, attributes.integer("POSITION"), widths=(3,))
    corners = _corners(document, field, len(points))
    faces = _triangles(corners, mode)
    if len(faces) * 3 != len(corners) and mode == _TRIANGLES:
        _warn(field, f"has {len(corners)} corners, no multiple of 3; the last ones are left out")
    if not len(faces):
        _warn(field, "has no triangles and is left out")
        return None
    document.spend(len(points) * _VERTEX_BYTES + len(faces) * 3 * _CORNER_BYTES, field.place)
    try:
        return Mesh(points, faces, attributes=_attributes(document, attributes, len(points), uv_map))
    except GeometryError as error:
        raise FileError(field.path, str(error), field.place) from error


def _corners(document: Document, field: Field, vertices: int) -> Indices:
    if "indices" not in field:
        return np.arange(vertices, dtype=np.int64)
    values = read_accessor(document, field.integer("indices"), widths=(1,))[:, 0]
    if values.dtype.kind != "u":
        field.fail(f"must be unsigned whole numbers, but are {values.dtype}", "indices")
    return values.astype(np.int64)


def _triangles(corners: Indices, mode: int) -> Indices:
    """(t, 3) corners of triangles, strips and fans; what stitches a strip together, without area, is dropped.

    Source: glTF 2.0, section 3.7.2.1.
    """
    if mode == _TRIANGLES:
        return corners[: len(corners) // 3 * 3].reshape(-1, 3)
    i = np.arange(max(len(corners) - 2, 0))
    if mode == _STRIP:
        faces = np.stack([corners[i], corners[i + 1 + i % 2], corners[i + 2 - i % 2]], axis=1)
    else:
        faces = np.stack([corners[i + 1], corners[i + 2], np.broadcast_to(corners[:1], i.shape)], axis=1)
    a, b, c = faces.T
    return np.asarray(faces[(a != b) & (b != c) & (c != a)])


def _attributes(document: Document, field: Field, vertices: int, uv_map: UvMap) -> dict[str, Array]:
    found: dict[str, Array] = {}
    uv_name = f"TEXCOORD_{uv_map.set}"
    wanted = (
        ("normal", "NORMAL", (3,)),
        ("tangent", "TANGENT", (4,)),
        ("uv", uv_name, (2,)),
        ("colour", "COLOR_0", (3, 4)),
    )
    for name, key, widths in wanted:
        # Tangents count with normals alone.
        if key not in field or (name == "tangent" and "normal" not in found):
            continue
        values = read_accessor(document, field.integer(key), widths=widths)
        if len(values) != vertices:
            field.fail(f"has {len(values)} values for {vertices} positions", key)
        if values.dtype.kind == "f" and not np.isfinite(values).all():
            _warn(field, f"{key} holds values that are not finite, and is left out")
            continue
        found[name] = _upward(values, uv_map) if name == "uv" else values.astype(np.float32, copy=False)
    return found


def _upward(uv: Array, uv_map: UvMap) -> npt.NDArray[np.float64]:
    """Texture coordinates with their origin at the lower left; float64, so that 1 − v can be undone."""
    mapped = uv.astype(np.float64)
    if not uv_map.is_plain:
        matrix = np.array(uv_map.matrix)
        mapped = mapped @ matrix[:, :2].T + matrix[:, 2]
    mapped[:, 1] = 1.0 - mapped[:, 1]
    return mapped


def _warn(field: Field, reason: str) -> None:
    warnings.warn(f"{fspath(field.path)}, {field.place}: {reason}", IsophoteWarning, stacklevel=2)
