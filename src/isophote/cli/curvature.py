"""`isophote curvature`: how a mesh bends, in numbers and as a picture."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from isophote.cli.messages import print_facts, print_json
from isophote.cli.options import one_of, picture_size

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from isophote.shapes.mesh import Mesh

__all__ = ["EXAMPLES", "curvature"]

EXAMPLES = """\b
Examples:
  isophote curvature bunny.obj
  isophote curvature bunny.obj -o bent.png --kind mean
  isophote curvature scan.ply -o ridges.png --kind k1 --rings 4 --json

Curvature is in 1 / the file's unit of length (gaussian in its square), positive where the surface bends like a sphere
seen from outside. The picture is blue where it is negative, red where it is positive; --limit sets what is darkest.
"""
_KINDS = ("gaussian", "mean", "k1", "k2")
_PERCENT = (2, 50, 98)


def curvature(
    model: Annotated[Path, typer.Argument(metavar="MODEL", help="A mesh file.")],
    output: Annotated[Path | None, typer.Option("-o", "--output", metavar="FILE", help="Draw it to a picture.")] = None,
    kind: Annotated[
        str, typer.Option(metavar="|".join(_KINDS), callback=one_of(_KINDS), help="Which curvature.")
    ] = "gaussian",
    degree: Annotated[int, typer.Option(metavar="2|3|4", help="Degree of the polynomial around each vertex.")] = 3,
    rings: Annotated[int, typer.Option(metavar="N", help="Edges that it reaches; more smooth noise.")] = 2,
    limit: Annotated[float | None, typer.Option(metavar="X", help="Curvature at the ends of the scale.")] = None,
    size: Annotated[str, typer.Option(metavar="WxH", help="Width and height of the picture.")] = "640x480",
    as_json: Annotated[bool, typer.Option("--json", help="Print the result as JSON.")] = False,
) -> None:
    """Measure the curvature of a mesh, and draw it."""
    pixels = picture_size(size)
    if limit is not None and not 0 < limit < float("inf"):
        raise typer.BadParameter(f"--limit must be a number above 0, not {limit}")
    from isophote.analysis.curvature.discrete import curvature_totals
    from isophote.io.mesh_file import load_mesh
    from isophote.io.picture_file import check_picture_path

    if output is not None:
        check_picture_path(output)
    mesh = load_mesh(model)
    values = _values(mesh, kind, degree, rings)
    totals = curvature_totals(mesh)
    facts = {"file": str(model), "kind": kind, "vertices": len(values), **_spread(values)}
    facts |= {
        "total_gaussian": totals.gaussian,
        "total_boundary": totals.boundary,
        "total_mean": totals.mean,
        "euler": totals.euler,
    }
    if output is not None:
        _draw(mesh, values, limit, output, pixels)
        facts["picture"] = str(output)
    if as_json:
        print_json(facts)
    else:
        print_facts({name.replace("_", " "): _text(value) for name, value in facts.items()})


def _values(mesh: Mesh, kind: str, degree: int, rings: int) -> npt.NDArray[np.float64]:
    from isophote.analysis.curvature.fit import principal_curvatures

    found = principal_curvatures(mesh, degree, rings)
    return {"gaussian": found.k1 * found.k2, "mean": (found.k1 + found.k2) / 2, "k1": found.k1, "k2": found.k2}[kind]


def _spread(values: npt.NDArray[np.float64]) -> dict[str, Any]:
    import numpy as np

    known = values[np.isfinite(values)]
    if len(known) == 0:
        return {"unknown": len(values)}
    shares = dict(zip((f"percentile_{p}" for p in _PERCENT), np.percentile(known, _PERCENT).tolist(), strict=True))
    ends = {"least": float(known.min()), "greatest": float(known.max()), "mean": float(known.mean())}
    return {**ends, **shares, "unknown": len(values) - len(known)}


def _draw(
    mesh: Mesh, values: npt.NDArray[np.float64], limit: float | None, output: Path, size: tuple[int, int]
) -> None:
    from isophote.analysis.colouring import coloured
    from isophote.cli.progress import progress
    from isophote.rendering.render import render

    item = coloured(mesh, values, None if limit is None else (-limit, limit))
    render(item, size=size, progress=progress()).save(output)


def _text(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else f"{value:,}" if isinstance(value, int) else str(value)
