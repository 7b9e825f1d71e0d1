"""Items into trees, instances and what belongs to their triangles."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.accel.accelerator import Built, build_accelerator
from isophote.accel.tree import build_boxes
from isophote.convert.triangulate import Triangles, triangulate
from isophote.errors import SceneError
from isophote.kernels.accel.geometry import GEOMETRY
from isophote.kernels.accel.surface import SURFACES
from isophote.kernels.base.table import Packed
from isophote.lower.objects import join_objects, keep_alive
from isophote.shapes.mesh import Attribute, Mesh

__all__ = ["Part", "lower_geometry"]

FloatArray: TypeAlias = npt.NDArray[np.float32]
IntArray: TypeAlias = npt.NDArray[np.int32]
Matrix: TypeAlias = npt.NDArray[np.float64]

# A mesh used several times is still copied into the world's one tree if the copies stay below this many triangles: an
# instance costs every ray that comes near its box.
_BAKED_TRIANGLES = 65_536
_ROUNDING = 32 * 2.0**-24
_IDENTITY = np.eye(4)


class Part(NamedTuple):
    """An item made ready for lowering: its mesh, where it stands, its material's number, its number for the user, and
    for each triangle (or None) the number of the light that it is."""

    mesh: Mesh
    matrix: Matrix
    material: int
    public: int
    lights: IntArray | None


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
        self.faces, self.lights = _Rows(), _Rows()

    def add_bare(self, material: int, public: int, light: int) -> None:
        """An item without triangles, and the light that it is, or −1."""
        lights = -1 if light < 0 else self.lights.add(np.array([light], np.int32))
        self.items.append((0, material, lights, -1, -1, -1, 0, public))

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
                self._normals(mesh, cut, linear),
                self._uvs(mesh, cut),
                faces,
                int(turned_over),
                part.public,
            )
        )

    def _normals(self, mesh: Mesh, cut: Triangles, linear: Matrix) -> int:
        attribute = mesh.normals
        if attribute is None:
            return -1
        values = np.asarray(attribute.values[:, :3], np.float64)
        if not (linear == _IDENTITY[:3, :3]).all():
            values = values @ np.linalg.inv(linear)
            return self.normal_corners.add(_rows_of(attribute, mesh, cut, self.normals.add(_floats(values))))
        first = self.normals.once(mesh, _floats(values))
        return self.normal_corners.once(mesh, _rows_of(attribute, mesh, cut, first))

    def _uvs(self, mesh: Mesh, cut: Triangles) -> int:
        attribute = mesh.uvs
        if attribute is None:
            return -1
        first = self.uvs.once(mesh, _floats(attribute.values[:, :2]))
        return self.uv_corners.once(mesh, _rows_of(attribute, mesh, cut, first))

    def build(self, spans: IntArray, slack: FloatArray) -> Packed:
        return SURFACES.pack(
            items=np.array(self.items, np.int32).reshape(-1, 8),
            spans=spans,
            slack=slack,
            normals=self.normals.table(3, np.float32),
            normal_corners=self.normal_corners.table(3, np.int32),
            uvs=self.uvs.table(2, np.float32),
            uv_corners=self.uv_corners.table(3, np.int32),
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
    if (part.matrix == _IDENTITY).all():
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


def lower_geometry(
    parts: Sequence[Part],
    bare: Sequence[tuple[int, int, int]] = (),
    threads: int | None = None,
    accelerator: str = "bvh",
) -> tuple[Packed, Packed, FloatArray]:
    """Trees (or other accelerators), instances and surfaces of all parts, and the world's bounds, (2, 3) float32, of
    which the least is above the greatest where there are none.

    What is used once, or often but small, becomes one tree in the world; what is left becomes instances of one tree a
    mesh. `bare` are material, number for the user and light (or −1) of items that have no triangles; they get the rows
    of the surfaces' items behind those of the parts. Raises `SceneError` where coordinates leave the range of single
    precision.
    """
    uses: dict[int, int] = {}
    for part in parts:
        uses[id(part.mesh)] = uses.get(id(part.mesh), 0) + 1
    cuts = {id(part.mesh): triangulate(part.mesh) for part in parts}

    def stands_alone(part: Part) -> bool:
        count = uses[id(part.mesh)]
        return count == 1 or count * len(cuts[id(part.mesh)].triangles) <= _BAKED_TRIANGLES

    surfaces = _SurfaceBuilder()
    objects: list[Built] = []
    instances: list[tuple[int, Matrix, int, int]] = []  # object, matrix, first item, items
    pieces: list[tuple[FloatArray, IntArray]] = []
    first = 0
    for part in parts:
        if stands_alone(part):
            cut = cuts[id(part.mesh)]
            surfaces.add(part, cut, first, part.matrix)
            pieces.append((_placed(part), cut.triangles))
            first += len(cut.triangles)
    if pieces or not parts:
        instances.append((0, _IDENTITY, 0, len(pieces)))
        objects.append(_build(accelerator, *_merge(pieces), threads))
    shared: dict[int, int] = {}
    for part in parts:
        if not stands_alone(part):
            cut = cuts[id(part.mesh)]
            if id(part.mesh) not in shared:
                shared[id(part.mesh)] = len(objects)
                objects.append(_build(accelerator, _floats(part.mesh.vertices), cut.triangles, threads))
            instances.append((shared[id(part.mesh)], part.matrix, len(surfaces.items), 1))
            surfaces.add(part, cut, 0, _IDENTITY)
    for row in bare:
        surfaces.add_bare(*row)
    geometry, slack, bounds = _instances(accelerator, objects, instances)
    spans = np.array([row[2:] for row in instances], np.int32).reshape(-1, 2)
    return geometry, surfaces.build(spans, slack), bounds


def _build(accelerator: str, positions: FloatArray, triangles: IntArray, threads: int | None) -> Built:
    if not np.isfinite(positions).all():
        raise SceneError("an item's placed vertices leave the range of single precision (3.4e38); scale the scene down")
    return build_accelerator(accelerator, positions, triangles, threads)


def _instances(
    accelerator: str, objects: Sequence[Built], instances: Sequence[tuple[int, Matrix, int, int]]
) -> tuple[Packed, FloatArray, FloatArray]:
    """The tables of instances, with the rounding that each one's transform brings, and the world's bounds."""
    count = len(instances)
    to_world = np.zeros((count, 12), np.float32)
    to_object = np.zeros((count, 12), np.float32)
    boxes = np.zeros((count, 2, 3), np.float32)
    identity = np.zeros(count, np.uint8)
    slack = np.zeros(count, np.float32)
    for k, (number, matrix, _, _) in enumerate(instances):
        to_world[k] = matrix[:3].reshape(-1)
        to_object[k] = np.linalg.inv(matrix)[:3].reshape(-1)
        identity[k] = (matrix == _IDENTITY).all()
        boxes[k], slack[k] = _placed_box(objects[number].bounds.astype(np.float64), matrix, bool(identity[k]))
    top = build_boxes(boxes[:, 0], boxes[:, 1]) if count > 1 else None
    geometry = GEOMETRY.pack(
        **join_objects(accelerator, objects, [row[0] for row in instances]),
        to_object=to_object,
        to_world=to_world,
        identity=identity,
        top_nodes=top.nodes if top else np.zeros(0, np.float32),
        top_items=top.blocks.astype(np.int32, copy=False) if top else np.zeros(0, np.int32),
    )
    geometry = keep_alive(geometry, [built.tables for built in objects])
    return geometry, slack, np.stack([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)])


def _placed_box(box: Matrix, matrix: Matrix, identity: bool) -> tuple[Matrix, float]:
    """An instance's box in the world, widened by its rounding, and that rounding."""
    if identity:
        return box, 0.0
    corners = np.array([[box[i, 0], box[j, 1], box[k, 2], 1.0] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
    placed = corners @ matrix[:3].T
    local = float(np.abs(box).max())
    there, back = np.abs(matrix[:3]), np.abs(np.linalg.inv(matrix)[:3])
    stretch = float(there[:, :3].sum(axis=1).max())
    far = np.abs(placed).max(axis=0)
    # Rays come back to the object with rounding of their own, which the transform then stretches.
    returned = float((there[:, :3] @ (back[:, :3] @ far + back[:, 3])).max())
    slack = _ROUNDING * (stretch * local + float(there[:, 3].max()) + float(far.max()) + returned)
    return np.stack([placed.min(axis=0) - slack, placed.max(axis=0) + slack]), slack
