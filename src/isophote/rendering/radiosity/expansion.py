"""How light of linked nodes falls on leaves: polynomials over nodes where it is smooth, factors of leaves elsewhere."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.kernels.measure.link_gather import bucket_order, gather_far, leaf_irradiance, push_down
from isophote.kernels.trace.expand_links import STACK, expand_links
from isophote.kernels.trace.local_factors import far_factors, near_factors, place_irradiance
from isophote.rendering.pool import Pool
from isophote.rendering.radiosity.tree import PatchTree

__all__ = ["Expansion"]

Points: TypeAlias = npt.NDArray[np.float64]
Numbers: TypeAlias = npt.NDArray[np.int64]

_LINKS_A_JOB, _NODES_A_JOB, _LEAVES_A_JOB = 1024, 512, 256
_TERMS = 6


class Expansion:
    """Form factors of links from sources to receivers, of which the part `visible` is; made once for many bounces.

    With `bright` (nodes,), what nodes send out about, sources are as uneven as that says; empty, all are even. With
    `whole`, factors are those of what would be visible if nothing were in the way.

    Entries are in the order of their receivers, `near` those that leaves have for themselves.
    """

    def __init__(
        self,
        tree: PatchTree,
        receivers: Numbers,
        sources: Numbers,
        visible: Points,
        bright: Points,
        threads: int | None,
        *,
        whole: bool = False,
    ) -> None:
        self._tree, self._threads, self._count = tree, threads, len(tree)
        self._patches, self._bright = tree.packed(), bright
        self.leaves = tree.leaves
        self._order = np.argsort(tree.depth, kind="stable")
        self._frames, self._over = _frames(tree)
        self._expand(receivers, sources, visible)
        self._measure(np.ones_like(self._shares) if whole else self._shares)

    def __len__(self) -> int:
        return len(self._sources)

    def _expand(self, receivers: Numbers, sources: Numbers, visible: Points) -> None:
        counts, ends = np.zeros(len(receivers), np.int64), np.zeros(len(receivers), np.int64)
        entries = self._entries(0)
        self._walk((receivers, sources, visible, counts, ends), entries, False)
        ends = np.cumsum(counts)
        entries = self._entries(int(counts.sum()))
        self._walk((receivers, sources, visible, counts, ends), entries, True)
        keys, nodes, shares = entries
        starts, order = np.zeros(2 * self._count + 1, np.int64), np.zeros(len(keys), np.int64)
        bucket_order(keys, starts, order)
        self._sources, self._shares = nodes[order], shares[order]
        self._starts = starts[: self._count + 1]
        self._near_starts = starts[self._count :] - starts[self._count]

    @staticmethod
    def _entries(count: int) -> tuple[Numbers, npt.NDArray[np.int32], npt.NDArray[np.float32]]:
        """Room for so many: keys, sources and visible parts."""
        return np.zeros(count, np.int64), np.zeros(count, np.int32), np.zeros(count, np.float32)

    def _walk(
        self,
        links: tuple[Numbers, Numbers, Points, Numbers, Numbers],
        entries: tuple[Numbers, npt.NDArray[np.int32], npt.NDArray[np.float32]],
        fill: bool,
    ) -> None:
        """Count the entries of all links or, to `fill`, write them."""
        pool = Pool(self._threads)
        stacks = [np.zeros((STACK, 2), np.int64) for _ in range(pool.threads)]
        words, count = self._patches.words, len(links[0])

        def work(first: int, thread: int) -> None:
            expand_links(words, *links, *entries, stacks[thread], fill, first, min(first + _LINKS_A_JOB, count))

        self._run(pool, work, range(0, count, _LINKS_A_JOB))

    def _run(self, pool: Pool, work: Callable[[int, int], None], jobs: range) -> None:
        pool.run(work, jobs, lambda done: None)
        if pool.interrupted:
            raise KeyboardInterrupt

    def _over_nodes(self, work: Callable[[int, int], None], count: int, step: int) -> None:
        self._run(Pool(self._threads), lambda first, _: work(first, min(first + step, count)), range(0, count, step))

    @property
    def _near(self) -> slice:
        """The near entries."""
        return slice(int(self._starts[-1]), len(self._sources))

    def _measure(self, shares: npt.NDArray[np.float32]) -> None:
        near, every = self._near, np.arange(self._count)
        self._near_sources, self._near_shares = self._sources[near], shares[near]
        self._far_factors = np.zeros((near.start, _TERMS), np.float32)
        self._near_factors = np.zeros(len(self._near_sources), np.float32)
        words = self._patches.words

        def far(first: int, last: int) -> None:
            far_factors(words, self._starts, self._sources, shares, self._bright, self._far_factors, first, last)

        def close(first: int, last: int) -> None:
            near_factors(
                words,
                every,
                self._near_starts,
                self._near_sources,
                self._near_shares,
                self._bright,
                self._near_factors,
                first,
                last,
            )

        self._over_nodes(far, self._count, _NODES_A_JOB)
        self._over_nodes(close, self._count, _NODES_A_JOB)

    def near_sources(self, leaves: Numbers) -> tuple[Numbers, Numbers]:
        """Sources of the near entries of some leaves: rows of `leaves`, and for each the node."""
        first, counts = self._near_starts[leaves], np.diff(self._near_starts)[leaves]
        owner = np.repeat(np.arange(len(leaves)), counts)
        within = np.arange(len(owner)) - np.repeat(np.cumsum(counts) - counts, counts)
        return owner, self._near_sources[first[owner] + within].astype(np.int64)

    def _fields(self, light: Points) -> Points:
        """(nodes, 6, 3): polynomials of the irradiance over all nodes, from what is far of each."""
        fields = np.zeros((self._count, _TERMS, 3))

        def work(first: int, last: int) -> None:
            gather_far(self._starts, self._sources, self._far_factors, light, fields, first, last)

        self._over_nodes(work, self._count, _NODES_A_JOB)
        push_down(self._order, self._over, self._frames, fields)
        return fields

    def gathered(self, light: Points) -> Points:
        """(leaves, 3): irradiance of every leaf, from the radiosity `light` of all nodes."""
        fields, arriving, tree = self._fields(light), np.zeros((len(self.leaves), 3)), self._tree

        def work(first: int, last: int) -> None:
            leaf_irradiance(
                self.leaves,
                tree.sides,
                fields,
                self._near_starts,
                self._near_sources,
                self._near_factors,
                light,
                arriving,
                first,
                last,
            )

        self._over_nodes(work, len(arriving), _NODES_A_JOB)
        return arriving

    def at_places(self, light: Points, leaves: Numbers, places: Points) -> Points:
        """(n, 3): irradiance at places on leaves."""
        fields, found = self._fields(light), np.zeros((len(leaves), 3))

        def work(first: int, last: int) -> None:
            place_irradiance(
                self._patches.words,
                self._near_starts,
                self._near_sources,
                self._near_shares,
                self._bright,
                light,
                fields,
                leaves,
                places,
                found,
                first,
                last,
            )

        self._over_nodes(work, len(leaves), _LEAVES_A_JOB)
        return found


def _frames(tree: PatchTree) -> tuple[Points, Numbers]:
    """Places of nodes in the half edges of their parents, (n, 6) as `push_down` takes them, and the parents, −1 where
    these are not flat."""
    flat = tree.flat[np.maximum(tree.parent, 0)] != 0
    over = np.where((tree.parent >= 0) & flat, tree.parent, -1)
    frames = np.zeros((len(tree), 6))
    own = np.flatnonzero(over >= 0)
    p = over[own]
    along, across = tree.axes[p, :3], tree.axes[p, 3:]
    a, b, c = ((x * y).sum(axis=1) for x, y in ((along, along), (along, across), (across, across)))
    size = a * c - b * b
    # What gives a vector's share of each half edge.
    first = (c[:, None] * along - b[:, None] * across) / size[:, None]
    second = (a[:, None] * across - b[:, None] * along) / size[:, None]
    ways = (tree.centres[own] - tree.centres[p], tree.axes[own, :3], tree.axes[own, 3:])
    for k, way in enumerate(ways):
        frames[own, k], frames[own, 3 + k] = (way * first).sum(axis=1), (way * second).sum(axis=1)
    return frames, over
