"""Ray tracing: rays a second, direct light against Mitsuba, and how penumbras settle with the number of shadow rays.

    python bench/ray_trace.py [--rounds 5] [--size 256] [--samples 16] [--long 2048] [--no-peer]

Rays are those that `RayTrace` counts, shadow rays included, by processor time of the whole call without building the
tree. Direct light of the Cornell box is set against Mitsuba's `direct` integrator with as many samples of pixels and of
the lamp, by 1 / (MSE · processor seconds), against a long picture of ours by PathTrace, which knows nothing of either.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Sequence

import numpy as np

import isophote as iso
from common import Array, bumpy_sphere, print_machine, print_table
from peers import load_mitsuba
from scenes import SCENES, isophote_scene, mitsuba_scene, mitsuba_sensor

# Seconds between pictures of the two sides.
_REST = 0.3
LIGHT_SAMPLES = 4


def views(frequency: int) -> dict[str, tuple[iso.Scene, iso.RayTrace]]:
    """Scenes to count rays in, and their settings."""
    camera = iso.Camera((0, 2, 5), (0, 0.4, 0))
    ground = iso.Item(iso.plane(), iso.Matte((0.7, 0.5, 0.3)))
    lamp = iso.RectLight(size=(1, 1), power=60).at((-1, 2.5, 1))
    points = [iso.PointLight((x, 3, 1), 50) for x in (-2, -1, 1, 2)]
    bumpy = iso.Item(iso.Mesh(*bumpy_sphere(frequency)), iso.Matte(0.5)).scale(0.6).translate((0, 0.7, 0))
    balls = [iso.Item(iso.sphere(0.6), m).translate((x, 0.6, 0)) for x, m in ((-0.7, iso.Mirror()), (0.7, iso.Glass()))]
    plastic = iso.Item(iso.sphere(0.6), iso.Plastic("tomato")).translate((0, 0.6, 0))
    return {
        "Cornell box": (isophote_scene(SCENES["cornell"]()), iso.RayTrace()),
        "bumpy sphere, square light": (iso.Scene([ground, bumpy], [lamp], camera), iso.RayTrace()),
        "bumpy sphere, four points": (iso.Scene([ground, bumpy], points, camera), iso.RayTrace()),
        "plastic ball, square light": (iso.Scene([ground, plastic], [lamp], camera), iso.RayTrace()),
        "glass and mirror, depth 8": (iso.Scene([ground, *balls], [lamp], camera), iso.RayTrace(depth=8)),
    }


def shot(scene: iso.Scene, method: object, size: int, seed: int) -> tuple[iso.Image, float]:
    """A picture, and processor seconds without building the tree."""
    stamps: dict[tuple[str, float], float] = {}
    began = time.process_time()
    image = iso.render(
        scene,
        method,
        size=(size, size),
        seed=seed,
        progress=lambda stage, fraction: stamps.setdefault((stage, fraction), time.process_time()),
    )
    building = stamps["building the tree", 1.0] - stamps["building the tree", 0.0]
    return image, time.process_time() - began - building


def tell_rays(rounds: int, size: int, frequency: int) -> None:
    """Millions of rays by processor second."""
    rows = []
    for name, (scene, method) in views(frequency).items():
        rates = []
        for seed in range(rounds + 1):
            image, seconds = shot(scene, method, size, seed)
            rates.append(int(image.channels["rays"].sum()) / seconds / 1e6)
        # The first round warms up.
        rows.append((name, int(image.channels["rays"].sum()) / 1e6, np.median(rates[1:]), max(rates[1:])))
    print_table(("scene", "rays, million", "million a second, median", "best"), rows)


def tell_direct(rounds: int, size: int, samples: int, long_samples: int) -> None:
    """Direct light of the Cornell box against Mitsuba."""
    mitsuba, _ = load_mitsuba()
    description = SCENES["cornell"]()
    ours, theirs = isophote_scene(description), mitsuba_scene(mitsuba, description)
    long = _colour(iso.render(ours, iso.PathTrace(samples=long_samples, max_depth=2), size=(size, size), seed=99))
    method = iso.RayTrace(depth=1, samples=samples, light_samples=LIGHT_SAMPLES)

    def isophote(seed: int) -> tuple[Array, float]:
        image, seconds = shot(ours, method, size, seed)
        return _colour(image), seconds

    sides: dict[str, Callable[[int], tuple[Array, float]]] = {"Isophote, RayTrace": isophote}
    for sampler in ("multijitter", "independent"):
        sides[f"Mitsuba, direct, {sampler}"] = _mitsuba_shots(mitsuba, theirs, description, sampler, size, samples)
    found: dict[str, list[tuple[float, float]]] = {side: [] for side in sides}
    for seed in range(rounds + 1):
        for side, shoot in sides.items():
            # Mitsuba's threads go on looking for work a while, which would count as ours.
            time.sleep(_REST)
            picture, seconds = shoot(seed)
            if seed > 0:
                found[side].append((float(((picture - long) ** 2).mean() ** 0.5), seconds))
    scores = {side: [1 / (error**2 * seconds) for error, seconds in shots] for side, shots in found.items()}
    best = max(np.median(values) for side, values in scores.items() if side.startswith("Mitsuba"))
    rows = [
        (side, *(np.median(np.array(shots), axis=0)), np.median(scores[side]) / best) for side, shots in found.items()
    ]
    print_table(("side", "error", "processor s", "efficiency to the best peer"), rows)


def _mitsuba_shots(
    mitsuba: object, scene: object, description: object, sampler: str, size: int, samples: int
) -> Callable[[int], tuple[Array, float]]:
    sensor = mitsuba_sensor(mitsuba, description.view, size, sampler, samples)
    integrator = mitsuba.load_dict({"type": "direct", "emitter_samples": LIGHT_SAMPLES, "bsdf_samples": 0})

    def shoot(seed: int) -> tuple[Array, float]:
        began = time.process_time()
        picture = mitsuba.render(scene, sensor=sensor, integrator=integrator, spp=samples, seed=seed)
        return np.array(picture, np.float64), time.process_time() - began

    return shoot


def tell_penumbras(size: int, long_samples: int) -> None:
    """Error of one sample a pixel under a square light, by the number of shadow rays and the pattern."""
    scene = isophote_scene(SCENES["cornell"]())
    long = _colour(
        iso.render(scene, iso.RayTrace(1, max(1, long_samples // 16), 16, pattern="sobol"), size=(size, size), seed=9)
    )
    rows = []
    for rays in (1, 4, 16, 64):
        errors = []
        for pattern in ("independent", "jittered", "sobol", "blue-noise"):
            # The median leaves out the pixels that edges cross.
            image = iso.render(scene, iso.RayTrace(1, 16, rays, pattern=pattern), size=(size, size), seed=1)
            errors.append(float(np.median((_colour(image) - long) ** 2)) ** 0.5)
        rows.append((rays, *errors, errors[0] / errors[-1]))
    print_table(("shadow rays", "independent", "jittered", "sobol", "blue-noise", "independent / blue-noise"), rows)


def _colour(image: iso.Image) -> Array:
    return image.channels["colour"].astype(np.float64)


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--size", type=int, default=256)
    parser.add_argument("--samples", type=int, default=16)
    parser.add_argument("--frequency", type=int, default=224)
    parser.add_argument("--long", type=int, default=2048, help="samples of the long pictures")
    parser.add_argument("--no-peer", action="store_true")
    given = parser.parse_args(arguments)
    print_machine(*(() if given.no_peer else ("mitsuba",)))
    tell_rays(given.rounds, given.size, given.frequency)
    if not given.no_peer:
        tell_direct(given.rounds, given.size, given.samples, given.long)
    tell_penumbras(given.size, given.long)


if __name__ == "__main__":
    main()
