"""What every writer needs: a whole file, or none."""

from __future__ import annotations

import secrets
from collections.abc import Iterator
from contextlib import contextmanager
from os import PathLike, replace
from pathlib import Path
from typing import TypeAlias

from isophote.errors import FileError

__all__ = ["StrPath", "replacing", "write_bytes"]

StrPath: TypeAlias = str | PathLike[str]


@contextmanager
def replacing(path: StrPath) -> Iterator[Path]:
    """A temporary file beside `path` that takes its place when the block ends without an exception.

    A symbolic link stays and its target is replaced. Raises `FileError` when the folder cannot be written
    and when `path` is something that is no plain file.
    """
    target, temporary = _beside(path)
    try:
        yield temporary
        replace(temporary, target)
    except OSError as error:
        raise FileError(path, f"cannot be written: {_reason(error)}") from error
    finally:
        temporary.unlink(missing_ok=True)


def check_writable(path: StrPath) -> None:
    """Raise the `FileError` that writing to `path` would raise; a file that is there stays as it is."""
    target, temporary = _beside(path)
    try:
        # A name may be too long for a file and still short enough for the temporary one.
        target.lstat()
    except FileNotFoundError:
        pass
    except OSError as error:
        raise FileError(path, f"cannot be written: {_reason(error)}") from error
    finally:
        temporary.unlink(missing_ok=True)


def _beside(path: StrPath) -> tuple[Path, Path]:
    """What `path` stands for, and an empty temporary file beside it."""
    try:
        target = Path(path).resolve()
        if target.exists() and not target.is_file():
            raise FileError(path, "cannot be written: it is a folder or a device")
        # The ending stays, since some writers go by it.
        temporary = target.with_name(f".{target.stem[:100]}.{secrets.token_hex(4)}{target.suffix}")
        temporary.touch(exist_ok=False)
    except (OSError, ValueError, RuntimeError) as error:
        raise FileError(path, f"cannot be written: {_reason(error)}") from error
    return target, temporary


def write_bytes(path: StrPath, data: bytes) -> None:
    """Write a whole file at once. Raises `FileError` when it cannot be written."""
    with replacing(path) as temporary:
        temporary.write_bytes(data)


def _reason(error: Exception) -> str:
    return (getattr(error, "strerror", None) or str(error) or type(error).__name__).lower()
