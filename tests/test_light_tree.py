"""The light tree: chances that add up, picks as often as told, bounds that leave no light out, and the same pictures as
without it."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit

import isophote as iso
from isophote.kernels.base.table import Packed
from isophote.kernels.base.vec import vec3
from isophote.kernels.light.emitter import LIGHTS, sample_light
from isophote.kernels.light.light_tree_layout import ASK_WORDS
from isophote.kernels.trace.pick import chance_of_light, pick_for
from isophote.lower.lights import LightTable, rectangle_mesh
from scenes import box, icosphere
from statistics_of_samples import deviation

RNG = np.random.default_rng(7)
open_lights = LIGHTS.open
COLOUR = (3.0, 2.0, 1.0)


@njit(error_model="numpy")
def pick_many(words, place, normal, u, numbers, chances):
    lights, ask = open_lights(words), np.zeros(ASK_WORDS, np.float32)
    p, n = vec3(place[0], place[1], place[2]), vec3(normal[0], normal[1], normal[2])
    for i in range(len(u)):
        numbers[i], chances[i] = pick_for(lights, ask, p, n, u[i])


@njit(error_model="numpy")
def all_chances(words, place, normal, chances):
    lights, ask = open_lights(words), np.zeros(ASK_WORDS, np.float32)
    p, n = vec3(place[0], place[1], place[2]), vec3(normal[0], normal[1], normal[2])
    for k in range(len(chances)):
        chances[k] = chance_of_light(lights, ask, k, p, n)


@njit(error_model="numpy")
def brightest(words, place, normal, square, found):
    """The most that each light sends to a place, over some of its points."""
    lights = open_lights(words)
    p, n = vec3(place[0], place[1], place[2]), vec3(normal[0], normal[1], normal[2])
    for k in range(len(found)):
        for i in range(len(square)):
            s = sample_light(lights, k, p, square[i, 0], square[i, 1])
            cosine = s.x * n.x + s.y * n.y + s.z * n.z
            if s.density >= 0 and cosine > 0:
                found[k] = max(found[k], s.red * cosine)


def table_of(*lights: object) -> Packed:
    table = LightTable()
    for light in lights:
        if isinstance(light, iso.RectLight):
            table.add_mesh(rectangle_mesh(light), light.transform.matrix, light.radiance_rgb, light.two_sided)
        elif isinstance(light, iso.Item):
            table.add_mesh(light.shape, light.transform.matrix, light.material.radiance, light.material.two_sided)
        else:
            table.add(light, 10.0, 0)
    return table.build(10.0)


def place(size: float = 5.0) -> tuple[float, ...]:
    return tuple(RNG.uniform(-size, size, 3))


def direction() -> np.ndarray:
    v = RNG.normal(size=3)
    return (v / np.linalg.norm(v)).astype(np.float32)


def points(count: int) -> list[object]:
    return [iso.PointLight(place(), 10 ** RNG.uniform(-2, 2)) for _ in range(count)]


def mixed(count: int) -> list[object]:
    """Lights of every kind that has a place."""
    lights: list[object] = []
    for k in range(count):
        power, two_sided = 10 ** RNG.uniform(-2, 2), bool(k & 8)
        lights.append(
            (
                lambda p=power: iso.PointLight(place(), p),
                lambda p=power: iso.SpotLight(place(), p, target=place(), cone_degrees=RNG.uniform(5, 80)),
                lambda p=power, t=two_sided: iso.RectLight((0.7, 0.3), power=p, two_sided=t).at(place(), place()),
                lambda p=power, t=two_sided: iso.DiskLight(0.4, power=p, two_sided=t).at(place(), place()),
                lambda p=power: iso.SphereLight(0.3, power=p).at(place()),
            )[k % 5]()
        )
    return lights


SETS = {
    "few": lambda: points(8),
    "points": lambda: points(500),
    "mixed": lambda: mixed(600),
    "mesh": lambda: [iso.Item(icosphere(3), iso.Emitter(COLOUR))],
    "quads that face away": lambda: [iso.Item(box(1.0), iso.Emitter(COLOUR)).translate(place()) for _ in range(30)],
    "one place": lambda: [iso.PointLight((1, 2, 3), 1 + k) for k in range(100)],
    "in a row": lambda: [iso.PointLight((0.1 * k, 1, 0), 1) for k in range(100)],
    "and lights far away": lambda: [*mixed(50), iso.Sun((1, 2, 3), 5.0), iso.Sun((0, 2, 3), 1.0)],
    "with dark ones": lambda: [*points(20), *(iso.PointLight(place(), 0.0) for _ in range(20))],
    "huge range": lambda: [iso.PointLight(place(1e3), 10.0 ** RNG.uniform(-20, 20)) for _ in range(200)],
}


@pytest.mark.parametrize("name", SETS)
def test_chances_add_up_to_one_and_lights_are_picked_as_often_as_told(name):
    table = table_of(*SETS[name]())
    count = len(table.arrays["kinds"])
    u = ((np.arange(2**17) + RNG.random(2**17)) / 2**17).astype(np.float32)
    u = np.minimum(u, np.float32(1 - 2.0**-24))
    for normal in (np.zeros(3, np.float32), direction(), direction()):
        p = np.array(place(), np.float32)
        numbers, chances, told = np.zeros(len(u), np.int64), np.zeros(len(u), np.float32), np.zeros(count, np.float32)
        pick_many(table.words, p, normal, u, numbers, chances)
        all_chances(table.words, p, normal, told)
        none = 1 - told.astype(np.float64).sum()
        # Only bounds that promise light where there is none leave something over.
        assert none > -1e-5
        found = np.bincount(numbers + 1, minlength=count + 1)
        if told.max() == 0:
            assert found[0] == len(u)
            continue
        assert deviation(found, len(u) * np.concatenate([[max(none, 0)], told])) < 3.72
        picked = numbers >= 0
        assert np.allclose(chances[picked], told[numbers[picked]], rtol=1e-5)
