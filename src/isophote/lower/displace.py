"""Meshes displaced by textures."""

from __future__ import annotations

from typing import Any, TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.convert.dice import Diced, Measure, dice, weld_places
from isophote.convert.triangulate import Triangles, triangulate
from isophote.errors import GeometryError
from isophote.lower.texture_probe import texture_values
from isophote.scene.displacement import MOST_TRIANGLES, Displacement
from isophote.scene.texture import Texture
from isophote.shapes.mesh import Attribute, FaceLabels, Mesh

__all__ = ["DEFAULT_EDGES", "displace", "displaced_mesh", "edge_measure"]

Doubles: TypeAlias = npt.NDArray[np.float64]
Longs: TypeAlias = npt.NDArray[np.int64]

# How many edges span the box around a mesh, where nobody says.
DEFAULT_EDGES = 256
_SAME = 1e-6
_XYZ = 3


def displace(
    mesh: Mesh,
    texture: Texture,
    scale: float = 1.0,
    *,
    midlevel: float = 0.0,
    edge: float | None = None,
    most: int = MOST_TRIANGLES,
) -> Mesh:
    """A mesh cut into triangles with edges no longer than `edge` and moved along its normals by a texture.

    Vertices go to P + `scale` (h − `midlevel`) n, with h the texture's red channel at their texture coordinates and
    places, and n the blended normal, of length 1. One vertex for each place: where corners at a place differ in
    normals or in what the texture says, means count, weighted by angles, so that a closed mesh stays closed. Without
    `edge`, 1/256 of the diagonal of the mesh's box. The result has triangles, new normals, smooth wherever they were
    (everywhere if the mesh had none), and the other attributes and labels, but tangents.

    Raises `GeometryError` where it would need more than `most` triangles.
    """
    if not isinstance(mesh, Mesh):
        raise GeometryError(f"displace: only a Mesh is cut, not a {type(mesh).__name__}; to_mesh makes one of a field")
    settings = Displacement(texture, scale, midlevel, edge, most=most)
    return displaced_mesh(mesh, settings, edge_measure(mesh, settings.edge))


def edge_measure(mesh: Mesh, edge: float | None) -> Measure:
    """Lengths of edges in parts of `edge`, or of 1/256 of the diagonal of the mesh's box."""
    if edge is None:
        edge = float(np.linalg.norm(mesh.bounds[1] - mesh.bounds[0])) / DEFAULT_EDGES or 1.0
    longest = edge

    def measure(a: Doubles, b: Doubles) -> Doubles:
        lengths: Doubles = np.linalg.norm(b - a, axis=1) / longest
        return lengths

    return measure


def displaced_mesh(mesh: Mesh, settings: Displacement, measure: Measure) -> Mesh:
    """The mesh cut as `measure` wants and displaced."""
    cut = triangulate(mesh)
    columns = _Columns.of(mesh, cut)
    points, triangles = weld_places(mesh.vertices, cut.triangles)
    if columns.normals is None:
        columns = attrs.evolve(columns, normals=_vertex_normals(points, triangles)[triangles])
    diced = dice(points, triangles, columns.stacked(), measure, settings.most)
    parts = columns.unstacked(diced.values)
    moved = _moved(diced, parts, settings, mesh.uvs is not None)
    kept = {name: _flat(values) for name, values in parts.others.items()}
    smooth = _groups(diced.triangles, parts.normals) if mesh.normals is not None else diced.triangles
    kept["normal"] = Attribute(_vertex_normals(moved, diced.triangles, smooth), smooth.reshape(-1))
    if mesh.uvs is not None:
        kept["uv"] = _flat(parts.uvs)
    face = cut.face[diced.parent]
    labels = {name: FaceLabels(label.names, label.index[face]) for name, label in mesh.labels.items()}
    return Mesh(moved, diced.triangles, attributes=kept, labels=labels)


@attrs.frozen
class _Columns:
    """Values at the corners of triangles, (t, 3, d) each."""

    uvs: Doubles
    normals: Any
    others: dict[str, Doubles]

    @classmethod
    def of(cls, mesh: Mesh, cut: Triangles) -> _Columns:
        corners = {name: _at_corners(attribute, cut) for name, attribute in mesh.attributes.items()}
        uvs, normals = corners.pop("uv", None), corners.pop("normal", None)
        # What is along the surface turns with it.
        corners.pop("tangent", None)
        if uvs is None:
            uvs = np.zeros((len(cut.triangles), 3, 2))
        return cls(uvs[..., :2], None if normals is None else normals[..., :3], corners)

    def stacked(self) -> Doubles:
        return np.concatenate([self.uvs, self.normals, *self.others.values()], axis=2)

    def unstacked(self, values: Doubles) -> _Columns:
        widths = [2, _XYZ, *(part.shape[2] for part in self.others.values())]
        uvs, normals, *others = np.split(values, np.cumsum(widths)[:-1], axis=2)
        return _Columns(uvs, normals, dict(zip(self.others, others, strict=True)))


def _at_corners(attribute: Attribute, cut: Triangles) -> Doubles:
    rows = cut.triangles if attribute.indices is None else np.maximum(attribute.indices[cut.corners], 0)
    values: Doubles = attribute.values[rows].astype(np.float64)
    return values


def _flat(values: Doubles) -> Attribute:
    """Values at corners as an attribute."""
    rows = values.reshape(-1, values.shape[2]).astype(np.float32)
    return Attribute(rows, np.arange(len(rows)))


def _angles(points: Doubles, triangles: Longs) -> Doubles:
    """(t, 3): angle of each triangle at each corner."""
    places = points[triangles]
    angles = np.empty(triangles.shape)
    for k in range(3):
        a, b = places[:, (k + 1) % 3] - places[:, k], places[:, (k + 2) % 3] - places[:, k]
        angles[:, k] = np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), (a * b).sum(axis=1))
    return angles


def _sums(rows: Longs, values: Doubles, count: int) -> Doubles:
    """Sums (count, d) of the values (k, d) that go to each row."""
    return np.stack([np.bincount(rows, values[:, k], count) for k in range(values.shape[1])], axis=1)


def _unit(vectors: Doubles) -> Doubles:
    size = np.linalg.norm(vectors, axis=-1, keepdims=True)
    unit: Doubles = np.divide(vectors, size, out=np.zeros_like(vectors), where=size > 0)
    return unit


def _vertex_normals(points: Doubles, triangles: Longs, rows: Longs | None = None) -> Doubles:
    """Unit normals by the angles of the triangles around each vertex, or around what `rows` (t, 3) number."""
    rows = triangles if rows is None else rows
    places = points[triangles]
    faces = _unit(np.cross(places[:, 1] - places[:, 0], places[:, 2] - places[:, 0]))
    weighted = (_angles(points, triangles)[:, :, None] * faces[:, None]).reshape(-1, 3)
    count = int(rows.max()) + 1 if rows is not triangles else len(points)
    return _unit(_sums(rows.reshape(-1), weighted, count))


def _groups(triangles: Longs, normals: Doubles) -> Longs:
    """(t, 3): one number for corners at a vertex with the same normal."""
    rounded = np.round(_unit(normals.reshape(-1, 3)) / _SAME).astype(np.int64)
    keys = np.concatenate([triangles.reshape(-1, 1), rounded], axis=1)
    order = np.lexsort(keys.T[::-1])
    differs = (np.diff(keys[order], axis=0) != 0).any(axis=1)
    numbers = np.empty(len(keys), np.int64)
    numbers[order] = np.concatenate([[0], np.cumsum(differs)])
    return numbers.reshape(-1, 3)


def _moved(diced: Diced, parts: _Columns, settings: Displacement, has_uvs: bool) -> Doubles:
    """The vertices where the texture moves them."""
    corners, count = diced.triangles.reshape(-1), len(diced.points)
    weights = np.maximum(_angles(diced.points, diced.triangles), 1e-12).reshape(-1, 1)
    normals = _unit(_sums(corners, weights * _unit(parts.normals.reshape(-1, 3)), count))
    heights = _heights(diced, parts.uvs.reshape(-1, 2) if has_uvs else None, settings.texture)
    means = _sums(corners, weights * heights[:, None], count) / np.maximum(_sums(corners, weights, count), 1e-300)
    with np.errstate(over="ignore", invalid="ignore"):
        moved: Doubles = diced.points + settings.scale * (means - settings.midlevel) * normals
    if not np.isfinite(moved).all():
        raise GeometryError("displacement: the texture moves the surface beyond all numbers; give a smaller scale")
    return moved


def _heights(diced: Diced, uvs: Doubles | None, texture: Texture) -> Doubles:
    """The texture's red channel at every corner, asked once where corners at a place agree."""
    corners = diced.triangles.reshape(-1)
    if uvs is None:
        values: Doubles = texture_values(texture, own=diced.points)[:, 0].astype(np.float64)
        return values[corners]
    first = np.zeros(len(diced.points), np.int64)
    first[corners[::-1]] = np.arange(len(corners))[::-1]
    at_first = texture_values(texture, uvs[first], diced.points)[:, 0].astype(np.float64)
    heights: Doubles = at_first[corners]
    other = np.flatnonzero((uvs != uvs[first[corners]]).any(axis=1))
    if len(other):
        heights[other] = texture_values(texture, uvs[other], diced.points[corners[other]])[:, 0]
    return heights
