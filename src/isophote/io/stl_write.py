"""Writing STL, binary and text: triangles in single precision, with the normals of their planes."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from isophote.convert.triangulate import triangulate
from isophote.errors import FileError
from isophote.io.dropped import warn_dropped
from isophote.io.files import StrPath
from isophote.shapes.mesh import Mesh

__all__ = ["encode_stl"]

_FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
# A binary file must not begin with "solid", or some programs take it for text.
_TITLE = b"binary STL by Isophote"
_MOST = 2**32 - 1


def encode_stl(mesh: Mesh, path: StrPath, *, binary: bool = True) -> bytes:
    """The bytes of an STL file; `path` is for messages.

    Polygons are cut into triangles; coordinates are rounded to 32 bits in a binary file and kept in a text.
    Runs of one label "group" are the solids of a text. What STL cannot hold is left out, with an
    `IsophoteWarning`. Raises `FileError` for coordinates beyond 32 bits.
    """
    warn_dropped(mesh, path, "STL", attributes=("normal",), labels=() if binary else ("group",))
    triangles, face = _triangles(mesh)
    corners = mesh.vertices[triangles]
    if binary:
        return _encode_binary(path, corners)
    return _encode_text(corners, _solids(mesh, face))


def _triangles(mesh: Mesh) -> tuple[npt.NDArray[np.int32], npt.NDArray[np.int32]]:
    if (mesh.face_sizes == 3).all():
        return mesh.indices.reshape(-1, 3), np.arange(mesh.face_count, dtype=np.int32)
    cut = triangulate(mesh)
    return cut.triangles, cut.face


def _normals(corners: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """(m, 3): unit normals by the right-hand rule, 0 for a triangle without area."""
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    # Scaled to 1 first, so that the product of very short or very long edges stays within range.
    longest = np.maximum(np.abs(a).max(axis=1), np.abs(b).max(axis=1))[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        normal = np.cross(a / longest, b / longest)
        normal /= np.linalg.norm(normal, axis=1)[:, None]
    return np.nan_to_num(normal, nan=0.0, posinf=0.0, neginf=0.0)


def _encode_binary(path: StrPath, corners: npt.NDArray[np.float64]) -> bytes:
    if len(corners) > _MOST:
        raise FileError(path, f"{len(corners):,} triangles are more than a binary STL can count")
    facets = np.zeros(len(corners), _FACET)
    with np.errstate(over="ignore"):
        facets["corners"] = corners
    if not np.isfinite(facets["corners"]).all():
        largest = float(np.abs(corners).max())
        raise FileError(path, f"coordinates of {largest:g} are beyond binary STL (3.4e38); scale the mesh down")
    facets["normal"] = _normals(corners)
    return _TITLE.ljust(80) + len(corners).to_bytes(4, "little") + facets.tobytes()


def _solids(mesh: Mesh, face: npt.NDArray[np.int32]) -> list[tuple[str, int, int]]:
    """Runs of triangles of one group: name, first, last + 1."""
    groups = mesh.labels.get("group")
    if groups is None:
        return [("", 0, len(face))]
    label = groups.index[face]
    cuts = [0, *(np.flatnonzero(np.diff(label)) + 1).tolist(), len(label)]
    names = [" ".join(groups.names[label[a]].split()) if label[a] >= 0 else "" for a in cuts[:-1]]
    return list(zip(names, cuts[:-1], cuts[1:], strict=True))


def _encode_text(corners: npt.NDArray[np.float64], solids: list[tuple[str, int, int]]) -> bytes:
    rows: npt.NDArray[Any] = np.concatenate([_normals(corners), corners.reshape(-1, 9)], axis=1)
    facet = "  facet normal %r %r %r\n    outer loop\n" + "      vertex %r %r %r\n" * 3 + "    endloop\n  endfacet\n"
    parts = []
    for name, first, last in solids:
        body = "".join(facet % tuple(row) for row in rows[first:last].tolist())
        parts.append(f"solid {name}\n{body}endsolid {name}\n")
    return "".join(parts).encode()
