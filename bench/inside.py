"""Inside, distance and self-intersections against libigl, in turns, and by themselves.

    python bench/inside.py [--rounds 5] [--queries 1000000] [--frequency 59]

Every round starts from arrays: trees are built within the time, on both sides. The meshes are a bumpy sphere, and the
same with holes of some 220 edges in all. Points are uniform in the box from -1.2 to 1.2; those near the surface lie
within 5 % of it. Errors of winding numbers are the largest of 300 against the sum of all triangles' solid angles.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

import isophote as iso
from common import Array, Floats, Ints, Ratio, bumpy_sphere, in_turns, missing, print_machine, print_table, verdict

GOAL_WINDING, GOAL_JOIN = 3, 1
_HOLES = 5


def with_holes(positions: Floats, triangles: Ints) -> Ints:
    """The mesh's triangles but for those near some places."""
    middles = positions[triangles].mean(axis=1)
    places = middles[:: len(middles) // _HOLES + 1]
    # At 69,620 triangles a hole of this size has some 44 edges.
    near = np.linalg.norm(middles[:, None] - places[None], axis=2).min(axis=1) < 0.1 * np.sqrt(69620 / len(triangles))
    return np.ascontiguousarray(triangles[~near])


def solid_angles(positions: Array, triangles: Ints, points: Array) -> Array:
    """Winding numbers by the sum over all triangles (van Oosterom, Strackee 1983)."""
    corners, out = positions[triangles], np.empty(len(points))
    for i, p in enumerate(points):
        a, b, c = (corners[:, k] - p for k in range(3))
        x, y, z = (np.linalg.norm(v, axis=1) for v in (a, b, c))
        real = x * y * z + (a * b).sum(1) * z + (b * c).sum(1) * x + (c * a).sum(1) * y
        out[i] = np.arctan2((a * np.cross(b, c)).sum(1), real).sum() / (2 * np.pi)
    return out


def row(name: str, count: int, ours: Callable[[], object], theirs: Callable[[], object], rounds: int) -> list[object]:
    """A row: how many a second on both sides, and the ratio."""
    times = in_turns({"ours": ours, "theirs": theirs}, rounds)
    ratio = Ratio.of(times["ours"], times["theirs"])
    rates = [count / times[side].wall.min() / 1000 for side in ("ours", "theirs")]
    return [name, *rates, ratio.wall, ratio.wall_median, ratio.cpu]


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--queries", type=int, default=1_000_000)
    parser.add_argument("--frequency", type=int, default=59)
    options = parser.parse_args(arguments)
    try:
        import igl
    except ImportError:
        missing("libigl")
    print_machine("libigl")
    against_libigl(options, igl)
    alone(options)


def against_libigl(options: argparse.Namespace, igl: Any) -> None:
    """Print what libigl does too."""
    single, triangles = bumpy_sphere(options.frequency)
    positions = single.astype(np.float64)
    open_triangles = with_holes(single, triangles)
    rng = np.random.default_rng(0)
    box = rng.uniform(-1.2, 1.2, (options.queries, 3))
    near = positions[rng.integers(0, len(positions), options.queries)] * rng.uniform(0.95, 1.05, (options.queries, 1))
    rows, errors = [], []
    for name, faces in (("closed", triangles), ("with holes", open_triangles)):
        wide = faces.astype(np.int64)
        for where, points in (("box", box), ("near", near)):

            def ours(faces: Ints = faces, points: Array = points) -> Array:
                return iso.analysis.winding_number(iso.Mesh(positions, faces), points)

            def theirs(wide: Any = wide, points: Array = points) -> Array:
                return igl.fast_winding_number(positions, wide, points)

            title = f"winding number, {name}, {where}"
            exact = solid_angles(positions, faces, points[:300])
            errors.append([title, *(np.abs(side()[:300] - exact).max() for side in (ours, theirs))])
            found = row(title, len(points), ours, theirs, options.rounds)
            rows.append([*found, verdict(float(found[3]), GOAL_WINDING)])  # type: ignore[arg-type]
    wide = triangles.astype(np.int64)
    for where, points in (("box", box), ("near", near)):
        some = points[: max(1, len(points) // 5)]

        def closest(points: Array = some) -> object:
            return iso.analysis.closest_point(iso.Mesh(positions, triangles), points)

        def squares(points: Array = some) -> object:
            return igl.point_mesh_squared_distance(points, positions, wide)

        rows.append([*row(f"closest point, {where}", len(some), closest, squares, options.rounds), ""])
    zero, none, all_vertices = np.zeros(1, np.int64), np.zeros(0, np.int64), np.arange(len(positions))

    def geodesic() -> Array:
        return iso.analysis.geodesic_distance(iso.Mesh(positions, triangles), 0)

    def peer() -> Array:
        return igl.exact_geodesic(positions, wide, zero, none, all_vertices, none)

    rows.append([*row("exact geodesics, vertices", len(positions), geodesic, peer, min(options.rounds, 3)), ""])
    headings = ("", "ours, thousands a second", "libigl's", "ratio", "median", "processor time", "goal")
    print_table(headings, rows)
    errors.append(["exact geodesics, difference", np.abs(geodesic() - peer()).max(), ""])
    print_table(("largest error", "ours", "libigl's"), errors)


def alone(options: argparse.Namespace) -> None:
    """Print what has no peer here."""
    positions, triangles = bumpy_sphere(round(options.frequency * 71 / 59))
    two = np.concatenate([positions, positions + np.float32(0.3)])
    both = np.concatenate([triangles, triangles + len(positions)]).astype(np.int32)
    turn = np.linspace(0, 2 * np.pi, 100_000, endpoint=False)
    ring = ((1 + 0.3 * np.sin(40 * turn))[:, None]) * np.column_stack([np.cos(turn), np.sin(turn)])
    points = np.random.default_rng(1).uniform(-1.3, 1.3, (options.queries, 2))
    sides = {
        f"self-intersections, {len(triangles):,}": lambda: iso.analysis.self_intersections(
            iso.Mesh(positions, triangles)
        ),
        f"self-intersections, {len(both):,}, two that cross": lambda: iso.analysis.self_intersections(
            iso.Mesh(two, both)
        ),
        f"thickness, {len(triangles):,}": lambda: iso.analysis.thickness(iso.Mesh(positions, triangles)),
        f"heat, {len(triangles):,}": lambda: iso.analysis.geodesic_distance(iso.Mesh(positions, triangles), 0, "heat"),
        f"point_in_polygon, {len(points):,} in 100,000 edges": lambda: iso.analysis.point_in_polygon(ring, points),
    }
    rows = []
    for name, times in in_turns(sides, options.rounds).items():
        goal = verdict(times.wall.min(), GOAL_JOIN, at_most=True) if name.startswith("self") else ""
        rows.append([name, times.wall.min(), float(np.median(times.wall)), times.cpu.min(), goal])
    print_table(("", "seconds", "median", "processor", "goal"), rows)


if __name__ == "__main__":
    main()
