"""What the machine is, and the folder of compiled kernels."""

from __future__ import annotations

import platform
import re
import shutil
import sys
from pathlib import Path
from typing import Any

import llvmlite
import llvmlite.binding
import numba
import numpy as np

from isophote import __version__
from isophote.kernels.base.cache import cache_folder, usable_folder
from isophote.rendering.pool import Pool
from isophote.rendering.warm import compiled

__all__ = ["cache_facts", "clean_cache", "machine_facts"]

# Those of LLVM's features that decide how fast kernels are.
_FEATURES = ("sse4.2", "avx", "avx2", "fma", "avx512f", "avx512vl", "neon", "sve")
_VERSION_FOLDER = re.compile(r"[0-9a-f]{16}")


def machine_facts() -> dict[str, Any]:
    """Versions, the processor as LLVM knows it, and how many of them this process may use."""
    features = llvmlite.binding.get_host_cpu_features()
    return {
        "isophote": __version__,
        "python": platform.python_version(),
        "executable": sys.executable,
        "system": platform.platform(),
        "numpy": np.__version__,
        "numba": numba.__version__,
        "llvmlite": llvmlite.__version__,
        "llvm": ".".join(map(str, llvmlite.binding.llvm_version_info)),
        "cpu": llvmlite.binding.get_host_cpu_name(),
        "features": [name for name in _FEATURES if features.get(name)],
        "processors": Pool().threads,
    }


def cache_facts() -> dict[str, Any]:
    """Where compiled kernels lie, what they take, and what other versions left."""
    folder, stale = usable_folder(), _stale_folders()
    return {
        "folder": str(folder),
        "writable": folder.parent == cache_folder(),
        "compiled": compiled(),
        "bytes": _bytes(folder),
        "stale_folders": len(stale),
        "stale_bytes": sum(map(_bytes, stale)),
    }


def clean_cache() -> list[str]:
    """Remove the kernels of other versions; the folders that are gone."""
    removed = []
    for folder in _stale_folders():
        shutil.rmtree(folder, ignore_errors=True)
        if not folder.exists():
            removed.append(str(folder))
    return removed


def _stale_folders() -> list[Path]:
    """Folders of other versions' kernels; whatever else lies in the cache is nobody's business."""
    used = usable_folder()
    try:
        found = sorted(cache_folder().iterdir())
    except OSError:
        return []
    return [
        folder
        for folder in found
        if folder != used and _VERSION_FOLDER.fullmatch(folder.name) and folder.is_dir() and not folder.is_symlink()
    ]


def _bytes(folder: Path) -> int:
    total = 0
    for path in folder.rglob("*"):
        try:
            total += path.stat().st_size if path.is_file() else 0
        except OSError:
            continue  # Another process has just replaced it.
    return total
