"""Topology of meshes against libigl, in turns, and of ten million triangles by itself.

    python bench/topology.py [--rounds 5] [--frequency 224] [--large 707]

Ours is `topology`, which answers everything at once: edges, fans, components, boundary loops, genus, angle sums, and
what is to blame. libigl's `is_edge_manifold`, `is_vertex_manifold` and `euler_characteristic` together answer a part.
The meshes are bumpy spheres; the second has its triangles and vertices in random order, the third a hole in each
twentieth triangle and every twentieth turned over.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import Any

import numpy as np

import isophote as iso
from common import Floats, Ints, Ratio, bumpy_sphere, in_turns, missing, print_machine, print_table, verdict

GOAL_RATIO, GOAL_SECONDS = 10, 4


def shuffled(positions: Floats, triangles: Ints) -> tuple[Floats, Ints]:
    """The same mesh with vertices and triangles in random order."""
    rng = np.random.default_rng(0)
    order = rng.permutation(len(positions))
    place = np.empty_like(order)
    place[order] = np.arange(len(order))
    return positions[order], place[triangles[rng.permutation(len(triangles))]].astype(np.int32)


def damaged(positions: Floats, triangles: Ints) -> tuple[Floats, Ints]:
    """The same mesh without each twentieth triangle, and with as many turned over."""
    turned = triangles.copy()
    turned[10::20] = turned[10::20, ::-1]
    return positions, np.delete(turned, np.s_[::20], axis=0)


def against_libigl(name: str, positions: Floats, triangles: Ints, rounds: int, igl: Any) -> list[object]:
    """A row: seconds of both sides, and how many times as long libigl takes."""
    mesh = iso.Mesh(positions, triangles)
    wide = triangles.astype(np.int64)

    def theirs() -> None:
        igl.is_edge_manifold(wide)
        igl.is_vertex_manifold(wide)
        igl.euler_characteristic(wide)

    times = in_turns({"ours": lambda: iso.analysis.topology(mesh), "theirs": theirs}, rounds)
    ours, ratio = times["ours"], Ratio.of(times["ours"], times["theirs"])
    goal = verdict(ratio.wall, GOAL_RATIO)
    return [
        name,
        len(triangles),
        ours.wall.min(),
        ours.cpu.min(),
        times["theirs"].wall.min(),
        ratio.wall,
        ratio.wall_median,
        ratio.cpu,
        goal,
    ]


def alone(positions: Floats, triangles: Ints, rounds: int) -> list[list[object]]:
    """Rows of what is measured without a peer."""
    mesh = iso.Mesh(positions, triangles)
    sides = {
        "topology": lambda: iso.analysis.topology(mesh),
        "half_edges": lambda: iso.analysis.half_edges(mesh),
    }
    times = in_turns(sides, rounds)
    rows: list[list[object]] = []
    for name, side in times.items():
        goal = verdict(side.wall.min(), GOAL_SECONDS, at_most=True) if name == "topology" else ""
        rows.append([name, len(triangles), side.wall.min(), float(np.median(side.wall)), side.cpu.min(), goal])
    return rows


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--frequency", type=int, default=224, help="20 f² triangles beside libigl")
    parser.add_argument("--large", type=int, default=707, help="20 f² triangles alone")
    options = parser.parse_args(arguments)
    try:
        import igl
    except ImportError:
        missing("libigl")
    print_machine("libigl")
    sphere = bumpy_sphere(options.frequency)
    meshes = {"closed": sphere, "closed, in random order": shuffled(*sphere), "damaged": damaged(*sphere)}
    rows = [against_libigl(name, *mesh, options.rounds, igl) for name, mesh in meshes.items()]
    headings = ("mesh", "triangles", "ours s, min", "ours CPU s", "libigl s, min", "times ours", "median", "by CPU")
    print_table((*headings, "goal"), rows)
    rows = alone(*bumpy_sphere(options.large), options.rounds)
    print_table(("what", "triangles", "s, min", "s, median", "CPU s, min", "goal, s"), rows)


if __name__ == "__main__":
    main()
