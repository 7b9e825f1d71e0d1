"""Picking among many lights: the tree against shares by power alone, with error, time and efficiency.

    python bench/light_tree.py [--rounds 5] [--counts 100 1000 10000] [--size 96] [--samples 16] [--scenes city neon]
        [--mitsuba]

A city by night, whose streets have a lamp every 8 m: points, spots that shine down, or small spheres. It grows with the
number of lamps, and the camera looks down into the streets in its middle. And a hall lit by a neon tube, a knot of so
many triangles. Errors are against the mean of 24 pictures of other seeds and four times the samples, made by the tree;
the mean of all pictures is told in parts of that. Seconds are those of the processor, without building the tree, ours
on one thread; efficiency is 1 / (square error · seconds), so its ratio is that of the square errors at equal time.
With --mitsuba the city of points and the hall are rendered by Mitsuba, too, which picks among lights evenly.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import ModuleType
from typing import Any, TypeAlias

import numpy as np

import isophote as iso
from common import Array, print_machine, print_table
from isophote.convert.triangulate import triangulate
from isophote.lower import lights as lower_lights
from isophote.lower import scene as lower_scene
from isophote.lower.latest import Latest
from peers import load_mitsuba, mitsuba_mesh
from scenes import View, mitsuba_sensor

_STREET, _LAMP_GAP, _HEIGHT = 24.0, 8.0, 4.5
_REFERENCES = 24
Row: TypeAlias = tuple[object, ...]
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


def city(count: int, lamps: str = "points") -> iso.Scene:
    """The city with so many lamps: "points", "spots" or "spheres"."""
    random = np.random.default_rng(2)
    reach = (int(math.sqrt(count)) // 2 + 4) * _STREET
    ground = iso.Mesh([(-reach, 0, -reach), (-reach, 0, reach), (reach, 0, reach), (reach, 0, -reach)], [(0, 1, 2, 3)])
    lights: list[Any] = []
    for x, y, z in lamp_places(count):
        power = random.uniform(20, 100)
        colour = (1.0, random.uniform(0.5, 0.9), random.uniform(0.2, 0.8))
        if lamps == "spheres":
            lights.append(iso.SphereLight(0.15, power=power, colour=colour).at((x, y, z)))
        elif lamps == "spots":
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
    "city of spots": lambda count: city(count, "spots"),
    "city of spheres": lambda count: city(count, "spheres"),
    "neon": neon,
}
COMPARED = ("city", "neon")


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


def mitsuba_scene(mitsuba: ModuleType, scene: iso.Scene) -> Any:
    """A scene of matte and shining meshes and point lights for Mitsuba, loaded."""
    loaded: dict[str, Any] = {"type": "scene"}
    for number, item in enumerate(scene.items):
        vertices = item.transform.apply(item.shape.vertices).astype(np.float32)
        triangles = triangulate(item.shape).triangles.astype(np.int32)
        shines = isinstance(item.material, iso.Emitter)
        parts = {"bsdf": {"type": "diffuse", "reflectance": _rgb((0, 0, 0) if shines else item.material.colour)}}
        if shines:
            parts["emitter"] = {"type": "area", "radiance": _rgb(item.material.radiance)}
        loaded[f"item{number}"] = mitsuba_mesh(mitsuba, vertices, triangles, **parts)
    for number, light in enumerate(scene.lights):
        point = {"type": "point", "position": list(light.position), "intensity": _rgb(light.intensity_rgb)}
        loaded[f"light{number}"] = point
    return mitsuba.load_dict(loaded)


def _rgb(colour: Any) -> dict[str, Any]:
    return {"type": "rgb", "value": [float(channel) for channel in colour]}


def shoot_mitsuba(mitsuba: ModuleType, scene: iso.Scene, size: int, samples: int, seeds: range) -> tuple[Array, Array]:
    """As `shoot`, by Mitsuba."""
    loaded = mitsuba_scene(mitsuba, scene)
    camera = scene.camera
    view = View(tuple(camera.eye), tuple(camera.target), camera.fov_degrees)
    sensor = mitsuba_sensor(mitsuba, view, size, "multijitter", samples)
    integrator = mitsuba.load_dict({"type": "path", "max_depth": DEPTH, "rr_depth": 100})
    pictures, seconds = [], []
    # The first warms up.
    for seed in (seeds.start, *seeds):
        began = time.process_time()
        picture = mitsuba.render(loaded, sensor=sensor, integrator=integrator, spp=samples, seed=seed)
        pictures.append(np.array(picture, np.float64))
        seconds.append(time.process_time() - began)
    return np.array(pictures[1:]), np.array(seconds[1:])


def measured(name: str, count: int, options: argparse.Namespace, mitsuba: ModuleType | None) -> list[Row]:
    """Rows of the table for one scene, one for each way of picking."""
    scene, pictures, seconds = SCENES[name](count), {}, {}
    seeds, reference = range(options.rounds), np.zeros(0)
    for way, fewest in {"tree": 1, "power": 2**31}.items():
        with tree_from(fewest):
            pictures[way], seconds[way] = shoot(scene, options.size, options.samples, seeds)
            if way == "tree":
                many = range(1000, 1000 + _REFERENCES)
                reference = shoot(scene, options.size, 4 * options.samples, many)[0].mean(axis=0)
    if mitsuba is not None and name in COMPARED:
        pictures["Mitsuba"], seconds["Mitsuba"] = shoot_mitsuba(mitsuba, scene, options.size, options.samples, seeds)
    error = {way: float(((shots - reference) ** 2).mean()) for way, shots in pictures.items()}
    best = {way: float(times.min()) for way, times in seconds.items()}
    whole, brightness = error["tree"] * best["tree"], reference.mean()
    return [
        (
            name,
            count,
            way,
            float(pictures[way].mean() / brightness),
            error[way] ** 0.5 / brightness,
            best[way],
            error[way] / error["tree"],
            best[way] / best["tree"],
            error[way] * best[way] / whole,
        )
        for way in pictures
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--counts", type=int, nargs="+", default=[100, 1000, 10000])
    parser.add_argument("--scenes", nargs="+", default=list(SCENES), choices=list(SCENES))
    parser.add_argument("--size", type=int, default=96)
    parser.add_argument("--samples", type=int, default=16)
    parser.add_argument("--mitsuba", action="store_true", help="compare with Mitsuba, too")
    options = parser.parse_args()
    mitsuba = load_mitsuba()[0] if options.mitsuba else None
    print_machine(*(["mitsuba"] if mitsuba else []))
    rows = []
    for name in options.scenes:
        for count in options.counts:
            rows += measured(name, count, options, mitsuba)
    headings = ["scene", "lights", "picked by", "mean", "error", "s", "error² / tree", "s / tree", "tree is better by"]
    print_table(headings, rows)


if __name__ == "__main__":
    main()
