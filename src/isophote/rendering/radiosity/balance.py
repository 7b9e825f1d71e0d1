"""The balance of light over a tree of linked patches, B = E + ρ (H + Σ F B), by bounces."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.rendering.radiosity.expansion import Expansion
from isophote.rendering.radiosity.links import Links
from isophote.rendering.radiosity.tree import PatchTree

__all__ = ["Balance", "change_of"]

Points: TypeAlias = npt.NDArray[np.float64]
Numbers: TypeAlias = npt.NDArray[np.int64]


class Balance:
    """Links of the leaves, theirs and those of all nodes above them, made once for many bounces.

    If `bright` (nodes,) tells about what nodes send out, it is seen to where on them.
    """

    def __init__(self, tree: PatchTree, links: Links, threads: int | None, bright: Points | None = None) -> None:
        self._tree = tree
        lit = links.seen[:, 0] > 0
        a, b = links.pairs[lit].T
        receivers, sources = np.concatenate([a, b]), np.concatenate([b, a])
        shares = links.shares[lit].T.reshape(-1)
        even = np.zeros(0) if bright is None else bright
        self._expansion = Expansion(tree, receivers, sources, shares, even, threads)
        depths = np.argsort(tree.depth, kind="stable")
        self._levels = np.split(depths, np.cumsum(np.bincount(tree.depth))[:-1])
        self.leaves = tree.leaves
        # What leaves get in parts of what links say.
        self.gain = np.ones((len(self.leaves), 3))
        self._row = np.full(len(tree), -1)
        self._row[self.leaves] = np.arange(len(self.leaves))

    def gathered(self, light: Points) -> Points:
        """(leaves, 3): irradiance of every leaf, from the radiosity `light` of all nodes."""
        arriving: Points = self._expansion.gathered(light) * self.gain
        return arriving

    def at_places(self, light: Points, nodes: Numbers, places: Points) -> Points:
        """(n, 3): irradiance at places on leaves."""
        arriving: Points = self._expansion.at_places(light, nodes, places) * self.gain[self._row[nodes]]
        return arriving

    def correct(self, arriving: Points, correction: Points) -> None:
        """Let leaves get more than links say, in such parts as `correction` is of `arriving` (leaves, 3)."""
        after = np.maximum(arriving + correction, 0.0)
        self.gain = np.where(arriving > 0, after / np.where(arriving > 0, arriving, 1.0), 1.0)

    def near_sources(self, leaves: Numbers) -> tuple[Numbers, Numbers]:
        """What is near each of the leaves and sends light there: rows of `leaves`, and for each the node."""
        return self._expansion.near_sources(leaves)

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
        sums: Points = self.gathered(np.ones((len(self._tree), 3)))[:, 0]
        return sums


def change_of(before: Points, after: Points, emission: Points) -> float:
    """By how much a bounce changed the radiosity of any patch, in parts of the most that any reflects: a lamp may be a
    thousand times as bright."""
    largest = float((after - emission).max())
    return float(np.abs(after - before).max()) / largest if largest > 0 else 0.0
