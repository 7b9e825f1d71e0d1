"""Principal curvatures against libigl, in turns.

    python bench/curvature.py [--rounds 5] [--frequency 84]

libigl's `principal_curvature` at radius 2 fits a quadric to two rings, as ours does at degree 2.
Our default is degree 3.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence

import numpy as np

import isophote as iso
from common import Ratio, bumpy_sphere, in_turns, missing, print_machine, print_table, verdict

GOAL = 10
FITS = ((2, 2), (3, 2), (4, 3))


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--frequency", type=int, default=84, help="10 f² + 2 vertices")
    options = parser.parse_args(arguments)
    try:
        import igl
    except ImportError:
        missing("libigl")
    print_machine("libigl")
    positions, triangles = bumpy_sphere(options.frequency)
    mesh, vertices, faces = iso.Mesh(positions, triangles), positions.astype(np.float64), triangles.astype(np.int64)
    rows: list[list[object]] = []
    for degree, rings in FITS:
        sides = {
            "ours": lambda d=degree, r=rings: iso.analysis.principal_curvatures(mesh, d, r),
            "theirs": lambda: igl.principal_curvature(vertices, faces, 2),
        }
        times = in_turns(sides, options.rounds)
        ratio = Ratio.of(times["ours"], times["theirs"])
        speeds = [len(vertices) / times[side].wall.min() for side in sides]
        goal = verdict(ratio.wall, GOAL)
        rows.append([f"degree {degree}, {rings} rings", len(vertices), *speeds, ratio.wall, ratio.wall_median, goal])
    headings = ("fit", "vertices", "ours, vertices/s", "libigl, vertices/s", "times", "median", "goal")
    print_table(headings, rows)


if __name__ == "__main__":
    main()
