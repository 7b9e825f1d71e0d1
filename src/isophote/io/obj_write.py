"""Writing Wavefront OBJ: polygons with their corners, materials and groups."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import numpy.typing as npt

from isophote.errors import FileError
from isophote.io.dropped import warn_dropped
from isophote.io.files import StrPath
from isophote.io.vertex_colour import to_display
from isophote.shapes.mesh import Attribute, FaceLabels, Mesh

__all__ = ["encode_obj"]

Array = npt.NDArray[Any]


def encode_obj(mesh: Mesh, path: StrPath, *, materials: str = "") -> bytes:
    """The bytes of an OBJ file; `path` is for messages; `materials` names the file for "mtllib".

    Numbers are the shortest texts that give the same doubles again. "uv" and "normal" are written at the
    vertices or corners as they are, "colour" after the coordinates where it is at the vertices, "material"
    and "group" as "usemtl" and "g". What OBJ cannot hold is left out, with an `IsophoteWarning`. Raises
    `FileError` for names with line breaks or a "#" after a blank.
    """
    held = {"uv": 2, "normal": 3}
    corners = {name: a for name, a in mesh.attributes.items() if held.get(name) == a.values.shape[1]}
    colour = mesh.colours
    if colour is not None and (colour.indices is not None or colour.values.shape[1] not in (3, 4)):
        colour = None
    kept = (*corners, *(("colour",) if colour is not None else ()))
    warn_dropped(mesh, path, "OBJ", attributes=kept, labels=("material", "group"))
    parts = ["# Isophote\n"]
    if materials:
        parts.append(f"mtllib {_name(path, materials)}\n")
    points: Array = mesh.vertices
    if colour is not None:
        points = np.concatenate([points, to_display(colour.values)], axis=1)
    parts.append(_lines("v", points))
    parts += [_lines("vt" if name == "uv" else "vn", a.values) for name, a in sorted(corners.items(), reverse=True)]
    parts += _faces(path, mesh, corners)
    return "".join(parts).encode()


def _lines(keyword: str, rows: Array) -> str:
    pattern = keyword + " %r" * rows.shape[1] + "\n"
    text: str = pattern * len(rows) % tuple(rows.reshape(-1).tolist())
    return text


def _faces(path: StrPath, mesh: Mesh, corners: dict[str, Attribute]) -> list[str]:
    words = _corner_words(mesh, corners)
    offsets = mesh.offsets.tolist()
    lines = ["f " + " ".join(words[a:b]) + "\n" for a, b in itertools.pairwise(offsets)]
    for keyword, name in (("usemtl", "material"), ("g", "group")):
        labels = mesh.labels.get(name)
        if labels is not None:
            for face, label in _changes(labels):
                text = _name(path, labels.names[label]) if label >= 0 else ""
                lines[face] = f"{keyword} {text}".rstrip() + "\n" + lines[face]
    return lines


def _corner_words(mesh: Mesh, corners: dict[str, Attribute]) -> list[str]:
    """ "v", "v/vt", "v//vn" or "v/vt/vn" for each corner, counted from 1."""
    vertex = (mesh.indices + 1).tolist()
    if not corners:
        return list(map(str, vertex))
    uv, normal = (_numbers(corners.get(name), mesh) for name in ("uv", "normal"))
    return [_corner(*numbers) for numbers in zip(vertex, uv, normal, strict=True)]


def _numbers(attribute: Attribute | None, mesh: Mesh) -> list[int]:
    """The number of each corner's row, counted from 1; 0 where it has none."""
    if attribute is None:
        return [0] * len(mesh.indices)
    index = mesh.indices if attribute.indices is None else attribute.indices
    numbers: list[int] = (index + 1).tolist()
    return numbers


def _corner(vertex: int, uv: int, normal: int) -> str:
    if normal:
        return f"{vertex}/{uv or ''}/{normal}"
    return f"{vertex}/{uv}" if uv else str(vertex)


def _changes(labels: FaceLabels) -> list[tuple[int, int]]:
    """Faces at which the label changes, and to what."""
    at = np.flatnonzero(np.diff(labels.index, prepend=-1))
    return list(zip(at.tolist(), labels.index[at].tolist(), strict=True))


def _name(path: StrPath, name: str) -> str:
    """A name that reads back as it is."""
    if name != name.strip() or any(c in name for c in "\r\n") or " #" in f" {name}" or name.endswith("\\"):
        reason = "use one without line breaks, white space around it, a backslash at its end and a # before a word"
        raise FileError(path, f"OBJ cannot hold the name {name!r}; {reason}")
    return name
