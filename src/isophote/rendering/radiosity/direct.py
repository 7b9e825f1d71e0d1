"""Light from what is no patch: points, suns, spots, disks, balls and skies."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.kernels.base.table import Packed
from isophote.kernels.trace.patch_light import PLACES, direct_light
from isophote.kernels.trace.wave import new_wave
from isophote.lower.field_table import scratch_words
from isophote.rendering.pool import Pool
from isophote.rendering.radiosity.cutting import FINER, PARTS, PEAK
from isophote.rendering.radiosity.links import level
from isophote.rendering.radiosity.tree import PatchTree
from isophote.scene.light import DiskLight, Light, PointLight, SphereLight
from isophote.scene.spot_light import SpotLight

__all__ = ["Direct", "Spots", "cut_by_direct", "cut_under_spots", "direct_irradiance", "spots_of"]

Points: TypeAlias = npt.NDArray[np.float64]
Numbers: TypeAlias = npt.NDArray[np.int64]

_WAVE = 272
_NODES_A_JOB = 256
# Where light varies over a leaf by more than this part of what it gets, it is looked at in so many places in the end.
_UNEVEN, _MANY = 0.05, 1024


class Spots(NamedTuple):
    """Lights that are somewhere: where, (n, 3), their radii in metres and the mean of their channels' intensities,
    (n,) in W/sr, to the side where that is most."""

    places: Points
    radii: Points
    intensity: Points


def spots_of(lights: Sequence[Light]) -> Spots:
    """The points, spots, disks and balls among lights."""
    found: list[tuple[npt.ArrayLike, float, npt.ArrayLike]] = []
    for light in lights:
        if isinstance(light, PointLight | SpotLight):
            found.append((light.position, 0.0, light.intensity_rgb))
        elif isinstance(light, DiskLight | SphereLight):
            seen = np.pi * light.radius**2 * np.asarray(light.radiance_rgb)
            found.append((light.transform.matrix[:3, 3], light.radius, seen))
    places = np.array([place for place, _, _ in found], np.float64).reshape(-1, 3)
    intensity = np.array([colour for _, _, colour in found], np.float64).reshape(-1, 3).mean(axis=1)
    return Spots(places, np.array([radius for _, radius, _ in found], np.float64), intensity)


class Direct:
    """Irradiance of nodes as they come, (n, 3), with how much it varies within each and the most, (n,) each."""

    def __init__(self, scene: Packed, tree: PatchTree, threads: int | None) -> None:
        self._scene, self._tree, self._threads = scene, tree, threads
        self.values = np.zeros((0, 3))
        self.spread, self.most = np.zeros(0), np.zeros(0)

    def complete(self) -> None:
        """Values for nodes that have none yet."""
        known, count = len(self.values), len(self._tree)
        new = np.arange(known, count)
        found = np.zeros((count - known, 5))
        flat = self._tree.sides[new] > 0
        found[flat] = direct_irradiance(self._scene, self._tree, new[flat], self._threads)
        self.values = np.concatenate([self.values, found[:, :3]])
        self.spread, self.most = np.append(self.spread, found[:, 3]), np.append(self.most, found[:, 4])

    def finish(self) -> None:
        """Look closer at leaves over which light varies much, as at the edges of shadows."""
        leaves = self._tree.leaves
        uneven = leaves[self.spread[leaves] > _UNEVEN * level(self.values[leaves])]
        self.values[uneven] = direct_irradiance(self._scene, self._tree, uneven, self._threads, _MANY)[:, :3]


def direct_irradiance(
    scene: Packed, tree: PatchTree, nodes: Numbers, threads: int | None, places: int = PLACES
) -> Points:
    """(n, 5): irradiance of patches from all lights that are no patches, by so many places of each, a multiple of 16;
    how much it varies within each; and the most."""
    found = np.zeros((len(nodes), 5))
    environment = scene.arrays["lights"].arrays["environment"].arrays
    sky = bool(np.any(environment["constant"] > 0)) or len(environment["texels"]) > 0
    patches, pool = tree.packed(), Pool(threads)
    words = scratch_words(scene.arrays["fields"])
    waves = [new_wave(_WAVE, words) for _ in range(pool.threads)]
    scratch = [np.zeros((PLACES, 3)) for _ in range(pool.threads)]

    def work(first: int, thread: int) -> None:
        last = min(first + _NODES_A_JOB, len(nodes))
        own = waves[thread].words
        direct_light(scene.words, patches.words, own, nodes, sky, places, scratch[thread], found, first, last)

    pool.run(work, range(0, len(nodes), _NODES_A_JOB), lambda done: None)
    if pool.interrupted:
        raise KeyboardInterrupt
    return found


def cut_by_direct(
    tree: PatchTree, direct: Direct, spots: Spots, allowed: float, patch: float, *, follow_lamps: bool
) -> None:
    """Cut patches over which light that comes from no patch changes by more than `allowed`, and those between whose
    places a light that is near may bring a peak of so much. Edges do not get shorter than `patch`, or, to
    `follow_lamps`, an eighth of how near a light is where that is less."""
    while True:
        leaves = tree.leaves[level(tree.albedo[tree.leaves]) > 0]
        dull = level(tree.albedo[leaves])
        reach, most = _near_spots(tree, spots, leaves)
        least = np.full(len(leaves), patch)
        if follow_lamps:
            least = np.minimum(patch, np.maximum(reach / PARTS, patch / FINER))
        peak = (most > np.maximum(PEAK * direct.most[leaves], allowed / dull)) & (2 * reach < tree.edges[leaves])
        poor = (peak | (direct.spread[leaves] * dull > allowed)) & (tree.edges[leaves] >= 2 * least)
        if not poor.any():
            return
        tree.cut(leaves[poor])
        direct.complete()


def cut_under_spots(tree: PatchTree, direct: Direct, spots: Spots, patch: float, *, follow_lamps: bool) -> None:
    """Cut patches until those under lights are no longer than these are high: else their light may be overlooked."""
    shortest = patch / FINER if follow_lamps else patch
    while True:
        leaves = tree.leaves[level(tree.albedo[tree.leaves]) > 0]
        reach, most = _near_spots(tree, spots, leaves)
        edges = tree.edges[leaves]
        poor = (most > PEAK * direct.most[leaves]) & (2 * reach < edges) & (edges >= 2 * shortest)
        if not poor.any():
            return
        tree.cut(leaves[poor])
        direct.complete()


def _near_spots(tree: PatchTree, spots: Spots, leaves: Numbers) -> tuple[Points, Points]:
    """How near the light is that may send the most to a place on each leaf, or its radius where that is more, and what
    that would be, (n,) each."""
    reach, most = np.full(len(leaves), np.inf), np.zeros(len(leaves))
    for place, radius, intensity in zip(*spots, strict=True):
        way = place - tree.centres[leaves]
        height = (way * tree.normals[leaves]).sum(axis=1)
        aside = np.sqrt(np.maximum((way**2).sum(axis=1) - height**2, 0.0))
        near = np.hypot(height, np.maximum(aside - tree.radii[leaves], 0.0))
        near = np.maximum(near, max(radius, 1e-300))
        # Lights behind a leaf send nothing there.
        arriving = np.where(height > -radius, intensity / near**2, 0.0)
        more = arriving > most
        reach, most = np.where(more, near, reach), np.where(more, arriving, most)
    return reach, most
