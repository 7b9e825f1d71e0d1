"""The one tree of exceptions: each says what is wrong, where, and what would mend it."""

from __future__ import annotations

from os import PathLike, fspath

__all__ = ["Error", "FileError", "GeometryError", "IsophoteWarning", "RenderError", "SceneError"]


class Error(Exception):
    """Base of every exception that Isophote raises on purpose."""


class GeometryError(Error):
    """A shape cannot be what was asked: non-finite coordinates, faces out of range, no faces."""


class SceneError(Error):
    """A scene, camera, light or material is described by values that have no meaning."""


class RenderError(Error):
    """A picture cannot be made as asked: size, samples, method."""


class FileError(Error):
    """A file cannot be read or written.

    `path` is the file, `place` where in it (a line, a byte, a key; may be empty), `reason` what is wrong
    and what would mend it.
    """

    def __init__(self, path: str | PathLike[str], reason: str, place: str = "") -> None:
        self.path = fspath(path)
        self.place = place
        self.reason = reason
        where = f"{self.path}, {place}" if place else self.path
        super().__init__(f"{where}: {reason}")


class IsophoteWarning(UserWarning):
    """Something was replaced or left out, and the result is still usable: a missing texture, say."""
