"""A mesh made from another one's corners, with its attributes and labels."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.errors import GeometryError
from isophote.shapes.mesh import Attribute, FaceLabels, Mesh

__all__ = ["Edit", "Longs", "chosen_faces", "unchanged"]

Longs: TypeAlias = npt.NDArray[np.int64]


class Edit(NamedTuple):
    """How a new mesh is made from an old one.

    `vertex` is for each new vertex the old one that it is, or -1; vertex number i of these -1 lies in the middle of the
    old vertices `middles[i]`. New face f has the corners `offsets[f]` to `offsets[f + 1]`: their new vertices
    `indices`, the old corners `corner` that they come from, or -1. `face` is the old face of each new one, or -1.
    """

    vertex: Longs
    indices: Longs
    offsets: Longs
    corner: Longs
    face: Longs
    middles: Sequence[Longs] = ()

    def made_from(self, old: Mesh) -> Mesh:
        """The new mesh. Raises `GeometryError` where it has no faces."""
        if len(self.face) == 0:
            raise GeometryError("nothing is left of the mesh: every face names a vertex twice")
        attributes = {name: self._attribute(old, attribute) for name, attribute in old.attributes.items()}
        labels = {
            name: FaceLabels(label.names, _picked(label.index, self.face, -1)) for name, label in old.labels.items()
        }
        points = self._rows(old.vertices)
        return Mesh.from_polygons(points, self.indices, self.offsets, attributes=attributes, labels=labels)

    def _attribute(self, old: Mesh, attribute: Attribute) -> Attribute:
        """Values at vertices stay there where each new vertex has one; else they become values at corners."""
        if attribute.indices is not None:
            return Attribute(attribute.values, _picked(attribute.indices, self.corner, -1))
        kept = np.flatnonzero(self.corner >= 0)
        was, now = old.indices[self.corner[kept]], self.vertex[self.indices[kept]]
        differ = np.flatnonzero(was != now)
        values = attribute.values
        if _all_equal(values[was[differ]], values[now[differ]]):
            return Attribute(self._rows(values))
        return Attribute(values, _picked(old.indices, self.corner, -1))

    def _rows(self, values: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """Values at the new vertices, from those at the old ones."""
        rows = values[self.vertex]
        new = np.flatnonzero(self.vertex < 0)
        for at, ring in zip(new, self.middles, strict=True):
            middle = np.mean(values[ring] / len(ring), axis=0) * len(ring)
            rows[at] = middle if np.issubdtype(values.dtype, np.floating) else np.rint(middle)
        return rows


def _picked(values: npt.NDArray[Any], places: Longs, missing: int) -> npt.NDArray[Any]:
    return np.where(places >= 0, values[places], missing)


def _all_equal(a: npt.NDArray[Any], b: npt.NDArray[Any]) -> bool:
    return np.array_equal(a, b, equal_nan=np.issubdtype(a.dtype, np.inexact))


def unchanged(mesh: Mesh) -> Edit:
    """The edit that makes the same mesh."""
    return Edit(
        np.arange(len(mesh.vertices)),
        mesh.indices.astype(np.int64),
        mesh.offsets,
        np.arange(len(mesh.indices)),
        np.arange(mesh.face_count),
    )


def chosen_faces(mesh: Mesh, keep: npt.NDArray[np.bool_]) -> Edit:
    """The edit that keeps the faces of a mask, (faces,), and all vertices."""
    corner = np.flatnonzero(np.repeat(keep, mesh.face_sizes))
    offsets = np.concatenate([np.zeros(1, np.int64), np.cumsum(mesh.face_sizes[keep])])
    return unchanged(mesh)._replace(
        indices=mesh.indices[corner].astype(np.int64), offsets=offsets, corner=corner, face=np.flatnonzero(keep)
    )
