"""Where compiled kernels are kept, and when they are stale.

Numba stamps a cached function with its own file only, so an edit in another file of `kernels/` would go
unseen. Here the stamp of every kernel is one digest over all of `kernels/` and the versions of what
compiles it, and the folder is the user's cache.
"""

from __future__ import annotations

import hashlib
import os
import sys
import tempfile
from functools import cache
from pathlib import Path

import llvmlite
import numba
import numpy as np
from numba.core import caching

__all__ = ["KernelLocator", "cache_folder", "install", "kernels_digest", "usable_folder"]

_KERNELS = Path(__file__).resolve().parent.parent


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
def kernels_digest() -> str:
    """Digest over the text of `kernels/` and the versions of Python, NumPy, Numba and LLVM."""
    digest = hashlib.sha256()
    for version in (sys.version, np.__version__, numba.__version__, llvmlite.__version__):
        digest.update(version.encode())
    for path in sorted(_KERNELS.rglob("*.py")):
        digest.update(path.relative_to(_KERNELS).as_posix().encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()


@cache
def usable_folder() -> Path:
    """Folder of this version's kernels, made; a temporary one where the cache folder is not writable."""
    folder = cache_folder() / kernels_digest()[:16]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=folder).close()
    except OSError:
        return Path(tempfile.mkdtemp(prefix="isophote-kernels-"))
    return folder


class KernelLocator(caching._CacheLocator):
    """Numba's cache locator for functions below `kernels/`."""

    def __init__(self, py_func, py_file):
        module = Path(py_file).resolve().relative_to(_KERNELS).with_suffix("")
        self._name = ".".join(module.parts)
        self._line = py_func.__code__.co_firstlineno

    def get_cache_path(self):
        return str(usable_folder())

    def get_source_stamp(self):
        return kernels_digest()

    def get_disambiguator(self):
        return f"{self._name}-{self._line}"

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
