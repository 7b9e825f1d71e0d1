"""Running the command line inside the tests' process, and files to run it on."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from typer.testing import CliRunner

from isophote.cli.main import app

QUICK = ("--size", "16x12", "--samples", "1")

TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
"""A triangle as an OBJ file."""

SCENE = """import isophote as iso
scene = iso.Scene(
    [iso.Item(iso.Mesh([(-1, -1, 0), (1, -1, 0), (0, 1, 0)], [(0, 1, 2)]), iso.Matte("tomato"))],
    lights=[iso.Sky("white")],
    camera=iso.Camera((0, 0, 3), (0, 0, 0)),
)
"""
"""A scene as a Python file."""


def run(*arguments: object) -> Any:
    """The result of `isophote ARGUMENTS`; an exception that would be a traceback is raised."""
    result = CliRunner().invoke(app, [str(argument) for argument in arguments])
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    assert "Traceback" not in result.stderr
    return result


def succeeds(*arguments: object) -> str:
    """What a command that ends with status 0 prints on stdout."""
    result = run(*arguments)
    assert result.exit_code == 0, result.stderr
    return str(result.stdout)


def facts(*arguments: object) -> dict[str, Any]:
    """What a command prints as JSON."""
    read: dict[str, Any] = json.loads(succeeds(*arguments, "--json"))
    return read


def refuses(*arguments: object) -> str:
    """The message of a command that fails: one line on stderr, nothing on stdout, status 1."""
    result = run(*arguments)
    assert result.exit_code == 1, (result.stdout, result.stderr)
    assert result.stdout == ""
    lines = [line for line in result.stderr.splitlines() if not line.startswith("isophote: warning: ")]
    assert len(lines) == 1, lines
    assert lines[0].startswith("isophote: error: ")
    return lines[0].removeprefix("isophote: error: ")


def misused(*arguments: object) -> str:
    """The message of a command that is written wrongly: status 2."""
    result = run(*arguments)
    assert result.exit_code == 2, (result.stdout, result.stderr)
    assert result.stdout == ""
    return str(result.stderr)


def written(folder: Path, name: str, content: str | bytes) -> Path:
    """A file with this content."""
    path = folder / name
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path
