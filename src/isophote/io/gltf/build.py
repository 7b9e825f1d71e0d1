"""A glTF file in the making: lists of JSON objects and one block of bytes."""

from __future__ import annotations

import base64
import json
import struct
from typing import Any, TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

__all__ = ["Builder"]

Array: TypeAlias = npt.NDArray[Any]
Json: TypeAlias = dict[str, Any]

_CODES = {"uint16": 5123, "uint32": 5125, "float32": 5126}
_TYPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}
_ARRAY_BUFFER, _INDEX_BUFFER = 34962, 34963
_GLB = struct.Struct("<4sII")
_CHUNK = struct.Struct("<I4s")
_LARGEST_GLB = 2**32 - 1


@attrs.define
class Builder:
    """Collects the parts of a file; `add` puts an object into a list and tells its number."""

    lists: dict[str, list[Json]] = attrs.field(factory=dict)
    extensions: set[str] = attrs.field(factory=set)
    blob: bytearray = attrs.field(factory=bytearray)

    def add(self, key: str, value: Json) -> int:
        """The number of a new entry of the list `key`."""
        entries = self.lists.setdefault(key, [])
        entries.append(value)
        return len(entries) - 1

    def add_bytes(self, data: bytes, target: int | None = None) -> int:
        """The number of a new buffer view."""
        self.blob += b"\x00" * (-len(self.blob) % 4)
        view: Json = {"buffer": 0, "byteOffset": len(self.blob), "byteLength": len(data)}
        self.blob += data
        return self.add("bufferViews", view if target is None else view | {"target": target})

    def add_array(self, values: Array, *, bounds: bool = False) -> int:
        """The number of a new accessor: float32 (n, 2 to 4) attributes, with their bounds, or (n,) unsigned indices."""
        stack = values.reshape(len(values), -1)
        target = _INDEX_BUFFER if values.ndim == 1 else _ARRAY_BUFFER
        little = np.ascontiguousarray(stack, stack.dtype.newbyteorder("<"))
        accessor: Json = {
            "bufferView": self.add_bytes(little.tobytes(), target),
            "componentType": _CODES[stack.dtype.name],
            "count": len(stack),
            "type": _TYPES[stack.shape[1]],
        }
        if bounds:
            accessor |= {"min": stack.min(axis=0).tolist(), "max": stack.max(axis=0).tolist()}
        return self.add("accessors", accessor)

    def glb(self, root: Json) -> bytes:
        """The bytes of a GLB. Raises `ValueError` where they are more than the format can count."""
        text = self._text(root, {"byteLength": len(self.blob)})
        text += b" " * (-len(text) % 4)
        binary = bytes(self.blob) + b"\x00" * (-len(self.blob) % 4)
        size = _GLB.size + _CHUNK.size + len(text) + (_CHUNK.size + len(binary) if binary else 0)
        if size > _LARGEST_GLB:
            raise ValueError(f"its {size:,} bytes are more than a GLB can hold")
        parts = [_GLB.pack(b"glTF", 2, size), _CHUNK.pack(len(text), b"JSON"), text]
        if binary:
            parts += [_CHUNK.pack(len(binary), b"BIN\x00"), binary]
        return b"".join(parts)

    def gltf(self, root: Json) -> bytes:
        """The bytes of a .gltf that stands alone, its buffer in a data URI."""
        uri = "data:application/octet-stream;base64," + base64.b64encode(self.blob).decode()
        return self._text(root, {"byteLength": len(self.blob), "uri": uri})

    def _text(self, root: Json, buffer: Json) -> bytes:
        used = {"extensionsUsed": sorted(self.extensions)} if self.extensions else {}
        buffers = {"buffers": [buffer]} if self.blob else {}
        document = {"asset": {"version": "2.0", "generator": "Isophote"}, **root, **used, **self.lists, **buffers}
        return json.dumps(document, allow_nan=False, separators=(",", ":")).encode()
