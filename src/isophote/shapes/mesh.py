"""Polygon meshes: vertices, faces of any size, attributes and labels, kept as they were given."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any, TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.errors import GeometryError

__all__ = ["Attribute", "FaceLabels", "Mesh"]

FloatArray: TypeAlias = npt.NDArray[np.floating[Any]]
IntArray: TypeAlias = npt.NDArray[np.integer[Any]]

_LARGEST_INDEX = np.iinfo(np.int32).max


def _frozen(array: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """A read-only view, so that nobody's array is changed through a mesh, or a mesh through an array."""
    view = array.view()
    view.flags.writeable = False
    return view


def _own(array: npt.NDArray[Any], dtype: npt.DTypeLike) -> npt.NDArray[Any]:
    """The array in this type, copied if someone could still write to it."""
    typed = np.ascontiguousarray(array, dtype)
    return typed.copy() if _can_change(typed) else typed


def _can_change(array: npt.NDArray[Any]) -> bool:
    """Whether an array, or one that it is a view of, is writeable."""
    base: object = array
    while isinstance(base, np.ndarray):
        if base.flags.writeable:
            return True
        base = base.base
    return base is not None


@attrs.frozen(eq=False)
class Attribute:
    """Values at the vertices, or at the corners of the faces.

    `values` is (k, d). Without `indices` there is one row for each vertex; with `indices`, shape
    (corners,), corner `i` (in the order of `Mesh.indices`) has row `indices[i]`; -1 marks a corner that
    has none.
    """

    values: npt.NDArray[Any]
    indices: IntArray | None = None

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Attribute):
            return NotImplemented
        return _same(self.values, other.values) and _same(self.indices, other.indices)

    def __hash__(self) -> int:
        return hash((self.values.shape, self.indices is None))


@attrs.frozen(eq=False)
class FaceLabels:
    """One name for each face: its material, say. `index` is (m,), into `names`; -1 where a face has none."""

    names: tuple[str, ...]
    index: IntArray

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, FaceLabels):
            return NotImplemented
        return self.names == other.names and _same(self.index, other.index)

    def __hash__(self) -> int:
        return hash(self.names)


class Mesh:
    """A polygon mesh.

    `vertices` is (n, 3); `faces` an (m, k) array of vertex numbers or a sequence of lists of any length
    (3 or more). Nothing is merged, reordered or dropped. `attributes` maps a name to an `Attribute`
    (the standard ones are "normal" (k, 3), "tangent" (k, 4), "uv" (k, 2) and "colour" (k, 3 or 4), linear); `labels`
    maps "material" or "group" to `FaceLabels`. A plain (n, d) array of attributes is one row for each vertex.

    Raises `GeometryError` for non-finite coordinates, wrong shapes, faces out of range and no faces.
    """

    __slots__ = ("_attributes", "_indices", "_labels", "_offsets", "_vertices")

    def __init__(
        self,
        vertices: npt.ArrayLike,
        faces: npt.ArrayLike | Sequence[Sequence[int]],
        *,
        attributes: Mapping[str, Attribute | npt.ArrayLike] | None = None,
        labels: Mapping[str, FaceLabels] | None = None,
    ) -> None:
        indices, offsets = _flatten(faces)
        self._set(vertices, indices, offsets, attributes or {}, labels or {})

    @classmethod
    def from_polygons(
        cls,
        vertices: npt.ArrayLike,
        indices: npt.ArrayLike,
        offsets: npt.ArrayLike,
        *,
        attributes: Mapping[str, Attribute | npt.ArrayLike] | None = None,
        labels: Mapping[str, FaceLabels] | None = None,
    ) -> Mesh:
        """A mesh from flat corners: face `i` has vertices `indices[offsets[i]:offsets[i + 1]]`."""
        mesh = cls.__new__(cls)
        mesh._set(vertices, _integers(indices), _integers(offsets), attributes or {}, labels or {})
        return mesh

    def _set(
        self,
        vertices: npt.ArrayLike,
        indices: IntArray,
        offsets: IntArray,
        attributes: Mapping[str, Attribute | npt.ArrayLike],
        labels: Mapping[str, FaceLabels],
    ) -> None:
        points = _points(vertices)
        _check_faces(len(points), indices, offsets)
        self._vertices = _frozen(points)
        self._indices = _frozen(_own(indices, np.int32))
        self._offsets = _frozen(_own(offsets, np.int64))
        checked = {name: _attribute(name, a, len(points), len(indices)) for name, a in attributes.items()}
        self._attributes: Mapping[str, Attribute] = MappingProxyType(checked)
        self._labels: Mapping[str, FaceLabels] = MappingProxyType(
            {name: _checked_labels(name, label, len(offsets) - 1) for name, label in labels.items()}
        )

    @property
    def vertices(self) -> npt.NDArray[np.float64]:
        """(n, 3) float64 positions."""
        return self._vertices

    @property
    def indices(self) -> npt.NDArray[np.int32]:
        """(corners,) int32 vertex numbers of all faces, one after another."""
        return self._indices

    @property
    def offsets(self) -> npt.NDArray[np.int64]:
        """(m + 1,) int64: face `i` owns corners `offsets[i]` to `offsets[i + 1]`."""
        return self._offsets

    @property
    def face_count(self) -> int:
        """Number of faces, m."""
        return len(self._offsets) - 1

    @property
    def face_sizes(self) -> npt.NDArray[np.int64]:
        """(m,) number of corners of each face."""
        return np.diff(self._offsets)

    @property
    def faces(self) -> npt.NDArray[np.int32] | tuple[npt.NDArray[np.int32], ...]:
        """(m, k) int32 where all faces have k corners, else a tuple of m arrays."""
        sizes = self.face_sizes
        if (sizes == sizes[0]).all():
            return self._indices.reshape(-1, int(sizes[0]))
        return tuple(self._indices[a:b] for a, b in zip(self._offsets[:-1], self._offsets[1:], strict=True))

    @property
    def attributes(self) -> Mapping[str, Attribute]:
        """Every attribute by its name."""
        return self._attributes

    @property
    def labels(self) -> Mapping[str, FaceLabels]:
        """Every labelling of the faces by its name."""
        return self._labels

    @property
    def normals(self) -> Attribute | None:
        """The attribute "normal", (k, 3)."""
        return self._attributes.get("normal")

    @property
    def uvs(self) -> Attribute | None:
        """The attribute "uv", (k, 2), with the origin at the lower left."""
        return self._attributes.get("uv")

    @property
    def colours(self) -> Attribute | None:
        """The attribute "colour", (k, 3 or 4), linear."""
        return self._attributes.get("colour")

    @property
    def bounds(self) -> npt.NDArray[np.float64]:
        """(2, 3): least and greatest corner of the box of the vertices that faces use."""
        used = np.zeros(len(self._vertices), bool)
        used[self._indices] = True
        points = self._vertices if used.all() else self._vertices[used]
        return np.stack([points.min(axis=0), points.max(axis=0)])

    def with_(
        self,
        *,
        vertices: npt.ArrayLike | None = None,
        attributes: Mapping[str, Attribute | npt.ArrayLike] | None = None,
        labels: Mapping[str, FaceLabels] | None = None,
    ) -> Mesh:
        """The same faces with other vertices, attributes or labels."""
        return Mesh.from_polygons(
            self._vertices if vertices is None else vertices,
            self._indices,
            self._offsets,
            attributes=self._attributes if attributes is None else attributes,
            labels=self._labels if labels is None else labels,
        )

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Mesh):
            return NotImplemented
        return (
            _same(self._vertices, other._vertices)
            and _same(self._indices, other._indices)
            and _same(self._offsets, other._offsets)
            and dict(self._attributes) == dict(other._attributes)
            and dict(self._labels) == dict(other._labels)
        )

    def __hash__(self) -> int:
        return hash((self._vertices.shape, self._indices.tobytes()[:256]))

    def __reduce__(self) -> tuple[Any, ...]:
        return _restored, (self._vertices, self._indices, self._offsets, dict(self._attributes), dict(self._labels))

    def __repr__(self) -> str:
        if len(self._vertices) + self.face_count <= 64 and not self._attributes and not self._labels:
            faces = [[int(i) for i in face] for face in self.faces]
            return f"Mesh({self._vertices.tolist()}, {faces})"
        extra = "".join(f", {name}" for name in (*self._attributes, *self._labels))
        return f"<Mesh: {len(self._vertices):,} vertices, {self.face_count:,} faces{extra}>"


def _restored(
    vertices: FloatArray,
    indices: IntArray,
    offsets: IntArray,
    attributes: dict[str, Attribute],
    labels: dict[str, FaceLabels],
) -> Mesh:
    """A mesh from what `Mesh.__reduce__` took apart: for copies and other processes."""
    return Mesh.from_polygons(vertices, indices, offsets, attributes=attributes, labels=labels)


def _same(a: npt.NDArray[Any] | None, b: npt.NDArray[Any] | None) -> bool:
    if a is None or b is None:
        return a is b
    return a is b or np.array_equal(a, b)


def _integers(values: npt.ArrayLike) -> IntArray:
    array = np.asarray(values)
    if array.size == 0:
        return np.zeros(0, np.int64)
    if not np.issubdtype(array.dtype, np.integer):
        raise GeometryError(f"faces must be whole numbers, but they are {array.dtype}")
    return array.reshape(-1)


def _flatten(faces: npt.ArrayLike | Sequence[Sequence[int]]) -> tuple[IntArray, IntArray]:
    """Flat indices and offsets of a face array or of lists of any length."""
    if isinstance(faces, np.ndarray) and faces.ndim == 2:
        count, size = faces.shape
        return _integers(faces), np.arange(count + 1, dtype=np.int64) * size
    rows = [np.asarray(face) for face in faces]  # type: ignore[union-attr]
    sizes = np.array([row.size for row in rows], dtype=np.int64)
    offsets = np.concatenate([np.zeros(1, np.int64), np.cumsum(sizes)])
    return _integers(np.concatenate(rows) if rows else []), offsets


def _points(vertices: npt.ArrayLike) -> npt.NDArray[np.float64]:
    try:
        given = np.asarray(vertices, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise GeometryError(f"vertices must be numbers of shape (n, 3): {error}") from error
    if given.ndim != 2 or given.shape[1] != 3:
        raise GeometryError(f"vertices must have shape (n, 3), but have {given.shape}")
    if not np.isfinite(given).all():
        finite = np.isfinite(given).all(axis=1)
        bad = int(np.argmin(finite))
        raise GeometryError(f"vertex {bad} is not finite: {given[bad].tolist()} ({int((~finite).sum())} such in all)")
    return _own(given, np.float64)


def _check_faces(vertex_count: int, indices: IntArray, offsets: IntArray) -> None:
    if len(offsets) < 2:
        raise GeometryError("the mesh has no faces")
    if offsets[0] != 0 or offsets[-1] != len(indices):
        raise GeometryError(f"offsets must run from 0 to the number of corners, {len(indices)}")
    sizes = np.diff(offsets)
    if sizes.min() < 3:
        bad = int(np.argmax(sizes < 3))
        raise GeometryError(f"face {bad} has {int(sizes[bad])} corners; a face needs 3 or more")
    if vertex_count > _LARGEST_INDEX:
        raise GeometryError(f"{vertex_count:,} vertices are more than 32-bit faces can name")
    if indices.min() < 0 or indices.max() >= vertex_count:
        corner = int(np.argmax((indices < 0) | (indices >= vertex_count)))
        face = int(np.searchsorted(offsets, corner, side="right")) - 1
        raise GeometryError(
            f"face {face} names vertex {int(indices[corner])}, but the vertices are 0 to {vertex_count - 1}"
        )


def _attribute(name: str, given: Attribute | npt.ArrayLike, vertices: int, corners: int) -> Attribute:
    attribute = given if isinstance(given, Attribute) else Attribute(np.asarray(given))
    values, indices = np.asarray(attribute.values), attribute.indices
    if values.ndim == 1:
        values = values[:, None]
    if values.ndim != 2:
        raise GeometryError(f'attribute "{name}" must have shape (k, d), but has {values.shape}')
    if indices is None:
        if len(values) != vertices:
            raise GeometryError(f'attribute "{name}" has {len(values)} rows for {vertices} vertices')
        return Attribute(_frozen(_own(values, values.dtype)))
    indices = _integers(indices)
    if len(indices) != corners:
        raise GeometryError(f'attribute "{name}" has {len(indices)} indices for {corners} corners')
    if indices.min() < -1 or indices.max() >= len(values):
        raise GeometryError(f'attribute "{name}" names rows outside 0 to {len(values) - 1}')
    return Attribute(_frozen(_own(values, values.dtype)), _frozen(_own(indices, np.int32)))


def _checked_labels(name: str, labels: FaceLabels, faces: int) -> FaceLabels:
    index = np.asarray(labels.index)
    if index.shape != (faces,):
        raise GeometryError(f'labels "{name}" have shape {index.shape} for {faces} faces')
    if index.min() < -1 or index.max() >= len(labels.names):
        raise GeometryError(f'labels "{name}" name entries outside 0 to {len(labels.names) - 1}')
    return FaceLabels(tuple(labels.names), _frozen(_own(index, np.int32)))
