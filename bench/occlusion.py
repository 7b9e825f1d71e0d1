"""Ambient occlusion at vertices against libigl, in turns, tree included.

    python bench/occlusion.py [--rounds 5] [--frequency 84] [--samples 64] [--meshes sphere cave room FILE]

"sphere" is a bumpy ball, "cave" the same from within, "room" a box with three balls in it, seen from within.
libigl's `ambient_occlusion` picks directions evenly over the hemisphere, so ours does too (`weights="uniform"`).
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

import isophote as iso
from common import Ratio, bumpy_sphere, geodesic_sphere, in_turns, missing, print_machine, print_table, verdict

GOAL = 15


def bumpy(options: argparse.Namespace) -> tuple[np.ndarray, np.ndarray]:
    """A ball with bumps, from outside."""
    return bumpy_sphere(options.frequency)


def cave(options: argparse.Namespace) -> tuple[np.ndarray, np.ndarray]:
    """The same from within."""
    positions, triangles = bumpy_sphere(options.frequency)
    return positions, np.ascontiguousarray(triangles[:, ::-1])


def room(options: argparse.Namespace) -> tuple[np.ndarray, np.ndarray]:
    """A box of 4 × 2.5 × 3 with walls of fine squares, from within, and three balls on its floor."""
    cells = options.frequency // 2
    across = np.linspace(-1, 1, cells + 1)
    u, v = (grid.reshape(-1) for grid in np.meshgrid(across, across, indexing="ij"))
    row, column = (grid.reshape(-1) for grid in np.mgrid[0:cells, 0:cells])
    at = row * (cells + 1) + column
    square = np.stack([at, at + 1, at + cells + 1, at + 1, at + cells + 2, at + cells + 1], axis=1).reshape(-1, 3)
    points, triangles, count = [], [], 0
    for axis in range(3):
        for side in (1.0, -1.0):
            wall = np.roll(np.stack([np.full_like(u, side), u, v], axis=1), axis, axis=1)
            points.append(wall * (2, 1.25, 1.5))
            triangles.append((square if side > 0 else square[:, ::-1]) + count)
            count += len(wall)
    ball, faces = geodesic_sphere(cells)
    for radius, x, z in ((0.6, -1.0, -0.5), (0.4, 0.3, 0.6), (0.5, 1.2, -0.6)):
        points.append(ball * radius + (x, radius - 1.25 + 1e-3, z))
        triangles.append(faces + count)
        count += len(ball)
    return np.concatenate(points).astype(np.float32), np.concatenate(triangles).astype(np.int32)


MESHES = {"sphere": bumpy, "cave": cave, "room": room}


def mesh_of(name: str, options: argparse.Namespace) -> tuple[np.ndarray, np.ndarray]:
    """Points and triangles of a mesh by its name here, or of a file."""
    if name in MESHES:
        return MESHES[name](options)
    mesh = iso.load_mesh(name)
    return mesh.vertices.astype(np.float32), iso.triangulate(mesh).triangles


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--frequency", type=int, default=84, help="10 f² + 2 vertices")
    parser.add_argument("--samples", type=int, default=64)
    parser.add_argument("--meshes", nargs="+", default=["sphere"], help="sphere, cave, room, or files")
    options = parser.parse_args(arguments)
    try:
        import igl
    except ImportError:
        missing("libigl")
        return
    print_machine("libigl")
    rows, notes = [], []
    for name in options.meshes:
        row, note = measure(name, options, igl.ambient_occlusion)
        rows.append(row)
        notes.append(note)
    headings = (
        "mesh", "vertices", "ours, million rays/s", "by a core", "libigl", "by a core", "times", "median", "CPU times",
        "goal",
    )  # fmt: skip
    print_table(headings, rows)
    print("\n" + "\n".join(notes))


def measure(name: str, options: argparse.Namespace, peer: Callable[..., np.ndarray]) -> tuple[list[object], str]:
    """The row of a mesh, and how far both agree."""
    positions, triangles = mesh_of(name, options)
    mesh, vertices, faces = iso.Mesh(positions, triangles), positions.astype(np.float64), triangles.astype(np.int64)
    normals = iso.analysis.vertex_normals(mesh)

    def ours() -> np.ndarray:
        return iso.ambient_occlusion(mesh, samples=options.samples, weights="uniform", progress=False).occlusion

    def theirs() -> np.ndarray:
        return peer(vertices, faces, vertices, normals, options.samples)

    a, b = ours().astype(np.float64), np.asarray(theirs(), np.float64)
    # Means of as many samples on both sides.
    deviation = np.sqrt(np.maximum(a * (1 - a) + b * (1 - b), 1 / options.samples) / options.samples)
    within = float((np.abs(a - b) <= 3 * deviation).mean())
    times = in_turns({"ours": ours, "theirs": theirs}, options.rounds)
    ratio, rays = Ratio.of(times["ours"], times["theirs"]), len(vertices) * options.samples / 1e6
    speeds = [rays / seconds.min() for side in times.values() for seconds in (side.wall, side.cpu)]
    short = Path(name).name
    row = [short, len(vertices), *speeds, ratio.wall, ratio.wall_median, ratio.cpu, verdict(ratio.wall, GOAL)]
    return row, f"{short}: means {a.mean():.4f} and {b.mean():.4f}; {within:.2%} within three standard errors"


if __name__ == "__main__":
    main()
