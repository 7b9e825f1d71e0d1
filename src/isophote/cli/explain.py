"""`isophote explain`: why a pixel of a picture has its colour."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from isophote.cli.messages import print_json
from isophote.cli.options import picture_size

__all__ = ["EXAMPLES", "explain"]

EXAMPLES = """\b
Examples:
  isophote explain glasses.py --pixel 320,240
  isophote explain bunny.obj --size 800x800 --pixel 400,300 -o rays.png
  isophote explain room.glb --depth 3 --json

Tells the rays that `isophote render --method ray` with the same size, seed and settings would follow for that pixel:
what each hits, what each light adds there, and how it all adds up to the colour. The picture shows the rays in the
scene.
"""


def explain(
    scene: Annotated[
        Path,
        typer.Argument(
            metavar="SCENE", help="A Python file that defines `scene` or `shape`, a glTF, an OBJ or any mesh file."
        ),
    ],
    pixel: Annotated[
        str | None, typer.Option(metavar="X,Y", help="Column and row, from the upper left.  [default: the middle]")
    ] = None,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="FILE", help="Draw the rays in the scene into a picture.")
    ] = None,
    samples: Annotated[int, typer.Option(metavar="N", help="Rays of the camera for the pixel.")] = 1,
    depth: Annotated[int, typer.Option(metavar="N", help="Rays in a row at most.")] = 6,
    light_samples: Annotated[int, typer.Option(metavar="N", help="Shadow rays to each light with a size.")] = 4,
    size: Annotated[str, typer.Option(metavar="WxH", help="Size of the picture that the pixel is in.")] = "640x480",
    seed: Annotated[int, typer.Option(metavar="N", help="As for the picture.")] = 0,
    as_json: Annotated[bool, typer.Option("--json", help="Print everything as JSON.")] = False,
) -> None:
    """Tell why a pixel has its colour."""
    where = None if pixel is None else _pixel(pixel)
    dimensions = picture_size(size)
    from isophote.cli.subject import load_subject
    from isophote.io.picture_file import check_picture_path
    from isophote.rendering.explanation.explain import explain as explain_pixel
    from isophote.rendering.ray_trace import RayTrace

    if output is not None:
        check_picture_path(output)
    target = output.resolve() if output is not None else None
    method = RayTrace(depth=depth, samples=samples, light_samples=light_samples)
    found = explain_pixel(load_subject(scene), where, method=method, size=dimensions, seed=seed)
    if target is not None:
        found.picture().save(target)
    if as_json:
        print_json(found.data())
    else:
        typer.echo(str(found))


def _pixel(text: str) -> tuple[int, int]:
    try:
        x, y = (int(part) for part in text.split(","))
    except ValueError:
        raise typer.BadParameter(
            f"{text!r} is no pixel; write column and row as 320,240", param_hint="--pixel"
        ) from None
    return x, y
