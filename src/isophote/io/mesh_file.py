"""Mesh files by their endings: which function reads and which writes."""

from __future__ import annotations

import gzip
import inspect
import math
from collections.abc import Callable, Collection
from pathlib import Path
from typing import Any, Literal, TypeAlias, TypeVar

import numpy as np
import numpy.typing as npt

from isophote.errors import FileError, GeometryError
from isophote.io.files import StrPath, write_bytes
from isophote.io.gltf.read import read_gltf_mesh
from isophote.io.gltf.write import encode_gltf_mesh
from isophote.io.obj_read import read_obj
from isophote.io.obj_write import encode_obj
from isophote.io.off_read import read_off
from isophote.io.off_write import encode_off
from isophote.io.ply_read import read_ply
from isophote.io.ply_write import encode_ply
from isophote.io.source import read_source
from isophote.io.stl_read import read_stl
from isophote.io.stl_write import encode_stl
from isophote.io.threemf_read import read_3mf
from isophote.io.threemf_write import encode_3mf
from isophote.shapes.mesh import Attribute, Mesh

__all__ = ["READERS", "WRITERS", "Encoder", "Reader", "Up", "encoder_for", "load_mesh", "save_mesh"]

Reader: TypeAlias = Callable[[Path, bytes], Mesh]
"""From the path, for messages and neighbouring files, and the bytes, unpacked, to the mesh."""
Encoder: TypeAlias = Callable[..., bytes]
"""From the mesh, the path, for messages, and options by name to the bytes."""
Up: TypeAlias = Literal["y", "z"]

_Function = TypeVar("_Function")

READERS: dict[str, Reader] = {
    ".3mf": read_3mf,
    ".glb": read_gltf_mesh,
    ".gltf": read_gltf_mesh,
    ".obj": read_obj,
    ".off": read_off,
    ".ply": read_ply,
    ".stl": read_stl,
}
WRITERS: dict[str, Encoder] = {
    ".3mf": encode_3mf,
    ".glb": encode_gltf_mesh,
    ".gltf": encode_gltf_mesh,
    ".obj": encode_obj,
    ".off": encode_off,
    ".ply": encode_ply,
    ".stl": encode_stl,
}

# How a file begins that cannot be anything else, whatever its name ends with.
_BEGINNINGS = {b"ply\n": ".ply", b"ply\r": ".ply", b"glTF": ".glb"}


def load_mesh(path: StrPath, *, up: Up | None = None, scale: float = 1.0) -> Mesh:
    """The mesh in a file, as it was stored: nothing is merged, reordered, triangulated or dropped.

    The ending of the name, in any case, tells the format; a further ".gz" tells that gzip packed it.
    `up="z"` turns a file whose z axis points up into the world, where y does: (x, y, z) becomes
    (x, z, −y); `scale`, above 0, multiplies the coordinates (0.001 for a file in millimetres).

    Raises `FileError` (path, place in the file, reason) for unknown endings, files that cannot be read, are
    cut short or damaged, point clouds, coordinates that are not finite and faces that name vertices that
    are not there; `GeometryError` for another `up` or `scale`.
    """
    if up not in (None, "y", "z"):
        raise GeometryError(f'up must be "y" or "z", the axis that points up in the file, but is {up!r}')
    if not (math.isfinite(scale) and scale > 0):
        raise GeometryError(f"scale must be a finite number above 0, but is {scale!r}")
    file = Path(path)
    reader = _by_ending(READERS, file, "reads")
    data = read_source(file)
    reader = READERS.get(_BEGINNINGS.get(data[:4], ""), reader)
    try:
        mesh = reader(file, data)
        return mesh if up != "z" and scale == 1 else _placed(mesh, up, scale)
    except GeometryError as error:
        raise FileError(path, str(error)) from error


def save_mesh(mesh: Mesh, path: StrPath, **options: object) -> None:
    """Write a mesh in the format that the ending tells; see `isophote.save`."""
    file = Path(path)
    data = encoder_for(path, options)(mesh, file, **options)
    # Without a time in it, equal meshes give equal files.
    write_bytes(path, gzip.compress(data, mtime=0) if file.suffix.lower() == ".gz" else data)


def encoder_for(path: StrPath, options: Collection[str]) -> Encoder:
    """What writes meshes with the ending of a name and options of these names; `FileError` where nothing does."""
    encode = _by_ending(WRITERS, Path(path), "writes meshes as")
    known = [name for name, p in inspect.signature(encode).parameters.items() if p.kind is p.KEYWORD_ONLY]
    unknown = [name for name in options if name not in known]
    if unknown:
        has = f"its options are {', '.join(known)}" if known else "it has none"
        raise FileError(path, f'this format has no option "{unknown[0]}"; {has}')
    return encode


def _by_ending(functions: dict[str, _Function], file: Path, does: str) -> _Function:
    endings = [suffix.lower() for suffix in file.suffixes]
    packed = endings[-1:] == [".gz"]
    ending = "".join(endings[:-1][-1:] if packed else endings[-1:])
    if ending not in functions:
        known = ", ".join(sorted(functions))
        named = f'the ending "{ending}" is not known' if ending else "the name has no ending"
        raise FileError(file, f"{named}; Isophote {does} {known}, each also with .gz after it")
    return functions[ending]


def _placed(mesh: Mesh, up: Up | None, scale: float) -> Mesh:
    """The mesh scaled, and turned by a quarter about x where z points up."""
    attributes = dict(mesh.attributes)
    vertices = mesh.vertices
    if up == "z":
        vertices = _turned(vertices)
        normals = mesh.normals
        if normals is not None and normals.values.shape[1] == 3:
            attributes["normal"] = Attribute(_turned(normals.values), normals.indices)
    with np.errstate(over="ignore"):
        scaled = vertices * scale
    return mesh.with_(vertices=scaled, attributes=attributes)


def _turned(vectors: npt.NDArray[Any]) -> npt.NDArray[Any]:
    return np.stack([vectors[:, 0], vectors[:, 2], -vectors[:, 1]], axis=1)
