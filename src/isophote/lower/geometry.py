"""Items into trees, instances and what belongs to their triangles."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.accel.accelerator import Built, build_accelerator
from isophote.convert.triangulate import Triangles, triangulate
from isophote.errors import SceneError
from isophote.kernels.accel.surface import ITEM_COLUMNS, SURFACES
from isophote.kernels.base.table import Packed
from isophote.lower.objects import join_objects, keep_alive
from isophote.lower.placement import IDENTITY, Place, place_instances
from isophote.shapes.mesh import Attribute, Mesh

__all__ = ["Part", "lower_geometry"]

FloatArray: TypeAlias = npt.NDArray[np.float32]
IntArray: TypeAlias = npt.NDArray[np.int32]
Matrix: TypeAlias = npt.NDArray[np.float64]

# A mesh used several times is still copied into the world's one tree if the copies stay below this many triangles: an
# instance costs every ray that comes near its box.
_BAKED_TRIANGLES = 65_536
# Of a tangent and the sign of the other axis.
_TANGENT_WIDTH = 4


class Part(NamedTuple):
    """An item made ready for lowering: its mesh, where it stands, its material's number, its number for the user, for
    each triangle (or None) the number of the light that it is, whether it will be moved, and whether a normal map lies
    on it."""

    mesh: Mesh
    matrix: Matrix
    material: int
    public: int
    lights: IntArray | None
    moving: bool = False
    mapped: bool = False


class _Rows:
    """Tables that grow part by part; meshes that occur again share their rows."""

    def __init__(self) -> None:
        self.chunks: list[npt.NDArray[Any]] = []
        self.count = 0
        self.known: dict[int, int] = {}

    def add(self, rows: npt.NDArray[Any]) -> int:
        first = self.count
        self.chunks.append(rows)
        self.count += len(rows)
        return first

    def once(self, owner: object, rows: npt.NDArray[Any]) -> int:
        if id(owner) not in self.known:
            self.known[id(owner)] = self.add(rows)
        return self.known[id(owner)]

    def table(self, width: int, dtype: type) -> npt.NDArray[Any]:
        shape = (0, width) if width else (0,)
        return np.ascontiguousarray(np.concatenate([np.zeros(shape, dtype), *self.chunks]), dtype)


class _SurfaceBuilder:
    """Collects the table SURFACES."""

    def __init__(self) -> None:
        self.items: list[tuple[int, ...]] = []
        self.normals, self.normal_corners = _Rows(), _Rows()
        self.uvs, self.uv_corners = _Rows(), _Rows()
        self.tangents, self.tangent_corners = _Rows(), _Rows()
        self.faces, self.lights = _Rows(), _Rows()

    def add_bare(self, material: int, public: int, light: int) -> None:
        """An item without triangles, and the light that it is, or −1."""
        lights = -1 if light < 0 else self.lights.add(np.array([light], np.int32))
        self.items.append((0, material, lights, -1, -1, -1, 0, public, -1))

    def add(self, part: Part, cut: Triangles, first_triangle: int, world: Matrix) -> None:
        """One item; `world` takes its normals from the mesh to where its object stands."""
        mesh, linear = part.mesh, world[:3, :3]
        # Placed corners turn over in a mirror; an instance's normals go by the inverse, which keeps them outward.
        turned_over = np.linalg.det(linear) < 0
        faces = -1 if len(cut.triangles) == mesh.face_count else self.faces.once(mesh, cut.face)
        lights = -1 if part.lights is None else self.lights.add(part.lights)
        self.items.append(
            (
                first_triangle,
                part.material,
                lights,
                self._normals(mesh, cut, linear, part.mapped),
                self._uvs(mesh, cut),
                faces,
                int(turned_over),
                part.public,
                self._tangents(mesh, cut, linear) if part.mapped else -1,
            )
        )

    def _normals(self, mesh: Mesh, cut: Triangles, linear: Matrix, mapped: bool) -> int:
        attribute = mesh.normals
        if attribute is None:
            return -1
        values = np.asarray(attribute.values[:, :3], np.float64)
        if not (linear == IDENTITY[:3, :3]).all():
            values = values @ np.linalg.inv(linear)
            if mapped:
                # Their lengths count beside those of tangents.
                values *= abs(np.linalg.det(linear)) ** (1 / 3)
            return self.normal_corners.add(_rows_of(attribute, mesh, cut, self.normals.add(_floats(values))))
        first = self.normals.once(mesh, _floats(values))
        return self.normal_corners.once(mesh, _rows_of(attribute, mesh, cut, first))

    def _uvs(self, mesh: Mesh, cut: Triangles) -> int:
        attribute = mesh.uvs
        if attribute is None:
            return -1
        first = self.uvs.once(mesh, _floats(attribute.values[:, :2]))
        return self.uv_corners.once(mesh, _rows_of(attribute, mesh, cut, first))

    def _tangents(self, mesh: Mesh, cut: Triangles, linear: Matrix) -> int:
        """First row of an item's tangents: those of its mesh, or such as MikkTSpace has them."""
        attribute = mesh.attributes.get("tangent")
        if attribute is None or attribute.values.shape[1] != _TANGENT_WIDTH:
            if mesh.uvs is None:
                return -1
            # Loaded where there is a normal map.
            from isophote.convert.tangents import tangents

            attribute = tangents(mesh)
        values = np.array(attribute.values, np.float64)
        values[:, :3] = values[:, :3] @ linear.T
        size = np.linalg.norm(values[:, :3], axis=1, keepdims=True)
        values[:, :3] /= np.where(size > 0, size, 1.0)
        return self.tangent_corners.add(_rows_of(attribute, mesh, cut, self.tangents.add(_floats(values))))

    def build(self, spans: IntArray, slack: FloatArray) -> Packed:
        return SURFACES.pack(
            items=np.array(self.items, np.int32).reshape(-1, ITEM_COLUMNS),
            spans=spans,
            slack=slack,
            normals=self.normals.table(3, np.float32),
            normal_corners=self.normal_corners.table(3, np.int32),
            uvs=self.uvs.table(2, np.float32),
            uv_corners=self.uv_corners.table(3, np.int32),
            tangents=self.tangents.table(_TANGENT_WIDTH, np.float32),
            tangent_corners=self.tangent_corners.table(3, np.int32),
            faces=self.faces.table(0, np.int32),
            triangle_lights=self.lights.table(0, np.int32),
        )


def _floats(values: npt.NDArray[Any]) -> FloatArray:
    return np.ascontiguousarray(values, np.float32)


def _rows_of(attribute: Attribute, mesh: Mesh, cut: Triangles, first: int) -> IntArray:
    """(t, 3) rows of an attribute at the corners of each triangle, counted from `first`; a corner without one gets a
    row of zeros' stand-in: the first."""
    rows = cut.triangles if attribute.indices is None else np.maximum(attribute.indices[cut.corners], 0)
    return np.ascontiguousarray(rows + np.int32(first), np.int32)


def _placed(part: Part) -> FloatArray:
    """Vertices in the world, in single precision."""
    vertices = part.mesh.vertices
    if (part.matrix == IDENTITY).all():
        return _floats(vertices)
    return _floats(vertices @ part.matrix[:3, :3].T + part.matrix[:3, 3])


class _World(NamedTuple):
    """Everything that stands in the world by itself, as one list of triangles."""

    positions: FloatArray
    triangles: IntArray


def _merge(pieces: Sequence[tuple[FloatArray, IntArray]]) -> _World:
    if len(pieces) == 0:
        return _World(np.zeros((0, 3), np.float32), np.zeros((0, 3), np.int32))
    if len(pieces) == 1:
        return _World(*pieces[0])
    starts = np.cumsum([0, *(len(positions) for positions, _ in pieces)])
    triangles = [t + np.int32(s) for (_, t), s in zip(pieces, starts, strict=False)]
    return _World(np.concatenate([p for p, _ in pieces]), np.concatenate(triangles))


class _Instance(NamedTuple):
    """An object's number, where it stands, and the first of its items and how many they are."""

    object: int
    place: Place
    items: tuple[int, int]


def _instance(objects: Sequence[Built], number: int, matrix: Matrix, public: int, items: tuple[int, int]) -> _Instance:
    return _Instance(number, Place(objects[number].bounds.astype(np.float64), matrix, public), items)


def lower_geometry(
    parts: Sequence[Part],
    bare: Sequence[tuple[int, int, int]] = (),
    threads: int | None = None,
    accelerator: str = "bvh",
) -> tuple[Packed, Packed, FloatArray]:
    """Trees (or other accelerators), instances and surfaces of all parts, and the world's bounds, (2, 3) float32, of
    which the least is above the greatest where there are none.

    What is used once, or often but small, becomes one tree in the world; what is left, and what will be moved, becomes
    instances of one tree a mesh. `bare` are material, number for the user and light (or −1) of items that have no
    triangles; they get the rows of the surfaces' items behind those of the parts. Raises `SceneError` where coordinates
    leave the range of single precision.
    """
    uses: dict[int, int] = {}
    for part in parts:
        uses[id(part.mesh)] = uses.get(id(part.mesh), 0) + 1
    cuts = {id(part.mesh): triangulate(part.mesh) for part in parts}

    def stands_alone(part: Part) -> bool:
        count = uses[id(part.mesh)]
        if part.moving:
            return False
        return count == 1 or count * len(cuts[id(part.mesh)].triangles) <= _BAKED_TRIANGLES

    surfaces = _SurfaceBuilder()
    objects: list[Built] = []
    instances: list[_Instance] = []
    pieces: list[tuple[FloatArray, IntArray]] = []
    first = 0
    for part in parts:
        if stands_alone(part):
            cut = cuts[id(part.mesh)]
            surfaces.add(part, cut, first, part.matrix)
            pieces.append((_placed(part), cut.triangles))
            first += len(cut.triangles)
    if pieces or not parts:
        objects.append(_build(accelerator, *_merge(pieces), threads))
        instances.append(_instance(objects, 0, IDENTITY, -1, (0, len(pieces))))
    shared: dict[int, int] = {}
    for part in parts:
        if not stands_alone(part):
            cut = cuts[id(part.mesh)]
            if id(part.mesh) not in shared:
                shared[id(part.mesh)] = len(objects)
                objects.append(_build(accelerator, _floats(part.mesh.vertices), cut.triangles, threads))
            number = shared[id(part.mesh)]
            instances.append(_instance(objects, number, part.matrix, part.public, (len(surfaces.items), 1)))
            surfaces.add(part, cut, 0, IDENTITY)
    for row in bare:
        surfaces.add_bare(*row)
    alone = len(instances) == 1 and not shared
    fields, tables = join_objects(accelerator, objects, [instance.object for instance in instances], alone=alone)
    geometry, slack, bounds = place_instances(fields, [instance.place for instance in instances], accelerator)
    spans = np.array([instance.items for instance in instances], np.int32).reshape(-1, 2)
    return keep_alive(geometry, tables), surfaces.build(spans, slack), bounds


def _build(accelerator: str, positions: FloatArray, triangles: IntArray, threads: int | None) -> Built:
    if not np.isfinite(positions).all():
        raise SceneError("an item's placed vertices leave the range of single precision (3.4e38); scale the scene down")
    return build_accelerator(accelerator, positions, triangles, threads)
