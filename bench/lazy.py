"""Time from triangles to a picture of a part of them: the hierarchy that rays build, and the tree that is built first.

    python bench/lazy.py [--rounds 5] [--frequency 224] [--size 512]

A sphere with bumps, of 20 · frequency² triangles, seen from close by; "seen" are those whose middle is in the picture.
Sides take turns. "rays" are a `Tracer` and the camera's rays by `closest`; "picture" is all of `iso.render` by
`RayTrace`, with the shadow of a sun or with a sky all around.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

import isophote as iso
from common import Array, Ints, Rays, bumpy_sphere, in_turns, print_machine, print_table, verdict
from isophote.accel.accelerator import build_accelerator

HEADINGS = (
    "what", "threads", "seen", "bih, s", "median", "bvh, s", "median", "ratio, wall", "median", "ratio, CPU", "goal",
)  # fmt: skip
EYE, FOV_DEGREES = np.array([0.9, 0.7, 1.6]), 40.0
GOAL, BUILD_GOAL = 0.5, 0.1


def axes() -> tuple[Array, Array]:
    """The camera's right and up; it looks at the middle."""
    right = np.cross([0, 1, 0], EYE)
    right /= np.linalg.norm(right)
    return right, np.cross(EYE, right) / np.linalg.norm(EYE)


def close_rays(size: int) -> Rays:
    """Rays of the camera, row by row."""
    right, up = axes()
    steps = ((np.arange(size) + 0.5) / size * 2 - 1) * np.tan(np.radians(FOV_DEGREES / 2))
    x, y = (grid.reshape(-1, 1) for grid in np.meshgrid(steps, -steps))
    directions = x * right + y * up - EYE / np.linalg.norm(EYE)
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return Rays(np.tile(EYE, (size * size, 1)).astype(np.float32), directions.astype(np.float32))


def share_seen(mesh: iso.Mesh, triangles: Ints) -> float:
    """The part of the triangles whose middle is in the picture with nothing before it."""
    middles = mesh.vertices[triangles].mean(axis=1)
    toward = middles - EYE
    along = -(toward @ EYE) / np.linalg.norm(EYE)
    right, up = axes()
    reach = np.tan(np.radians(FOV_DEGREES / 2)) * along
    within = np.flatnonzero((abs(toward @ right) < reach) & (abs(toward @ up) < reach))
    hits = iso.Tracer(mesh).closest(np.tile(EYE, (len(within), 1)), toward[within])
    return float((hits.primitive == within).sum() / len(triangles))


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--frequency", type=int, default=224)
    parser.add_argument("--size", type=int, default=512, help="pictures are size × size")
    options = parser.parse_args(arguments)
    print_machine()
    points, triangles = bumpy_sphere(options.frequency)
    mesh, rays = iso.Mesh(points, triangles), close_rays(options.size)
    seen = share_seen(mesh, triangles)
    camera = iso.Camera(eye=tuple(EYE), target=(0, 0, 0), fov_degrees=FOV_DEGREES)

    def build(name: str, threads: int) -> Callable[[], object]:
        return lambda: build_accelerator(name, points, triangles, threads)

    def trace(name: str, threads: int) -> Callable[[], object]:
        return lambda: iso.Tracer(mesh, accelerator=name, threads=threads).closest(*rays)

    def picture(light: iso.Sun | iso.Sky, name: str, threads: int) -> Callable[[], object]:
        def run() -> object:
            # A new scene: tables of the one rendered last are used again.
            scene = iso.Scene([iso.Item(mesh)], [light], camera)
            method = iso.RayTrace(samples=1, accelerator=name)
            return iso.render(scene, method, size=(options.size, options.size), threads=threads, progress=False)

        return run

    rows = []
    sides = {
        "building": (build, BUILD_GOAL),
        "rays": (trace, GOAL),
        "picture, sun": (partial(picture, iso.Sun((1, 1, 2))), GOAL),
        "picture, sky": (partial(picture, iso.Sky(strength=1)), GOAL),
    }
    for what, (side, goal) in sides.items():
        for threads in (1, 2):
            found = in_turns({name: side(name, threads) for name in ("bih", "bvh")}, options.rounds)
            lazy, first = found["bih"], found["bvh"]
            ratio = float(lazy.wall.min() / first.wall.min())
            rows.append(
                [
                    what,
                    threads,
                    seen,
                    float(lazy.wall.min()),
                    float(np.median(lazy.wall)),
                    float(first.wall.min()),
                    float(np.median(first.wall)),
                    ratio,
                    float(np.median(lazy.wall / first.wall)),
                    float(lazy.cpu.min() / first.cpu.min()),
                    verdict(ratio, goal, at_most=True),
                ]
            )
    print_table(HEADINGS, rows)


if __name__ == "__main__":
    main()
