"""Meshes as primitives of glTF files."""

from __future__ import annotations

from typing import Any, TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.convert.triangulate import triangulate
from isophote.errors import FileError
from isophote.io.dropped import warn_dropped
from isophote.io.files import StrPath
from isophote.io.gltf.build import Builder
from isophote.shapes.mesh import Attribute, Mesh

__all__ = ["MeshWriter"]

Array: TypeAlias = npt.NDArray[Any]

_NAMES = {"normal": "NORMAL", "tangent": "TANGENT", "uv": "TEXCOORD_0", "colour": "COLOR_0"}
_WIDTHS = {"normal": (3,), "tangent": (4,), "uv": (2,), "colour": (3, 4)}
# What stands at the corners that have no value. There is no neutral direction.
_NEUTRAL = {"uv": 0.0, "colour": 1.0}


@attrs.define
class MeshWriter:
    """Writes the data of each mesh once, however many materials and places it has."""

    path: StrPath
    builder: Builder
    _primitives: dict[int, dict[str, Any]] = attrs.field(init=False, factory=dict)

    def primitive(self, mesh: Mesh) -> dict[str, Any]:
        """A primitive, as JSON, without a material. Raises `FileError` for coordinates beyond 32-bit floats."""
        if id(mesh) not in self._primitives:
            self._primitives[id(mesh)] = self._written(mesh)
        return dict(self._primitives[id(mesh)])

    def _written(self, mesh: Mesh) -> dict[str, Any]:
        kept = {name: attribute for name, attribute in mesh.attributes.items() if _fits(name, attribute)}
        warn_dropped(mesh, self.path, "glTF", attributes=kept, labels=())
        corners = triangulate(mesh).corners.ravel()
        vertices, rows, triangles = _split(mesh, kept, corners)
        with np.errstate(over="ignore"):
            points = mesh.vertices[vertices].astype(np.float32)
        if not np.isfinite(points).all():
            raise FileError(self.path, "has coordinates beyond the 32-bit floats of glTF; scale the scene down")
        attributes = {"POSITION": self.builder.add_array(points, bounds=True)}
        for name, attribute in kept.items():
            attributes[_NAMES[name]] = self.builder.add_array(_values(name, attribute, rows[name]))
        # The largest 16-bit number is kept for restarting strips.
        kind = np.uint16 if len(points) <= 65535 else np.uint32
        return {"attributes": attributes, "indices": self.builder.add_array(triangles.astype(kind))}


def _fits(name: str, attribute: Attribute) -> bool:
    if len(attribute.values) == 0 or attribute.values.shape[1] not in _WIDTHS.get(name, ()):
        return False
    return name in _NEUTRAL or attribute.indices is None or bool((attribute.indices >= 0).all())


def _split(mesh: Mesh, attributes: dict[str, Attribute], corners: Array) -> tuple[Array, dict[str, Array], Array]:
    """Which vertex and which row of each attribute every written vertex has, and the written triangles.

    Vertices keep their order and number where no attribute differs from corner to corner; otherwise each
    combination that occurs becomes one vertex.
    """
    split = {name: attribute.indices for name, attribute in attributes.items() if attribute.indices is not None}
    if not split:
        every = np.arange(len(mesh.vertices))
        return every, dict.fromkeys(attributes, every), mesh.indices[corners]
    columns = np.stack([mesh.indices[corners], *(indices[corners] for indices in split.values())])
    combinations, triangles = np.unique(columns, axis=1, return_inverse=True)
    vertices = combinations[0]
    rows = dict.fromkeys(attributes, vertices)
    rows |= dict(zip(split, combinations[1:], strict=True))
    return vertices, rows, triangles.reshape(-1)


def _values(name: str, attribute: Attribute, rows: Array) -> npt.NDArray[np.float32]:
    values = attribute.values[rows].astype(np.float64)
    missing = rows < 0
    if missing.any():
        values[missing] = _NEUTRAL[name]
    if name == "uv":
        values[:, 1] = 1.0 - values[:, 1]
    with np.errstate(over="ignore"):
        return np.nan_to_num(values.astype(np.float32))
