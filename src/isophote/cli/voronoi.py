"""`isophote voronoi`: diagrams of points from a file, drawn, and Fortune's sweep as a moving picture."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from isophote.cli.messages import print_facts, print_json
from isophote.cli.options import picture_size

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    from isophote.analysis.diagrams.result import Voronoi

__all__ = ["EXAMPLES", "voronoi"]

EXAMPLES = """\b
Examples:
  isophote voronoi points.csv -o cells.svg
  isophote voronoi points.csv -o cells.png --size 800x600 --lloyd 20
  isophote voronoi points.csv --animate sweep.gif
  isophote voronoi points.csv --json

The file holds a point a line, x and y, parted by commas, semicolons or blanks; a first line of names is passed over.
Cells are clipped to the box of the points with some room. The moving picture shows the sweep line rising, the beach
line of parabolas behind it, and the edges that their meetings draw.
"""
_MOST_FRAMES = 120


def voronoi(
    points: Annotated[Path, typer.Argument(metavar="POINTS", help="A file with x, y a line.")],
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="FILE", help="Draw it: .svg or a picture.")
    ] = None,
    animate: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Draw the sweep as a moving picture: .gif, .webp or .png.")
    ] = None,
    lloyd: Annotated[int, typer.Option(metavar="N", help="First move sites to their cells' centroids, N times.")] = 0,
    size: Annotated[str, typer.Option(metavar="WxH", help="Width and height of pictures.")] = "640x480",
    as_json: Annotated[bool, typer.Option("--json", help="Print the result as JSON.")] = False,
) -> None:
    """Make the Voronoi diagram of points, and draw it."""
    pixels = picture_size(size)
    if lloyd < 0:
        raise typer.BadParameter(f"--lloyd must be 0 or more, not {lloyd}")
    from isophote.analysis.diagrams.build import lloyd as relaxed
    from isophote.analysis.diagrams.build import voronoi as diagram
    from isophote.cli.voronoi_picture import check_targets, draw, draw_sweep
    from isophote.io.points_file import read_points

    check_targets(output, animate, pixels)
    sites = read_points(points)
    found = relaxed(sites, iterations=lloyd) if lloyd else diagram(sites)
    facts = {"file": str(points), **_facts(found)}
    if output is not None:
        draw(found, output, pixels)
        facts["picture"] = str(output)
    if animate is not None:
        facts["frames"] = draw_sweep(found, animate, pixels, _MOST_FRAMES)
        facts["animation"] = str(animate)
    if as_json:
        print_json(facts)
    else:
        print_facts({name.replace("_", " "): _text(value) for name, value in facts.items()})


def _facts(found: Voronoi) -> dict[str, Any]:
    present = found.cells.present
    areas: npt.NDArray[np.float64] = found.cells.areas[present]
    facts: dict[str, Any] = {
        "points": len(found.points),
        "cells": int(present.sum()),
        "repeated_points": int((~present).sum()),
        "vertices": len(found.vertices),
        "edges": len(found.edges),
        "endless_edges": int((found.edges[:, 1] < 0).sum()),
        "bounds": [found.bounds.min(axis=0).tolist(), found.bounds.max(axis=0).tolist()],
    }
    if len(areas):
        facts |= {"least_area": float(areas.min()), "mean_area": float(areas.mean())}
        facts |= {"greatest_area": float(areas.max())}
    return facts


def _text(value: Any) -> str:
    if isinstance(value, list):
        return "\n".join("  ".join(f"{coordinate:.6g}" for coordinate in corner) for corner in value)
    return f"{value:.6g}" if isinstance(value, float) else f"{value:,}" if isinstance(value, int) else str(value)
