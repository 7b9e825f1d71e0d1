"""Hierarchical radiosity: links refined while light settles."""

from __future__ import annotations

from typing import TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.errors import RenderError
from isophote.kernels.base.table import Packed
from isophote.kernels.trace.patch_light import direct_light
from isophote.kernels.trace.wave import new_wave
from isophote.lower.field_table import scratch_words
from isophote.progress import Reporter
from isophote.rendering.pool import Pool
from isophote.rendering.radiosity.balance import Balance, change_of
from isophote.rendering.radiosity.cutting import cut_by_irradiance, cut_painted_lamps
from isophote.rendering.radiosity.doubt import Doubt
from isophote.rendering.radiosity.links import Limits, Links, level
from isophote.rendering.radiosity.tree import PatchTree

__all__ = ["Settled", "direct_irradiance", "settle"]

Points: TypeAlias = npt.NDArray[np.float64]
Numbers: TypeAlias = npt.NDArray[np.int64]

_WAVE = 272
_NODES_A_JOB = 256
# Rounds of linking, each by the light of the one before, and with a smaller limit.
_ROUNDS = (16.0, 4.0, 1.0)
# What leaves see of uncertain light is sampled to a standard error of such a part of `error`, in parts of what arrives
# and of so much of the mean radiosity beside, by so many rays a leaf at most.
_SAMPLED, _DARK, _RAYS = 0.1, 0.02, 8192


@attrs.frozen(eq=False)
class Settled:
    """A tree in balance: `direct` (n, 3) is the irradiance from what is no patch, `bounces` the radiosity (n, 3) of all
    nodes after each bounce, the last the answer, `residuals` by how much each bounce changed it, `form_factor_sums`
    (leaves,) Σ F of every leaf."""

    tree: PatchTree
    balance: Balance
    direct: Points
    bounces: tuple[Points, ...]
    residuals: tuple[float, ...]
    links: int
    form_factor_sums: Points

    @property
    def light(self) -> Points:
        """(n, 3): radiosity of all nodes."""
        return self.bounces[-1]

    @property
    def irradiance(self) -> Points:
        """(leaves, 3): light that arrives at every leaf in the end."""
        arriving: Points = self.direct[self.tree.leaves] + self.balance.gathered(self.light)
        return arriving

    def radiosity_at(self, number: int, leaves: Numbers, places: Points) -> Points:
        """(n, 3): radiosity after so many bounces at places on leaves."""
        if number == 0:
            shining: Points = self.bounces[0][leaves]
            return shining
        arriving = self.balance.at_places(self.bounces[number - 1], leaves, places) + self.direct[leaves]
        radiosity: Points = self.tree.emission[leaves] + self.tree.albedo[leaves] * arriving
        return radiosity


class _Direct:
    """Irradiance from lights that are no patches, for nodes as they come."""

    def __init__(self, scene: Packed, tree: PatchTree, threads: int | None) -> None:
        self._scene, self._tree, self._threads = scene, tree, threads
        self.values = np.zeros((0, 3))
        self.spread = np.zeros(0)

    def complete(self) -> None:
        """Values for nodes that have none yet."""
        known, count = len(self.values), len(self._tree)
        new = np.arange(known, count)
        found = np.zeros((count - known, 4))
        flat = self._tree.sides[new] > 0
        found[flat] = direct_irradiance(self._scene, self._tree, new[flat], self._threads)
        self.values = np.concatenate([self.values, found[:, :3]])
        self.spread = np.concatenate([self.spread, found[:, 3]])


def direct_irradiance(scene: Packed, tree: PatchTree, nodes: Numbers, threads: int | None) -> Points:
    """(n, 4): irradiance of patches from all lights that are no patches, and how much it varies within each."""
    found = np.zeros((len(nodes), 4))
    environment = scene.arrays["lights"].arrays["environment"].arrays
    sky = bool(np.any(environment["constant"] > 0)) or len(environment["texels"]) > 0
    patches, pool = tree.packed(), Pool(threads)
    words = scratch_words(scene.arrays["fields"])
    waves = [new_wave(_WAVE, words) for _ in range(pool.threads)]
    places = [np.zeros((16, 3)) for _ in range(pool.threads)]

    def work(first: int, thread: int) -> None:
        last = min(first + _NODES_A_JOB, len(nodes))
        own = waves[thread].words
        direct_light(scene.words, patches.words, own, nodes, sky, places[thread], found, first, last)

    pool.run(work, range(0, len(nodes), _NODES_A_JOB), lambda done: None)
    if pool.interrupted:
        raise KeyboardInterrupt
    return found


def settle(
    scene: Packed,
    tree: PatchTree,
    *,
    error: float,
    patch: float,
    follow_lamps: bool,
    residual: float,
    most_links: int,
    report: Reporter,
    threads: int | None,
) -> Settled:
    """Link patches by `error`, in parts of the mean radiosity of the smallest patches, and let light bounce until no
    patch changes by more than `residual` of the most that any reflects.

    Sources: Hanrahan, Salzman, Aupperle, "A Rapid Hierarchical Radiosity Algorithm", SIGGRAPH 1991; clusters: Smits,
    Arvo, Greenberg, "A Clustering Algorithm for Radiosity in Complex Environments", SIGGRAPH 1994.
    """
    cut_painted_lamps(tree, patch)
    direct = _Direct(scene, tree, threads)
    direct.complete()
    mean = _expected_mean(tree, direct.values)
    if mean <= 0:
        raise RenderError("Radiosity: nothing shines; give lights, or items with an Emitter material")
    # Where faces are small already, the smallest patches are these.
    flux = error * mean * min(patch**2, _typical(tree.faces.areas))
    _cut_by_direct(tree, direct, error * mean, patch)
    links = Links(scene, tree, threads)
    light, uneven = tree.emission + tree.albedo * direct.values, np.zeros(len(tree))
    for number, factor in enumerate(_ROUNDS):

        def show(count: int, nodes: int, number: int = number) -> None:
            report(f"linking patches ({nodes:,} patches, {count:,} links)", (number + 0.5) / len(_ROUNDS))

        links.refine(light, uneven, Limits(flux * factor, patch, most_links), show)
        direct.complete()
        balance = Balance(tree, links, threads)
        bounces, residuals = _bounce(balance, tree, direct.values, 1e-2, report)
        while cut_by_irradiance(tree, balance, bounces[-1], error * mean * factor, patch, follow_lamps=follow_lamps):
            direct.complete()
            balance = Balance(tree, links, threads)
            bounces, residuals = _bounce(balance, tree, direct.values, 1e-2, report)
        light, uneven = bounces[-1], balance.unevenness(bounces[-1])
    sums = balance.form_factor_sums()
    links.weigh(light)
    balance = Balance(tree, links, threads, level(light))
    bounces, residuals = _bounce(balance, tree, direct.values, residual, report)
    arriving = balance.gathered(bounces[-1])
    allowed = _SAMPLED * error * (level(direct.values[tree.leaves] + arriving) + _DARK * mean)
    correction = Doubt(scene, tree, links, bounces[-1], threads).corrections(arriving, allowed, _RAYS, report)
    balance.correct(arriving, correction)
    bounces, residuals = _bounce(balance, tree, direct.values, residual, report)
    return Settled(tree, balance, direct.values, tuple(bounces), tuple(residuals), len(links), sums)


def _expected_mean(tree: PatchTree, direct: Points) -> float:
    """Mean radiosity as if light were spread evenly: what is sent out, over the share that is not given back."""
    own = tree.parent < 0 if (tree.sides[tree.roots] > 0).all() else np.arange(len(tree)) < (tree.sides > 0).sum()
    areas = tree.areas[own]
    sent = level(tree.emission[own] + tree.albedo[own] * direct[own]) @ areas
    kept = level(tree.albedo[own]) @ areas
    return float(sent / max(areas.sum() - kept, 0.05 * areas.sum()))


def _typical(areas: Points) -> float:
    """The area that half of the whole is in larger faces than."""
    ordered = np.sort(areas)
    return float(ordered[np.searchsorted(np.cumsum(ordered), ordered.sum() / 2)])


def _cut_by_direct(tree: PatchTree, direct: _Direct, allowed: float, patch: float) -> None:
    """Cut patches over which light that comes from no patch changes much."""
    while True:
        leaves = tree.leaves
        varies = direct.spread[leaves] * level(tree.albedo[leaves]) > allowed
        poor = leaves[varies & (tree.edges[leaves] >= 2 * patch)]
        if len(poor) == 0:
            return
        tree.cut(poor)
        direct.complete()


def _bounce(
    balance: Balance, tree: PatchTree, direct: Points, residual: float, report: Reporter
) -> tuple[list[Points], list[float]]:
    """Radiosity after each bounce, from emission alone on, and by how much each changed it."""
    light = balance.pulled(tree.emission)
    bounces, residuals = [light], []
    leaves = balance.leaves
    while True:
        after = balance.bounced(light, direct)
        change = change_of(light[leaves], after[leaves], tree.emission[leaves])
        bounces.append(after)
        residuals.append(change)
        light = after
        report("bouncing light", min(1.0, np.log(max(change, 1e-30)) / np.log(residual)))
        if change <= residual or len(bounces) > 1000:
            return bounces, residuals
