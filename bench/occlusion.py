"""Ambient occlusion at vertices against libigl, in turns, tree included.

    python bench/occlusion.py [--rounds 5] [--frequency 84] [--samples 64]

libigl's `ambient_occlusion` picks directions evenly over the hemisphere, so ours does too (`weights="uniform"`).
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence

import numpy as np

import isophote as iso
from common import Ratio, bumpy_sphere, in_turns, missing, print_machine, print_table, verdict

GOAL = 15


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--frequency", type=int, default=84, help="10 f² + 2 vertices")
    parser.add_argument("--samples", type=int, default=64)
    options = parser.parse_args(arguments)
    try:
        import igl
    except ImportError:
        missing("libigl")
        return
    print_machine("libigl")
    positions, triangles = bumpy_sphere(options.frequency)
    mesh, vertices, faces = iso.Mesh(positions, triangles), positions.astype(np.float64), triangles.astype(np.int64)
    normals = iso.analysis.vertex_normals(mesh)

    def ours() -> np.ndarray:
        return iso.ambient_occlusion(mesh, samples=options.samples, weights="uniform", progress=False).occlusion

    def theirs() -> np.ndarray:
        return igl.ambient_occlusion(vertices, faces, vertices, normals, options.samples)

    a, b = ours().astype(np.float64), np.asarray(theirs(), np.float64)
    # Means of as many samples on both sides.
    deviation = np.sqrt(np.maximum(a * (1 - a) + b * (1 - b), 1 / options.samples) / options.samples)
    within = float((np.abs(a - b) <= 3 * deviation).mean())
    times = in_turns({"ours": ours, "theirs": theirs}, options.rounds)
    ratio = Ratio.of(times["ours"], times["theirs"])
    speeds = [len(vertices) * options.samples / 1e6 / times[side].wall.min() for side in times]
    headings = ("vertices", "ours, million rays/s", "libigl, million rays/s", "times", "median", "CPU times", "goal")
    goal = verdict(ratio.wall, GOAL)
    print_table(headings, [[len(vertices), *speeds, ratio.wall, ratio.wall_median, ratio.cpu, goal]])
    print(f"\nmeans {a.mean():.4f} and {b.mean():.4f}; {within:.2%} of the vertices within three standard errors")


if __name__ == "__main__":
    main()
