"""`isophote info`: what a model or a scene holds."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from isophote.cli.messages import print_facts, print_json
from isophote.cli.options import picture_size

if TYPE_CHECKING:
    from isophote.cli.facts import Facts
    from isophote.scene.scene import Scene
    from isophote.shapes.mesh import Mesh

__all__ = ["EXAMPLES", "info"]

EXAMPLES = """\b
Examples:
  isophote info bunny.obj
  isophote info truck.glb --json
  isophote info dragon.ply.gz --tree
  isophote info scan.stl --picture defects.png

A glTF and a Python file are told as scenes, other files as one mesh. Bounds are the least and the greatest corner,
in the file's units. The triangles of an STL are joined where their corners coincide.

The picture shows the model from before and behind: boundary edges blue, edges of three or more faces red, edges along
which faces run the same way green, vertices whose faces do not form one fan magenta. What is hidden shines through.
"""
_SCENES = (".gltf", ".glb", ".py")
# Meshes, components and defects of each kind that are listed: for people, and as JSON.
_FEW, _MANY = 5, 1000


def info(
    model: Annotated[Path, typer.Argument(metavar="MODEL", help="A mesh file, a glTF, or a Python file.")],
    tree: Annotated[
        bool, typer.Option("--tree", help="Also build the tree that rays use, and tell its memory.")
    ] = False,
    weld: Annotated[
        float | None,
        typer.Option(metavar="X", help="Take vertices within this distance as one.  [default: 0 for STL, else not]"),
    ] = None,
    picture: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Draw the model, and mark what is wrong with it.")
    ] = None,
    size: Annotated[str, typer.Option(metavar="WxH", help="Pixels of each of the picture's two views.")] = "480x480",
    as_json: Annotated[bool, typer.Option("--json", help="Print the result as JSON.")] = False,
) -> None:
    """Say what a model or a scene holds, how it is connected, and what is wrong with it."""
    width, height = picture_size(size)
    if picture is not None:
        from isophote.io.picture_file import check_picture_path

        check_picture_path(picture)
    target = None if picture is None else picture.resolve()
    subject = _load(model)
    facts = {"file": str(model), **_facts(subject, tree)}
    subject = _with_weld(subject, model, weld)
    facts.update(_topology(subject, _MANY if as_json else _FEW))
    if target is not None:
        _draw(subject, target, (width, height))
        facts["picture"] = str(picture)
    if as_json:
        print_json(facts)
    else:
        print_facts(_lines(facts))


def _load(path: Path) -> Scene | Mesh:
    from isophote.cli.subject import load_subject
    from isophote.io.mesh_file import load_mesh
    from isophote.scene.scene import Item, Scene
    from isophote.shapes.mesh import Mesh

    suffixes = [suffix.lower() for suffix in path.suffixes if suffix.lower() != ".gz"]
    if suffixes[-1:] and suffixes[-1] in _SCENES:
        subject = load_subject(path)
        return subject if isinstance(subject, Scene | Mesh) else Scene([_as_item(subject, Item)])
    return load_mesh(path)


def _as_item(subject: Any, kind: type) -> Any:
    return subject if isinstance(subject, kind) else kind(subject)


def _facts(subject: Scene | Mesh, tree: bool) -> Facts:
    from isophote.cli.facts import mesh_facts, scene_facts
    from isophote.scene.scene import Scene

    if isinstance(subject, Scene):
        facts = {"kind": "scene", **scene_facts(subject)}
    else:
        facts = {"kind": "mesh", **mesh_facts(subject)}
    if not tree:
        return facts
    from isophote.cli.tree_facts import tree_facts

    return {**facts, **tree_facts(subject)}


def _with_weld(subject: Scene | Mesh, path: Path, weld: float | None) -> Scene | Mesh:
    from isophote.cli.topology_facts import with_weld

    return with_weld(subject, path, weld)


def _topology(subject: Scene | Mesh, most: int) -> Facts:
    from isophote.cli.topology_facts import mesh_topology, scene_topology
    from isophote.scene.scene import Scene

    return scene_topology(subject, most) if isinstance(subject, Scene) else mesh_topology(subject, most)


def _draw(subject: Scene | Mesh, target: Path, size: tuple[int, int]) -> None:
    from isophote.cli.defect_picture import draw_defects
    from isophote.scene.scene import Item, Scene

    draw_defects(subject if isinstance(subject, Scene) else Scene([Item(subject)]), target, size)


def _lines(facts: Facts) -> dict[str, str]:
    """Facts as people read them; what is empty is left out."""
    lines = {name.replace("_", " "): _text(name, value) for name, value in facts.items()}
    return {name: text for name, text in lines.items() if text}


def _text(name: str, value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:,.12g}"
    if name == "bounds":
        return "\n".join("  ".join(f"{coordinate:.6g}" for coordinate in corner) for corner in value)
    if isinstance(value, dict):
        return "\n".join(f"{_key(key)}: {_inline(member)}" for key, member in value.items() if member is not None)
    return f"{value:,}" if isinstance(value, int) else str(value)


def _inline(value: Any) -> str:
    if isinstance(value, dict):
        return ", ".join(f"{_key(key)} {_text('', member)}" for key, member in value.items() if member is not None)
    return _text("", value)


def _key(key: object) -> str:
    return str(key).replace("non_manifold", "non-manifold").replace("_", " ") or "(none)"
