"""Voronoi diagrams against Shewchuk's Triangle and SciPy's Qhull, and medial axes of polygons.

    python bench/voronoi.py [--rounds 5] [--points 1000000] [--edges 10000]

All give vertices and edges, endless ones too, unclipped. Triangle and Qhull use one processor.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence

import numpy as np

import isophote as iso
from common import Ratio, in_turns, missing, print_machine, print_table, verdict

TRIANGLE_GOAL, SCIPY_GOAL, AXIS_GOAL = 1.5, 20, 1.0


def wavy(count: int) -> np.ndarray:
    """A rough star of this many edges."""
    angle = np.arange(count) * 2 * np.pi / count
    radius = 1 + 0.3 * np.sin(5 * angle) + 0.2 * np.sin(17 * angle)
    radius += 2 / count * np.random.default_rng(1).normal(size=count)
    return radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--points", type=int, default=1_000_000)
    parser.add_argument("--edges", type=int, default=10_000)
    options = parser.parse_args(arguments)
    try:
        import triangle
    except ImportError:
        missing("triangle")
    from scipy.spatial import Voronoi

    print_machine("triangle", "scipy")
    points = np.random.default_rng(0).random((options.points, 2))
    sides = {
        "dual": lambda: iso.analysis.voronoi(points),
        "sweep": lambda: iso.analysis.voronoi(points, method="sweep"),
        "triangle": lambda: triangle.voronoi(points),
        "scipy": lambda: Voronoi(points),
    }
    times = in_turns(sides, options.rounds)
    rows: list[list[object]] = []
    for ours in ("dual", "sweep"):
        for theirs, goal in (("triangle", TRIANGLE_GOAL), ("scipy", SCIPY_GOAL)):
            ratio = Ratio.of(times[ours], times[theirs])
            seconds = [times[side].wall.min() for side in (ours, theirs)]
            rows.append([f"{ours} against {theirs}", *seconds, *ratio, verdict(ratio.wall, goal)])
    headings = ("Voronoi", "ours, s", "theirs, s", "times", "median", "CPU times", "median", "goal")
    print_table(headings, rows)

    polygon = wavy(options.edges)
    axis = in_turns({"axis": lambda: iso.analysis.medial_axis(polygon)}, options.rounds)["axis"]
    row = [
        options.edges,
        axis.wall.min(),
        float(np.median(axis.wall)),
        verdict(axis.wall.min(), AXIS_GOAL, at_most=True),
    ]
    print_table(("medial axis, edges", "s", "median", "goal"), [row])


if __name__ == "__main__":
    main()
