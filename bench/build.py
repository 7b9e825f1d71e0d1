"""Building the tree of a million triangles against Embree (embreex), on all cores, and the memory it takes.

    python bench/build.py [--rounds 9] [--frequency 224]

Ours runs from float32 positions and int32 triangles to the finished tree, checks of the input included. embreex copies
the mesh in a slow loop and builds in the first query: both together, and the building alone, are told. Memory: what
the tree takes, and what Python holds after a `Tracer` of a one-mesh scene was made, as tracemalloc counts it: mesh,
tables and tree. The goal is for these together; what is needed for a moment while they are made is told beside it.
"""

from __future__ import annotations

import argparse
import gc
import tracemalloc
from collections.abc import Sequence

import numpy as np

import isophote as iso
from common import Floats, Ints, Ratio, Times, bumpy_sphere, print_machine, print_table, timed, verdict
from isophote.accel.tree import build_triangles
from isophote.accel.tree_statistics import tree_statistics
from peers import commit, embree_scene

GOAL_SECONDS, GOAL_BYTES = 0.35, 120
HELD = "mesh, tables and tree"


def build_times(positions: Floats, triangles: Ints, rounds: int) -> dict[str, Times]:
    """Seconds of each side, in turns; building alone is part of what embreex does as a whole."""
    found: dict[str, list[tuple[float, float]]] = {"ours": [], "ours, 1 thread": [], "copy": [], "commit": []}
    for number in range(rounds + 1):
        scenes = []

        def copy(scenes: list[object] = scenes) -> None:
            scenes.append(embree_scene(positions, triangles, committed=False))

        once = {
            "ours": timed(lambda: build_triangles(positions, triangles)),
            "ours, 1 thread": timed(lambda: build_triangles(positions, triangles, threads=1)),
            "copy": timed(copy),
            "commit": timed(lambda scenes=scenes: commit(scenes[0])),
        }
        # The first round warms up.
        if number > 0:
            for side, seconds in once.items():
                found[side].append(seconds)
    return {side: Times(*np.array(seconds).T) for side, seconds in found.items()}


def memory(positions: Floats, triangles: Ints) -> list[tuple[str, float]]:
    """Bytes a triangle: of the tree, of mesh, tables and tree together, and at most while making them."""
    tree = tree_statistics(build_triangles(positions, triangles)).bytes
    gc.collect()
    tracemalloc.start()
    # A mesh may keep what it is given without a copy; it counts all the same.
    mesh = iso.Mesh(positions.copy(), triangles.copy())
    of_mesh = tracemalloc.get_traced_memory()[0]
    tracer = iso.Tracer(mesh)
    gc.collect()
    held, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    del tracer
    figures = {
        "tree (nodes and leaf blocks)": tree,
        "all tables after lowering, tree included": held - of_mesh,
        "the mesh itself (float64 vertices, faces)": of_mesh,
        HELD: held,
        "most while lowering": peak,
    }
    return [(name, count / len(triangles)) for name, count in figures.items()]


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--frequency", type=int, default=224, help="20 f² triangles")
    options = parser.parse_args(arguments)
    print_machine("embreex")
    positions, triangles = bumpy_sphere(options.frequency)
    found = build_times(positions, triangles, options.rounds)
    found["copy and commit"] = Times(*(a + b for a, b in zip(found["copy"], found["commit"], strict=True)))
    rows = []
    for name, side in (
        ("Isophote", "ours"),
        ("Isophote, 1 thread", "ours, 1 thread"),
        ("Embree, building alone", "commit"),
        ("Embree, mesh copied and built", "copy and commit"),
    ):
        times, ratio = found[side], Ratio.of(found["ours"], found[side])
        met = verdict(times.wall.min(), GOAL_SECONDS, at_most=True) if side == "ours" else ""
        medians = (float(np.median(values)) for values in times)
        rows.append([name, times.wall.min(), times.cpu.min(), *medians, ratio.wall, ratio.wall_median, ratio.cpu, met])
    print(f"{len(triangles):,} triangles\n")
    print_table(
        ("side", "wall s, min", "CPU s, min", "wall s, median", "CPU s, median", "times ours, wall", "median", "by CPU",
         "goal, s"),
        rows,
    )  # fmt: skip
    held = [
        [name, count, verdict(count, GOAL_BYTES, at_most=True) if name == HELD else ""]
        for name, count in memory(positions, triangles)
    ]
    print_table(("memory", "bytes a triangle", "goal"), held)


if __name__ == "__main__":
    main()
