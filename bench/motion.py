"""Motion blur: what it costs beside the same scene standing still, its noise, and its steps.

    python bench/motion.py [--rounds 5] [--size 192] [--samples 64] [--parts cost noise steps]

`cost`: processor seconds of one picture by one thread, of scenes in which something small or everything moves, and of
the same scenes as they stand in the middle of that time; least and median of the rounds, sides in turns; and how much
of it makes the tables of the moments. `noise`: root mean square error of a shining square that slides past, against its
closed form, by pattern and samples, mean over rounds. `steps`: the same by the number of moments, at 4,096 samples.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

import numpy as np

import isophote as iso
from common import Array, bumpy_sphere, in_turns, print_machine, print_table, verdict
from isophote.rendering import exposure
from isophote.rendering.method import Job

REST = iso.Transform.identity()
# The goal: what moves costs no more than this many times what stands still, tables aside.
GOAL = 1.5
WIDTH, WAY = 32, 3.0


def _floor() -> iso.Item:
    return iso.Item(iso.Mesh([(-4, -1, -4), (-4, -1, 4), (4, -1, 4), (4, -1, -4)], [(0, 1, 2, 3)]), iso.Matte(0.7))


def _scene(items: Sequence[iso.Item]) -> iso.Scene:
    lamp = iso.RectLight(size=(1.5, 1.5), power=90).at((1, 4, 2), target=(0, 0, 0))
    camera = iso.Camera((0, 1, 6), (0, 0, 0), fov_degrees=35, shutter=(0, 1))
    return iso.Scene([_floor(), *items], [lamp, iso.Sky("white", 0.3)], camera)


def _ball(x: float = 1.2) -> iso.Item:
    motion = iso.Motion({0: REST.translate((x, -0.4, 1)), 1: REST.translate((x, 0.4, 1))})
    return iso.Item(iso.sphere(0.3), iso.Matte("tomato"), motion)


def _million() -> iso.Scene:
    vertices, faces = bumpy_sphere(224)
    return _scene([iso.Item(iso.Mesh(vertices, faces), iso.Matte(0.6)), _ball()])


def _turning() -> iso.Scene:
    vertices, faces = bumpy_sphere(224)
    return _scene([iso.Item(iso.Mesh(vertices, faces), iso.Matte(0.6), iso.Motion.turn("y", 0.5))])


def _crowd() -> iso.Scene:
    places = np.random.default_rng(1).uniform((-2, -1, -2), (2, 1.5, 1), (1000, 3))
    solid = iso.sphere(0.06)
    items = [
        iso.Item(
            solid, iso.Matte(0.6), iso.Motion({0: REST.translate(p), 1: REST.translate(p + np.array([0.1, 0.2, 0]))})
        )
        for p in places
    ]
    return _scene(items)


def _field() -> iso.Scene:
    knob = iso.sphere(0.8).union(iso.box(1), blend=0.2) - iso.cylinder(0.3)
    return _scene([iso.Item(knob, iso.Matte("gold"), iso.Motion.turn("y", 1.0))])


SCENES: dict[str, Callable[[], iso.Scene]] = {
    "a ball beside a million still triangles": _million,
    "a million triangles that turn": _turning,
    "1,000 balls that all move": _crowd,
    "a field that turns": _field,
}


def _cost(rounds: int, size: int, samples: int) -> None:
    rows = []
    for name, make in SCENES.items():
        moving = make()
        still, method = moving.still(), iso.PathTrace(samples=samples)

        def draw(scene: iso.Scene, method: iso.PathTrace = method) -> None:
            iso.render(scene, method, size=(size, size), threads=1, progress=False)

        sides = {"moving": lambda scene=moving: draw(scene), "still": lambda scene=still: draw(scene)}
        times = in_turns(sides, rounds)
        job = Job(moving, (size, size), 0, 1, lambda stage, part: None)
        tables = []
        for _ in range(rounds):
            began = time.process_time()
            count = len(exposure.expose(job).moments)
            tables.append(time.process_time() - began)
        least, middle = ([f(times[side].cpu) for side in sides] for f in (np.min, np.median))
        ratio = (least[0] - min(tables)) / least[1]
        rows.append([name, count, *least, *middle, min(tables), ratio, verdict(ratio, GOAL, at_most=True)])
    print(f"Path tracing, {size} × {size} pixels, {samples} samples; processor seconds\n")
    headings = ["scene", "moments", "moving, least", "still, least", "moving, median", "still, median", "tables"]
    print_table([*headings, "moving without tables / still", "goal"], rows)


# --- against a closed form ------------------------------------------------------------------------


def _slide() -> iso.Scene:
    square = iso.Mesh([(-0.5, -0.5, 0), (0.5, -0.5, 0), (0.5, 0.5, 0), (-0.5, 0.5, 0)], [(0, 1, 2, 3)])
    motion = iso.Motion({0: REST.translate((-2, 0, 0)), 1: REST.translate((-2 + WAY, 0, 0))})
    camera = iso.OrthographicCamera((0, 0, 5), (0, 0, 0), height=2, shutter=(0, 1))
    return iso.Scene([iso.Item(square, iso.Emitter((1, 1, 1)), motion)], camera=camera)


def _covered() -> Array:
    """(32,): how much of a pixel's width, and of the time, the square covers."""
    edges = (np.arange(WIDTH + 1) - WIDTH / 2) / 4
    signs = {-2.5: 1, -2.5 + WAY: -1, -1.5: -1, -1.5 + WAY: 1}
    return 4 * np.diff(sum(sign * np.maximum(edges - x, 0) ** 2 / 2 for x, sign in signs.items()) / WAY)


def _error(samples: int, pattern: str, rounds: int) -> float:
    method, errors = iso.PathTrace(samples=samples, pattern=pattern), []
    for seed in range(rounds):
        picture = iso.render(_slide(), method, size=(WIDTH, 8), seed=seed, progress=False)
        errors.append(picture.channels["colour"][2:6, :, 0] - _covered())
    return float(np.sqrt(np.mean(np.square(errors))))


def _noise(rounds: int) -> None:
    counts = (4, 16, 64, 256)
    found = {
        pattern: [_error(n, pattern, rounds) for n in counts] for pattern in ("independent", "jittered", "blue-noise")
    }
    rows = [[pattern, *errors, errors[1] / found["independent"][1]] for pattern, errors in found.items()]
    print("A square that slides past: root mean square error\n")
    print_table(["pattern", *(f"{n} samples" for n in counts), "of independent, at 16"], rows)


@contextmanager
def _of_moments(count: int) -> Iterator[None]:
    before = exposure._LEAST, exposure._MOST
    exposure._LEAST = exposure._MOST = count
    try:
        yield
    finally:
        exposure._LEAST, exposure._MOST = before


def _steps(rounds: int) -> None:
    rows = []
    for count in (4, 8, 16, 32, 64, 256):
        with _of_moments(count):
            rows.append([count, WAY * 4 / count, _error(4096, "blue-noise", rounds)])
    print("The same by the number of moments, 4,096 samples\n")
    print_table(["moments", "pixels from one to the next", "root mean square error"], rows)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--size", type=int, default=192)
    parser.add_argument("--samples", type=int, default=64)
    parser.add_argument("--parts", nargs="+", choices=("cost", "noise", "steps"), default=("cost", "noise", "steps"))
    options = parser.parse_args()
    print_machine()
    if "cost" in options.parts:
        _cost(options.rounds, options.size, options.samples)
    if "noise" in options.parts:
        _noise(options.rounds)
    if "steps" in options.parts:
        _steps(options.rounds)


if __name__ == "__main__":
    main()
