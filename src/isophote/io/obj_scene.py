"""OBJ files with their materials as scenes."""

from __future__ import annotations

import warnings
from os import fspath
from pathlib import Path

import attrs
import numpy as np
import numpy.typing as npt

from isophote.errors import FileError, IsophoteWarning
from isophote.io.mtl import MtlMaterial, parse_mtl
from isophote.io.obj_read import parse_obj
from isophote.io.source import read_source
from isophote.io.texture_file import load_texture
from isophote.scene.colour import Colour
from isophote.scene.image_texture import ImageTexture
from isophote.scene.material import Emitter, Glass, Matte, Mirror
from isophote.scene.material_base import Material
from isophote.scene.scene import Item, Scene
from isophote.shapes.mesh import Attribute, FaceLabels, Mesh

__all__ = ["read_obj_scene"]

# Illumination models of the format that reflect, and that let light through.
_MIRRORS = (3, 5)
_GLASSES = (4, 6, 7, 9)
_DEFAULT_IOR = 1.5


def read_obj_scene(path: Path, data: bytes, *, strict: bool = False) -> Scene:
    """A scene with one item for each material of an OBJ file.

    Kd becomes `Matte`, with map_Kd its texture; Ke above 0 `Emitter`; the reflecting models 3 and 5 `Mirror`; the
    transparent ones 4, 6, 7 and 9 `Glass`, where Ni is above 1 or the material is not opaque. Missing libraries,
    materials and textures give an `IsophoteWarning` and a neutral or magenta stand-in; with `strict` a `FileError`.
    """
    file = parse_obj(path, data)
    mesh, labels = file.mesh, file.mesh.labels.get("material")
    if labels is None:
        return Scene([Item(mesh, name=path.stem)])
    reader = _Materials(path, _library(path, file.libraries, strict), strict)
    numbers = [int(number) for number in np.unique(labels.index)]
    ordered = sorted(numbers, key=lambda number: int(np.argmax(labels.index == number)))
    items = []
    for number in ordered:
        name = labels.names[number] if number >= 0 else None
        part = _without_materials(mesh) if len(numbers) == 1 else _part(mesh, labels.index == number)
        items.append(Item(part, Matte() if name is None else reader.material(name), name=name))
    return Scene(items)


def _library(path: Path, lines: tuple[str, ...], strict: bool) -> dict[str, MtlMaterial]:
    """All materials of the libraries that an OBJ file names."""
    materials: dict[str, MtlMaterial] = {}
    for line in lines:
        # One name with blanks in it, or several names.
        names = [line] if _exists(path.parent, line) else line.split()
        for name in names:
            try:
                materials |= parse_mtl(read_source(path.parent / name.replace("\\", "/")))
            except FileError as error:
                _complain(path, f'the material library "{name}" cannot be read: {error.reason}', strict)
    return materials


def _exists(folder: Path, name: str) -> bool:
    try:
        return (folder / name).is_file()
    except (OSError, ValueError):
        return False


def _complain(path: Path, reason: str, strict: bool, instead: str = "") -> None:
    if strict:
        raise FileError(path, reason)
    warnings.warn(f"{fspath(path)}: {reason}{instead}", IsophoteWarning, stacklevel=2)


@attrs.define
class _Materials:
    path: Path
    library: dict[str, MtlMaterial]
    strict: bool
    _textures: dict[tuple[str, bool], ImageTexture] = attrs.field(init=False, factory=dict)

    def material(self, name: str) -> Material:
        """What the library says of a material."""
        given = self.library.get(name)
        if given is None:
            _complain(self.path, f'there is no material "{name}" in its libraries', self.strict, "; grey stands for it")
            return Matte()
        if given.emission is not None and any(given.emission):
            return Emitter(given.emission)
        glass = given.illumination in _GLASSES and ((given.ior or 0) > 1 or given.opacity < 1)
        if glass:
            ior = given.ior if given.ior is not None and given.ior > 1 else _DEFAULT_IOR
            filtering = given.transmission
            return Glass(ior, 1.0 if filtering is None or not any(filtering) else self._reflected(filtering))
        if given.illumination in _MIRRORS:
            return Mirror(1.0 if given.specular is None else self._reflected(given.specular))
        if given.diffuse_map is not None:
            return Matte(self._texture(given.diffuse_map, given.clamped))
        return Matte() if given.diffuse is None else Matte(self._reflected(given.diffuse))

    def _reflected(self, colour: Colour) -> Colour:
        """A colour that reflects no more light than comes."""
        if max(colour) > 1:
            _complain(self.path, f"a colour of {colour} reflects more light than comes", self.strict, "; cut at 1")
        red, green, blue = (min(channel, 1.0) for channel in colour)
        return red, green, blue

    def _texture(self, name: str, clamped: bool) -> ImageTexture:
        if (name, clamped) not in self._textures:
            self._textures[name, clamped] = self._read(name, clamped)
        return self._textures[name, clamped]

    def _read(self, name: str, clamped: bool) -> ImageTexture:
        try:
            return load_texture(self.path.parent / name.replace("\\", "/"), wrap="clamp" if clamped else "repeat")
        except FileError as error:
            reason = f'the texture "{name}" cannot be read ({error.reason})'
            _complain(self.path, reason, self.strict, "; magenta stands for it")
            return ImageTexture.missing(name)


def _without_materials(mesh: Mesh) -> Mesh:
    """The mesh without labels that its item's material makes needless."""
    return mesh.with_(labels={name: label for name, label in mesh.labels.items() if name != "material"})


def _part(mesh: Mesh, chosen: npt.NDArray[np.bool_]) -> Mesh:
    """The chosen faces of a mesh, with the vertices and the rows of attributes that they use, in their order.

    The label "material" is left out, for all of them have one.
    """
    sizes = mesh.face_sizes
    corners = np.flatnonzero(np.repeat(chosen, sizes))
    vertices, indices = np.unique(mesh.indices[corners], return_inverse=True)
    offsets = np.concatenate([[0], np.cumsum(sizes[chosen])])
    attributes = {}
    for name, attribute in mesh.attributes.items():
        if attribute.indices is None:
            attributes[name] = Attribute(attribute.values[vertices])
            continue
        rows, places = np.unique(attribute.indices[corners], return_inverse=True)
        none = int(rows[0] == -1)
        if len(rows) > none:
            attributes[name] = Attribute(attribute.values[rows[none:]], places.reshape(-1) - none)
    labels = {
        name: FaceLabels(label.names, label.index[chosen]) for name, label in mesh.labels.items() if name != "material"
    }
    return Mesh.from_polygons(
        mesh.vertices[vertices], indices.reshape(-1), offsets, attributes=attributes, labels=labels
    )
