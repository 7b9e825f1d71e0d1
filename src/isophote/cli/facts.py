"""What a mesh or a scene holds, in numbers and names."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from typing import Any, TypeAlias

import numpy as np

from isophote.scene.light import Environment
from isophote.scene.material_base import textures_of
from isophote.scene.scene import Scene
from isophote.shapes.mesh import Attribute, FaceLabels, Mesh

__all__ = ["Facts", "mesh_facts", "scene_facts"]

Facts: TypeAlias = dict[str, Any]


def mesh_facts(mesh: Mesh) -> Facts:
    """Vertices, faces by their number of corners, triangles that they make, bounds, attributes and labels."""
    sizes, counts = np.unique(mesh.face_sizes, return_counts=True)
    return {
        "vertices": len(mesh.vertices),
        "faces": mesh.face_count,
        "faces_by_size": {int(size): int(count) for size, count in zip(sizes, counts, strict=True)},
        "triangles": triangle_count(mesh),
        "bounds": mesh.bounds.tolist(),
        "attributes": {name: _attribute_facts(attribute) for name, attribute in mesh.attributes.items()},
        "labels": {name: _label_facts(label) for name, label in mesh.labels.items()},
    }


def triangle_count(mesh: Mesh) -> int:
    """How many triangles the faces make."""
    return int((mesh.face_sizes - 2).sum())


def _attribute_facts(attribute: Attribute) -> Facts:
    rows, columns = attribute.values.shape
    place = "vertices" if attribute.indices is None else "corners"
    return {"at": place, "rows": rows, "columns": columns, "type": str(attribute.values.dtype)}


def _label_facts(label: FaceLabels) -> dict[str, int]:
    """Faces with each name; "" for those that have none."""
    counts = np.bincount(label.index + 1, minlength=len(label.names) + 1).tolist()
    named = dict(zip(label.names, counts[1:], strict=True))
    return {**named, "": counts[0]} if counts[0] else named


def scene_facts(scene: Scene) -> Facts:
    """Items, the meshes that they share, materials, textures, lights and camera; triangles as stored and as placed."""
    meshes = [item.shape for item in scene.items if isinstance(item.shape, Mesh)]
    distinct = {id(mesh): mesh for mesh in meshes}
    uses = Counter(id(mesh) for mesh in meshes)
    triangles = {key: triangle_count(mesh) for key, mesh in distinct.items()}
    return {
        "name": scene.name,
        "items": len(scene.items),
        "meshes": len(distinct),
        "instances": sum(count for count in uses.values() if count > 1),
        "vertices": sum(len(mesh.vertices) for mesh in distinct.values()),
        "triangles": sum(triangles.values()),
        "placed_triangles": sum(triangles[key] * count for key, count in uses.items()),
        "bounds": scene.bounds.tolist() if scene.items else None,
        "materials": _by_kind({item.material for item in scene.items}),
        "textures": len(_textures(scene)),
        "lights": _by_kind(scene.lights),
        "camera": None if scene.camera is None else repr(scene.camera),
    }


def _by_kind(members: Iterable[object]) -> dict[str, int]:
    return dict(sorted(Counter(type(member).__name__ for member in members).items()))


def _textures(scene: Scene) -> set[int]:
    """Identities of the textures of all materials and of the sky."""
    found = [texture for item in scene.items for texture in textures_of(item.material)]
    found += [light.texture for light in scene.lights if isinstance(light, Environment)]
    return {id(texture) for texture in found}
