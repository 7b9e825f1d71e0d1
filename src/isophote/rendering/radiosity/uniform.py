"""Radiosity on even patches with the whole matrix of form factors: gathering, and progressive shooting."""

from __future__ import annotations

from typing import TypeAlias

import attrs
import numpy as np
import numpy.typing as npt

from isophote.errors import RenderError
from isophote.kernels.base.table import Packed
from isophote.progress import Reporter
from isophote.rendering.radiosity.direct import direct_irradiance
from isophote.rendering.radiosity.faces import Faces
from isophote.rendering.radiosity.links import level
from isophote.rendering.radiosity.matrix import DirectionRows, FactorMatrix, PairRows
from isophote.rendering.radiosity.tree import PatchTree

__all__ = ["UniformSettled", "check_count", "cut_evenly", "settle_evenly"]

Points: TypeAlias = npt.NDArray[np.float64]
Numbers: TypeAlias = npt.NDArray[np.int64]

_MOST_BYTES = 2**31
# From here on a number is told by its first digits.
_MOST_DIGITS = 1e9
_MOST_BOUNCES = 1000
# Shots a patch after which light that does not settle is given up.
_MOST_SHOTS = 200
# Edges may be longer than asked for by rounding.
_ROUNDING = 1 + 1e-9


@attrs.frozen(eq=False)
class UniformSettled:
    """Even patches in balance, as `Settled`: `bounces` (nodes, 3) after each bounce, or each time that half of the
    light left was shot; `irradiance` (leaves, 3); `form_factor_sums` (leaves,), NaN for what never shot."""

    tree: PatchTree
    direct: Points
    bounces: tuple[Points, ...]
    residuals: tuple[float, ...]
    links: int
    irradiance: Points
    form_factor_sums: Points

    @property
    def light(self) -> Points:
        """(n, 3): radiosity of all nodes."""
        return self.bounces[-1]

    def radiosity_at(self, number: int, leaves: Numbers, places: Points) -> Points:
        """(n, 3): radiosity after so many bounces, the same all over each leaf."""
        radiosity: Points = self.bounces[number][leaves]
        return radiosity


def check_count(faces: Faces, patch: float, most: int) -> int:
    """How many patches of edges up to `patch` there will be. Raises `RenderError` where their matrix is too large."""
    used = np.where((faces.sides == 3)[:, None, None], faces.corners[:, [0, 1, 2, 0]], faces.corners)
    edges = np.linalg.norm(used - np.roll(used, 1, axis=1), axis=2).max(axis=1)
    levels = np.ceil(np.log2(np.maximum(edges / (patch * _ROUNDING), 1.0)))
    count = float((4.0**levels).sum())
    if count**2 > most or 4 * count**2 > _MOST_BYTES:
        size = _told(4 * count**2 / 2**20)
        raise RenderError(
            f"Radiosity: {_told(count)} patches have {_told(count**2)} form factors, some {size} MB; at most "
            f"{min(most, _MOST_BYTES // 4):,} may be kept; give larger patches, or method='hierarchical'"
        )
    return int(count)


def _told(number: float) -> str:
    """A number with all its digits while they are few."""
    return f"{number:,.0f}" if number < _MOST_DIGITS else f"{number:.2g}"


def cut_evenly(tree: PatchTree, patch: float) -> None:
    """Cut all faces until no edge is longer than `patch`."""
    while True:
        leaves = tree.leaves
        long = leaves[tree.edges[leaves] > patch * _ROUNDING]
        if len(long) == 0:
            return
        tree.cut(long)


def settle_evenly(
    scene: Packed,
    tree: PatchTree,
    *,
    method: str,
    form_factors: str,
    directions: int,
    residual: float,
    report: Reporter,
    threads: int | None,
) -> UniformSettled:
    """The balance of light on the leaves of `tree`, by "gathering" until no patch changes by more than `residual` of
    the brightest, or by "shooting" until that part of all light that is sent out is left unshot.

    Sources: Goral et al., "Modeling the Interaction of Light Between Diffuse Surfaces", SIGGRAPH 1984; Cohen et al.,
    "A Progressive Refinement Approach to Fast Radiosity Image Generation", SIGGRAPH 1988.
    """
    leaves = tree.leaves
    direct = direct_irradiance(scene, tree, leaves, threads)[:, :3]
    emission, albedo = tree.emission[leaves], tree.albedo[leaves]
    if not (emission + albedo * direct).any():
        raise RenderError("Radiosity: nothing shines; give lights, or items with an Emitter material")
    rows = (
        PairRows(scene, tree, threads)
        if form_factors == "rays"
        else DirectionRows(tree, form_factors, directions, threads)
    )
    matrix = FactorMatrix(len(leaves), rows)
    solver = _gather if method == "gathering" else _shoot
    areas = tree.areas[leaves] * tree.open[leaves]
    steps, residuals, arriving = solver(matrix, emission, albedo, direct, areas, residual, report)
    bounces = []
    for step in steps:
        whole = np.zeros((len(tree), 3))
        whole[leaves] = step
        bounces.append(whole)
    everywhere = np.zeros((len(tree), 3))
    everywhere[leaves] = direct
    links = int(matrix.known.sum()) * len(leaves)
    return UniformSettled(tree, everywhere, tuple(bounces), tuple(residuals), links, arriving, matrix.sums())


_Found: TypeAlias = tuple[list[Points], list[float], Points]


def _gather(
    matrix: FactorMatrix,
    emission: Points,
    albedo: Points,
    direct: Points,
    areas: Points,
    residual: float,
    report: Reporter,
) -> _Found:
    """Jacobi's iteration: every patch gathers from all others, one bounce after another."""
    factors = matrix.filled(lambda part: report("measuring form factors", part))
    steps, residuals = [emission], []
    while True:
        arriving = direct + (factors @ steps[-1].astype(np.float32)).astype(np.float64)
        after = emission + albedo * arriving
        change = float(np.abs(after - steps[-1]).max() / after.max())
        steps.append(after)
        residuals.append(change)
        report("bouncing light", min(1.0, np.log(max(change, 1e-30)) / np.log(residual)))
        if change <= residual or len(steps) > _MOST_BOUNCES:
            return steps, residuals, arriving


def _shoot(
    matrix: FactorMatrix,
    emission: Points,
    albedo: Points,
    direct: Points,
    areas: Points,
    residual: float,
    report: Reporter,
) -> _Found:
    """Again and again the patch with most light not yet sent out shoots it at all others: Bⱼ += ρⱼ Bᵢ Fᵢⱼ Aᵢ / Aⱼ."""
    unshot = emission + albedo * direct
    light, arriving = unshot.copy(), direct.copy()
    sent = float(level(unshot) @ areas)
    steps, residuals = [emission], []
    shares = np.where(areas > 0, 1 / np.where(areas > 0, areas, 1.0), 0.0)
    left, shots, due = sent, 0, sent
    while left > residual * sent and shots < _MOST_SHOTS * len(areas):
        number = int(np.argmax(level(unshot) * areas))
        share = matrix.row(number).astype(np.float64) * (areas[number] * shares)
        received = share[:, None] * unshot[number]
        arriving += received
        unshot[number] = 0.0
        unshot += albedo * received
        light += albedo * received
        left, shots = float(level(unshot) @ areas), shots + 1
        if left <= due / 2 or left <= residual * sent:
            steps.append(light.copy())
            residuals.append(left / sent)
            due = left
            ambient = _ambient(unshot, albedo, areas).mean()
            stage = f"shooting light ({shots:,} shots, ambient light {ambient:.3g} W/m²)"
            report(stage, min(1.0, np.log(max(left / sent, 1e-30)) / np.log(residual)))
    return steps, residuals, arriving


def _ambient(unshot: Points, albedo: Points, areas: Points) -> Points:
    """(3,): irradiance that light not yet shot will give patches on average, all its bounces together, as if it were
    spread evenly: R Σ ΔBᵢ Aᵢ / Σ A, R = 1 / (1 − ρ̄) (Cohen et al. 1988, section 4.3)."""
    share = areas / areas.sum()
    kept = np.minimum(share @ albedo, 0.99)
    ambient: Points = (share @ unshot) / (1 - kept)
    return ambient
