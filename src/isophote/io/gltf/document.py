"""The container: JSON and the bytes beside it, in one GLB file or in several."""

from __future__ import annotations

import base64
import binascii
import struct
from pathlib import Path
from typing import NoReturn
from urllib.parse import unquote_to_bytes, urlsplit

from isophote.errors import FileError
from isophote.io.files import StrPath
from isophote.io.gltf.field import Field, parse_json
from isophote.io.source import read_source

__all__ = ["GLB_MAGIC", "Document", "open_document"]

GLB_MAGIC = b"glTF"
_JSON_CHUNK = 0x4E4F534A
_BINARY_CHUNK = 0x004E4942

# A file may use its bytes many times over; beyond this it does nothing else.
_FREE_BYTES = 256 << 20
_BYTES_PER_BYTE = 64

_SUPPORTED = frozenset(
    (
        "EXT_texture_webp",
        "KHR_lights_punctual",
        "KHR_materials_emissive_strength",
        "KHR_materials_ior",
        "KHR_materials_transmission",
        "KHR_materials_unlit",
        "KHR_mesh_quantization",
        "KHR_texture_transform",
    )
)


class Document:
    """A parsed glTF file: `root`, its JSON, and its buffers, which are read when they are first used."""

    def __init__(self, path: StrPath, root: Field, binary: bytes | None, size: int) -> None:
        self.path = path
        self.root = root
        self._binary = binary
        self._buffers: dict[int, bytes] = {}
        self._room = _FREE_BYTES + _BYTES_PER_BYTE * size

    def fail(self, reason: str, place: str = "") -> NoReturn:
        """Raise a `FileError` for this file."""
        raise FileError(self.path, reason, place)

    def spend(self, size: int, place: str) -> None:
        """Account for `size` bytes before they are allocated. Raises `FileError` once they pass all bounds."""
        self._room -= size
        if self._room < 0:
            self.fail("its parts add up to far more than the bytes of the file can be meant to hold", place)

    def buffer(self, index: int) -> bytes:
        """The bytes of a buffer, exactly as many as it declares."""
        if index not in self._buffers:
            field = self.root.entry("buffers", index)
            uri, length = field.text("uri"), field.integer("byteLength")
            if uri is None:
                if index != 0 or self._binary is None:
                    field.fail("names no uri, and there is no binary chunk for it")
                data = self._binary
            else:
                data = self.resource(uri, field.place)
                self._room += _BYTES_PER_BYTE * len(data)
            if len(data) < length:
                field.fail(f"declares {length} bytes, but has {len(data)}; the file is cut short")
            self._buffers[index] = data[:length]
        return self._buffers[index]

    def view(self, index: int) -> tuple[memoryview, int]:
        """The bytes of a buffer view and its stride, 0 where it is tight."""
        field = self.root.entry("bufferViews", index)
        data = self.buffer(field.integer("buffer"))
        offset, length = field.integer("byteOffset", 0), field.integer("byteLength")
        if offset + length > len(data):
            field.fail(f"ends at byte {offset + length} of a buffer of {len(data)} bytes")
        return memoryview(data)[offset : offset + length], field.integer("byteStride", 0)

    def resource(self, uri: str, place: str) -> bytes:
        """The bytes that a URI stands for: data in it, or a file beside this one."""
        if uri[:5].lower() == "data:":
            return self._embedded(uri, place)
        return read_source(self.file(uri, place))

    def file(self, uri: str, place: str) -> Path:
        """The path of the file that a relative URI names."""
        try:
            scheme, name = urlsplit(uri).scheme, unquote_to_bytes(uri).decode()
        except ValueError as error:
            self.fail(f"its uri cannot be read: {error}", place)
        # One letter is a drive, not a scheme.
        if len(scheme) > 1 or "\x00" in name:
            self.fail(f"its uri {uri[:80]!r} names no file beside this one", place)
        return Path(self.path).parent / name

    def _embedded(self, uri: str, place: str) -> bytes:
        head, comma, body = uri.partition(",")
        if not comma:
            self.fail("its data uri has no comma before the data", place)
        raw = unquote_to_bytes(body)
        if not head.lower().endswith(";base64"):
            return raw
        try:
            return base64.b64decode(raw + b"=" * (-len(raw) % 4), validate=True)
        except binascii.Error as error:
            self.fail(f"its data uri is no base64: {error}", place)


def open_document(path: StrPath, data: bytes) -> Document:
    """The glTF document in the bytes of a .gltf or .glb file, told by content; other files lie beside `path`.

    Raises `FileError` for files that are damaged, of another version of glTF, or that require extensions
    which cannot be read.
    """
    text, binary = _chunks(path, data) if data.startswith(GLB_MAGIC) else (data, None)
    root = parse_json(path, text)
    _check_version(root)
    for name in root.array("extensionsRequired"):
        if name not in _SUPPORTED:
            root.fail(f"needs the extension {str(name)[:80]!r}, which cannot be read", "extensionsRequired")
    return Document(path, root, binary, len(data))


def _check_version(root: Field) -> None:
    asset = root.child("asset")
    version = None if asset is None else asset.text("version")
    if version is None:
        root.fail("is no glTF: it has no asset with a version")
    if not version.startswith("2."):
        root.fail(f"is glTF {version[:20]}; only version 2 can be read", "asset.version")


def _chunks(path: StrPath, data: bytes) -> tuple[bytes, bytes | None]:
    """The JSON and the binary chunk of a GLB."""
    if len(data) < 20:
        raise FileError(path, "is cut short: a GLB has 20 bytes or more", "byte 0")
    version, length = struct.unpack_from("<II", data, 4)
    if version != 2:
        raise FileError(path, f"is GLB {version}; only version 2 can be read", "byte 4")
    if length > len(data):
        raise FileError(path, f"is cut short: it declares {length} bytes, but has {len(data)}", "byte 8")
    chunks: dict[int, bytes] = {}
    at = 12
    while at + 8 <= length:
        size, kind = struct.unpack_from("<II", data, at)
        if at + 8 + size > length:
            raise FileError(path, f"has a chunk of {size} bytes that ends beyond the file", f"byte {at}")
        if at == 12 and kind != _JSON_CHUNK:
            raise FileError(path, "must begin with a JSON chunk", "byte 16")
        chunks.setdefault(kind, data[at + 8 : at + 8 + size])
        at += 8 + size
    if _JSON_CHUNK not in chunks:
        raise FileError(path, "has no JSON chunk", "byte 12")
    return chunks[_JSON_CHUNK], chunks.get(_BINARY_CHUNK)
