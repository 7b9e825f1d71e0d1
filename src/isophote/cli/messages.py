"""What the command line says: results to stdout, errors, warnings and logs as single lines to stderr."""

from __future__ import annotations

import json
import sys
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import typer

from isophote.errors import Error, IsophoteWarning

__all__ = ["log", "print_facts", "print_json", "shown"]


def log(text: str) -> None:
    """Say something beside the result."""
    print(f"isophote: {' '.join(text.split())}", file=sys.stderr, flush=True)


def print_json(facts: Mapping[str, Any]) -> None:
    """Print a result for programs. Numbers that JSON does not know become null."""
    typer.echo(json.dumps(_plain(facts), indent=2, ensure_ascii=False, allow_nan=False))


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(key): _plain(member) for key, member in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(member) for member in value]
    if isinstance(value, float) and not abs(value) < float("inf"):
        return None
    return value


def print_facts(facts: Mapping[str, str]) -> None:
    """Print a result for people: names on the left, values on the right, further lines of a value below it."""
    width = max(len(name) for name in facts) + 2
    for name, text in facts.items():
        typer.echo(f"{name:<{width}}" + text.replace("\n", "\n" + " " * width))


@contextmanager
def shown(traceback: bool = False) -> Iterator[None]:
    """Turns errors into a line on stderr and exit status 1, warnings into lines; `traceback` lets errors through."""
    with _warnings_as_lines():
        try:
            yield
        except Error as error:
            if traceback:
                raise
            _fail(f"error: {error}", error)
        except MemoryError as error:
            if traceback:
                raise
            _fail("error: there is not enough memory for this", error)
        except KeyboardInterrupt as error:
            _fail("interrupted", error)


def _fail(text: str, error: BaseException) -> None:
    log(text)
    raise typer.Exit(1) from error


@contextmanager
def _warnings_as_lines() -> Iterator[None]:
    with warnings.catch_warnings():
        warnings.simplefilter("always", IsophoteWarning)
        warnings.showwarning = _once(lambda text: log(f"warning: {text}"))
        yield


def _once(say: Callable[[str], None]) -> Callable[..., None]:
    said: set[str] = set()

    def show(message: Warning | str, *_: object, **__: object) -> None:
        text = str(message)
        if text not in said:
            said.add(text)
            say(text)

    return show
