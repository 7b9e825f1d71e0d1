"""Exact primitives against meshes of a hundred thousand triangles of the same solids, one thread.

    python bench/primitives.py [--rounds 7] [--size 640] [--triangles 100000]

Rays go through `Tracer.closest` and `Tracer.occluded`, as a user calls them: random ones from a sphere around to points
of a ball, and those of a camera, row by row, in packets (`coherent=True`) and one by one. Pictures are path-traced
under a constant sky, whole calls of `render` after the first. Times are processor time, the least of all rounds; a
ratio is how many times as long the mesh takes.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from functools import partial

import numpy as np

import isophote as iso
from common import Rays, camera_rays, in_turns, print_machine, print_table, verdict

GOAL = 3.0
SOLIDS = {
    "sphere": iso.sphere(1.0),
    "cylinder": iso.cylinder(0.6, 1.4),
    "torus": iso.torus(0.8, 0.3),
}


def mesh_of(name: str, triangles: int) -> iso.Mesh:
    """A closed mesh of a solid of about so many triangles: rings of points about y, from below to above."""
    across = int((triangles / 4) ** 0.5) if name == "sphere" else int((triangles / 8) ** 0.5)
    around = triangles // (2 * across)
    s = np.linspace(0, 1, across + 1)
    if name == "sphere":
        angle = np.pi * (s - 0.5)
        profile = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    elif name == "cylinder":
        corners = np.array([(0, -0.7), (0.6, -0.7), (0.6, 0.7), (0, 0.7)])
        profile = np.stack([np.interp(3 * s, range(4), corners[:, k]) for k in (0, 1)], axis=1)
    else:
        angle = 2 * np.pi * s - np.pi
        profile = np.stack([0.8 + 0.3 * np.cos(angle), 0.3 * np.sin(angle)], axis=1)
    turn = 2 * np.pi * np.arange(around) / around
    rings = [np.stack([r * np.cos(turn), np.full(around, y), -r * np.sin(turn)], axis=1) for r, y in profile]
    here = np.arange((across + 1) * around).reshape(across + 1, around)
    there = np.roll(here, -1, axis=1)
    quads = np.stack([here[:-1], there[:-1], there[1:], here[1:]], axis=-1).reshape(-1, 4)
    return iso.Mesh(np.concatenate(rings), np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]))


def random_rays(count: int) -> Rays:
    """From a sphere of radius 3 to points of the unit cube."""
    rng = np.random.default_rng(2)
    origins = rng.normal(size=(count, 3))
    origins *= 3 / np.linalg.norm(origins, axis=1, keepdims=True)
    directions = rng.uniform(-1, 1, (count, 3)) - origins
    return Rays(origins.astype(np.float32), directions.astype(np.float32))


def rays_table(rounds: int, size: int, triangles: int) -> None:
    rows = []
    kinds = {"random": (random_rays(size * size), False), "camera, single": (camera_rays(size), False)}
    kinds["camera, packets"] = kinds["camera, single"][0], True
    for name, exact in SOLIDS.items():
        mesh = mesh_of(name, triangles)
        ours, theirs = iso.Tracer(exact, threads=1), iso.Tracer(mesh, threads=1)
        for kind, (rays, coherent) in kinds.items():
            asked = {
                f"{query} {side}": partial(getattr(tracer, query), *rays, coherent=coherent)
                for query in ("closest", "occluded")
                for side, tracer in (("exact", ours), ("mesh", theirs))
            }
            found = in_turns(asked, rounds)
            best = {side: times.cpu.min() / len(rays.origins) * 1e9 for side, times in found.items()}
            closest, occluded = (best[f"{q} mesh"] / best[f"{q} exact"] for q in ("closest", "occluded"))
            nanoseconds = (best["closest exact"], best["closest mesh"])
            rows.append((name, kind, *nanoseconds, closest, verdict(closest, GOAL), occluded))
    headings = ("solid", "rays", "closest, exact, ns", "mesh, ns", "ratio", "goal", "ratio, occluded")
    print_table(headings, rows)


def pictures_table(rounds: int, size: int, triangles: int) -> None:
    rows = []
    camera = iso.Camera((1.5, 1.6, 3.0), (0, 0, 0), fov_degrees=40)
    for name, exact in SOLIDS.items():
        mesh = mesh_of(name, triangles)
        for material in (iso.Matte(), iso.Glass(1.5)):
            scenes = {
                side: iso.Scene([iso.Item(shape, material)], [iso.Sky()], camera)
                for side, shape in (("exact", exact), ("mesh", mesh))
            }
            found = in_turns(
                {
                    side: lambda scene=scene: iso.render(
                        scene, iso.PathTrace(samples=16), size=(size, size), threads=1, progress=False
                    )
                    for side, scene in scenes.items()
                },
                rounds,
            )
            best = {side: times.cpu.min() for side, times in found.items()}
            ratio = best["mesh"] / best["exact"]
            rows.append((name, type(material).__name__, best["exact"], best["mesh"], ratio, verdict(ratio, GOAL)))
    print_table(("solid", "material", "exact, s", "mesh, s", "ratio", "goal"), rows)


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--size", type=int, default=640, help="rays are size × size, pictures a quarter of it wide")
    parser.add_argument("--triangles", type=int, default=100_000)
    options = parser.parse_args(arguments)
    print_machine()
    rays_table(options.rounds, options.size, options.triangles)
    pictures_table(options.rounds, options.size // 4, options.triangles)


if __name__ == "__main__":
    main()
