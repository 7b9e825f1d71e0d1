"""SCENE on the command line: a Python file that defines a scene or a shape, or a model."""

from __future__ import annotations

import contextlib
import os
import runpy
import sys
import traceback
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any, TypeAlias

from isophote.errors import Error, FileError, IsophoteWarning
from isophote.io.scene_file import load_scene
from isophote.scene.scene import Item, Scene, Shape, is_shape

__all__ = ["Subject", "load_shape", "load_subject", "strictly"]

Subject: TypeAlias = Scene | Item | Shape

_SHAPE_NAMES = ("part", "shape")


def load_subject(path: Path, *, strict: bool = False) -> Subject:
    """What a file describes: of a Python file `scene`, or else `part`, `shape` or its only shape; otherwise the scene
    in a model.

    A Python file runs in its own folder: it imports its neighbours and names files from there. Its `__name__` is not
    "__main__", and what it prints goes to stderr. With `strict`, whatever would be a warning is an error. Raises
    `FileError`, for a Python file that raises with the file's line.
    """
    with strictly(path) if strict else contextlib.nullcontext():
        if path.suffix.lower() == ".py":
            return _from_python(path)
        return load_scene(path, strict=strict)


def load_shape(path: Path) -> Shape:
    """The shape that a Python file defines: `part`, `shape`, or the only shape among its global names.

    It runs as `load_subject` runs it. Raises `FileError`.
    """
    defined = _run(path)
    for name in _SHAPE_NAMES:
        if name in defined:
            shape: Shape = defined[name]
            break
    else:
        named = _shapes(defined)
        if len({id(value) for value in named.values()}) != 1:
            several = f"several shapes ({', '.join(named)})" if named else "no shape"
            raise FileError(path, f"defines {several}; write `part = ...` for the one that is meant")
        name, shape = next(iter(named.items()))
    if not is_shape(shape):
        raise FileError(path, f"`{name}` must be a shape, but is a {type(shape).__name__}")
    return shape


@contextlib.contextmanager
def strictly(path: Path) -> Iterator[None]:
    """Turns an `IsophoteWarning` into a `FileError`."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", IsophoteWarning)
        try:
            yield
        except IsophoteWarning as warning:
            raise FileError(path, str(warning)) from warning


def _from_python(path: Path) -> Subject:
    defined = _run(path)
    for name in ("scene", *_SHAPE_NAMES):
        if name in defined:
            return _checked(path, name, defined[name])
    shapes = _shapes(defined)
    if len({id(shape) for shape in shapes.values()}) == 1:
        return next(iter(shapes.values()))
    several = f" but several shapes ({', '.join(shapes)})" if shapes else ""
    raise FileError(path, f"defines neither `scene` nor `shape`{several}; write `scene = isophote.Scene(...)`")


def _shapes(defined: dict[str, Any]) -> dict[str, Shape]:
    """The shapes among a file's global names."""
    return {name: value for name, value in defined.items() if is_shape(value) and not name.startswith("_")}


def _checked(path: Path, name: str, value: Any) -> Subject:
    if isinstance(value, Scene | Item) or is_shape(value):
        subject: Subject = value
        return subject
    raise FileError(path, f"`{name}` must be a Scene, an Item or a shape, but is a {type(value).__name__}")


def _run(path: Path) -> dict[str, Any]:
    """The global names of a Python file after it has run."""
    file = path.resolve()
    if not file.is_file():
        raise FileError(path, "cannot be read: there is no such file")
    try:
        with contextlib.redirect_stdout(sys.stderr), contextlib.chdir(file.parent), _importing_from(file.parent):
            return runpy.run_path(str(file), run_name="isophote_scene")
    except SystemExit as error:
        raise FileError(path, f"stops with SystemExit({error.code!r})", _line(file, error)) from error
    except OSError as error:
        if _line(file, error):
            raise _raised(path, file, error) from error
        raise FileError(path, f"cannot be read: {(error.strerror or str(error)).lower()}") from error
    except Exception as error:
        raise _raised(path, file, error) from error


@contextlib.contextmanager
def _importing_from(folder: Path) -> Iterator[None]:
    before = list(sys.path)
    sys.path.insert(0, os.fspath(folder))
    try:
        yield
    finally:
        sys.path[:] = before


def _raised(path: Path, file: Path, error: Exception) -> FileError:
    if isinstance(error, SyntaxError) and error.filename == str(file):
        return FileError(path, f"{type(error).__name__}: {error.msg}", f"line {error.lineno}")
    text = str(error)
    # Isophote's own messages speak for themselves.
    reason = text if isinstance(error, Error | IsophoteWarning) else f"{type(error).__name__}: {text}".rstrip(": ")
    return FileError(path, reason, _line(file, error))


def _line(file: Path, error: BaseException) -> str:
    """The last line of the file that was on the way to the error, as a place; empty where none was."""
    lines = [frame.lineno for frame in traceback.extract_tb(error.__traceback__) if frame.filename == str(file)]
    return f"line {lines[-1]}" if lines else ""
