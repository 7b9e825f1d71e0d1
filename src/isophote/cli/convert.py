"""`isophote convert`: one file into another."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from isophote.cli.messages import log, print_json
from isophote.cli.options import one_of

if TYPE_CHECKING:
    from isophote.cli.facts import Facts
    from isophote.scene.scene import Shape

__all__ = ["EXAMPLES", "convert"]

EXAMPLES = """\b
Examples:
  isophote convert part.py part.stl --cell 0.5
  isophote convert part.py part.3mf --tolerance 0.01 --unit millimeter
  isophote convert part.py part.html
  isophote convert scan.ply scan.glb
  isophote convert cad.stl model.obj --up z --scale 0.001

\b
A Python file defines the field as `part` or `shape`, or as its only shape:
  import isophote as iso
  part = (iso.sphere(1) & iso.box(1.5)) - iso.cylinder(0.5)

Fields become closed meshes, with sharp edges; without --cell or --tolerance, the longest side has 128 cells.
"""
_METHODS = ("dual-contouring", "surface-nets")


def convert(
    source: Annotated[Path, typer.Argument(metavar="IN", help="A Python file that defines a field, or a mesh file.")],
    target: Annotated[
        Path, typer.Argument(metavar="OUT", help="A mesh file, or for a field .html: the ending tells the format.")
    ],
    cell: Annotated[float | None, typer.Option(metavar="X", help="Cubes that a field is looked at in.")] = None,
    tolerance: Annotated[float | None, typer.Option(metavar="X", help="How far mesh and field may be apart.")] = None,
    method: Annotated[
        str | None,
        typer.Option(
            metavar="|".join(_METHODS),
            callback=one_of(_METHODS),
            help="Where vertices of a field's mesh lie: on its edges, or in the middle.  [default: dual-contouring]",
        ),
    ] = None,
    up: Annotated[
        str | None, typer.Option(metavar="y|z", callback=one_of(("y", "z")), help="Axis that points up in a mesh IN.")
    ] = None,
    scale: Annotated[float | None, typer.Option(metavar="X", help="What to multiply lengths of a mesh IN by.")] = None,
    unit: Annotated[str | None, typer.Option(metavar="NAME", help="What a length of 1 is, in a 3MF.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the result as JSON.")] = False,
) -> None:
    """Convert a field to a mesh or a page, or a mesh from one format to another."""
    of_fields = {"cell": cell, "tolerance": tolerance, "method": method}
    of_meshes = {"up": up, "scale": scale}
    is_field = source.suffix.lower() == ".py"
    _refuse(of_meshes if is_field else of_fields, "a mesh" if is_field else "a field")
    begin = time.perf_counter()
    options = {"unit": unit} if unit is not None else {}
    shape = _loaded(source, is_field, {name: value for name, value in of_meshes.items() if value is not None})
    made = {name: value for name, value in of_fields.items() if value is not None}
    facts = {"file": str(source), "output": str(target), **_saved(shape, target, made, options)}
    facts["seconds"] = round(time.perf_counter() - begin, 3)
    if as_json:
        print_json(facts)
    else:
        log(_line(facts))


def _refuse(options: dict[str, Any], kind: str) -> None:
    """Options that mean nothing for this input."""
    given = [name for name, value in options.items() if value is not None]
    if given:
        raise typer.BadParameter(f"--{given[0]} is for {kind} as IN")


def _loaded(source: Path, is_python: bool, options: dict[str, Any]) -> Shape:
    from isophote.cli.subject import load_shape
    from isophote.io.mesh_file import load_mesh

    return load_shape(source) if is_python else load_mesh(source, **options)


def _saved(shape: Shape, target: Path, made: dict[str, Any], options: dict[str, Any]) -> Facts:
    """Write the shape, and what was written."""
    from isophote.cli.facts import triangle_count
    from isophote.io.field_file import check_mesh_target
    from isophote.io.save import save
    from isophote.shapes.field.field import Field
    from isophote.shapes.mesh import Mesh

    facts: Facts = {}
    if isinstance(shape, Field) and target.suffix.lower() != ".html":
        from isophote.convert.contour import sensible_cell, to_mesh

        check_mesh_target(target, options)
        if not made.keys() & {"cell", "tolerance"}:
            made["cell"] = sensible_cell(shape)
            log(f"cell {made['cell']:.4g}; --cell or --tolerance makes it finer or coarser")
        facts |= made
        shape = to_mesh(shape, **made)
    save(shape, target, **options)
    if isinstance(shape, Mesh):
        facts |= {"vertices": len(shape.vertices), "faces": shape.face_count, "triangles": triangle_count(shape)}
    facts["bytes"] = target.stat().st_size
    return facts


def _line(facts: Facts) -> str:
    mesh = f"{facts['triangles']:,} triangles, " if "triangles" in facts else ""
    return f"{facts['output']}: {mesh}{facts['bytes']:,} bytes, in {facts['seconds']:.2f} s"
