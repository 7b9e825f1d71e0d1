"""Which parts of patches lie within solids."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.kernels.base.table import Packed
from isophote.kernels.trace.covered import find_covered
from isophote.kernels.trace.wave import new_wave
from isophote.lower.field_table import scratch_words
from isophote.rendering.pool import Pool

__all__ = ["Coverage"]

_WAVE = 272
_NODES_A_JOB = 512


class Coverage:
    """Asks for the cells of patches that lie within solids of a scene; `solid` (items,) tells which items are closed
    and turned outward."""

    Bits: TypeAlias = npt.NDArray[np.int32]

    def __init__(self, scene: Packed, solid: npt.NDArray[np.bool_], threads: int | None) -> None:
        self._scene, self._threads = scene, threads
        self._solid = np.ascontiguousarray(solid, np.uint8)

    def __call__(self, patches: Packed, nodes: npt.NDArray[np.int64]) -> Bits:
        """(n,): a bit for each of the 4 × 4 cells of each patch."""
        found = np.zeros(len(nodes), np.int32)
        if not self._solid.any() or len(nodes) == 0:
            return found
        pool = Pool(self._threads)
        words = scratch_words(self._scene.arrays["fields"])
        waves = [new_wave(_WAVE, words) for _ in range(pool.threads)]

        def work(first: int, thread: int) -> None:
            last = min(first + _NODES_A_JOB, len(nodes))
            find_covered(self._scene.words, patches.words, waves[thread].words, nodes, self._solid, found, first, last)

        pool.run(work, range(0, len(nodes), _NODES_A_JOB), lambda done: None)
        if pool.interrupted:
            raise KeyboardInterrupt
        return found
