"""`isophote selfcheck`: what is computed against what is exact."""

from __future__ import annotations

from typing import Annotated

import typer

from isophote.cli.messages import log, print_json

__all__ = ["EXAMPLES", "TOPICS", "selfcheck"]

# What can be checked by itself; what knows the checks loads slowly.
TOPICS = {
    "random-numbers": "sample patterns are even, stratified, unrelated",
    "materials": "reciprocity, energy, white furnace, samplers of every material",
    "lights": "irradiance of every kind of light, in closed form",
    "enclosures": "B = E / (1 − ρ) by path tracing and radiosity; white bodies under a white sky",
    "form-factors": "of polygons: unit squares, closure, reciprocity",
    "occlusion": "ambient occlusion beside a wall, in a bowl, below a ball",
    "rays": "every accelerator against all triangles; closed meshes",
    "fields": "rays and meshes of fields against formulas",
    "agreement": "radiosity and ray tracing against path tracing; threads",
}

_TOPICS = "\n".join(f"  {name:<16}{text}" for name, text in TOPICS.items())

EXAMPLES = f"""\b
Examples:
  isophote selfcheck
  isophote selfcheck --thorough
  isophote selfcheck form-factors --json

\b
Topics:
{_TOPICS}

The table says of each quantity what was measured, what it is exactly, by how much the two may differ (± either way, +
only above), and how long it took. Where chance is left, 4.5 standard errors are allowed: with another --seed one
check in 30,000 fails by chance. The first run on a machine compiles kernels, which takes a minute or two. The exit
status is 1 where a check fails. `isophote doctor` tells what the machine can do.
"""


def selfcheck(
    topics: Annotated[
        list[str] | None, typer.Argument(metavar="[TOPIC]...", help="What to check; everything if none is named.")
    ] = None,
    thorough: Annotated[
        bool,
        typer.Option(
            "--thorough/--quick",
            help="Take 16 times the samples, and allow a quarter of the noise.",
            show_default="quick",
        ),
    ] = False,
    seed: Annotated[int, typer.Option(metavar="N", help="Other random numbers.")] = 0,
    threads: Annotated[int | None, typer.Option(metavar="N", help="Threads.  [default: all processors]")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the result as JSON.")] = False,
) -> None:
    """Measure what is known exactly, and show what is right."""
    for topic in topics or ():
        if topic not in TOPICS:
            raise typer.BadParameter(f"{topic!r} is not one of {', '.join(TOPICS)}")
    from isophote.checks.run import selfcheck as check
    from isophote.cli.progress import progress

    report = check(topics or None, thorough=thorough, seed=seed, progress=progress(), threads=threads)
    if as_json:
        print_json(report.as_dict())
    else:
        typer.echo(str(report))
    if not report.passed:
        log(f"error: failed: {', '.join(f'{found.topic}, {found.name}' for found in report.failures)}")
        raise typer.Exit(1)
