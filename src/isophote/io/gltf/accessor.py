"""Accessors: typed arrays in the bytes of a glTF file, tight, interleaved or sparse."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.io.gltf.document import Document
from isophote.io.gltf.field import Field

__all__ = ["COMPONENTS", "WIDTHS", "read_accessor"]

Array: TypeAlias = npt.NDArray[Any]

COMPONENTS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}


def read_accessor(document: Document, index: int, *, widths: tuple[int, ...]) -> Array:
    """Values (count, width) of an accessor: float32, from normalised whole numbers too, or whole as stored.

    `widths` are the numbers of components that fit the use. Raises `FileError` where the accessor does not fit
    its use or its bytes.
    """
    field = document.root.entry("accessors", index)
    width = WIDTHS.get(field.text("type") or "", 0)
    if width not in widths:
        field.fail(f"must be one of {[name for name, w in WIDTHS.items() if w in widths]}", "type")
    dtype = _component(field)
    count = field.integer("count")
    if count == 0:
        field.fail("must be 1 or more", "count")
    if "bufferView" in field:
        view = field.integer("bufferView")
        values = _elements(document, field, view, field.integer("byteOffset", 0), count, width, dtype).copy()
    else:
        document.spend(count * width * dtype.itemsize, field.place)
        values = np.zeros((count, width), dtype)
    sparse = field.child("sparse")
    if sparse is not None:
        _substitute(document, sparse, values)
    return _normalised(values) if field.flag("normalized") else values


def _component(field: Field) -> np.dtype[Any]:
    code = field.integer("componentType")
    if code not in COMPONENTS:
        field.fail(f"must be one of {list(COMPONENTS)}, but is {code}", "componentType")
    return np.dtype(COMPONENTS[code])


def _elements(
    document: Document, field: Field, view: int, offset: int, count: int, width: int, dtype: np.dtype[Any]
) -> Array:
    """(count, width) of a buffer view, where it lies; nothing is allocated."""
    data, stride = document.view(view)
    size = width * dtype.itemsize
    if stride and not size <= stride <= 252:
        field.fail(f"elements of {size} bytes do not fit a stride of {stride}", "bufferView")
    stride = stride or size
    end = offset + (count - 1) * stride + size
    if end > len(data):
        field.fail(f"needs {end} bytes of a buffer view of {len(data)}", "count")
    document.spend(count * size, field.place)
    return np.ndarray((count, width), dtype, data, offset, (stride, dtype.itemsize))


def _substitute(document: Document, sparse: Field, values: Array) -> None:
    """Put the values of a sparse accessor in their places."""
    count = sparse.integer("count")
    indices, replacements = sparse.child("indices"), sparse.child("values")
    if indices is None or replacements is None:
        sparse.fail("needs indices and values")
    if not 1 <= count <= len(values):
        sparse.fail(f"must be 1 to {len(values)}", "count")
    kind = _component(indices)
    if kind.kind != "u":
        indices.fail("must be unsigned", "componentType")
    view, offset = indices.integer("bufferView"), indices.integer("byteOffset", 0)
    places = _elements(document, indices, view, offset, count, 1, kind)[:, 0].astype(np.int64)
    if places.max() >= len(values):
        indices.fail(f"names element {int(places.max())} of {len(values)}")
    view, offset = replacements.integer("bufferView"), replacements.integer("byteOffset", 0)
    values[places] = _elements(document, replacements, view, offset, count, values.shape[1], values.dtype)


def _normalised(values: Array) -> Array:
    """c / largest, and not below −1. Source: glTF 2.0, section 3.6.2.2."""
    if values.dtype.kind == "f":
        return values
    largest = np.float32(np.iinfo(values.dtype).max)
    return np.asarray(np.maximum(values.astype(np.float32) / largest, np.float32(-1)))
