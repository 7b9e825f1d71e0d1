"""Accelerators against the tree of eight children a node, on eight scenes: building, memory, rays, visits.

    python bench/accelerators.py [--rounds 5] [--size 192] [--scenes soup scan …] [--accelerators grid …]
    python bench/accelerators.py --agree 1000000

Rays are a camera's, row by row, and one diffuse bounce off each of their hits, on one thread, by `Tracer.closest`. The
ratio is that of rays a second to those of "bvh" on the same rays in the same run. With `--agree`, instead: whether
every accelerator finds the distances of brute force on so many rays over every mesh of the models, bit for bit.
"""

from __future__ import annotations

import argparse
import warnings
from collections.abc import Sequence

import numpy as np

import isophote as iso
from accelerator_scenes import MODELS, SCENES, bounce_from, view_rays
from common import Rays, in_turns, print_machine, print_table
from isophote.accel.accelerator import ACCELERATORS, build_accelerator

HEADINGS = (
    "scene", "accelerator", "triangles", "build, s", "bytes a triangle", "rays", "Mray/s", "ratio", "median",
    "nodes a ray", "triangles a ray", "depth",
)  # fmt: skip
# Tests of triangles by brute force in one go.
CHUNK = 2_000_000_000


def measure(scene: str, names: Sequence[str], rounds: int, size: int) -> list[list[object]]:
    """The rows of one scene."""
    points, triangles = SCENES[scene]()
    mesh = iso.Mesh(points, triangles)
    every = list(dict.fromkeys(["bvh", *names]))
    building = in_turns(
        {name: lambda name=name: build_accelerator(name, points, triangles, threads=1) for name in every}, rounds
    )
    bytes_each = {name: build_accelerator(name, points, triangles).bytes / len(triangles) for name in every}
    tracers = {name: iso.Tracer(mesh, accelerator=name, threads=1) for name in every}
    camera = view_rays(scene, size)
    rows: list[list[object]] = []
    for kind, rays in {"camera": camera, "bounce": bounce_from(tracers["bvh"], camera)}.items():
        found = in_turns({name: lambda name=name, rays=rays: tracers[name].closest(*rays) for name in every}, rounds)
        for name in names:
            ours, tree = found[name].cpu, found["bvh"].cpu
            counts = tracers[name].count(*rays)
            rows.append(
                [
                    scene,
                    name,
                    len(triangles),
                    float(building[name].cpu.min()),
                    round(bytes_each[name]),
                    kind,
                    float(len(rays.origins) / ours.min() / 1e6),
                    float(tree.min() / ours.min()),
                    float(np.median(tree / ours)),
                    float(counts.nodes.mean()),
                    float(counts.primitives.mean()),
                    int(counts.depth.max()),
                ]
            )
    return rows


def random_rays(mesh: iso.Mesh, count: int, seed: int) -> Rays:
    """Rays from in and around the mesh's box to places in it; every eighth along an axis or in a plane of two."""
    rng = np.random.default_rng(seed)
    low, high = mesh.bounds
    size = np.maximum(high - low, 1e-3 * (high - low).max())
    origins = low + size * rng.uniform(-0.5, 1.5, (count, 3))
    directions = low + size * rng.uniform(0, 1, (count, 3)) - origins
    flat = rng.random(count) < 0.125
    directions[flat] *= rng.random((int(flat.sum()), 3)) < 0.5
    directions[(directions == 0).all(axis=1)] = (0, 0, -1)
    return Rays(origins.astype(np.float32), directions.astype(np.float32))


def disagreements(mesh: iso.Mesh, names: Sequence[str], count: int, threads: int | None) -> tuple[int, dict[str, int]]:
    """How many rays meet anything by brute force, and on how many each accelerator differs from it, in distance or in
    whether there is anything."""
    tracers = {name: iso.Tracer(mesh, accelerator=name, threads=threads) for name in ("brute", *names)}
    hits, differ = 0, dict.fromkeys(names, 0)
    step = max(1, CHUNK // max(len(iso.triangulate(mesh).triangles), 1))
    for first in range(0, count, step):
        rays = random_rays(mesh, min(step, count - first), first)
        truth = tracers["brute"].closest(*rays)
        hits += int(truth.hit.sum())
        for name in names:
            found = tracers[name].closest(*rays)
            wrong = (found.distance != truth.distance) | (tracers[name].occluded(*rays) != truth.hit)
            differ[name] += int(wrong.sum())
    return hits, differ


def agree(names: Sequence[str], count: int, threads: int | None) -> None:
    """Print a row for every model, the small ones first, as soon as it is known."""
    models = sorted(_models(), key=lambda model: len(iso.triangulate(model[1]).triangles))
    every = count * sum(len(iso.triangulate(mesh).triangles) for _, mesh in models)
    print(f"{len(models)} models, {count:,} rays each: {every:.2g} tests of triangles by brute force", flush=True)
    print("model | triangles | rays | hits | " + " | ".join(f"{name} differs" for name in names), flush=True)
    total = np.zeros(2 + len(names), np.int64)
    for name, mesh in models:
        hits, differ = disagreements(mesh, names, count, threads)
        row = [count, hits, *differ.values()]
        total += row
        cells = [name, len(iso.triangulate(mesh).triangles), *row]
        print(" | ".join(str(cell) for cell in cells), flush=True)
    print("all | | " + " | ".join(str(number) for number in total.tolist()), flush=True)


def _models() -> list[tuple[str, iso.Mesh]]:
    """All meshes that can be read, by their names in the folder."""
    found = []
    for path in sorted(MODELS.rglob("*")):
        if path.suffix not in (".obj", ".off", ".ply", ".stl", ".gz"):
            continue
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                mesh = iso.load_mesh(path)
        except iso.Error:
            continue
        if len(mesh.faces):
            found.append((path.relative_to(MODELS).as_posix(), mesh))
    return found


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--size", type=int, default=192, help="camera rays are size × size")
    parser.add_argument("--scenes", nargs="+", choices=SCENES, default=list(SCENES))
    parser.add_argument("--accelerators", nargs="+", choices=ACCELERATORS, default=list(ACCELERATORS))
    parser.add_argument("--agree", type=int, metavar="RAYS", help="compare with brute force on so many rays a mesh")
    parser.add_argument("--threads", type=int, help="threads of --agree; all cores unless given")
    options = parser.parse_args(arguments)
    print_machine()
    if options.agree:
        agree(options.accelerators, options.agree, options.threads)
        return
    rows = [row for name in options.scenes for row in measure(name, options.accelerators, options.rounds, options.size)]
    print_table(HEADINGS, rows)


if __name__ == "__main__":
    main()
