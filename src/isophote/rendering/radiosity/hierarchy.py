"""Hierarchical radiosity: links refined while light settles."""

from __future__ import annotations

from typing import TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.errors import RenderError
from isophote.kernels.base.table import Packed
from isophote.progress import Reporter
from isophote.rendering.radiosity.balance import Balance, change_of
from isophote.rendering.radiosity.cutting import cut_by_irradiance, cut_painted_lamps
from isophote.rendering.radiosity.direct import Direct, Spots, cut_by_direct, cut_under_spots
from isophote.rendering.radiosity.doubt import Doubt
from isophote.rendering.radiosity.links import Limits, Links, level
from isophote.rendering.radiosity.tree import PatchTree

__all__ = ["Settled", "settle"]

Points: TypeAlias = npt.NDArray[np.float64]
Numbers: TypeAlias = npt.NDArray[np.int64]

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


def settle(
    scene: Packed,
    tree: PatchTree,
    spots: Spots,
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
    direct = Direct(scene, tree, threads)
    direct.complete()
    cut_under_spots(tree, direct, spots, patch, follow_lamps=follow_lamps)
    mean = _expected_mean(tree, direct.values)
    if mean <= 0:
        raise RenderError("Radiosity: nothing shines; give lights, or items with an Emitter material")
    # Where faces are small already, the smallest patches are these.
    flux = error * mean * min(patch**2, _typical(tree.faces.areas))
    cut_by_direct(tree, direct, spots, error * mean, patch, follow_lamps=follow_lamps)
    links = Links(scene, tree, threads)
    light, uneven = tree.emission + tree.albedo * direct.values, np.zeros(len(tree))
    for number, factor in enumerate(_ROUNDS):

        def show(part: float, number: int = number) -> None:
            report("linking patches", (number + part) / len(_ROUNDS))

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
    direct.finish()
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
    own = tree.leaves
    areas = tree.areas[own]
    sent = level(tree.emission[own] + tree.albedo[own] * direct[own]) @ areas
    kept = level(tree.albedo[own]) @ areas
    return float(sent / max(areas.sum() - kept, 0.05 * areas.sum()))


def _typical(areas: Points) -> float:
    """The area that half of the whole is in larger faces than."""
    ordered = np.sort(areas)
    return float(ordered[np.searchsorted(np.cumsum(ordered), ordered.sum() / 2)])


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
