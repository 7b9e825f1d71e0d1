"""Writing OFF: polygons, and colours, normals and texture coordinates where they are at the vertices."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from isophote.io.dropped import warn_dropped
from isophote.io.files import StrPath
from isophote.io.off_read import FACE_COLOUR
from isophote.io.vertex_colour import as_exact_bytes, to_display
from isophote.shapes.mesh import Attribute, Mesh

__all__ = ["encode_off"]

Array = npt.NDArray[Any]


def encode_off(mesh: Mesh, path: StrPath) -> bytes:
    """The bytes of an OFF file; `path` is for messages.

    Numbers are the shortest texts that give the same doubles again; colours that come from 8 bits are
    written as such. A colour of vertices always gets alpha, which the format demands. What OFF cannot hold is
    left out, with an `IsophoteWarning`.
    """
    kept = {name: a for name, a in mesh.attributes.items() if _at_vertices(name, a)}
    of_faces = _face_colours(mesh, kept)
    warn_dropped(mesh, path, "OFF", attributes=(*kept, *of_faces), labels=())
    columns = [_words(mesh.vertices)]
    if "normal" in kept:
        columns.append(_words(kept["normal"].values))
    if "colour" in kept:
        linear = kept["colour"].values
        columns.append(_colour_words(np.pad(linear, ((0, 0), (0, 4 - linear.shape[1])), constant_values=1)))
    if "uv" in kept:
        columns.append(_words(kept["uv"].values))
    kind = ("ST" if "uv" in kept else "") + ("C" if "colour" in kept else "") + ("N" if "normal" in kept else "")
    lines = [f"{kind}OFF", f"{len(mesh.vertices)} {mesh.face_count} 0"]
    lines += map(" ".join, zip(*columns, strict=True))
    ends = next(iter(of_faces.values()), [""] * mesh.face_count)
    corners = list(map(str, mesh.indices.tolist()))
    offsets = mesh.offsets.tolist()
    for a, b, end in zip(offsets[:-1], offsets[1:], ends, strict=True):
        lines.append(f"{b - a} {' '.join(corners[a:b])}{end}")
    return ("\n".join(lines) + "\n").encode()


def _at_vertices(name: str, attribute: Attribute) -> bool:
    widths = {"normal": (3,), "uv": (2,), "colour": (3, 4)}
    return attribute.indices is None and attribute.values.shape[1] in widths.get(name, ())


def _face_colours(mesh: Mesh, kept: dict[str, Attribute]) -> dict[str, list[str]]:
    """The colour with which each row of a face ends, by the name of the attribute that holds it."""
    name = FACE_COLOUR if "colour" in kept else "colour"
    attribute = mesh.attributes.get(name)
    if attribute is None or attribute.indices is None or attribute.values.shape[1] not in (3, 4):
        return {}
    first = attribute.indices[mesh.offsets[:-1]]
    if not np.array_equal(attribute.indices, np.repeat(first, mesh.face_sizes)):
        return {}
    words = ["", *(" " + word for word in _colour_words(attribute.values))]
    return {name: [words[i + 1] for i in first.tolist()]}


def _words(rows: Array) -> list[str]:
    return [" ".join(map(repr, row)) for row in rows.tolist()]


def _colour_words(linear: Array) -> list[str]:
    """Integers from 0 to 255 where they hold the colours exactly, else numbers with a decimal point."""
    coded = as_exact_bytes(linear)
    return _words(to_display(linear) if coded is None else coded)
