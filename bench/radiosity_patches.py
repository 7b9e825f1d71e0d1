"""Radiosity patch by patch: the mean irradiance of patches against rays from many places of each.

    python bench/radiosity_patches.py [--only room furnished] [--patches 400] [--samples 4096] [--settings 0.06 0.005]

Light of the lamp is integrated over patch and lamp by rays between them; all other light by rays into the half space,
spread by the cosine, that bring what leaves the places they meet: for that a finer solution is asked. The reference is
the mean of four runs, whose differences tell its own error. Patches are chosen at random.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence

import numpy as np
from scipy.stats import qmc

import isophote as iso
from common import print_machine
from light import furnished, room

GOAL, RUNS, AT_ONCE = 0.005, 4, 400_000
# How far rays start above patches, in metres, and how dark patches may be to be compared, in W/m².
ABOVE, DARK = 2e-4, 0.02
# The lamp of both rooms: a corner, two edges, and its radiance, more than anything reflects.
CORNER, ALONG, ACROSS, RADIANCE = (np.array(v) for v in ((-0.25, 1.98, -0.25), (0.5, 0, 0), (0, 0, 0.5), 15.0))


class Reference:
    """Rays in a room whose light is known from a fine solution."""

    def __init__(self, scene: iso.Scene) -> None:
        fine = iso.radiosity(scene, iso.Radiosity(patch=0.04, error=0.003), progress=False)
        self._tracer, self._faces = iso.Tracer(fine.mesh), np.asarray(fine.mesh.faces)
        self._colours = fine.mesh.colours.values.astype(np.float64).mean(axis=1)

    def irradiance(self, corners: np.ndarray, normals: np.ndarray, samples: int, seed: int) -> np.ndarray:
        """(n,): mean over what of patches (n, 4, 3) lies within no solid."""
        points = [qmc.Sobol(4, seed=seed + k).random(samples) for k in range(2)]
        random, found = np.random.default_rng(seed), np.zeros(len(corners))
        step = max(1, AT_ONCE // samples)
        for first in range(0, len(corners), step):
            own, normal = corners[first : first + step], normals[first : first + step]
            for way, numbers in zip((self._from_lamp, self._from_walls), points, strict=True):
                shifted = (numbers + random.random((len(own), 1, 4))) % 1
                places = on_patches(own, shifted[..., 0], shifted[..., 1]).reshape(-1, 3)
                up = np.repeat(normal, samples, axis=0)
                is_open = ~self._is_buried(places, up)
                light = np.where(is_open, way(places, up, *shifted[..., 2:].reshape(-1, 2).T), 0.0)
                counts = np.maximum(is_open.reshape(-1, samples).sum(axis=1), 1)
                found[first : first + step] += light.reshape(-1, samples).sum(axis=1) / counts
        return found

    def _is_buried(self, places: np.ndarray, up: np.ndarray) -> np.ndarray:
        """Whether places lie within solids: what is above them turns its back on them."""
        hits = self._tracer.closest(places + ABOVE * up, up)
        return hits.hit & ((hits.normal * up).sum(axis=1) > 0)

    def _from_lamp(self, places: np.ndarray, up: np.ndarray, u: np.ndarray, v: np.ndarray) -> np.ndarray:
        way = CORNER + u[:, None] * ALONG + v[:, None] * ACROSS - places
        square = (way**2).sum(axis=1)
        light = np.maximum((way * up).sum(axis=1), 0) * np.maximum(way[:, 1], 0) / square**2 * (RADIANCE / 4)
        go = np.flatnonzero(light > 0)
        start = places[go] + ABOVE * up[go]
        blocked = self._tracer.closest(start, places[go] + way[go] - start, 0.999).hit
        light[go[blocked]] = 0
        return light

    def _from_walls(self, places: np.ndarray, up: np.ndarray, u: np.ndarray, v: np.ndarray) -> np.ndarray:
        side = np.cross(np.where(np.abs(up[:, :1]) < 0.9, [[1.0, 0, 0]], [[0, 1.0, 0]]), up)
        side /= np.linalg.norm(side, axis=1, keepdims=True)
        x, y, z = np.sqrt(u) * np.cos(2 * np.pi * v), np.sqrt(u) * np.sin(2 * np.pi * v), np.sqrt(1 - u)
        way = x[:, None] * side + y[:, None] * np.cross(up, side) + z[:, None] * up
        hits = self._tracer.closest(places + ABOVE * up, way)
        corner, weights = self._colours[self._faces[np.maximum(hits.primitive, 0)]], hits.uv.astype(np.float64)
        light = corner[:, 0] * (1 - weights.sum(axis=1)) + (corner[:, 1:] * weights).sum(axis=1)
        return np.where(hits.hit & (corner.max(axis=1) < 0.9 * RADIANCE), np.pi * light, 0.0)


def on_patches(corners: np.ndarray, u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """(n, k, 3): places on triangles, whose last corner is NaN, and parallelograms."""
    three = np.isnan(corners[:, 3, 0])
    fold = three[:, None] & (u + v > 1)
    u, v = np.where(fold, 1 - u, u)[..., None], np.where(fold, 1 - v, v)[..., None]
    origin, last = corners[:, None, 0], np.where(three[:, None], corners[:, 2], np.nan_to_num(corners[:, 3]))
    return origin + u * (corners[:, None, 1] - origin) + v * (last[:, None] - origin)


def compare(name: str, scene: iso.Scene, settings: iso.Radiosity, patches: int, samples: int) -> None:
    began = time.process_time()
    found = iso.radiosity(scene, settings, progress=False)
    seconds = time.process_time() - began
    normals = np.cross(found.corners[:, 1] - found.corners[:, 0], found.corners[:, 2] - found.corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    middle = np.nanmean(found.corners, axis=1)
    inside = (np.abs(middle + 0.02 * normals - (0, 1, 0)) < 1).all(axis=1) & (found.albedo.mean(axis=1) > 0)
    # What solids cover wholly is dark.
    chosen = np.flatnonzero(inside & (found.irradiance.mean(axis=1) > DARK))
    chosen = np.sort(np.random.default_rng(5).choice(chosen, min(patches, len(chosen)), replace=False))
    reference = Reference(scene)
    runs = np.array(
        [reference.irradiance(found.corners[chosen], normals[chosen], samples, 10 * k) for k in range(RUNS)]
    )
    exact = runs.mean(axis=0)
    lit = exact > DARK
    noise = runs.std(axis=0, ddof=1)[lit] / RUNS**0.5 / exact[lit]
    off = (found.irradiance[chosen].mean(axis=1) / np.maximum(exact, 1e-300) - 1)[lit]
    size = np.abs(off)
    print(
        f"| {name} | {len(found.areas):,} | {seconds:.2f} | {off.mean():+.2%} | {np.median(size):.3%} | "
        f"{np.percentile(size, 90):.2%} | {np.percentile(size, 99):.2%} | {size.max():.1%} | "
        f"{(size <= GOAL).mean():.1%} | {np.median(noise):.3%} |",
        flush=True,
    )


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    scenes = {"room": lambda: room(1), "furnished": furnished}
    parser.add_argument("--only", nargs="+", choices=tuple(scenes), default=tuple(scenes))
    parser.add_argument("--patches", type=int, default=400)
    parser.add_argument("--samples", type=int, default=4096, help="rays a patch in each of four runs, twice")
    parser.add_argument("--settings", type=float, nargs=2, metavar=("PATCH", "ERROR"), help="else those by default")
    options = parser.parse_args(arguments)
    settings = (
        iso.Radiosity(patch=options.settings[0], error=options.settings[1]) if options.settings else iso.Radiosity()
    )
    print_machine()
    print(f"| room | patches | s of processors | mean | median | 90 % | 99 % | most | within {GOAL:.1%} | noise |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    for name in options.only:
        compare(name, scenes[name](), settings, options.patches, options.samples)


if __name__ == "__main__":
    main()
