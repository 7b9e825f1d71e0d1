"""Writing glTF 2.0 and GLB: scenes with their materials, cameras and lights, and single meshes."""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from os import fspath
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.errors import FileError, IsophoteWarning
from isophote.io.dropped import warn_displaced
from isophote.io.files import StrPath, write_bytes
from isophote.io.gltf.build import Builder
from isophote.io.gltf.material import MARK
from isophote.io.gltf.write_material import MaterialWriter
from isophote.io.gltf.write_mesh import MeshWriter
from isophote.scene.camera import AnyCamera, OrthographicCamera
from isophote.scene.light import Light, PointLight, Sun
from isophote.scene.scene import Item, Scene
from isophote.scene.spot_light import SpotLight
from isophote.scene.transform import look_frame
from isophote.shapes.mesh import Mesh

__all__ = ["encode_gltf_mesh", "encode_gltf_scene", "write_gltf_scene"]

Json: TypeAlias = dict[str, Any]
Matrix: TypeAlias = npt.NDArray[np.float64]

_LIGHTS = "KHR_lights_punctual"
_NEAR = 0.01


def write_gltf_scene(path: StrPath, scene: Scene) -> None:
    """Write a scene of meshes; see `encode_gltf_scene`. Raises `FileError` also where it cannot be written."""
    write_bytes(path, encode_gltf_scene(scene, path))


def encode_gltf_scene(scene: Scene, path: StrPath) -> bytes:
    """The bytes of a .glb with a scene of meshes, or of a .gltf that holds everything itself, as `path` ends.

    A mesh that several items share is written once. Polygons become triangles, and vertices are split where an
    attribute differs from corner to corner. Point lights, spots and suns are kept; other lights are left out, with an
    `IsophoteWarning`. Raises `FileError` for shapes that are no meshes.
    """
    warn_displaced(scene.items, path, "glTF")
    builder = Builder()
    nodes = _item_nodes(path, builder, scene.items) + _light_nodes(path, builder, scene.lights)
    if scene.camera is not None:
        nodes.append(_camera_node(builder, scene.camera))
    return _encoded(path, builder, nodes, scene.name)


def encode_gltf_mesh(mesh: Mesh, path: Path) -> bytes:
    """The bytes of a .glb, or of a .gltf that holds everything itself, with one mesh in it."""
    builder = Builder()
    primitive = MeshWriter(path, builder).primitive(mesh)
    node = {"mesh": builder.add("meshes", {"primitives": [primitive]})}
    return _encoded(path, builder, [builder.add("nodes", node)], None)


def _encoded(path: StrPath, builder: Builder, nodes: Sequence[int], name: str | None) -> bytes:
    scene: Json = {"nodes": list(nodes)} if nodes else {}
    if name is not None:
        scene["name"] = name
    root: Json = {"scene": builder.add("scenes", scene)}
    lights = builder.lists.pop(_LIGHTS, None)
    if lights is not None:
        root["extensions"] = {_LIGHTS: {"lights": lights}}
    try:
        endings = [suffix.lower() for suffix in Path(path).suffixes]
        return builder.gltf(root) if ".gltf" in endings[-2:] else builder.glb(root)
    except ValueError as error:
        raise FileError(path, f"cannot be written: {error}") from error


def _item_nodes(path: StrPath, builder: Builder, items: Sequence[Item]) -> list[int]:
    meshes, materials = MeshWriter(path, builder), MaterialWriter(path, builder)
    written: dict[tuple[int, int], int] = {}
    nodes = []
    for index, item in enumerate(items):
        if not isinstance(item.shape, Mesh):
            kind = type(item.shape).__name__
            raise FileError(
                path, f"glTF holds meshes, and this is a {kind}; make a mesh of it first", f"items[{index}]"
            )
        key = id(item.shape), materials.material(item.material)
        if key not in written:
            primitive = meshes.primitive(item.shape) | {"material": key[1]}
            written[key] = builder.add("meshes", {"primitives": [primitive]})
        node: Json = {"mesh": written[key], **_placed(item.transform.matrix)}
        nodes.append(builder.add("nodes", node if item.name is None else node | {"name": item.name}))
    return nodes


def _placed(matrix: Matrix) -> Json:
    return {} if np.array_equal(matrix, np.eye(4)) else {"matrix": matrix.T.ravel().tolist()}


def _camera_node(builder: Builder, camera: AnyCamera) -> int:
    reach = {"target_distance": math.dist(camera.eye, camera.target)}
    if isinstance(camera, OrthographicCamera):
        half = camera.height / 2
        lens: Json = {"xmag": half, "ymag": half, "znear": 0.0, "zfar": 1000 * max(half, *reach.values())}
        written: Json = {"type": "orthographic", "orthographic": lens}
    else:
        lens = {"yfov": math.radians(camera.fov_degrees), "znear": _NEAR}
        written = {"type": "perspective", "perspective": lens}
        reach |= {"lens_radius": camera.lens_radius, "pixel_aspect": camera.pixel_aspect}
        reach |= {} if camera.focus_distance is None else {"focus_distance": camera.focus_distance}
    mark: Json = {**reach}
    if not isinstance(camera, OrthographicCamera):
        mark["principal_point"] = list(camera.principal_point)
    number = builder.add("cameras", written | {"extras": {MARK: mark}})
    return builder.add("nodes", {"camera": number, **_placed(camera.transform.matrix)})


def _light_nodes(path: StrPath, builder: Builder, lights: Sequence[Light]) -> list[int]:
    nodes, lost = [], []
    for light in lights:
        if isinstance(light, PointLight):
            matrix = np.eye(4)
            matrix[:3, 3] = light.position
            nodes.append(_light_node(builder, "point", light.power / (4 * math.pi), light.colour, matrix))
        elif isinstance(light, Sun):
            matrix = _turned(light.unit_direction)
            nodes.append(_light_node(builder, "directional", light.irradiance, light.colour, matrix))
        elif isinstance(light, SpotLight):
            nodes.append(_spot_node(builder, light))
        else:
            lost.append(type(light).__name__)
    if lost:
        warnings.warn(
            f"{fspath(path)}: glTF has no place for {', '.join(lost)}, which is left out", IsophoteWarning, stacklevel=4
        )
    return nodes


def _turned(back: Sequence[float]) -> Matrix:
    """The placement whose −Z, along which lights shine, goes against `back`."""
    matrix = np.eye(4)
    up = (0, 0, 1) if abs(back[1]) > 0.9 else (0, 1, 0)
    matrix[:3, :3] = look_frame(tuple(back), (0, 0, 0), up).T
    return matrix


def _spot_node(builder: Builder, light: SpotLight) -> int:
    x, y, z = light.unit_axis
    matrix = _turned((-x, -y, -z))
    matrix[:3, 3] = light.position
    outer = math.radians(light.cone_degrees / 2)
    # A hard edge is not glTF's: its inner cone must be narrower.
    inner = 0.999 * outer if light.inner_degrees is None else math.radians(light.inner_degrees / 2)
    target = light.target or light.position
    mark: Json = {"hard": float(light.inner_degrees is None), "exponent": light.exponent}
    mark["target_distance"] = math.dist(light.position, target) or 1.0
    rest: Json = {
        "spot": {"innerConeAngle": min(inner, 0.999 * outer), "outerConeAngle": outer},
        "extras": {MARK: mark},
    }
    return _light_node(builder, "spot", light.intensity, light.colour, matrix, rest)


def _light_node(
    builder: Builder, kind: str, intensity: float, colour: Sequence[float], matrix: Matrix, rest: Json | None = None
) -> int:
    # Colours are at most 1 in glTF; a power of two moves between colour and intensity without rounding.
    excess = 2.0 ** math.ceil(math.log2(max(*colour, 1.0)))
    light = {"type": kind, "intensity": intensity * excess, "color": [channel / excess for channel in colour]}
    light |= rest or {}
    builder.extensions.add(_LIGHTS)
    held = {_LIGHTS: {"light": builder.add(_LIGHTS, light)}}
    return builder.add("nodes", {"extensions": held, **_placed(matrix)})
