"""Delaunay triangulations against Shewchuk's Triangle and SciPy's Qhull, in the plane and in space; hulls; refinement.

    python bench/delaunay.py [--rounds 5] [--points 1000000] [--space 100000]

Triangle is exact, Qhull is not. Both use one processor.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence

import numpy as np

import isophote as iso
from common import Array, Ratio, in_turns, missing, print_machine, print_table, verdict

TRIANGLE_GOAL, SCIPY_GOAL, SPACE_GOAL = 2, 16, 5
HEADINGS = ("points", "ours, s", "theirs, s", "times", "median", "CPU times", "median", "goal")


def row(
    name: str, rounds: int, ours: Callable[[], object], theirs: Callable[[], object], goal: float | None = None
) -> list[object]:
    times = in_turns({"ours": ours, "theirs": theirs}, rounds)
    ratio = Ratio.of(times["ours"], times["theirs"])
    said = verdict(ratio.wall, goal) if goal is not None else ""
    return [name, times["ours"].wall.min(), times["theirs"].wall.min(), *ratio, said]


def clouds(count: int) -> dict[str, Array]:
    """Points of several kinds."""
    rng = np.random.default_rng(0)
    side = int(count**0.5)
    angle = rng.random(count) * 2 * np.pi
    return {
        "uniform": rng.random((count, 2)),
        "normal": rng.normal(size=(count, 2)),
        "clusters": rng.normal(size=(count, 2)) * 1e-3 + rng.random((100, 2))[rng.integers(0, 100, count)],
        "grid": np.stack(np.divmod(np.arange(side * side), side), axis=1).astype(float),
        "circle": np.stack([np.cos(angle), np.sin(angle)], axis=1),
    }


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--points", type=int, default=1_000_000)
    parser.add_argument("--space", type=int, default=100_000)
    options = parser.parse_args(arguments)
    try:
        import triangle
    except ImportError:
        missing("triangle")
    from scipy.spatial import ConvexHull, Delaunay

    print_machine("triangle", "scipy")
    delaunay, rounds = iso.analysis.delaunay, options.rounds
    plane = clouds(options.points)
    uniform = plane["uniform"]
    rows = [
        row(f"{name}, against Triangle", rounds, lambda p=p: delaunay(p), lambda p=p: triangle.delaunay(p), goal)
        for (name, p), goal in zip(plane.items(), (TRIANGLE_GOAL, None, None, None, None), strict=True)
    ]
    rows.append(row("uniform, against SciPy", rounds, lambda: delaunay(uniform), lambda: Delaunay(uniform), SCIPY_GOAL))
    print_table((f"{options.points:,} of the plane", *HEADINGS[1:]), rows)

    space = np.random.default_rng(1).random((options.space, 3))
    ball = np.random.default_rng(2).normal(size=(options.space, 3))
    rows = [
        row("uniform, against SciPy", rounds, lambda: delaunay(space), lambda: Delaunay(space), SPACE_GOAL),
        row("normal, against SciPy", rounds, lambda: delaunay(ball), lambda: Delaunay(ball)),
        row("lifted hull", rounds, lambda: delaunay(space, method="lifted"), lambda: Delaunay(space)),
    ]
    print_table((f"{options.space:,} of space", *HEADINGS[1:]), rows)

    hull = iso.analysis.convex_hull
    sphere = ball / np.linalg.norm(ball, axis=1, keepdims=True)
    rows = [
        row("hull, plane, uniform", rounds, lambda: hull(uniform), lambda: ConvexHull(uniform)),
        row("hull, plane, circle", rounds, lambda: hull(plane["circle"]), lambda: ConvexHull(plane["circle"])),
        row("hull, space, uniform", rounds, lambda: hull(space), lambda: ConvexHull(space)),
        row("hull, space, sphere", rounds, lambda: hull(sphere), lambda: ConvexHull(sphere)),
    ]
    print_table(("against SciPy", *HEADINGS[1:]), rows)

    few = np.random.default_rng(3).random((1000, 2))
    coarse = delaunay(few)
    rows = []
    for degrees, area in ((20, None), (30, None), (30, 1e-5)):
        wish = f"pq{degrees}" + (f"a{area:.9f}" if area else "")

        def ours(degrees: int = degrees, area: float | None = area) -> iso.analysis.Delaunay:
            return iso.analysis.refine_triangulation(coarse, degrees, area)

        def theirs(wish: str = wish.replace("p", "")) -> dict[str, Array]:
            return triangle.triangulate({"vertices": few}, wish)

        counts = f"{len(ours().points)} and {len(theirs()['vertices'])} points"
        rows.append(row(f"{wish}: {counts}", rounds, ours, theirs))
    print_table(("refinement against Triangle", *HEADINGS[1:]), rows)


if __name__ == "__main__":
    main()
