"""The light tree: chances that add up, picks as often as told, bounds that leave no light out, and the same pictures as
without it."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit

import isophote as iso
from isophote.checks.statistics import chi_square_deviation
from isophote.kernels.base.table import Packed
from isophote.kernels.base.vec import vec3
from isophote.kernels.light.emitter import LIGHTS, sample_light
from isophote.kernels.light.light_tree_layout import ASK_WORDS
from isophote.kernels.trace.pick import chance_of_light, pick_for
from isophote.lower import lamps as lower_lamps
from isophote.lower import lights as lower_lights
from isophote.lower.lights import LightTable, rectangle_mesh
from scenes import box, icosphere, plane, render

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
        assert chi_square_deviation(found, len(u) * np.concatenate([[max(none, 0)], told])) < 3.72
        picked = numbers >= 0
        assert np.allclose(chances[picked], told[numbers[picked]], rtol=1e-5)


@pytest.mark.parametrize("name", SETS)
def test_no_light_that_reaches_a_place_is_left_out(name):
    table = table_of(*SETS[name]())
    count = len(table.arrays["kinds"])
    square = RNG.random((32, 2)).astype(np.float32)
    for _ in range(20):
        p, normal = np.array(place(), np.float32), direction()
        told, sent = np.zeros(count, np.float32), np.zeros(count, np.float32)
        all_chances(table.words, p, normal, told)
        brightest(table.words, p, normal, square, sent)
        # What single precision may make of chances: those of the weakest beside the strongest are below its range.
        assert (told[sent > 1e-12 * sent.max()] > 0).all()


def test_lights_nearby_that_face_the_place_are_picked_first():
    near, far = iso.PointLight((0, 1, 0), 1.0), [iso.PointLight((k, 30, 0), 1.0) for k in range(-20, 20)]
    behind, away = iso.PointLight((0, -1, 0), 50.0), iso.RectLight((1, 1), power=50.0).at((0, 1.5, 0), (0, 9, 0))
    chances = np.zeros(43, np.float32)
    # The rectangle's row comes first: its shape stands among the items.
    all_chances(table_of(away, near, behind, *far).words, np.zeros(3, np.float32), np.float32([0, 1, 0]), chances)
    assert chances[1] > 0.9
    assert chances[0] < 1e-3
    assert chances[2] < 1e-3


# --- pictures ---------------------------------------------------------------------------------------------------------


def by_power(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(lower_lights, "FEWEST", 2**31)


def lamps_over_a_floor(make: object, count: int) -> tuple[list[iso.Item], list[object]]:
    """Twenty lamps over a floor with a cube and a ball of rough glass."""
    generator = np.random.default_rng(3)
    lights = [make(tuple(generator.uniform((-3, 0.8, -3), (3, 2, 3))), 1 + k % 5) for k in range(count)]
    glass = iso.Item(icosphere(2, 0.4, smooth=True), iso.Glass(roughness=0.3)).translate((-0.8, 0.5, 0.5))
    cube = iso.Item(box(0.6), iso.Principled((0.8, 0.5, 0.3), roughness=0.4)).translate((0.6, 0.3, 0))
    return [iso.Item(plane(8.0), iso.Matte(0.7)), cube, glass], lights


LAMPS = {
    "points": lambda p, power: iso.PointLight(p, power),
    "spots": lambda p, power: iso.SpotLight(p, power, target=(p[0], 0, p[2] + 0.5), cone_degrees=100, inner_degrees=60),
    "rectangles": lambda p, power: iso.RectLight((0.4, 0.2), power=power).at(p, (0, 0, 0)),
    "disks": lambda p, power: iso.DiskLight(0.2, power=power, two_sided=True).at(p, (0, 0, 0)),
    "spheres": lambda p, power: iso.SphereLight(0.1, power=power).at(p),
    "triangles": lambda p, power: iso.Item(icosphere(1, 0.15), iso.Emitter((power, 1, 1))).translate(p),
    "and a sky": None,
}


@pytest.mark.parametrize("name", LAMPS)
def test_pictures_are_the_same_in_the_mean_as_without_the_tree(name, monkeypatch):
    items, lights = lamps_over_a_floor(LAMPS[name] or LAMPS["rectangles"], 20)
    if name == "triangles":
        items, lights = [*items, *lights], []
    if name == "and a sky":
        pixels = np.full((8, 16, 3), 0.2, np.float32)
        pixels[2, 5] = 20
        lights = [*lights, iso.Sun((1, 3, 2), 1.0), iso.Environment(iso.ImageTexture(pixels))]
    camera = iso.Camera((0, 3, 5), (0, 0.3, 0))
    settings = {"camera": camera, "size": (24, 18), "samples": 128, "max_depth": 4}
    tree = render(items, lights, **settings, seed=1)
    by_power(monkeypatch)
    power = render(items, lights, **settings, seed=2)
    images = tree.channels, power.channels
    difference = images[0]["colour"].astype(np.float64) - images[1]["colour"]
    variance = images[0]["variance"].astype(np.float64) + images[1]["variance"]
    assert (
        np.abs(difference.mean(axis=(0, 1)) / np.sqrt(variance.sum(axis=(0, 1)))).max() * difference[..., 0].size < 3.7
    )
    # Less noise for the same samples.
    assert images[0]["variance"].mean() < 1.05 * images[1]["variance"].mean()


def test_what_is_met_by_chance_and_what_is_aimed_at_share_the_light(monkeypatch):
    """A closed room whose walls all shine: the radiance of every ray is known, E / (1 − ρ), whatever the shares."""
    radiance, albedo = 0.5, 0.6
    walls = iso.Item(
        icosphere(2, 3.0, smooth=False), iso.Emitter((radiance,) * 3, body=iso.Matte(albedo), two_sided=True)
    )
    image = render([walls], camera=iso.Camera((0, 0, 1), (0, 0, 0)), size=(8, 8), samples=256, max_depth=60)
    colour, variance = (image.channels[name].astype(np.float64) for name in ("colour", "variance"))
    wanted = radiance / (1 - albedo)
    assert abs(colour.mean() - wanted) < 3.7 * np.sqrt(variance.sum()) / colour.size + 1e-4


def test_the_same_picture_for_any_number_of_threads():
    items, lights = lamps_over_a_floor(LAMPS["points"], 30)
    pictures = [render(items, lights, samples=4, size=(40, 30), threads=threads) for threads in (1, 2)]
    assert np.array_equal(pictures[0].channels["colour"], pictures[1].channels["colour"])


def test_trees_of_many_triangles_are_built_fast_enough_and_bound_every_one():
    count = 20_000
    corners = RNG.uniform(-5, 5, (count, 1, 3)) + RNG.uniform(-0.1, 0.1, (count, 3, 3))
    mesh = iso.Mesh(corners.reshape(-1, 3), np.arange(3 * count).reshape(-1, 3))
    tree = table_of(iso.Item(mesh, iso.Emitter(COLOUR))).arrays["tree"].arrays
    nodes = tree["nodes"].reshape(-1, 11, 8)
    children = nodes[:, 10].view(np.int32)
    lanes = nodes[:, 9] != 0
    leaves = ~children[lanes & (children < 0)]
    assert np.array_equal(np.sort(leaves), np.arange(count))
    # Eight a node, but where the tree ends.
    assert len(nodes) < count / 2
    # Every triangle lies in the balls of all nodes above it.
    hung = tree["leaves"].astype(np.int64)
    triangles = corners
    while (hung >= 0).any():
        at, lane = hung[hung >= 0] // 8, hung[hung >= 0] % 8
        triangles = triangles[hung >= 0]
        middle, radius = nodes[at, 0:3, lane], nodes[at, 3, lane]
        far = np.linalg.norm(triangles - middle[:, None], axis=2).max(axis=1)
        assert (far <= radius * (1 + 1e-5) + 1e-5).all()
        hung = tree["parents"][at].astype(np.int64)


def test_many_lamps_look_the_same_as_few(monkeypatch):
    """Spheres and disks that are asked one by one, and those in the tree of primitives, are met alike."""
    items, _ = lamps_over_a_floor(LAMPS["spheres"], 0)
    lights = [
        LAMPS["spheres" if k % 2 else "disks"](tuple(RNG.uniform((-2, 0.8, -2), (2, 2, 2))), 1) for k in range(30)
    ]
    camera = iso.Camera((0, 3, 5), (0, 1, 0))
    many = render(items, lights, camera, samples=64, size=(32, 24), max_depth=3)
    monkeypatch.setattr(lower_lamps, "_FEW", 100)
    few = render(items, lights, camera, samples=64, size=(32, 24), max_depth=3, seed=2)
    assert np.array_equal(many.channels["item"], few.channels["item"])
    assert np.allclose(many.channels["distance"], few.channels["distance"], rtol=1e-4)
    difference = many.channels["colour"].astype(np.float64) - few.channels["colour"]
    variance = many.channels["variance"].astype(np.float64) + few.channels["variance"]
    assert abs(difference.sum()) < 3.7 * np.sqrt(variance.sum())


def test_many_lamps_stand_in_the_way_of_radiosity_as_few_do(monkeypatch):
    """Dark disks between two plates, one of which shines: as many as are asked one by one, and one more."""
    shining = iso.Item(plane(2.0), iso.Emitter(2.0)).rotate("x", np.pi).translate((0, 2, 0))
    floor = iso.Item(plane(2.0), iso.Matte(0.5))
    disks = [iso.DiskLight(0.25, power=0).at((x, 1, z)) for x in np.linspace(-0.8, 0.8, 4) for z in (-0.6, 0, 0.6, 1.2)]
    found = []
    for few in (100, 0):
        monkeypatch.setattr(lower_lamps, "_FEW", few)
        solution = iso.radiosity(iso.Scene([shining, floor], disks), iso.Radiosity(patch=0.5))
        found.append(solution)
    bare = iso.radiosity(iso.Scene([shining, floor]), iso.Radiosity(patch=0.5))
    values = [(s.areas[:, None] * s.irradiance)[s.item == 1].sum() for s in (*found, bare)]
    assert values[0] == pytest.approx(values[1], rel=1e-3)
    assert values[0] < 0.97 * values[2]
