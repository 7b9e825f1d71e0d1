"""The last step: what leaves see of the light that links are not sure of, by rays of their own."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.kernels.base.table import Packed
from isophote.kernels.trace.doubtful_light import BATCH, CHANCES, PROVED, doubtful_light
from isophote.kernels.trace.wave import new_wave
from isophote.lower.field_table import scratch_words
from isophote.progress import Reporter
from isophote.rendering.pool import Pool
from isophote.rendering.radiosity.expansion import Expansion
from isophote.rendering.radiosity.links import Links, level
from isophote.rendering.radiosity.tree import PatchTree

__all__ = ["Doubt"]

Points: TypeAlias = npt.NDArray[np.float64]
Numbers: TypeAlias = npt.NDArray[np.int64]

_WAVE = 272
_LEAVES_A_JOB = 64


class Doubt(Expansion):
    """Links that do not prove all to be visible, with factors as if all were."""

    def __init__(self, scene: Packed, tree: PatchTree, links: Links, light: Points, threads: int | None) -> None:
        self._scene, self._light = scene, light
        self._solid = np.ascontiguousarray(tree.faces.solid, np.uint8)
        a, b = links.pairs.T
        receivers, sources = np.concatenate([a, b]), np.concatenate([b, a])
        unsure, shares = np.tile(links.seen[:, 2] > 0, 2), links.shares.T.reshape(-1)
        counts = (level(light)[sources] > 0) & (unsure | _parted(tree)[receivers])
        shares = np.where(unsure, shares, PROVED)[counts]
        super().__init__(tree, receivers[counts], sources[counts], shares, level(light), threads, whole=True)

    def corrections(self, arriving: Points, allowed: Points, most: int, report: Reporter) -> Points:
        """(leaves, 3): irradiance beside `arriving` (leaves, 3), which links tell of, to a standard error of `allowed`
        (leaves,), by `most` rays a leaf at most."""
        found, count = np.zeros((len(self.leaves), 3)), len(self.leaves)
        pool, words, room = Pool(self._threads), scratch_words(self._scene.arrays["fields"]), self._most_sources()
        waves = [new_wave(_WAVE, words) for _ in range(pool.threads)]
        chances = [np.zeros((room, CHANCES)) for _ in waves]
        picked = [np.zeros(room, np.int64) for _ in waves]
        ends = [np.zeros(BATCH, np.int64) for _ in waves]
        tone = level(self._light)

        def work(first: int, thread: int) -> None:
            doubtful_light(
                self._scene.words,
                self._patches.words,
                waves[thread].words,
                self._solid,
                self._starts,
                self._near_starts,
                self._sources,
                self._shares,
                self._far_factors,
                self._near_factors,
                self._light,
                tone,
                self._tree.parent,
                self.leaves,
                arriving,
                allowed,
                most,
                chances[thread],
                picked[thread],
                ends[thread],
                found,
                first,
                min(first + _LEAVES_A_JOB, count),
            )

        jobs = range(0, count, _LEAVES_A_JOB)
        pool.run(work, jobs, lambda done: report("gathering what is in doubt", done / max(len(jobs), 1)))
        if pool.interrupted:
            raise KeyboardInterrupt
        return found

    def _most_sources(self) -> int:
        """Entries that count for any one leaf, its own and those of what it is part of, at most."""
        counts, parent = np.diff(self._starts), self._tree.parent
        for node in np.split(self._order, np.cumsum(np.bincount(self._tree.depth))[:-1])[1:]:
            counts[node] += np.where(parent[node] >= 0, counts[np.maximum(parent[node], 0)], 0)
        return int((counts + np.diff(self._near_starts)).max(initial=0)) + 1


def _parted(tree: PatchTree) -> npt.NDArray[np.bool_]:
    """(nodes,): whether a leaf that is partly within a solid is part of each node."""
    found: npt.NDArray[np.bool_] = (tree.covered != 0) & (tree.first_child < 0)
    for depth in range(int(tree.depth.max()), 0, -1):
        own = np.flatnonzero((tree.depth == depth) & found & (tree.parent >= 0))
        found[tree.parent[own]] = True
    return found
