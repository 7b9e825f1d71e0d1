"""The balance of light over a tree of linked patches, B = E + ρ (H + Σ F B), by bounces."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.kernels.measure.link_gather import gather_links
from isophote.kernels.trace.leaf_factors import count_links, leaf_factors, place_irradiance
from isophote.rendering.pool import Pool
from isophote.rendering.radiosity.links import Links
from isophote.rendering.radiosity.tree import PatchTree

__all__ = ["Balance"]

Points: TypeAlias = npt.NDArray[np.float64]
Numbers: TypeAlias = npt.NDArray[np.int64]

_NODES_A_JOB, _LEAVES_A_JOB = 4096, 256


class Balance:
    """Links of the leaves, theirs and those of all nodes above them, made once for many bounces."""

    def __init__(self, tree: PatchTree, links: Links, threads: int | None) -> None:
        self._tree, self._threads = tree, threads
        self._patches = tree.packed()
        lit = links.seen[:, 0] > 0
        a, b = links.pairs[lit].T
        receiver, source = np.concatenate([a, b]), np.concatenate([b, a])
        order = np.argsort(receiver, kind="stable")
        self._sources = np.ascontiguousarray(source[order].astype(np.int32))
        self._visible = np.tile(links.seen[lit, 0], 2)[order]
        self._starts = np.concatenate([[0], np.cumsum(np.bincount(receiver, minlength=len(tree)))])
        depths = np.argsort(tree.depth, kind="stable")
        self._levels = np.split(depths, np.cumsum(np.bincount(tree.depth))[:-1])
        self.leaves = tree.leaves
        self._expand()

    def _expand(self) -> None:
        counts = np.zeros(len(self.leaves), np.int64)
        count_links(self._tree.parent, self._starts, self.leaves, counts)
        self._leaf_starts = np.concatenate([[0], np.cumsum(counts)])
        total = int(self._leaf_starts[-1])
        self._leaf_sources, self._factors = np.zeros(total, np.int32), np.zeros(total, np.float32)

        def work(first: int, last: int) -> None:
            leaf_factors(
                self._patches.words,
                self._tree.parent,
                self._starts,
                self._sources,
                self._visible,
                self.leaves,
                self._leaf_starts,
                self._leaf_sources,
                self._factors,
                first,
                last,
            )

        self._run(work, len(self.leaves), _LEAVES_A_JOB)

    def _run(self, work: Callable[[int, int], None], count: int, step: int) -> None:
        pool = Pool(self._threads)
        jobs = range(0, count, step)
        pool.run(lambda first, thread: work(first, min(first + step, count)), jobs, lambda done: None)
        if pool.interrupted:
            raise KeyboardInterrupt

    def gathered(self, light: Points) -> Points:
        """(leaves, 3): irradiance of every leaf, from the radiosity `light` of all nodes."""
        arriving = np.zeros((len(self.leaves), 3))

        def work(first: int, last: int) -> None:
            gather_links(self._leaf_starts, self._leaf_sources, self._factors, light, arriving, first, last)

        self._run(work, len(arriving), _NODES_A_JOB)
        return arriving

    def at_places(self, light: Points, nodes: Numbers, places: Points) -> Points:
        """(n, 3): irradiance at places on patches."""
        found = np.zeros((len(nodes), 3))

        def work(first: int, last: int) -> None:
            place_irradiance(
                self._patches.words,
                self._tree.parent,
                self._starts,
                self._sources,
                self._visible,
                light,
                nodes,
                places,
                found,
                first,
                last,
            )

        self._run(work, len(nodes), _LEAVES_A_JOB)
        return found

    def pulled(self, light: Points) -> Points:
        """`light` (n, 3) of the leaves, and means of it for all nodes above, by the areas that lie within no solid."""
        tree = self._tree
        weight = (tree.areas * tree.open)[:, None]
        found = np.concatenate([light * weight, weight], axis=1)
        found[tree.first_child >= 0] = 0.0
        for nodes in reversed(self._levels[1:]):
            own = nodes[tree.parent[nodes] >= 0]
            np.add.at(found, tree.parent[own], found[own])
        means: Points = found[:, :3] / np.where(found[:, 3:] > 0, found[:, 3:], 1.0)
        return means

    def bounced(self, light: Points, direct: Points) -> Points:
        """Radiosity after one more bounce: emission and what is reflected of direct light and of `light`."""
        tree, leaves = self._tree, self.leaves
        after = np.zeros((len(tree), 3))
        after[leaves] = tree.emission[leaves] + tree.albedo[leaves] * (direct[leaves] + self.gathered(light))
        return self.pulled(after)

    def unevenness(self, light: Points) -> Points:
        """(n,): standard deviation of the leaves' radiosities within every node."""
        tone = light.mean(axis=1)
        square = np.zeros((len(tone), 3))
        square[self.leaves, 0] = tone[self.leaves] ** 2
        mean_square = self.pulled(square)[:, 0]
        spread: Points = np.sqrt(np.maximum(mean_square - tone**2, 0.0))
        return spread

    def form_factor_sums(self) -> Points:
        """(leaves,): Σ F over all that each leaf is linked to; 1 in closed rooms."""
        if len(self._factors) == 0:
            return np.zeros(len(self.leaves))
        sums: Points = np.add.reduceat(np.append(self._factors, 0).astype(np.float64), self._leaf_starts[:-1])
        return np.where(np.diff(self._leaf_starts) > 0, sums, 0.0)
