"""Picking among many lights: the tree against shares by power alone, with error, time and efficiency.

    python bench/light_tree.py [--rounds 5] [--counts 1 100 1000 10000] [--size 96] [--samples 16] [--scenes city neon]

A city by night, whose streets have a lamp every 8 m: points, a third of them spots that shine down, or small spheres.
It grows with the number of lamps, and the camera looks down into the streets in its middle. And a hall lit by a neon
tube, a knot of so many triangles. MSE is against the mean of 24 pictures of other seeds and four times the samples,
made by the tree; the means of both ways are told. Seconds are those of the processor, on one thread, without building
the tree; efficiency is 1 / (MSE · seconds), so its ratio is that of the errors squared at equal time.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

import isophote as iso
from common import Array, print_machine, print_table
from isophote.lower import lights as lower_lights
from isophote.lower import scene as lower_scene
from isophote.lower.latest import Latest

_STREET, _LAMP_GAP, _HEIGHT = 24.0, 8.0, 4.5
_REFERENCES = {"tree": 24, "power": 8}
DEPTH = 3


def _slab(size: tuple[float, float, float], middle: tuple[float, float, float]) -> tuple[Array, Array]:
    corners = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) / 2
    faces = np.array([(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)])
    return corners * size + middle, faces


def lamp_places(count: int) -> Array:
    """(n, 3) places of lamps along the streets of a square city, those nearest to its middle first."""
    streets = int(math.sqrt(count)) // 2 + 3
    along = np.arange(-streets * _STREET / 2, streets * _STREET / 2, _LAMP_GAP) + _LAMP_GAP / 2
    across = (np.arange(streets) - (streets - 1) / 2) * _STREET
    x, z = (grid.reshape(-1) for grid in np.meshgrid(along, across))
    places = np.concatenate(
        [np.stack([x, np.full(len(x), _HEIGHT), z], 1), np.stack([z, np.full(len(x), _HEIGHT), x], 1)]
    )
    return places[np.argsort(np.hypot(places[:, 0], places[:, 2]), kind="stable")[:count]]


def houses(count: int) -> iso.Item:
    """Blocks of houses between the streets, as one mesh."""
    random = np.random.default_rng(1)
    streets = int(math.sqrt(count)) // 2 + 3
    middles = (np.arange(streets + 1) - streets / 2) * _STREET
    vertices, faces, first = [], [], 0
    for x in middles:
        for z in middles:
            for dx, dz in ((-4, -4), (-4, 4), (4, -4), (4, 4)):
                height = random.uniform(3, 14)
                points, quads = _slab((7, height, 7), (x + dx, height / 2, z + dz))
                vertices.append(points)
                faces.append(quads + first)
                first += 8
    return iso.Item(iso.Mesh(np.concatenate(vertices), np.concatenate(faces)), iso.Matte((0.6, 0.55, 0.5)))


def city(count: int, spheres: bool = False) -> iso.Scene:
    """The city with so many lamps."""
    random = np.random.default_rng(2)
    reach = (int(math.sqrt(count)) // 2 + 4) * _STREET
    ground = iso.Mesh([(-reach, 0, -reach), (-reach, 0, reach), (reach, 0, reach), (reach, 0, -reach)], [(0, 1, 2, 3)])
    lights: list[Any] = []
    for k, (x, y, z) in enumerate(lamp_places(count)):
        power = random.uniform(20, 100)
        colour = (1.0, random.uniform(0.5, 0.9), random.uniform(0.2, 0.8))
        if spheres:
            lights.append(iso.SphereLight(0.15, power=power, colour=colour).at((x, y, z)))
        elif k % 3 == 0:
            lights.append(
                iso.SpotLight((x, y, z), power, target=(x, 0, z), cone_degrees=60, inner_degrees=40, colour=colour)
            )
        else:
            lights.append(iso.PointLight((x, y, z), power, colour=colour))
    camera = iso.Camera((30, 34, 44), (0, 0, 0), fov_degrees=50)
    return iso.Scene([iso.Item(ground, iso.Matte(0.4)), houses(count)], lights, camera)


def neon(count: int) -> iso.Scene:
    """A hall with pillars, lit by a knot of about so many triangles."""
    around = max(4, round(math.sqrt(count / 40)))
    along = max(8, count // (2 * around))
    t = np.arange(along) * 2 * np.pi / along
    curve = np.stack([4 * np.sin(3 * t), 2 + 1.2 * np.sin(4 * t + 1), 4 * np.cos(5 * t)], 1)
    ahead = np.roll(curve, -1, 0) - np.roll(curve, 1, 0)
    ahead /= np.linalg.norm(ahead, axis=1)[:, None]
    side = np.cross(ahead, (0, 1, 0))
    side /= np.linalg.norm(side, axis=1)[:, None]
    up = np.cross(side, ahead)
    a = np.arange(around) * 2 * np.pi / around
    points = curve[:, None] + 0.05 * (np.cos(a)[:, None] * side[:, None] + np.sin(a)[:, None] * up[:, None])
    i, j = (grid.reshape(-1) for grid in np.mgrid[0:along, 0:around])
    p, q = (i * around + j), (i * around + (j + 1) % around)
    r, s = ((i + 1) % along * around + (j + 1) % around), ((i + 1) % along * around + j)
    triangles = np.concatenate([np.stack([p, r, q], 1), np.stack([p, s, r], 1)])
    tube = iso.Item(iso.Mesh(points.reshape(-1, 3), triangles), iso.Emitter((8.0, 3.0, 5.0)))
    room, quads = _slab((12, 5, 12), (0, 2.5, 0))
    items = [iso.Item(iso.Mesh(room, quads[:, ::-1]), iso.Matte(0.6)), tube]
    for x in (-3, 0, 3):
        for z in (-3, 0, 3):
            items.append(iso.Item(iso.Mesh(*_slab((0.5, 5, 0.5), (x, 2.5, z))), iso.Matte((0.5, 0.6, 0.7))))
    return iso.Scene(items, [], iso.Camera((5.5, 2.5, 5.5), (0, 1.6, 0), fov_degrees=75))


SCENES: dict[str, Callable[[int], iso.Scene]] = {
    "city": city,
    "city of spheres": lambda count: city(count, spheres=True),
    "neon": neon,
}


@contextmanager
def tree_from(fewest: int) -> Iterator[None]:
    """Scenes have a light tree from so many lights on."""
    before = lower_lights.FEWEST
    lower_lights.FEWEST = fewest
    lower_scene._latest = Latest()
    try:
        yield
    finally:
        lower_lights.FEWEST = before
        lower_scene._latest = Latest()


def shoot(scene: iso.Scene, size: int, samples: int, seeds: range) -> tuple[Array, Array]:
    """Pictures (n, h, w, 3) and seconds of the processor for each, without building trees."""
    pictures, seconds = [], []
    method = iso.PathTrace(samples=samples, max_depth=DEPTH)
    for seed in seeds:
        stamps: dict[tuple[str, float], float] = {}

        def mark(stage: str, fraction: float, stamps: dict[tuple[str, float], float] = stamps) -> None:
            stamps.setdefault((stage, fraction), time.process_time())

        image = iso.render(scene, method, size=(size, size), seed=seed, progress=mark, threads=1)
        seconds.append(time.process_time() - stamps["building the tree", 1.0])
        pictures.append(image.channels["colour"].astype(np.float64))
    return np.array(pictures), np.array(seconds)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--counts", type=int, nargs="+", default=[1, 100, 1000, 10000])
    parser.add_argument("--scenes", nargs="+", default=list(SCENES), choices=list(SCENES))
    parser.add_argument("--size", type=int, default=96)
    parser.add_argument("--samples", type=int, default=16)
    options = parser.parse_args()
    print_machine()
    rows = []
    for name in options.scenes:
        for count in options.counts:
            scene = SCENES[name](count)
            ways = {"tree": 1, "power": 2**31}
            long, shots = {}, {}
            for way, fewest in ways.items():
                with tree_from(fewest):
                    many = range(1000, 1000 + _REFERENCES[way])
                    long[way] = shoot(scene, options.size, 4 * options.samples, many)[0].mean(axis=0)
                    shots[way] = shoot(scene, options.size, options.samples, range(options.rounds))
            print(name, count, {way: f"{picture.mean():.5g}" for way, picture in long.items()}, flush=True)
            errors = {way: float(((shots[way][0] - long["tree"]) ** 2).mean()) for way in ways}
            seconds = {way: float(shots[way][1].min()) for way in ways}
            mean = long["tree"].mean()
            rows.append(
                (
                    name,
                    count,
                    errors["tree"] ** 0.5 / mean,
                    errors["power"] ** 0.5 / mean,
                    seconds["tree"],
                    seconds["power"],
                    errors["power"] / errors["tree"],
                    errors["power"] * seconds["power"] / (errors["tree"] * seconds["tree"]),
                )
            )
    print_table(["scene", "lights", "error", "by power", "s", "s by power", "variance", "efficiency"], rows)


if __name__ == "__main__":
    main()
