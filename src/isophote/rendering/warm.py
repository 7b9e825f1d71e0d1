"""First use on a machine: kernels are compiled once, on two processors, with a bar."""

from __future__ import annotations

import gc
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from numba.core import event

from isophote.accel.tree import build_triangles
from isophote.kernels.base.cache import is_compiled
from isophote.kernels.base.table import Table
from isophote.kernels.trace import first_hit, path, tables, wave
from isophote.progress import Reporter

__all__ = ["compiled", "warm_up"]

STAGE = "compiling kernels (first use on this machine)"

# Functions that one picture compiles; only the bar depends on it.
_FUNCTIONS = 100
_OTHER_PROCESS = "from isophote.rendering.warm import compile_others; compile_others()"


def compiled() -> bool:
    """Whether the kernels of a picture lie in the cache."""
    kernels = ((path, "path_trace_tile"), (first_hit, "first_hits"))
    return all(is_compiled(Path(module.__file__ or ""), name) for module, name in kernels)


@contextmanager
def _without_collecting() -> Iterator[None]:
    """Pause the collection of cyclic garbage, which takes a sixth of compiling and finds next to nothing."""
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()


@_without_collecting()
def compile_others() -> None:
    """Compile what a picture needs besides its method: the tree's builder, and first hits."""
    build_triangles(np.eye(3, dtype=np.float32), np.array([[0, 1, 2]], np.int32), threads=1)
    first_hit.first_hits(_words(tables.SCENE), _words(first_hit.FEATURES), 0, 0, 0)


@_without_collecting()
def compile_path_tracer() -> None:
    """Compile the path tracer: a tile without pixels needs no tables."""
    words = (_words(table) for table in (tables.SCENE, tables.PLAN, tables.FILM))
    path.path_trace_tile(*words, wave.new_wave(1).words, 0, 0, 0, 0, 0, 0)


def _words(table: Table) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
    return np.zeros(3 * table.size, np.int64)


def warm_up(report: Reporter) -> None:
    """Compile what is not in the cache yet, half of it in a second process; both write to the same cache."""
    if compiled():
        return
    with _counted(report):
        other = None
        if sys.executable:
            other = subprocess.Popen(
                [sys.executable, "-c", _OTHER_PROCESS], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
            )
        try:
            compile_path_tracer()
        finally:
            if other is not None:
                other.wait()
        # From the cache now, or here if the other process could not.
        compile_others()


class _Counter(event.Listener):
    """Turns Numba's compilation events into a fraction."""

    def __init__(self, report: Reporter) -> None:
        self._report = report
        self._count = 0

    def on_start(self, event: object) -> None:
        self._report(STAGE, min(self._count / _FUNCTIONS, 0.99))

    def on_end(self, event: object) -> None:
        self._count += 1


@contextmanager
def _counted(report: Reporter) -> Iterator[None]:
    report(STAGE, 0.0)
    with event.install_listener("numba:compile", _Counter(report)):
        yield
    report(STAGE, 1.0)
