"""Which patches exchange light directly: links between nodes of the tree, made finer where that matters."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.errors import RenderError
from isophote.kernels.base.table import Packed
from isophote.kernels.trace.exchange import exchanges, lit_shares
from isophote.kernels.trace.shaft import new_shaft
from isophote.kernels.trace.wave import new_wave
from isophote.lower.field_table import scratch_words
from isophote.rendering.pool import Pool
from isophote.rendering.radiosity.tree import PatchTree

__all__ = ["Limits", "Links", "level"]

Points: TypeAlias = npt.NDArray[np.float64]
Numbers: TypeAlias = npt.NDArray[np.int64]
Report: TypeAlias = Callable[[float], None]
Work: TypeAlias = Callable[[int, int, npt.NDArray[np.int64], npt.NDArray[np.int64]], None]

_WAVE = 272
_PAIRS_A_JOB = 2048
# Pairs that are asked for at once: what bounds the memory of a round.
_MOST_AT_ONCE = 2**21
_BYTES_A_LINK = 64
# Where of so many pairs such a part was too coarse, as of those before, so many times over, the links to come can be
# told. They must be so many times what is allowed to be refused: in the end fewer pairs are split.
_MANY, _MOSTLY, _IN_A_ROW, _TOO_MANY = 50_000, 0.75, 3, 8.0
# What pairs are split into.
_PARTS = 4
# How much more an uneven source counts than doubtful visibility: its errors add up over links, for light is brightest
# where much of it is seen from.
_MIXED = 5.0
_LEAST_ALBEDO = 0.1


@attrs.frozen
class Limits:
    """`flux`: what a link may be off, in W; `patch`: length of edges in metres below which patches are not cut;
    `links`: how many there may be."""

    flux: float
    patch: float
    links: int


def level(light: Points) -> Points:
    """One number for a colour, by which links are judged: the mean of its channels."""
    mean: Points = light.mean(axis=1)
    return mean


def _cure(links: float) -> str:
    """What so many links take, and what would mend it."""
    return f"some {int(links * _BYTES_A_LINK) >> 20:,} MB; give larger patches, a larger error or more max_links"


class Links:
    """Pairs of nodes (n, 2); for each the part that is visible, what would be exchanged per radiosity if all were, in
    m², and how far the visible part may be off."""

    def __init__(self, scene: Packed, tree: PatchTree, threads: int | None) -> None:
        self._scene, self._tree, self._threads = scene, tree, threads
        self.pairs = np.zeros((0, 2), np.int64)
        self.seen = np.zeros((0, 3))
        self.asked = 0
        self._shares: Points | None = None

    def __len__(self) -> int:
        return len(self.pairs)

    @property
    def shares(self) -> Points:
        """(n, 2): what part of the light of each pair's second node reaches the first, and of the first's the second;
        the visible part of each, until they are weighed."""
        return np.tile(self.seen[:, :1], 2) if self._shares is None else self._shares

    def weigh(self, light: Points) -> None:
        """Weigh what is visible of pairs that see parts of each other by the light (n, 3) that it sends out: what lies
        in the shade of a thing is mostly what another does not see for the same thing."""
        partly = np.flatnonzero((self.seen[:, 0] > 0) & (self.seen[:, 0] < 1))
        pairs, bright = self.pairs[partly], level(light)
        found = np.tile(self.seen[partly, :1], 2)

        def work(first: int, last: int, wave: npt.NDArray[np.int64], _: npt.NDArray[np.int64]) -> None:
            lit_shares(self._scene.words, self._tree.packed().words, wave, bright, pairs, found, first, last)

        self._over(work, len(pairs), lambda part: None)
        self._shares = self.shares.copy()
        self._shares[partly] = found

    def refine(self, light: Points, uneven: Points, limits: Limits, report: Report) -> None:
        """Split links that carry more error than `limits.flux` while `light` (n, 3) leaves the nodes, and varies by
        `uneven` (n,) within each; new patches get the values of those that they were cut from.

        `report` is told what part is done of all that is known to be to do. Raises `RenderError` where there are more
        links than `limits.links`, and long before if there are bound to be many times as many.
        """
        state = np.stack([level(light), uneven], axis=1)
        self._shares = None
        if self.asked == 0:
            self._take(self._first_pairs(), state, limits, report)
            return
        poor = self._too_coarse(self.pairs, self.seen, state, limits)
        pairs = self.pairs[poor]
        self.pairs, self.seen = self.pairs[~poor], self.seen[~poor]
        self._take(self._split(pairs, limits), state, limits, report)

    def _first_pairs(self) -> Numbers:
        roots = self._tree.roots
        a, b = np.triu_indices(len(roots), k=0 if len(roots) == 1 else 1)
        return np.stack([roots[a], roots[b]], axis=1)

    def _take(self, pairs: Numbers, state: Points, limits: Limits, report: Report) -> None:
        """Ask for pairs, keep those that will do as links, split the others, until none is left."""
        kept: list[tuple[Numbers, Points]] = [(self.pairs, self.seen)]
        waiting, count, growing, done = [pairs], len(self), 0, 0
        while waiting:
            now = waiting.pop()
            if len(now) > _MOST_AT_ONCE:
                waiting.append(now[_MOST_AT_ONCE:])
                now = now[:_MOST_AT_ONCE]
            now = self._apart(now)
            if len(now) == 0:
                continue
            state = self._inherited(state)
            ahead = sum(len(later) for later in waiting)

            def show(part: float, done: int = done, now: int = len(now), ahead: int = ahead) -> None:
                report((done + part * now) / (done + now + ahead))

            found = self._asked_for(now, show)
            done += len(now)
            poor = self._too_coarse(now, found, state, limits)
            linked = ~poor & (found[:, 1] > 0)
            kept.append((now[linked], found[linked]))
            count += int(linked.sum())
            growing = growing + 1 if poor.mean() >= _MOSTLY else 0
            if count > limits.links:
                raise RenderError(f"Radiosity: more than {limits.links:,} links are needed, {_cure(limits.links)}")
            if growing >= _IN_A_ROW and len(now) >= _MANY:
                expected = count + self._expected(now[poor], float(poor.mean()), limits)
                if expected > _TOO_MANY * limits.links:
                    raise RenderError(
                        f"Radiosity: some {expected:.0e} links are needed, by how the first {self.asked:,} pairs of "
                        f"patches went, and max_links is {limits.links:,}: {_cure(expected)}"
                    )
            if poor.any():
                waiting.append(self._split(now[poor], limits))
        self.pairs = np.concatenate([pairs for pairs, _ in kept])
        self.seen = np.concatenate([seen for _, seen in kept])

    def _expected(self, pairs: Numbers, poor: float, limits: Limits) -> float:
        """About how many links it takes in the place of some, if of each that is split the part `poor` is split again
        until patches are as small as they may get."""
        tree = self._tree
        faces = np.maximum(tree.span[:, 1] - tree.span[:, 0], 1)
        edges = np.where(tree.sides > 0, tree.edges, np.sqrt(tree.areas / faces))
        levels = np.log2(np.maximum(edges / limits.patch, 1.0)) + np.where(tree.sides > 0, 0.0, np.log2(faces) / 2)
        return float((_PARTS * (_PARTS * poor) ** (levels[pairs].sum(axis=1) - 1).clip(0)).sum())

    def _inherited(self, state: Points) -> Points:
        """Values of nodes that came later are those of their parents."""
        known = len(state)
        if known == len(self._tree):
            return state
        values = np.concatenate([state, np.zeros((len(self._tree) - known, 2))])
        # Children come after their parents, but may have children within the same round.
        new = np.arange(known, len(values))
        for depth in np.unique(self._tree.depth[new]):
            own = new[self._tree.depth[new] == depth]
            values[own] = values[self._tree.parent[own]]
        return values

    def _asked_for(self, pairs: Numbers, report: Report) -> Points:
        """(n, 3): what the kernel finds for pairs."""
        found = np.zeros((len(pairs), 3))
        patches = self._tree.packed()

        def work(first: int, last: int, wave: npt.NDArray[np.int64], shaft: npt.NDArray[np.int64]) -> None:
            exchanges(self._scene.words, patches.words, wave, shaft, pairs, found, first, last)

        self._over(work, len(pairs), report)
        self.asked += len(pairs)
        return found

    def _over(self, work: Work, count: int, report: Report) -> None:
        """Do pairs in parts, each thread with scratch of its own."""
        pool = Pool(self._threads)
        words = scratch_words(self._scene.arrays["fields"])
        waves = [new_wave(_WAVE, words) for _ in range(pool.threads)]
        shafts = [new_shaft() for _ in range(pool.threads)]

        def job(first: int, thread: int) -> None:
            work(first, min(first + _PAIRS_A_JOB, count), waves[thread].words, shafts[thread].words)

        jobs = range(0, count, _PAIRS_A_JOB)
        pool.run(job, jobs, lambda done: report(done / max(len(jobs), 1)))
        if pool.interrupted:
            raise KeyboardInterrupt

    def _too_coarse(self, pairs: Numbers, seen: Points, state: Points, limits: Limits) -> npt.NDArray[np.bool_]:
        """Which pairs carry more error than they may, and can be split."""
        tree = self._tree
        # What absorbs all light is measured, too.
        (bright, uneven), dull = self._inherited(state).T, np.maximum(level(tree.albedo), _LEAST_ALBEDO)
        a, b = pairs.T
        visible, exchange, doubt = seen.T
        hidden = np.maximum(bright[b] * dull[a], bright[a] * dull[b]) * doubt
        mixed = _MIXED * np.maximum(uneven[b] * dull[a], uneven[a] * dull[b]) * visible
        with np.errstate(invalid="ignore"):
            error = np.where(hidden + mixed > 0, exchange * (hidden + mixed), 0.0)
        able = self._divisible(limits)
        poor: npt.NDArray[np.bool_] = (error > limits.flux) & (able[a] | able[b])
        return poor

    def _divisible(self, limits: Limits) -> npt.NDArray[np.bool_]:
        tree = self._tree
        return (tree.first_child >= 0) | ((tree.sides > 0) & (tree.edges >= 2 * limits.patch))

    def _apart(self, pairs: Numbers) -> Numbers:
        """Pairs of a node with itself are pairs of its children; a flat patch does not see itself."""
        tree = self._tree
        done = [pairs[pairs[:, 0] != pairs[:, 1]]]
        same = pairs[pairs[:, 0] == pairs[:, 1], 0]
        same = same[tree.sides[same] == 0]
        while len(same):
            first, count = tree.first_child[same], tree.children[same]
            inner = []
            for i in range(int(count.max())):
                for j in range(i, int(count.max())):
                    own = count > j
                    pair = np.stack([first[own] + i, first[own] + j], axis=1)
                    if i == j:
                        inner.append(pair[:, 0])
                    else:
                        done.append(pair)
            same = np.concatenate(inner)
            same = same[tree.sides[same] == 0]
        return np.concatenate(done)

    def _split(self, pairs: Numbers, limits: Limits) -> Numbers:
        """The larger node of each pair replaced by its children, a cluster before a patch."""
        tree = self._tree
        able = self._divisible(limits)
        a, b = pairs.T
        # Clusters are opened before patches are cut: that costs no patches.
        large = 4 * tree.radii.max()
        rank_a, rank_b = (tree.radii[end] + np.where(tree.sides[end] == 0, large, 0.0) for end in (a, b))
        first = able[a] & (~able[b] | (rank_a >= rank_b))
        chosen, other = np.where(first, a, b), np.where(first, b, a)
        tree.cut(np.unique(chosen))
        count = tree.children[chosen]
        again = np.repeat(np.arange(len(chosen)), count)
        place = np.arange(len(again)) - np.repeat(np.cumsum(count) - count, count)
        return np.stack([tree.first_child[chosen[again]] + place, other[again]], axis=1)
