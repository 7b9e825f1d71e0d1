"""First use on a machine: the kernels of contouring are compiled once, on two processors."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

from isophote.kernels.base.cache import is_compiled
from isophote.kernels.base.compiling import without_collecting
from isophote.kernels.forms import tape_entries
from isophote.kernels.measure import contour_brick, contour_faces, contour_faults, contour_regions
from isophote.progress import Reporter

__all__ = ["compile_others", "warm_up"]

_STAGE = "compiling kernels (first use on this machine)"
_OTHER_PROCESS = "from isophote.convert.contour_warm import compile_others; compile_others()"

_WORDS = "int64[::1]"
# The interpreters' functions.
_ENTRIES = ("_values", "_bounds", "_gradients")
_BRICK_KERNEL = (contour_brick, "contour_bricks", f"({_WORDS}, {_WORDS}, {_WORDS}, int64[::1], int64, int64, int64)")
_OTHERS = (
    (contour_regions, "find_bricks", f"({_WORDS}, {_WORDS}, int64, int64, int64[::1])"),
    (contour_faces, "index_bricks", f"({_WORDS}, int64, int64)"),
    (contour_faces, "find_vertices", f"({_WORDS}, int64[::1])"),
    (contour_faces, "write_faces", f"({_WORDS}, int64[::1], {_WORDS}, int64[::1])"),
    (contour_faces, "number_vertices", "(int32[:, ::1], int32[::1])"),
    (
        contour_faces,
        "place_vertices",
        "(float64[:, ::1], float64, float64[::1], int32[::1], float64[:, ::1])",
    ),
    (contour_faces, "mend_faces", f"({_WORDS}, int64, int32[:, ::1], int32[::1], {_WORDS}, int64)"),
    (contour_faults, "find_faults", f"({_WORDS}, int64[::1], int64[::1], int32[::1], int64[:, ::1])"),
)

# Stages that are done in this process.
_ready: set[str] = set()


def warm_up(report: Reporter) -> None:
    """Compile what is not in the cache yet, half of it in a second process; both write to the same cache."""
    # Looked at once: the cache's folder may hold thousands of files.
    if not _ready:
        kernels = [(module, name) for module, name, _ in (_BRICK_KERNEL, *_OTHERS)]
        kernels += [(tape_entries, name) for name in _ENTRIES]
        if not all(is_compiled(Path(module.__file__ or ""), name) for module, name in kernels):
            _compile_all(report)
        _ready.add(_STAGE)


def _compile_all(report: Reporter) -> None:
    report(_STAGE, 0.0)
    other = None
    if sys.executable:
        silent = subprocess.DEVNULL
        other = subprocess.Popen([sys.executable, "-c", _OTHER_PROCESS], stdout=silent, stderr=silent)
    try:
        _compile(_BRICK_KERNEL)
    finally:
        if other is not None:
            other.wait()
    report(_STAGE, 0.6)
    # From the cache now, or here if the other process could not.
    compile_others()
    report(_STAGE, 1.0)


def compile_others() -> None:
    """Compile what contouring needs besides its longest kernel."""
    with without_collecting():
        tape_entries.pack_interpreters()
    for kernel in _OTHERS:
        _compile(kernel)


@without_collecting()
def _compile(kernel: tuple[Any, str, str]) -> None:
    module, name, signature = kernel
    getattr(module, name).compile(signature)
