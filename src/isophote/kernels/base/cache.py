"""Where compiled kernels are kept, and when they are stale.

Numba stamps a cached function with its own file only, so an edit in another file that it calls would go unseen.
Here the stamp of a kernel is a digest over its file and all files of `kernels/` that it imports, directly or not, and
is part of the name under which it is kept: an edit makes just what depends on it be compiled again, and two checkouts
never see each other's code. The folder is the user's cache, a folder below it for each set of versions.
"""

from __future__ import annotations

import hashlib
import os
import re
import sys
import tempfile
from functools import cache
from pathlib import Path

import llvmlite
import numba
import numpy as np
from numba.core import caching

__all__ = [
    "KernelLocator",
    "cache_folder",
    "install",
    "is_compiled",
    "source_digest",
    "sources_of",
    "usable_folder",
]

_KERNELS = Path(__file__).resolve().parent.parent
_DIGITS = 16
# Modules of `kernels/` in import statements, and the names taken from them. Parsing would take ten times as long, at
# every start.
_IMPORT = re.compile(r"^\s*(?:from|import) (isophote\.kernels[\w.]*)(?: import (\([^)]*\)|[^\n]*))?", re.MULTILINE)


def cache_folder() -> Path:
    """Folder of the compiled kernels: `$ISOPHOTE_CACHE_DIR`, else the user's cache folder."""
    named = os.environ.get("ISOPHOTE_CACHE_DIR")
    if named:
        return Path(named)
    if sys.platform == "win32":
        base = Path(os.environ.get("LOCALAPPDATA", Path.home() / "AppData" / "Local"))
    elif sys.platform == "darwin":
        base = Path.home() / "Library" / "Caches"
    else:
        base = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache"))
    return base / "isophote" / "kernels"


@cache
def _versions_digest() -> str:
    """Digest over the versions of Python, NumPy, Numba and LLVM."""
    versions = (sys.version, np.__version__, numba.__version__, llvmlite.__version__)
    return hashlib.sha256("\n".join(versions).encode()).hexdigest()


@cache
def _imports(path: Path) -> tuple[Path, ...]:
    """Files of `kernels/` that a file imports, and the packages that they lie in."""
    files = []
    for module, names in _IMPORT.findall(path.read_text("utf-8")):
        place = _KERNELS.joinpath(*module.split(".")[2:])
        for at in (place, *(place / name for name in re.findall(r"\w+", names))):
            files += [file for file in (at.with_suffix(".py"), at / "__init__.py") if file.is_file()]
    return tuple(files)


@cache
def sources_of(path: Path) -> tuple[Path, ...]:
    """A file of `kernels/` and all others there that it imports, directly or not, in the order of their names."""
    found: set[Path] = set()
    following = [path]
    while following:
        file = following.pop()
        if file not in found:
            found.add(file)
            following += _imports(file)
    return tuple(sorted(found))


@cache
def source_digest(path: Path) -> str:
    """Digest over the text of `sources_of` a file."""
    digest = hashlib.sha256()
    for source in sources_of(path):
        digest.update(source.relative_to(_KERNELS).as_posix().encode())
        digest.update(source.read_bytes())
    return digest.hexdigest()


@cache
def usable_folder() -> Path:
    """Folder of these versions' kernels, made; a temporary one where the cache folder is not writable."""
    folder = cache_folder() / _versions_digest()[:16]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=folder).close()
    except OSError:
        return Path(tempfile.mkdtemp(prefix="isophote-kernels-"))
    return folder


def is_compiled(path: Path, function: str) -> bool:
    """Whether the kernel `function` of a file lies in the cache as it is now."""
    return any(usable_folder().glob(f"*{function}-*-{source_digest(path)[:_DIGITS]}*.nbi"))


class KernelLocator(caching._CacheLocator):
    """Numba's cache locator for functions below `kernels/`."""

    def __init__(self, py_func, py_file):
        self._path = Path(py_file).resolve()
        self._name = ".".join(self._path.relative_to(_KERNELS).with_suffix("").parts)
        self._line = py_func.__code__.co_firstlineno

    def get_cache_path(self):
        return str(usable_folder())

    def get_source_stamp(self):
        return source_digest(self._path)

    def get_disambiguator(self):
        return f"{self._name}-{self._line}-{source_digest(self._path)[:_DIGITS]}"

    @classmethod
    def from_function(cls, py_func, py_file):
        if _KERNELS not in Path(py_file).resolve().parents:
            return None
        return cls(py_func, py_file)


def install() -> None:
    """Let Numba ask `KernelLocator` first; other packages' functions go on to Numba's own locators."""
    classes = caching.CacheImpl._locator_classes
    if KernelLocator not in classes:
        classes.insert(0, KernelLocator)
