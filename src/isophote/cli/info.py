"""`isophote info`: what a model or a scene holds."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from isophote.cli.messages import print_facts, print_json

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

A glTF and a Python file are told as scenes, other files as one mesh. Bounds are the least and the greatest corner,
in the file's units.
"""
_SCENES = (".gltf", ".glb", ".py")


def info(
    model: Annotated[Path, typer.Argument(metavar="MODEL", help="A mesh file, a glTF, or a Python file.")],
    tree: Annotated[
        bool, typer.Option("--tree", help="Also build the tree that rays use, and tell its memory.")
    ] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print the result as JSON.")] = False,
) -> None:
    """Say what a model or a scene holds."""
    subject = _load(model)
    facts = {"file": str(model), **_facts(subject, tree)}
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


def _lines(facts: Facts) -> dict[str, str]:
    """Facts as people read them; what is empty is left out."""
    lines = {name.replace("_", " "): _text(name, value) for name, value in facts.items()}
    return {name: text for name, text in lines.items() if text}


def _text(name: str, value: Any) -> str:
    if value is None:
        return ""
    if name == "bounds":
        return "\n".join("  ".join(f"{coordinate:.6g}" for coordinate in corner) for corner in value)
    if isinstance(value, dict):
        return "\n".join(f"{_key(key)}: {_inline(member)}" for key, member in value.items())
    return f"{value:,}" if isinstance(value, int | float) else str(value)


def _inline(value: Any) -> str:
    if isinstance(value, dict):
        return ", ".join(f"{_key(key)} {_text('', member)}" for key, member in value.items())
    return _text("", value)


def _key(key: object) -> str:
    return str(key).replace("_", " ") or "(none)"
