"""Reading glTF 2.0 and GLB: a file as a `Scene`, or all of its meshes as one `Mesh`."""

from __future__ import annotations

import json
import warnings
from os import fspath
from pathlib import Path

import attrs
import numpy as np
import numpy.typing as npt

from isophote.errors import IsophoteWarning, SceneError
from isophote.io.gltf.document import Document, open_document
from isophote.io.gltf.field import Field
from isophote.io.gltf.geometry import UvMap, read_primitive
from isophote.io.gltf.material import MaterialReader
from isophote.io.gltf.merge import merged
from isophote.io.gltf.nodes import PlacedNode, read_camera, read_light, scene_name, walk
from isophote.scene.camera import AnyCamera
from isophote.scene.light import Light
from isophote.scene.scene import Item, Scene
from isophote.scene.transform import Transform
from isophote.shapes.mesh import Mesh

__all__ = ["read_gltf_mesh", "read_gltf_scene"]


def read_gltf_scene(path: Path, data: bytes, *, strict: bool = False) -> Scene:
    """The scene in a glTF file: one item for each primitive of each placed mesh, with lights and first camera.

    Primitives that are placed several times share one `Mesh`. Raises `FileError` for what does not fit, and with
    `strict` also for missing and damaged pictures, which otherwise are replaced, with an `IsophoteWarning`.
    """
    document = open_document(path, data)
    parts = _Parts(document, MaterialReader(document, strict))
    items: list[Item] = []
    lights: list[Light] = []
    camera: AnyCamera | None = None
    for node in walk(document):
        items += parts.items(node)
        light = read_light(document, node)
        lights += [] if light is None else [light]
        camera = camera or read_camera(document, node)
    return Scene(items, lights, camera, scene_name(document))


def read_gltf_mesh(path: Path, data: bytes) -> Mesh:
    """All meshes of a glTF file's scene, placed in the world and put into one; labels tell the materials.

    Attributes that some of them lack become attributes of corners. Raises `FileError` for what does not fit, and
    for files without triangles.
    """
    document = open_document(path, data)
    parts = _Parts(document, None)
    placed: list[tuple[Mesh, npt.NDArray[np.float64]]] = []
    names: list[str | None] = []
    for node in walk(document):
        for mesh, primitive in parts.meshes(node):
            # What a placed copy takes, before it is made.
            document.spend(48 * (len(mesh.vertices) + len(mesh.indices)), primitive.place)
            placed.append((mesh, node.matrix))
            names.append(_material_name(document, primitive))
    if not placed:
        document.fail("holds no triangles")
    return merged(placed, names)


def _material_name(document: Document, primitive: Field) -> str | None:
    if "material" not in primitive:
        return None
    index = primitive.integer("material")
    return document.root.entry("materials", index).text("name") or f"material {index}"


@attrs.define
class _Parts:
    """The primitives of a document, each read once for each way in which a material uses its coordinates."""

    document: Document
    materials: MaterialReader | None
    _meshes: dict[tuple[str, UvMap], Mesh | None] = attrs.field(init=False, factory=dict)

    def items(self, node: PlacedNode) -> list[Item]:
        """The items at a node."""
        if "mesh" not in node.field or self.materials is None:
            return []
        try:
            transform = Transform(node.matrix)
        except SceneError as error:
            warnings.warn(
                f"{fspath(self.document.path)}, {node.field.place}: is left out, since {error}",
                IsophoteWarning,
                stacklevel=3,
            )
            return []
        name = node.field.text("name") or self._mesh_field(node).text("name")
        return [
            Item(mesh, self.materials.material(primitive), transform, name) for mesh, primitive in self.meshes(node)
        ]

    def meshes(self, node: PlacedNode) -> list[tuple[Mesh, Field]]:
        """The meshes at a node, with the primitives they come from."""
        if "mesh" not in node.field:
            return []
        primitives = self._mesh_field(node).children("primitives")
        found = [(self._mesh(primitive), primitive) for primitive in primitives]
        return [(mesh, primitive) for mesh, primitive in found if mesh is not None]

    def _mesh_field(self, node: PlacedNode) -> Field:
        return self.document.root.entry("meshes", node.field.integer("mesh"))

    def _mesh(self, primitive: Field) -> Mesh | None:
        """The mesh of a primitive; primitives of the same data, such as those of two materials, share it."""
        uv_map = UvMap() if self.materials is None else self.materials.uv_map(primitive)
        data = json.dumps([primitive.value.get(key) for key in ("attributes", "indices", "mode")], sort_keys=True)
        if (data, uv_map) not in self._meshes:
            self._meshes[data, uv_map] = read_primitive(self.document, primitive, uv_map)
        return self._meshes[data, uv_map]
