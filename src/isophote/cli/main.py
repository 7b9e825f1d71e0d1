"""The command `isophote`: its verbs, and what is the same for all of them."""

from __future__ import annotations

from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from isophote import __version__
from isophote.cli import bake, convert, curvature, doctor, explain, info, render, selfcheck, voronoi
from isophote.cli.messages import shown

__all__ = ["app", "main"]

_HELP = """Describe 3D shapes, render them, look into their files.

\b
First steps:
  isophote render bunny.obj -o bunny.png
  isophote info bunny.obj
  isophote doctor

Results go to standard output, progress and messages to standard error. The exit status is 0, or 1 where something
failed, or 2 where the command was written wrongly. `isophote VERB --help` explains a verb and shows examples.
"""


class _Verbs(TyperGroup):
    """Runs a verb with errors and warnings shown as lines."""

    def invoke(self, ctx: Any) -> Any:
        with shown(traceback=ctx.params.get("traceback", False)):
            return super().invoke(ctx)


app = typer.Typer(
    name="isophote",
    cls=_Verbs,
    help=_HELP,
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
)
app.command("render", epilog=render.EXAMPLES)(render.render)
app.command("explain", epilog=explain.EXAMPLES)(explain.explain)
app.command("bake", epilog=bake.EXAMPLES)(bake.bake)
app.command("info", epilog=info.EXAMPLES)(info.info)
app.command("convert", epilog=convert.EXAMPLES)(convert.convert)
app.command("curvature", epilog=curvature.EXAMPLES)(curvature.curvature)
app.command("voronoi", epilog=voronoi.EXAMPLES)(voronoi.voronoi)
app.command("selfcheck", epilog=selfcheck.EXAMPLES)(selfcheck.selfcheck)
app.command("doctor", epilog=doctor.EXAMPLES)(doctor.doctor)


def _version(asked: bool) -> None:
    if asked:
        typer.echo(f"isophote {__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version and stop.")
    ] = False,
    traceback: Annotated[bool, typer.Option("--traceback", help="Show where in the code an error arose.")] = False,
) -> None:
    del version, traceback  # Both have done their work by now: see `_version` and `_Verbs`.


def main() -> None:
    """The command `isophote`."""
    app(prog_name="isophote")
