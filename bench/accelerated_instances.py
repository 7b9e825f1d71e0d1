"""Accelerators over instances: a thousand placed copies of one mesh; rays, visits.

    python bench/accelerated_instances.py [--count 1000] [--rounds 5] [--size 96]

Rays are a camera's and one bounce off each of their hits, on one thread, by `Tracer.closest`. Each accelerator holds
the triangles of the mesh and the boxes of its copies; the ratio is that of rays a second to those of "bvh" on the same
rays and run.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence

import numpy as np

import isophote as iso
from accelerator_scenes import bounce_from
from common import Rays, geodesic_sphere, in_turns, print_machine, print_table
from isophote.accel.accelerator import ACCELERATORS

HEADINGS = ("accelerator", "rays", "Mray/s", "ratio", "median", "nodes a ray", "triangles a ray")


def copies(count: int) -> iso.Scene:
    """Balls of 1,280 triangles, stretched and turned, all over a block of space on a ground."""
    ball, rng = iso.Mesh(*geodesic_sphere(8)), np.random.default_rng(7)
    ground = iso.Mesh([(-30, -12, -30), (-30, -12, 30), (30, -12, 30), (30, -12, -30)], [(0, 1, 2, 3)])
    items = [iso.Item(ground)]
    for _ in range(count):
        place, size = rng.uniform(-1, 1, 3) * (20, 10, 20), rng.uniform(0.3, 1.5, 3)
        items.append(iso.Item(ball).scale(size).rotate("y", float(rng.uniform(0, 6))).translate(place))
    return iso.Scene(items)


def view_rays(size: int) -> Rays:
    """A pinhole camera from above a corner, row by row."""
    eye = np.array([30.0, 12.0, 38.0])
    back = eye / np.linalg.norm(eye)
    right = np.cross([0, 1, 0], back)
    right /= np.linalg.norm(right)
    steps = ((np.arange(size) + 0.5) / size * 2 - 1) * np.tan(np.radians(20))
    x, y = (grid.reshape(-1, 1) for grid in np.meshgrid(steps, -steps))
    directions = x * right + y * np.cross(back, right) - back
    return Rays(np.tile(eye, (size * size, 1)).astype(np.float32), directions.astype(np.float32))


def measure(count: int, rounds: int, size: int) -> list[list[object]]:
    """The rows of all accelerators."""
    scene = copies(count)
    tracers = {name: iso.Tracer(scene, accelerator=name, threads=1) for name in ACCELERATORS}
    camera = view_rays(size)
    rows: list[list[object]] = []
    for kind, rays in {"camera": camera, "bounce": bounce_from(tracers["bvh"], camera)}.items():
        found = in_turns({name: lambda name=name, rays=rays: tracers[name].closest(*rays) for name in tracers}, rounds)
        for name, tracer in tracers.items():
            ours, tree, counts = found[name].cpu, found["bvh"].cpu, tracer.count(*rays)
            rate = len(rays.origins) / ours.min() / 1e6
            ratios = float(tree.min() / ours.min()), float(np.median(tree / ours))
            rows.append([name, kind, float(rate), *ratios, float(counts.nodes.mean()), float(counts.primitives.mean())])
    return rows


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=1_000)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--size", type=int, default=96, help="camera rays are size × size")
    options = parser.parse_args(arguments)
    print_machine()
    print_table(HEADINGS, measure(options.count, options.rounds, options.size))


if __name__ == "__main__":
    main()
