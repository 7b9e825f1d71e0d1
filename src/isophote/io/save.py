"""Writing anything to a file by its ending."""

from __future__ import annotations

from functools import singledispatch

from isophote.errors import FileError
from isophote.io.files import StrPath
from isophote.scene.measured import Measured
from isophote.scene.scene import Scene
from isophote.shapes.field.field import Field
from isophote.shapes.mesh import Mesh

__all__ = ["save"]


@singledispatch
def save(thing: object, path: StrPath, **options: object) -> None:
    """Write a thing to a file, in the format that the ending of its name tells; whole, or not at all.

    A `Mesh` goes to .ply, .stl, .obj, .off, .3mf, .glb and .gltf, and with a further .gz packed by gzip. Options by
    name: `binary` (PLY and STL, true by default), `endian` (PLY, "little" or "big"), `unit` (3MF, "millimeter"). A
    `Field` goes to the same, as the mesh that `to_mesh` makes with its options, `cell` or `tolerance` say, and else
    with 128 cells along its longest side; and to .html, a page that stands alone. A `Scene` goes to .glb and .gltf,
    with its materials, textures, camera, point lights and suns, and to .obj with .mtl and .png beside it; an `Image`
    to .png, .exr and other endings of pictures. A `Measured` goes to .binary, MERL's format.

    Raises `FileError` for endings that are not known for this thing, for what the format cannot hold
    and where the file cannot be written. What a format merely has no place for is left out, with an
    `IsophoteWarning`.
    """
    raise FileError(path, f"a {type(thing).__name__} cannot be saved; Isophote saves {_known()}")


@save.register
def _(thing: Mesh, path: StrPath, **options: object) -> None:
    # Imported here, and below: who renders a picture needs no formats of meshes and scenes.
    from isophote.io.mesh_file import save_mesh

    save_mesh(thing, path, **options)


@save.register
def _(thing: Scene, path: StrPath, **options: object) -> None:
    from isophote.io.scene_file import save_scene

    save_scene(thing, path, **options)


@save.register
def _(thing: Field, path: StrPath, **options: object) -> None:
    from isophote.io.field_file import save_field

    save_field(thing, path, **options)


@save.register
def _(thing: Measured, path: StrPath, **options: object) -> None:
    from isophote.io.brdf_file import save_brdf

    save_brdf(thing, path, **options)


def _known() -> str:
    return ", ".join(sorted(kind.__name__ for kind in save.registry if kind is not object))
