"""Path tracing against Mitsuba: error and time of the Cornell box, and of a million triangles under a sky.

    python bench/path_trace.py [--rounds 5] [--scenes cornell bumpy1M] [--size 256] [--samples 64]

Paths of at most 8 rays, box filter, as many threads as there are cores. Efficiency is 1 / (MSE · seconds), MSE the mean
square error over all linear colours against a long Mitsuba picture (4,096 and 1,024 samples), made at first use and
kept in ~/.cache/isophote-bench. Every round renders with another seed, and the sides take turns. Mitsuba renders a
scene that is loaded; of ours both are told: the whole of `iso.render`, which builds the tree and makes all channels,
and that without building the tree. Of Mitsuba there are several samplers, with Russian roulette from its default depth
on and without: the best of them by median efficiency is what ours is set against. Its lamp is a rectangle, which it
samples best; as a mesh of two triangles it is told beside that. (Its orthogonal sampler is left out:
it takes squares of primes only, 121 samples for 64.)

Mitsuba's llvm_ad_rgb needs LLVM (on Debian: `apt-get install libllvm19` and
DRJIT_LIBLLVM_PATH=/usr/lib/x86_64-linux-gnu/libLLVM.so.19.1); scalar_rgb stands in where there is none.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np

import isophote as iso
from common import Array, print_machine, print_table, verdict
from peers import load_mitsuba
from scenes import GOALS, REFERENCE_SAMPLES, SCENES, Description, isophote_scene, mitsuba_scene, mitsuba_sensor

DEPTH = 8
# Mitsuba's sampler, and the ray from which Russian roulette may end a path.
CONTENDERS = (("multijitter", 100), ("multijitter", 5), ("stratified", 5), ("ldsampler", 5), ("independent", 5))
_BATCH = 64
_OURS, _OURS_ALONE = "Isophote, whole call", "Isophote, without building the tree"


class Reference(NamedTuple):
    """A long picture, (h, w, 3), and the variance of its values."""

    mean: Array
    variance: Array


class Shot(NamedTuple):
    """A picture and the seconds it took."""

    picture: Array
    wall: float
    cpu: float


class Score(NamedTuple):
    """One side's rounds: efficiency of each by wall and processor time, root mean square errors and seconds."""

    efficiency: Array
    efficiency_cpu: Array
    error: Array
    wall: Array
    cpu: Array
    pictures: Array

    @classmethod
    def of(cls, shots: Sequence[Shot], reference: Reference) -> Score:
        pictures = np.stack([shot.picture for shot in shots])
        square = ((pictures - reference.mean) ** 2).mean(axis=(1, 2, 3))
        wall, cpu = (np.array([shot[k] for shot in shots]) for k in (1, 2))
        # Processor time is spread over the cores as if they were this process's own.
        even = cpu / (os.cpu_count() or 1)
        return cls(1 / (square * wall), 1 / (square * even), square**0.5, wall, cpu, pictures)


def reference(mitsuba: ModuleType, name: str, scene: Any, description: Description, size: int) -> Reference:
    """The long picture of a scene, from the cache or made now."""
    samples = REFERENCE_SAMPLES[name]
    folder = Path.home() / ".cache" / "isophote-bench"
    path = folder / f"{name}-{size}-{samples}.npz"
    if not path.exists():
        print(f"Making the reference of {name}, {samples} samples ...", flush=True)
        sensor = mitsuba_sensor(mitsuba, description.view, size, "multijitter", _BATCH)
        shoot = mitsuba_shots(mitsuba, scene, sensor, 100, _BATCH)
        total, squares, count = 0.0, 0.0, samples // _BATCH
        for batch in range(count):
            picture = shoot(1_000_000 + batch).picture
            total, squares = total + picture, squares + picture**2
        mean = total / count
        variance = np.maximum(squares / count - mean**2, 0) / max(count - 1, 1)
        folder.mkdir(parents=True, exist_ok=True)
        np.savez(path, mean=mean, variance=variance)
    with np.load(path) as kept:
        return Reference(kept["mean"], kept["variance"])


def mitsuba_shots(mitsuba: ModuleType, scene: Any, sensor: Any, roulette: int, samples: int) -> Callable[[int], Shot]:
    """A function that renders a loaded scene with a seed."""
    integrator = mitsuba.load_dict({"type": "path", "max_depth": DEPTH, "rr_depth": roulette})

    def shoot(seed: int) -> Shot:
        wall, cpu = time.perf_counter(), time.process_time()
        picture = mitsuba.render(scene, sensor=sensor, integrator=integrator, spp=samples, seed=seed)
        colours = np.array(picture, np.float64)
        return Shot(colours, time.perf_counter() - wall, time.process_time() - cpu)

    return shoot


def isophote_shots(scene: iso.Scene, size: int, samples: int) -> Callable[[int], tuple[Shot, Shot]]:
    """A function that renders with a seed: timed as a whole, and without building the tree."""

    def shoot(seed: int) -> tuple[Shot, Shot]:
        stamps: dict[tuple[str, float], tuple[float, float]] = {}

        def mark(stage: str, fraction: float) -> None:
            stamps.setdefault((stage, fraction), (time.perf_counter(), time.process_time()))

        wall, cpu = time.perf_counter(), time.process_time()
        method = iso.PathTrace(samples=samples, max_depth=DEPTH)
        image = iso.render(scene, method, size=(size, size), seed=seed, progress=mark)
        picture = image.channels["colour"].astype(np.float64)
        wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
        (wall0, cpu0), (wall1, cpu1) = (stamps["building the tree", fraction] for fraction in (0.0, 1.0))
        return Shot(picture, wall, cpu), Shot(picture, wall - (wall1 - wall0), cpu - (cpu1 - cpu0))

    return shoot


def scores(mitsuba: ModuleType, name: str, size: int, samples: int, rounds: int) -> dict[str, Score]:
    """All sides' scores, in turns."""
    description = SCENES[name]()
    theirs, ours = mitsuba_scene(mitsuba, description), isophote_scene(description)
    long = reference(mitsuba, name, theirs, description, size)
    ours_shoot = isophote_shots(ours, size, samples)
    sides = {}
    for sampler, roulette in CONTENDERS:
        sensor = mitsuba_sensor(mitsuba, description.view, size, sampler, samples)
        sides[f"Mitsuba, {sampler}, rr_depth {roulette}"] = mitsuba_shots(mitsuba, theirs, sensor, roulette, samples)
        if description.lamps and sampler == "multijitter":
            as_mesh = mitsuba_scene(mitsuba, description, lamps_as_meshes=True)
            name_as_mesh = f"Mitsuba, {sampler}, rr_depth {roulette}, lamp as a mesh"
            sides[name_as_mesh] = mitsuba_shots(mitsuba, as_mesh, sensor, roulette, samples)
    shots: dict[str, list[Shot]] = {side: [] for side in (_OURS, _OURS_ALONE, *sides)}
    for seed in range(rounds + 1):
        whole, alone = ours_shoot(seed)
        made = {_OURS: whole, _OURS_ALONE: alone, **{side: shoot(seed) for side, shoot in sides.items()}}
        # The first round warms up.
        if seed > 0:
            for side, shot in made.items():
                shots[side].append(shot)
    found = {side: Score.of(list_of_shots, long) for side, list_of_shots in shots.items()}
    tell(name, found, long, GOALS[name])
    return found


def tell(name: str, found: dict[str, Score], long: Reference, goal: float) -> None:
    """Tables of one scene: efficiency against the best of Mitsuba, and whether the pictures are the same."""
    peers = {side: score for side, score in found.items() if side.startswith("Mitsuba")}
    best = peers[max(peers, key=lambda side: np.median(peers[side].efficiency_cpu))]
    rows, checks = [], []
    for side, score in found.items():
        medians = (np.median(values) for values in (score.error, score.wall, score.cpu))
        ratios = score.efficiency / best.efficiency, score.efficiency_cpu / best.efficiency_cpu
        against = [float(np.median(ratio)) for ratio in ratios]
        extremes = (
            score.efficiency.max() / best.efficiency.max(),
            score.efficiency_cpu.max() / best.efficiency_cpu.max(),
        )
        met = verdict(against[1], goal) if side in (_OURS, _OURS_ALONE) else ""
        efficiency = np.median(score.efficiency), np.median(score.efficiency_cpu)
        rows.append(
            [side, *medians, score.wall.min(), score.cpu.min(), *efficiency, against[0], extremes[0], against[1],
             extremes[1], met]
        )  # fmt: skip
        checks.append([side, *likeness(score.pictures, long)])
    print(f"{name}\n")
    print_table(
        ("side", "RMSE", "wall s, median", "CPU s, median", "wall s, min", "CPU s, min", "efficiency by wall",
         "by CPU / cores", "ratio by wall, median", "of the best rounds", "ratio by CPU, median", "of the best rounds",
         "goal"),
        rows,
    )  # fmt: skip
    print_table(("side", "mean of the picture", "of the reference", "off by %", "values beyond 3 σ, %"), checks)


def likeness(pictures: Array, long: Reference) -> list[object]:
    """Means, their difference in per cent, and the part of the values whose mean over rounds is beyond 3 σ.

    σ is estimated from the rounds, so that Student's distribution holds: of five, 4.0 % lie beyond in the same picture.
    """
    mean, count = pictures.mean(axis=0), len(pictures)
    variance = long.variance + (pictures.var(axis=0, ddof=1) / count if count > 1 else 0)
    beyond = np.abs(mean - long.mean) > 3 * variance**0.5 + 1e-6
    off = 100 * (mean.mean() / long.mean.mean() - 1)
    return [f"{mean.mean():.6f}", f"{long.mean.mean():.6f}", f"{off:+.3f}", f"{100 * beyond.mean():.2f}"]


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--scenes", nargs="+", choices=SCENES, default=["cornell", "bumpy1M"])
    parser.add_argument("--size", type=int, default=256)
    parser.add_argument("--samples", type=int, default=64)
    options = parser.parse_args(arguments)
    mitsuba, _ = load_mitsuba()
    print_machine("mitsuba")
    print(f"Mitsuba {mitsuba.variant()}\n")
    for name in options.scenes:
        scores(mitsuba, name, options.size, options.samples, options.rounds)


if __name__ == "__main__":
    main()
