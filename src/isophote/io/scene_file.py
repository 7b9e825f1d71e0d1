"""Scenes from files, by the endings of their names."""

from __future__ import annotations

from pathlib import Path

from isophote.errors import FileError, GeometryError, SceneError
from isophote.io.files import StrPath
from isophote.io.gltf.read import read_gltf_scene
from isophote.io.gltf.write import write_gltf_scene
from isophote.io.mesh_file import load_mesh
from isophote.io.obj_scene import read_obj_scene
from isophote.io.obj_scene_write import write_obj_scene
from isophote.io.source import read_source
from isophote.scene.scene import Item, Scene

__all__ = ["load_scene", "save_scene"]

_GLTF = (".gltf", ".glb")


def load_scene(path: StrPath, *, strict: bool = False) -> Scene:
    """The scene in a file: .gltf and .glb whole, .obj with its materials, and any other mesh file as one item.

    A glTF gives one item for each primitive of each placed mesh, its lights and its first camera; an OBJ one item
    for each material. A scene without camera or lights has none. Missing and damaged textures are replaced by
    magenta, with an `IsophoteWarning`; with `strict` they raise.

    Raises `FileError` (path, place in the file, reason) for unknown endings and for files that cannot be read, are
    damaged, or need what cannot be read.
    """
    file = Path(path)
    ending = _ending(file)
    try:
        if ending in _GLTF:
            return read_gltf_scene(file, read_source(file), strict=strict)
        if ending == ".obj":
            return read_obj_scene(file, read_source(file), strict=strict)
        return Scene([Item(load_mesh(file), name=file.stem)])
    except (GeometryError, SceneError) as error:
        raise FileError(path, str(error)) from error


def save_scene(scene: Scene, path: StrPath, **options: object) -> None:
    """Write a scene as .glb, .gltf or .obj, which have no options; see `isophote.save`."""
    if options:
        raise FileError(path, f"scenes are written without options, but {', '.join(options)} is given")
    ending = Path(path).suffix.lower()
    if ending in _GLTF:
        write_gltf_scene(path, scene)
    elif ending == ".obj":
        write_obj_scene(path, scene)
    else:
        raise FileError(path, f"a scene cannot be written with this ending; use one of {', '.join(_GLTF)}, .obj")


def _ending(file: Path) -> str:
    endings = [suffix.lower() for suffix in file.suffixes]
    if endings[-1:] == [".gz"]:
        endings.pop()
    return endings[-1] if endings else ""
