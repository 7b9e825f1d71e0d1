"""Rays a second on one core against Embree (embreex, single rays): the closest hit, and whether there is any.

    python bench/rays.py [--rounds 7] [--meshes 70k 1M] [--size 1024]

Sets: a camera's rays row by row; one diffuse bounce off each of their hits; random directions from inside. Ours is
`Tracer` with one thread, as a user calls it: checks of the rays, allocation and interpreter included. "Kernel" is the
compiled query alone, over arrays that are there. For the closest hit embreex is asked for as much (`output=True`:
distance, uv, ids, normal; ours: distance, uv, ids, place in the tree), and for the distance alone.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

import isophote as iso
from common import (
    FREQUENCIES,
    Ratio,
    Rays,
    bounce_rays,
    bumpy_sphere,
    camera_rays,
    in_turns,
    inside_rays,
    print_machine,
    print_table,
    verdict,
)
from isophote.kernels.trace.rays import QUERY, closest_rays, occluded_rays
from isophote.kernels.trace.wave import new_wave
from isophote.lower.scene import lower_scene
from peers import embree_scene

GOALS = {"camera": 1.1, "bounce": 1.1, "inside": 1.0}
SPEED_HEADINGS = (
    "mesh", "rays", "query", "ours", "kernel", "Embree", "Mray/s by", "ratio", "median", "kernel ratio", "goal"
)  # fmt: skip
AGREEMENT_HEADINGS = (
    "mesh", "rays", "count", "hits ours", "hits Embree", "differ, closest", "differ, any", "largest gap of distance"
)  # fmt: skip


def kernels(mesh: iso.Mesh, rays: Rays) -> tuple[Callable[[], None], Callable[[], None]]:
    """The compiled queries (closest, any) over `rays` with all arrays made beforehand."""
    scene = lower_scene(iso.Scene([iso.Item(mesh)], camera=iso.Camera((0, 0, 1), (0, 0, 0))), (1, 1))
    count, wave = len(rays.origins), new_wave(272)
    numbers = {name: np.empty(count, np.int32) for name in ("item", "primitive", "slot", "instance")}
    query = QUERY.pack(
        origins=rays.origins,
        directions=rays.directions,
        limit=np.full(count, np.inf, np.float32),
        distance=np.empty(count, np.float32),
        uv=np.empty((count, 2), np.float32),
        blocked=np.empty(count, np.uint8),
        **numbers,
    )
    return (
        lambda: closest_rays(scene.words, query.words, wave.words, 0, count, False),
        lambda: occluded_rays(scene.words, query.words, wave.words, 0, count, False),
    )


def speeds(name: str, mesh: iso.Mesh, tracer: iso.Tracer, embree: Any, rays: Rays, rounds: int) -> list[list[object]]:
    """The rows of one set of rays, without the mesh's name."""
    closest, occluded = kernels(mesh, rays)
    found = in_turns(
        {
            "closest": lambda: tracer.closest(*rays),
            "closest kernel": closest,
            "closest, all": lambda: embree.run(*rays, output=True),
            "closest, distance": lambda: embree.run(*rays, query="DISTANCE"),
            "any": lambda: tracer.occluded(*rays),
            "any kernel": occluded,
            "any, Embree": lambda: embree.run(*rays, query="OCCLUDED"),
        },
        rounds,
    )
    rows: list[list[object]] = []
    millions = len(rays.origins) / 1e6
    for query, ours, theirs in (
        ("closest, against all", "closest", "closest, all"),
        ("closest, against distance alone", "closest", "closest, distance"),
        ("any", "any", "any, Embree"),
    ):
        ratio = Ratio.of(found[ours], found[theirs])
        inner = Ratio.of(found[f"{ours} kernel"], found[theirs])
        sides = [found[ours], found[f"{ours} kernel"], found[theirs]]
        goal = verdict(ratio.cpu, GOALS[name])
        cpu, wall = ([millions / times[k].min() for times in sides] for k in (1, 0))
        rows.append([name, query, *cpu, "CPU", ratio.cpu, ratio.cpu_median, inner.cpu, goal])
        rows.append([name, query, *wall, "wall", ratio.wall, ratio.wall_median, inner.wall, ""])
    return rows


def agreement(name: str, tracer: iso.Tracer, embree: Any, rays: Rays) -> list[object]:
    """Whether both sides meet the same things."""
    hits, reach = tracer.closest(*rays), embree.run(*rays, query="DISTANCE")
    theirs = reach < 1e30
    both = hits.hit & theirs
    gap = np.abs(hits.distance[both] - reach[both]).max(initial=0)
    # embreex answers 0 where a ray is blocked.
    any_differs = (tracer.occluded(*rays) != (embree.run(*rays, query="OCCLUDED") == 0)).sum()
    return [name, len(reach), hits.hit.sum(), theirs.sum(), (hits.hit != theirs).sum(), any_differs, f"{gap:.1e}"]


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--meshes", nargs="+", choices=FREQUENCIES, default=list(FREQUENCIES))
    parser.add_argument("--size", type=int, default=1024, help="camera rays are size × size")
    options = parser.parse_args(arguments)
    print_machine("embreex")
    rows, checks = [], []
    for tag in options.meshes:
        positions, triangles = bumpy_sphere(FREQUENCIES[tag])
        mesh = iso.Mesh(positions, triangles)
        tracer, embree = iso.Tracer(mesh, threads=1), embree_scene(positions, triangles)
        camera = camera_rays(options.size)
        sets = {"camera": camera, "bounce": bounce_rays(tracer, camera), "inside": inside_rays(options.size**2)}
        for name, rays in sets.items():
            rows += [[tag, *row] for row in speeds(name, mesh, tracer, embree, rays, options.rounds)]
            checks.append([tag, *agreement(name, tracer, embree, rays)])
    print_table(SPEED_HEADINGS, rows)
    print_table(AGREEMENT_HEADINGS, checks)


if __name__ == "__main__":
    main()
