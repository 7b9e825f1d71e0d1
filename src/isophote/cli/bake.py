"""`isophote bake`: ambient occlusion of a model into a texture."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from isophote.cli.messages import print_json

if TYPE_CHECKING:
    from isophote.rendering.occlusion.bake import BakedOcclusion
    from isophote.scene.scene import Item, Scene
    from isophote.shapes.mesh import Mesh

__all__ = ["EXAMPLES", "bake"]

EXAMPLES = """\b
Examples:
  isophote bake bunny.obj -o bunny.glb
  isophote bake truck.glb -o truck-ao.glb --size 2048 --samples 256
  isophote bake vase.ply -o ao.png --max-distance 0.5

A .glb or .gltf is the model with an occlusion texture in each mesh's material; glass and what glows by itself stay as
they are. A .png is the map alone, of a model of one mesh. A mesh without texture coordinates is unwrapped first, which
needs `pip install isophote[uv]`.
"""

_ENDINGS = (".glb", ".gltf", ".png")


def bake(
    model: Annotated[
        Path,
        typer.Argument(
            metavar="MODEL", help="A Python file that defines `scene` or `shape`, a glTF, an OBJ or any mesh file."
        ),
    ],
    output: Annotated[
        Path, typer.Option("-o", "--output", metavar="FILE", help="The model, .glb or .gltf, or the map, .png.")
    ],
    size: Annotated[int, typer.Option(metavar="N", help="Texels along each side of a texture.")] = 1024,
    samples: Annotated[int, typer.Option(metavar="N", help="Rays a texel.")] = 64,
    max_distance: Annotated[
        float | None, typer.Option(metavar="X", help="Length of rays, in metres.  [default: without end]")
    ] = None,
    gutter: Annotated[int, typer.Option(metavar="N", help="Texels around faces that repeat theirs.")] = 4,
    unwrap: Annotated[
        bool,
        typer.Option("--unwrap", help="Make new texture coordinates, of meshes that have some and no textures, too."),
    ] = False,
    seed: Annotated[int, typer.Option(metavar="N", help="The same seed gives the same texture.")] = 0,
    threads: Annotated[int | None, typer.Option(metavar="N", help="Threads.  [default: all processors]")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print what was baked as JSON.")] = False,
) -> None:
    """Bake ambient occlusion into a texture."""
    ending = output.suffix.lower()
    if ending not in _ENDINGS:
        raise typer.BadParameter(f"{output}: use one of {', '.join(_ENDINGS)}", param_hint="--output")
    from isophote.cli.progress import progress
    from isophote.cli.subject import load_subject
    from isophote.errors import FileError, GeometryError
    from isophote.io.files import check_writable
    from isophote.io.save import save
    from isophote.rendering.occlusion.bake import bake_occlusion
    from isophote.scene.scene import Item, Scene

    check_writable(output)
    began = time.monotonic()
    maps: list[BakedOcclusion] = []
    target = output.resolve()
    subject = load_subject(model)
    scene = subject if isinstance(subject, Scene) else Scene([subject if isinstance(subject, Item) else Item(subject)])
    scene = _with_coordinates(scene, model, unwrap, {"size": size, "padding": max(gutter, 2)})

    def baked(item: Item) -> BakedOcclusion:
        try:
            found = bake_occlusion(
                item,
                size=size,
                samples=samples,
                max_distance=max_distance,
                gutter=gutter,
                among=scene,
                seed=seed,
                progress=progress(),
                threads=threads,
            )
        except GeometryError as error:
            raise FileError(model, f"{error}, as --unwrap does", _place(item)) from error
        maps.append(found)
        return found

    if ending == ".png":
        baked(_only([item for item in scene.items if _takes_occlusion(item)], model)).save(target)
    else:
        items = [_with_map(item, baked(item)) if _takes_occlusion(item) else item for item in scene.items]
        save(scene.with_(items=items), target)
    if as_json:
        print_json({"output": str(output), "seconds": round(time.monotonic() - began, 3), "maps": _facts(maps)})


def _facts(maps: list[BakedOcclusion]) -> list[dict[str, float]]:
    """Of each map: texels a side, how many of them faces touch, and how open the sky is above those on average."""
    return [
        {
            "size": len(found.coverage),
            "covered texels": int(found.coverage.sum()),
            "mean visibility": round(float(found.visibility[found.coverage].mean()), 4),
        }
        for found in maps
    ]


def _takes_occlusion(item: Item) -> bool:
    from isophote.scene.material import Emitter, Glass
    from isophote.scene.thin_glass import ThinGlass
    from isophote.shapes.mesh import Mesh

    return isinstance(item.shape, Mesh) and not isinstance(item.material, Glass | ThinGlass | Emitter)


def _with_coordinates(scene: Scene, model: Path, afresh: bool, packing: dict[str, int]) -> Scene:
    """The scene with texture coordinates on all meshes that are baked; items that share a mesh still do.

    Raises `FileError` where there are none to bake, or one cannot be unwrapped.
    """
    from isophote.errors import FileError
    from isophote.shapes.mesh import Mesh

    made: dict[int, Mesh] = {}
    items = list(scene.items)
    for i, item in enumerate(items):
        if not _takes_occlusion(item) or not isinstance(item.shape, Mesh):
            continue
        mesh = item.shape
        if id(mesh) not in made:
            made[id(mesh)] = _unwrapped(item, mesh, model, packing) if afresh or mesh.uvs is None else mesh
        items[i] = item.with_(shape=made[id(mesh)])
    if not made:
        raise FileError(model, "has no mesh to bake; `isophote convert` makes meshes of fields")
    return scene.with_(items=items)


def _unwrapped(item: Item, mesh: Mesh, model: Path, packing: dict[str, int]) -> Mesh:
    from isophote.convert.unwrap import unwrap
    from isophote.errors import FileError, GeometryError
    from isophote.scene.material_base import textures_of

    if mesh.uvs is not None and textures_of(item.material):
        raise FileError(model, "--unwrap would move the textures of its material", _place(item))
    try:
        return unwrap(mesh, **packing)
    except GeometryError as error:
        raise FileError(model, str(error), _place(item)) from error


def _place(item: Item) -> str:
    return f'mesh "{item.name}"' if item.name else ""


def _only(meshes: list[Item], model: Path) -> Item:
    """The one mesh of a model. Raises `FileError`."""
    from isophote.errors import FileError

    if len(meshes) != 1:
        raise FileError(
            model, f"has {len(meshes) or 'no'} meshes to bake, and a .png holds the map of one; write a .glb"
        )
    return meshes[0]


def _with_map(item: Item, found: BakedOcclusion) -> Item:
    import attrs

    from isophote.scene.nearest import nearest_principled

    material = nearest_principled(item.material)
    return item.with_(material=attrs.evolve(material, occlusion_texture=found.texture, occlusion_strength=1.0))
