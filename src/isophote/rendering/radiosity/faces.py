"""The surfaces of a scene as flat one-sided faces: what radiosity cuts into patches."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.analysis.connectivity.topology import topology
from isophote.convert.triangulate import triangulate
from isophote.errors import RenderError
from isophote.lower.displaced import displaced
from isophote.lower.lights import rectangle_mesh
from isophote.lower.materials import emission_of, emission_texture_of
from isophote.lower.texture_probe import texture_values
from isophote.rendering.radiosity.meshes import surface_mesh
from isophote.scene.cutout import Cutout
from isophote.scene.light import RectLight
from isophote.scene.material import Emitter, Material
from isophote.scene.nearest import nearest_principled
from isophote.scene.relief import unturned
from isophote.scene.scene import Scene
from isophote.scene.texture import Texture
from isophote.shapes.mesh import Attribute, Mesh

__all__ = ["Around", "Faces", "Painted", "bounded", "faces_of", "looked_up"]

Points: TypeAlias = npt.NDArray[np.float64]

# A quad counts as a parallelogram if its fourth corner is where the others put it, to this part of its size.
_FLAT = 1e-6


class Painted(NamedTuple):
    """A texture, and the map from the world to the space of the shape that it is on, (4, 4)."""

    texture: Texture
    to_own: Points


class Around(NamedTuple):
    """Places (n, k) and the half-axes of what is looked at around them (n, 2, k)."""

    middle: Points
    axes: Points


@attrs.frozen(eq=False)
class Faces:
    """n triangles and parallelograms, each with one side that sends and receives light.

    `corners` (n, 4, 3), the last of a triangle's unused, counterclockwise as seen from the side; `sides` (n,) 3 or 4;
    `normals` (n, 3); `uvs` (n, 4, 2); `albedo`, `emission` (n, 3), the latter π times the radiance; `texture`, `glow`
    (n,): rows of `textures` that multiply the albedo and the emission, or −1; `item`, `primitive` (n,): what they are
    part of; `side` (n,): 1 behind a surface, else 0; `smooth` (n,): whether light is blended with that of neighbours
    that lie in other planes; `meshes`: the meshes that block light, placed in the world, `solid`: which of them are
    closed and turned outward.
    """

    corners: Points
    sides: npt.NDArray[np.uint8]
    normals: Points
    uvs: Points
    albedo: Points
    emission: Points
    texture: npt.NDArray[np.int64]
    glow: npt.NDArray[np.int64]
    item: npt.NDArray[np.int64]
    primitive: npt.NDArray[np.int64]
    side: npt.NDArray[np.int64]
    smooth: npt.NDArray[np.bool_]
    textures: tuple[Painted, ...]
    meshes: tuple[Mesh, ...]
    solid: npt.NDArray[np.bool_]

    @property
    def areas(self) -> Points:
        """(n,)."""
        cross = np.cross(self.corners[:, 1] - self.corners[:, 0], self.corners[:, 2] - self.corners[:, 0])
        areas: Points = np.linalg.norm(cross, axis=1) * np.where(self.sides == 3, 0.5, 1.0)
        return areas


class _Surface:
    """A material as radiosity knows it."""

    def __init__(self, material: Material, name: str) -> None:
        radiance, self.shines_behind = emission_of(material)
        self.albedo, self.emission = np.zeros(3), np.pi * np.array(radiance)
        self.texture: Texture | None = None
        self.glow = emission_texture_of(material)
        material = unturned(material.material if isinstance(material, Cutout) else material)
        if isinstance(material, Emitter):
            if material.body is None:
                return
            material = unturned(material.body)
        shown = nearest_principled(material)
        self.albedo, self.texture = np.array(shown.colour), shown.colour_texture
        if (self.albedo > 1).any():
            raise RenderError(f"{name}: albedo {tuple(self.albedo)} reflects more than it receives; give 1 at most")


def bounded(scene: Scene) -> Points:
    """(2, 3): the box around all items that have bounds. Raises `RenderError` where none has."""
    boxes = [item.bounds for item in scene.items if np.isfinite(item.bounds).all()]
    if not boxes:
        raise RenderError("Radiosity: no item has bounds; cut endless ones, as by field & iso.box(...)")
    return np.stack([np.min([box[0] for box in boxes], axis=0), np.max([box[1] for box in boxes], axis=0)])


def faces_of(scene: Scene, cell: float) -> Faces:
    """The faces of all items and rectangle lights of `scene`; fields are meshed with cells of `cell` metres.

    Endless planes end three diagonals of all else away. A closed mesh that is turned outward has faces on its outside
    only, any other on both sides. Raises `RenderError` for shapes without bounds and materials that reflect more than
    they receive.
    """
    parts: list[dict[str, npt.NDArray[np.generic]]] = []
    textures: list[Painted] = []
    meshes: list[Mesh] = []
    solid: list[bool] = []
    around = bounded(scene)
    for number, item in enumerate(displaced(scene).items):
        name = f"items[{number}]"
        mesh = surface_mesh(item, cell, around, name)
        surface = _Surface(item.material, name)
        solid.append(_add(parts, textures, meshes, mesh, item.transform.matrix, surface, number))
    for number, light in enumerate(scene.lights, start=len(scene.items)):
        if isinstance(light, RectLight):
            surface = _Surface(Emitter(light.radiance_rgb, two_sided=light.two_sided), f"lights[{number}]")
            matrix = light.transform.matrix
            solid.append(_add(parts, textures, meshes, rectangle_mesh(light), matrix, surface, number))
    if not parts:
        raise RenderError("Radiosity: the scene has no surfaces")
    joined = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    return Faces(**joined, textures=tuple(textures), meshes=tuple(meshes), solid=np.array(solid))


def _add(
    parts: list[dict[str, npt.NDArray[np.generic]]],
    textures: list[Painted],
    meshes: list[Mesh],
    mesh: Mesh,
    matrix: Points,
    surface: _Surface,
    number: int,
) -> bool:
    """The faces of one mesh, its front sides and, if they can be seen, its back sides. Returns whether it is solid."""
    placed = mesh.vertices @ matrix[:3, :3].T + matrix[:3, 3]
    turned = bool(np.linalg.det(matrix[:3, :3]) < 0)
    meshes.append(Mesh.from_polygons(placed, mesh.indices, mesh.offsets))
    corners, uvs, sides, primitive = _flat_faces(mesh, placed)
    edge1, edge2 = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    normals = np.cross(edge1, edge2)
    length = np.linalg.norm(normals, axis=1)
    real = length > 0
    corners, uvs, sides, primitive = corners[real], uvs[real], sides[real], primitive[real]
    normals = normals[real] / length[real, None]
    texture, glow = (_painted(textures, one, matrix) for one in (surface.texture, surface.glow))
    report = topology(mesh)
    solid = report.closed and report.oriented and _volume(mesh) > 0
    count = len(sides)
    for behind in (False, True):
        if behind and solid:
            break
        emission = surface.emission if not behind or surface.shines_behind else np.zeros(3)
        reverse = behind != turned
        parts.append(
            {
                "corners": _reversed(corners, sides) if reverse else corners,
                "uvs": _reversed(uvs, sides) if reverse else uvs,
                "sides": sides,
                "normals": -normals if reverse else normals,
                "albedo": np.tile(surface.albedo, (count, 1)),
                "emission": np.tile(emission, (count, 1)),
                "texture": np.full(count, texture, np.int64),
                "glow": np.full(count, glow, np.int64),
                "item": np.full(count, number, np.int64),
                "primitive": primitive,
                "side": np.full(count, int(behind)),
                "smooth": np.full(count, mesh.normals is not None),
            }
        )
    return bool(solid)


def _painted(textures: list[Painted], texture: Texture | None, matrix: Points) -> int:
    """Row of a texture on a shape that a matrix places, or −1."""
    if texture is None:
        return -1
    textures.append(Painted(texture, np.asarray(np.linalg.inv(matrix), np.float64)))
    return len(textures) - 1


def _volume(mesh: Mesh) -> float:
    """Signed volume: positive where a closed mesh is turned outward."""
    a, b, c = (mesh.vertices[column] for column in triangulate(mesh).triangles.T)
    return float((a * np.cross(b, c)).sum() / 6)


def _flat_faces(mesh: Mesh, placed: Points) -> tuple[Points, Points, npt.NDArray[np.uint8], npt.NDArray[np.int64]]:
    """(corners, texture coordinates, sides, face of the mesh): parallelograms whole, all else in triangles."""
    uv = _corner_uvs(mesh)
    quads = np.flatnonzero(mesh.face_sizes == 4)
    own = mesh.offsets[quads, None] + np.arange(4)
    p = placed[mesh.indices[own]]
    size = np.maximum(np.linalg.norm(p[:, 2] - p[:, 0], axis=1), np.linalg.norm(p[:, 3] - p[:, 1], axis=1))
    whole = np.linalg.norm(p[:, 0] + p[:, 2] - p[:, 1] - p[:, 3], axis=1) <= _FLAT * size
    cut = triangulate(mesh)
    is_whole = np.zeros(mesh.face_count, bool)
    is_whole[quads[whole]] = True
    rest = ~is_whole[cut.face]
    triangles = placed[cut.triangles[rest]]
    triangles = np.concatenate([triangles, triangles[:, :1]], axis=1)
    own = own[whole]
    corners = np.concatenate([p[whole], triangles])
    three = cut.corners[rest]
    uvs = np.concatenate([uv[own], uv[np.concatenate([three, three[:, :1]], axis=1)]])
    sides = np.repeat(np.array([4, 3], np.uint8), [len(own), len(triangles)])
    return corners, uvs, sides, np.concatenate([quads[whole], cut.face[rest]]).astype(np.int64)


def _corner_uvs(mesh: Mesh) -> Points:
    """(corners, 2): texture coordinates at the corners of faces; zeros where there are none."""
    attribute: Attribute | None = mesh.uvs
    if attribute is None:
        return np.zeros((len(mesh.indices), 2))
    rows = mesh.indices if attribute.indices is None else np.maximum(attribute.indices, 0)
    values: Points = np.asarray(attribute.values[rows, :2], np.float64)
    return values


def _reversed(rows: Points, sides: npt.NDArray[np.uint8]) -> Points:
    """Faces run the other way round."""
    return np.where((sides == 3)[:, None, None], rows[:, [0, 2, 1, 0]], rows[:, ::-1])


def looked_up(textures: Sequence[Painted], texture: npt.NDArray[np.int64], uvs: Around, places: Around) -> Points:
    """(n, 3): the linear colour of texture `texture[i]` around place i, and white where that is −1."""
    colour = np.ones((len(texture), 3))
    for number, (painted, to_own) in enumerate(textures):
        own = np.flatnonzero(texture == number)
        world, axes = places.middle[own], places.axes[own]
        found = texture_values(
            painted,
            uvs.middle[own],
            world @ to_own[:3, :3].T + to_own[:3, 3],
            world,
            uv_axes=uvs.axes[own],
            own_axes=axes @ to_own[:3, :3].T,
            world_axes=axes,
        )
        colour[own] = found[:, :3]
    return colour
