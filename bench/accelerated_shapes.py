"""Accelerators over exact primitives: many spheres, and a crowd of all kinds; building, rays, visits.

    python bench/accelerated_shapes.py [--count 100000] [--rounds 5] [--rays 20000]

Rays go from in and around the scene to places in it, on one thread, by `Tracer.closest`. Building is that of the
accelerator alone, over the boxes; the ratio is that of rays a second to those of "bvh" on the same rays and run.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence

import numpy as np

import isophote as iso
from common import in_turns, print_machine, print_table
from isophote.accel.accelerator import ACCELERATORS, build_things
from isophote.lower.primitive_table import primitive_of
from isophote.shapes.primitive.extent import boxes_around

HEADINGS = (
    "scene", "accelerator", "primitives", "build, s", "bytes each", "Mray/s", "ratio", "nodes a ray", "tests a ray",
    "depth",
)  # fmt: skip


def spheres(count: int) -> list[iso.Item]:
    """Spheres of many sizes all over a cube, a few of them through each other."""
    rng = np.random.default_rng(0)
    radii = count ** (-1 / 3) * rng.uniform(0.1, 0.6, count)
    places = rng.uniform(-1, 1, (count, 3))
    return [iso.Item(iso.sphere(float(r))).translate(p) for r, p in zip(radii, places, strict=True)]


def crowd(count: int) -> list[iso.Item]:
    """Solids of six kinds on a plane, turned every way."""
    rng = np.random.default_rng(1)
    kinds = [iso.sphere(1), iso.torus(0.8, 0.3), iso.cylinder(0.4, 2), iso.cone(0.8, 1.6), iso.box(1.2), iso.Disk(1)]
    items = []
    for k in range(count):
        size, angle = float(0.6 * count**-0.5 * rng.uniform(0.5, 1.5)), float(rng.uniform(0, 6))
        item = iso.Item(kinds[k % len(kinds)]).rotate(tuple(rng.normal(size=3)), angle).scale(size)
        items.append(item.translate((rng.uniform(-1, 1), size, rng.uniform(-1, 1))))
    return items


SCENES = {"spheres": spheres, "crowd": crowd}


def measure(name: str, count: int, rounds: int, ray_count: int) -> list[list[object]]:
    """The rows of one scene."""
    items = SCENES[name](count)
    boxes = boxes_around([primitive_of(item.shape).placed(item.transform.matrix) for item in items]).astype(np.float32)
    rng = np.random.default_rng(2)
    low, high = boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)
    origins = low + (high - low) * rng.uniform(-0.25, 1.25, (ray_count, 3))
    directions = low + (high - low) * rng.uniform(0, 1, (ray_count, 3)) - origins
    scene = iso.Scene(items)
    tracers = {kind: iso.Tracer(scene, accelerator=kind, threads=1) for kind in ACCELERATORS}
    corners = boxes[:, 0], boxes[:, 1]
    building = in_turns(
        {kind: lambda kind=kind: build_things(kind, *corners, threads=1) for kind in ACCELERATORS}, rounds
    )
    found = in_turns(
        {kind: lambda kind=kind: tracers[kind].closest(origins, directions) for kind in ACCELERATORS}, rounds
    )
    rows: list[list[object]] = []
    for kind in ACCELERATORS:
        ours, tree = found[kind].cpu, found["bvh"].cpu
        counts = tracers[kind].count(origins, directions)
        rows.append(
            [
                name,
                kind,
                count,
                float(building[kind].cpu.min()),
                round(build_things(kind, *corners).bytes / count),
                float(ray_count / ours.min() / 1e6),
                float(tree.min() / ours.min()),
                float(counts.nodes.mean()),
                float(counts.primitives.mean()),
                int(counts.depth.max()),
            ]
        )
    return rows


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=100_000, help="primitives of each scene")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--rays", type=int, default=20_000)
    parser.add_argument("--scenes", nargs="+", choices=SCENES, default=list(SCENES))
    options = parser.parse_args(arguments)
    print_machine()
    rows = [row for name in options.scenes for row in measure(name, options.count, options.rounds, options.rays)]
    print_table(HEADINGS, rows)


if __name__ == "__main__":
    main()
