"""Light: the path tracer against Mitsuba, and radiosity: form factors against closed forms, a room against path
tracing, and how cost grows with the elements.

    python bench/light.py [--only mitsuba form-factors room cost] [--size 48] [--samples 512]
        [--rounds 1] [--seeds 6] [--elements 1000 10000 100000]

Beside Mitsuba stands one scene for each kind of light and of reflectance that both have; see compare_mitsuba.py.
Elements are the faces of a room's walls, cut into grids beforehand, and what the solver cuts them into.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from importlib.util import find_spec

import numpy as np

import isophote as iso
from common import print_machine

FLOOR = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], float)
CEILING = np.add(FLOOR[::-1], (0, 0, 1))
WALL = np.array([(0, 0, 0), (0, 1, 0), (0, 1, 1), (0, 0, 1)], float)
COST_GOAL, SECONDS_GOAL, PATH_GOAL = 1.2, 20.0, 0.005
# Of normal deviates 99.73 % are within 3 σ; of so many values as there are, a tenth of a percent fewer may be.
MEAN_GOAL, SHARE_GOAL = 0.003, 0.996
PARTS = ("mitsuba", "form-factors", "room", "cost")


def grid(corner: Sequence[float], along: Sequence[float], across: Sequence[float], count: int) -> iso.Mesh:
    """A parallelogram as count × count of them."""
    i, j = np.meshgrid(np.arange(count + 1), np.arange(count + 1), indexing="ij")
    steps = np.stack([i.reshape(-1), j.reshape(-1)], axis=1) / count
    number = np.arange((count + 1) ** 2).reshape(count + 1, count + 1)
    faces = np.stack([number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]], axis=-1).reshape(-1, 4)
    return iso.Mesh(np.asarray(corner, float) + steps @ np.array([along, across], float), faces)


def room(count: int) -> iso.Scene:
    """Five walls with a lamp, as Cornell's box."""
    walls = [
        (grid((-1, 0, -1), (0, 0, 2), (2, 0, 0), count), (0.7, 0.7, 0.7)),
        (grid((-1, 2, -1), (2, 0, 0), (0, 0, 2), count), (0.7, 0.7, 0.7)),
        (grid((-1, 0, -1), (2, 0, 0), (0, 2, 0), count), (0.7, 0.7, 0.7)),
        (grid((-1, 0, 1), (0, 0, -2), (0, 2, 0), count), (0.6, 0.1, 0.1)),
        (grid((1, 0, -1), (0, 0, 2), (0, 2, 0), count), (0.1, 0.5, 0.1)),
    ]
    lamp = iso.RectLight(size=(0.5, 0.5), radiance=15).at((0, 1.98, 0))
    camera = iso.Camera((0, 1, 4.4), (0, 1, 0), fov_degrees=34)
    return iso.Scene([iso.Item(mesh, iso.Matte(colour)) for mesh, colour in walls], lights=[lamp], camera=camera)


def compare_with_mitsuba(size: int, samples: int) -> None:
    """Means of whole pictures, and pixels by their noise."""
    if find_spec("mitsuba") is None:
        print("Mitsuba is not installed")
        return
    from compare_mitsuba import KINDS, compare, has_models

    print("| scene | mean against Mitsuba's | standard error | within 3 σ | mean square deviation | goal |")
    print("|---|---|---|---|---|---|")
    for name in KINDS:
        if name == "environment" and not has_models():
            print("| environment | the picture of the sky is not here |  |  |  |  |")
            continue
        found, _, _ = compare(name, size, samples)
        off = abs(found.ratio - 1) - 3 * found.ratio_error
        met = "met" if off <= MEAN_GOAL and found.share >= SHARE_GOAL else "**missed**"
        print(
            f"| {name} | {found.ratio - 1:+.3%} | {found.ratio_error:.3%} | {found.share:.2%} | "
            f"{found.mean_square:.3f} | {met} |",
            flush=True,
        )
    print(f"\nGoal: means within {MEAN_GOAL:.1%} and three standard errors, {SHARE_GOAL:.1%} of the values within 3 σ.")


def compare_form_factors() -> None:
    """Unit squares, and all walls of a cube."""
    parallel, touching = iso.form_factor(FLOOR, CEILING), iso.form_factor(FLOOR, WALL)
    print(f"unit squares, parallel: {parallel:.9f}, off by {abs(parallel - 0.199824896):.1e} (goal 1e-4)")
    print(f"unit squares, touching: {touching:.9f}, off by {abs(touching - 0.200043776):.1e} (goal 1e-4)")
    print(f"closure of a cube: off by {abs(parallel + 4 * touching - 1):.1e} (goal 1e-6)")


def furnished() -> iso.Scene:
    """The room with two boxes that stand in it."""
    cube, white = iso.to_mesh(iso.box(1), cell=0.25, progress=False), iso.Matte(0.7)
    tall = iso.Item(cube, white).scale((0.55, 1.2, 0.55)).rotate("y", 0.3).translate((-0.35, 0.6, -0.3))
    low = iso.Item(cube, white).scale(0.55).rotate("y", -0.3).translate((0.4, 0.275, 0.35))
    scene = room(1)
    return iso.Scene([*scene.items, tall, low], lights=scene.lights, camera=scene.camera)


def blocks(image: iso.Image) -> np.ndarray:
    """Means over 8 × 8 pixels, without the rim."""
    colour = image.channels["colour"].astype(np.float64)
    return colour.reshape(10, 8, 10, 8, 3).mean(axis=(1, 3))[1:-1, 1:-1].mean(axis=2)


def compare_path_tracing(name: str, scene: iso.Scene, seeds: int) -> None:
    """Blocks of 8 × 8 pixels of a picture, against the mean of several path traced ones, their own noise removed."""
    method = iso.Radiosity(patch=0.06, error=0.005, samples=400)
    ours = blocks(iso.render(scene, method, size=(80, 80), progress=False))
    path = iso.PathTrace(samples=1024, max_depth=64)
    traced = np.array([blocks(iso.render(scene, path, size=(80, 80), seed=k, progress=False)) for k in range(seeds)])
    theirs = traced.mean(axis=0)
    noise = traced.std(axis=0, ddof=1) / seeds**0.5 / theirs
    errors = np.sqrt(np.maximum((ours / theirs - 1) ** 2 - noise**2, 0))
    print(
        f"{name} against path tracing, by blocks: median {np.median(errors):.2%}, nine in ten within "
        f"{np.percentile(errors, 90):.2%}, most {errors.max():.2%} (goal {PATH_GOAL:.1%}); noise {np.median(noise):.3%}"
    )


def measure_cost(wanted: Sequence[int], rounds: int) -> None:
    """Seconds for rooms of more and more elements, and the exponent between the first and the last."""
    found = []
    for count in wanted:
        # Walls have two sides.
        scene, best, busy = room(max(1, round((count / 10) ** 0.5))), np.inf, np.inf
        for _ in range(rounds):
            began, worked = time.perf_counter(), time.process_time()
            solution = iso.radiosity(scene, iso.Radiosity(patch=1.0, residual=1e-4), progress=False)
            best, busy = min(best, time.perf_counter() - began), min(busy, time.process_time() - worked)
        found.append((len(solution.areas), busy))
        print(
            f"{len(solution.areas):,} elements: {best:.2f} s, {busy:.2f} s of processors, {solution.links:,} links, "
            f"{solution.bounce_count} bounces, residual {solution.residuals[-1]:.1e}"
        )
    if len(found) > 1:
        (few, short), (many, long) = found[0], found[-1]
        print(f"exponent, by processor time: {np.log(long / short) / np.log(many / few):.2f} (goal {COST_GOAL})")
        print(f"{many:,} elements to a residual of 1e-4: {best:.1f} s (goal {SECONDS_GOAL:.0f} s for 100,000)")


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="+", choices=PARTS, default=PARTS)
    parser.add_argument("--size", type=int, default=48, help="of pictures beside Mitsuba's")
    parser.add_argument("--samples", type=int, default=512, help="paths a pixel in each of 16 runs of those")
    parser.add_argument("--rounds", type=int, default=1)
    parser.add_argument("--elements", type=int, nargs="+", default=[1000, 10_000, 100_000])
    parser.add_argument("--seeds", type=int, default=6)
    options = parser.parse_args(arguments)
    if options.seeds < 2:
        parser.error("--seeds needs 2 or more: what they differ by is the noise of the reference")
    print_machine()
    if "mitsuba" in options.only:
        compare_with_mitsuba(options.size, options.samples)
    if "form-factors" in options.only:
        compare_form_factors()
    if "room" in options.only:
        compare_path_tracing("room", room(1), options.seeds)
        compare_path_tracing("room with boxes", furnished(), options.seeds)
    if "cost" in options.only:
        iso.radiosity(room(2), iso.Radiosity(patch=1.0), progress=False)
        measure_cost(options.elements, options.rounds)


if __name__ == "__main__":
    main()
