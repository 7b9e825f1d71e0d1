"""Scenes as OBJ files with their materials and textures beside them."""

from __future__ import annotations

import warnings
from os import fspath
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.errors import FileError, IsophoteWarning
from isophote.io.dropped import warn_displaced
from isophote.io.files import StrPath, write_bytes
from isophote.io.obj_write import encode_obj
from isophote.io.texture_png import encode_texture, picture_of
from isophote.scene.colour import Colour
from isophote.scene.image_texture import ImageTexture
from isophote.scene.material import Emitter, Glass, Mirror
from isophote.scene.material_base import Material
from isophote.scene.nearest import nearest_principled
from isophote.scene.scene import Item, Scene
from isophote.scene.texture import Texture
from isophote.shapes.mesh import Attribute, FaceLabels, Mesh

__all__ = ["write_obj_scene"]

Array: TypeAlias = npt.NDArray[Any]

_DIFFUSE, _MIRROR, _GLASS = 2, 3, 7


def write_obj_scene(path: StrPath, scene: Scene) -> None:
    """Write a scene of meshes as .obj, its materials as .mtl and its textures as .png of the same name beside it.

    Items are placed in the world and have a material each, of their own name. Cameras and lights that are no items
    are left out, with an `IsophoteWarning`. Raises `FileError` for shapes that are no meshes, and where a file cannot
    be written.
    """
    target = Path(path)
    if not scene.items:
        raise FileError(path, "the scene has no items, and an OBJ without faces is no mesh")
    lost = [type(thing).__name__ for thing in (*scene.lights, scene.camera) if thing is not None]
    if lost:
        warnings.warn(f"{fspath(path)}: OBJ has no place for {', '.join(lost)}", IsophoteWarning, stacklevel=4)
    warn_displaced(scene.items, path, "OBJ")
    names = _names(scene.items)
    pictures: dict[ImageTexture, str] = {}
    library = "".join(
        f"newmtl {name}\n{_statements(item.material, target, pictures)}\n"
        for name, item in zip(names, scene.items, strict=True)
    )
    data = encode_obj(_joined(path, scene.items, names), path, materials=f"{target.stem}.mtl")
    # The file that names the others comes last.
    for texture, file in pictures.items():
        write_bytes(target.with_name(file), encode_texture(texture, "srgb"))
    write_bytes(target.with_suffix(".mtl"), b"# Isophote\n" + library.encode())
    write_bytes(path, data)


def _names(items: tuple[Item, ...]) -> list[str]:
    """A name for each item that OBJ can hold, no two alike."""
    taken: set[str] = set()
    names = []
    for number, item in enumerate(items):
        plain = (
            " ".join((item.name or f"item {number}").replace("#", " ").replace("\\", " ").split()) or f"item {number}"
        )
        name, count = plain, 1
        while name in taken:
            count += 1
            name = f"{plain} {count}"
        taken.add(name)
        names.append(name)
    return names


def _triple(keyword: str, values: Colour) -> str:
    return f"{keyword} {values[0]!r} {values[1]!r} {values[2]!r}\n"


def _statements(material: Material, path: Path, pictures: dict[ImageTexture, str]) -> str:
    """A material as the reader understands it; `pictures` gathers the files of textures."""
    if isinstance(material, Emitter):
        return _triple("Kd", (0.0, 0.0, 0.0)) + _triple("Ke", material.radiance) + f"illum {_DIFFUSE}\n"
    if isinstance(material, Mirror):
        return _triple("Kd", (0.0, 0.0, 0.0)) + _triple("Ks", material.colour) + f"illum {_MIRROR}\n"
    if isinstance(material, Glass):
        return _triple("Tf", material.colour) + f"Ni {material.ior!r}\nd 0.0\nillum {_GLASS}\n"
    colour, given = _diffuse(material)
    texture = picture_of(given, path)
    text = _triple("Kd", colour) + f"illum {_DIFFUSE}\n"
    if texture is not None:
        file = pictures.setdefault(texture, f"{path.stem}_{len(pictures)}.png")
        text += f"map_Kd {'-clamp on ' if texture.wrap == 'clamp' else ''}{file}\n"
    return text


def _diffuse(material: Material) -> tuple[Colour, Texture | None]:
    """What comes nearest to a material's colour, and its texture."""
    principled = nearest_principled(material)
    return principled.colour, principled.colour_texture


def _joined(path: StrPath, items: tuple[Item, ...], names: list[str]) -> Mesh:
    """All meshes placed in the world as one, its faces labelled with their materials."""
    meshes = []
    for number, item in enumerate(items):
        if not isinstance(item.shape, Mesh):
            raise FileError(path, f"items[{number}] is a {type(item.shape).__name__}; an OBJ holds meshes")
        meshes.append(_placed(item.shape, item.transform.matrix))
    held = [name for name in ("normal", "uv") if any(name in mesh.attributes for mesh in meshes)]
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])[:-1]
    sizes = np.concatenate([mesh.face_sizes for mesh in meshes])
    return Mesh.from_polygons(
        np.concatenate([mesh.vertices for mesh in meshes]),
        np.concatenate([mesh.indices + start for mesh, start in zip(meshes, starts, strict=True)]),
        np.concatenate([[0], np.cumsum(sizes)]),
        attributes={name: _attribute(meshes, name) for name in held},
        labels={"material": FaceLabels(tuple(names), np.repeat(np.arange(len(names)), [m.face_count for m in meshes]))},
    )


def _attribute(meshes: list[Mesh], name: str) -> Attribute:
    """One attribute of the corners of all meshes; −1 where a mesh has none."""
    rows, indices, start = [], [], 0
    for mesh in meshes:
        attribute = mesh.attributes.get(name)
        if attribute is None:
            indices.append(np.full(len(mesh.indices), -1, np.int64))
            continue
        own = mesh.indices if attribute.indices is None else attribute.indices
        indices.append(np.where(own < 0, -1, own.astype(np.int64) + start))
        rows.append(attribute.values[:, : 3 if name == "normal" else 2])
        start += len(attribute.values)
    return Attribute(np.concatenate(rows), np.concatenate(indices))


def _placed(mesh: Mesh, matrix: Array) -> Mesh:
    """A mesh in the world; faces keep their front where the matrix mirrors."""
    if (matrix == np.eye(4)).all():
        return mesh
    linear = matrix[:3, :3]
    attributes = dict(mesh.attributes)
    if "normal" in attributes:
        given = attributes["normal"]
        turned = np.asarray(given.values[:, :3], np.float64) @ np.linalg.inv(linear)
        lengths = np.linalg.norm(turned, axis=1, keepdims=True)
        turned = np.divide(turned, lengths, out=np.zeros_like(turned), where=lengths > 0)
        attributes["normal"] = Attribute(turned, given.indices)
    order = _reversed_faces(mesh.offsets) if np.linalg.det(linear) < 0 else slice(None)
    for name, attribute in attributes.items():
        if attribute.indices is not None:
            attributes[name] = Attribute(attribute.values, attribute.indices[order])
    vertices = mesh.vertices @ linear.T + matrix[:3, 3]
    return Mesh.from_polygons(vertices, mesh.indices[order], mesh.offsets, attributes=attributes)


def _reversed_faces(offsets: Array) -> Array:
    """Places of all corners with each face turned around."""
    face = np.repeat(np.arange(len(offsets) - 1), np.diff(offsets))
    return offsets[face] + offsets[face + 1] - 1 - np.arange(offsets[-1])
