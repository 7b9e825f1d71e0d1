"""The bounding interval hierarchy: rays build what they need of it, and it is the same whoever comes first."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import isophote as iso
from accelerator_rays import rays_at
from isophote.accel.accelerator import Built, accelerator_of, build_accelerator
from isophote.accel.bih import finish, parts_finished
from isophote.accel.tree import build_triangles
from isophote.kernels.accel.bih_layout import FINISHED
from isophote.kernels.accel.contract import LIMIT, PRIMITIVES, RAY_WORDS
from isophote.kernels.accel.layout import BLOCK, CHILD, LANES, LOWER, NODE, NUMBER, UPPER, WIDTH
from scenes import icosphere
from trees import GEOMETRIES, Geometry, soup, sphere

SOUP = soup(
    np.random.default_rng(3).normal(size=(20_000, 1, 3)) + np.random.default_rng(4).normal(0, 0.02, (20_000, 3, 3))
)


def closest(built: Built, origin: np.ndarray, direction: np.ndarray, name: str = "bih") -> tuple[int, float]:
    """What the entry answers: a slot, and the distance."""
    ray = np.zeros(RAY_WORDS, np.float32)
    ray[:3], ray[3:6], ray[LIMIT] = origin, direction, np.inf
    entry = accelerator_of(name).closest.compile().ctypes
    slot = entry(built.tables.words.ctypes.data, built.blocks.ctypes.data, ray.ctypes.data)
    assert (slot < 0) or ray.view(np.int32)[PRIMITIVES] > 0
    return slot, float(ray[LIMIT])


def finished(geometry: Geometry) -> Built:
    built = build_accelerator("bih", *geometry)
    finish(built)
    return built


def same_bits(a: Built, b: Built) -> bool:
    arrays = ("nodes", "blocks", "order", "parts", "states")
    return all(a.tables.arrays[name].tobytes() == b.tables.arrays[name].tobytes() for name in arrays)


def filled(built: Built) -> int:
    """How many blocks hold anything."""
    return int((built.blocks.reshape(-1, BLOCK) != 0).any(axis=1).sum())


def test_building_finishes_nothing_and_one_ray_little():
    geometry = sphere(160, 0.05)
    built = build_accelerator("bih", *geometry)
    assert parts_finished(built)[0] == 0
    assert filled(built) == 0
    slot, distance = closest(built, np.array([3, 0.1, 0.2]), np.array([-1, 0, 0]))
    assert slot >= 0
    assert 1.5 < distance < 2.5
    done, parts = parts_finished(built)
    assert 0 < done < 0.01 * parts
    assert 0 < filled(built) < 0.01 * filled(finished(geometry))


def test_rays_that_miss_everything_finish_nothing():
    built = build_accelerator("bih", *SOUP)
    assert closest(built, np.array([100, 100, 100]), np.array([1, 0, 0]))[0] == -1
    assert parts_finished(built)[0] == 0


def test_without_triangles_and_without_points_nothing_is_met():
    built = build_accelerator("bih", np.zeros((0, 3)), np.zeros((0, 3), np.int32))
    finish(built)
    assert parts_finished(built) == (0, 0)
    assert closest(built, np.zeros(3), np.array([1, 0, 0]))[0] == -1
    balls = [iso.Item(iso.sphere(0.4)).translate((k, 0, 0)) for k in range(8)]
    assert iso.Tracer(iso.Scene(balls), accelerator="bih").closest([(-3, 0.1, 0)], [(1, 0, 0)]).item[0] == 0


@pytest.mark.parametrize("coherent", [False, True])
def test_what_is_behind_what_is_seen_stays_as_it_is(coherent):
    """A wall before many: rays that stop there finish no others, one by one or in packets."""
    points, triangles = sphere(40, 0.0)
    walls = [iso.Item(iso.Mesh(points * (1, 1, 0.001), triangles)).translate((0, 0, -k)) for k in range(10)]
    tracer = iso.Tracer(iso.Scene(walls), accelerator="bih", threads=1)
    built = tracer._scene.arrays["geometry"].arrays["tables of objects"][0]
    grid = np.stack(np.meshgrid(*2 * [np.linspace(-0.4, 0.4, 30)], [3.0]), axis=-1).reshape(-1, 3)
    hits = tracer.closest(grid, [(0, 0, -1)], coherent=coherent)
    assert (hits.item == 0).all()
    states, parts = built.arrays["states"], built.arrays["parts"]
    done = built.arrays["order"][np.concatenate([np.arange(*row[:2]) for row in parts[states == FINISHED]])]
    assert (done < len(triangles)).mean() > 0.99
    assert 0 < (states == FINISHED).mean() < 0.15
    assert tracer.occluded(grid, [(0, 0, -1)], coherent=coherent).all()


@pytest.mark.parametrize("geometry", [sphere(60, 0.05), SOUP], ids=["sphere", "soup"])
def test_answers_are_those_of_the_whole_hierarchy(geometry):
    lazy, eager = build_accelerator("bih", *geometry), finished(geometry)
    rays = rays_at(iso.Mesh(*geometry), 300)
    before = 0
    for origin, direction in zip(*rays, strict=True):
        assert closest(lazy, origin, direction) == closest(eager, origin, direction)
        assert parts_finished(lazy)[0] >= before
        before = parts_finished(lazy)[0]
    assert 0 < before <= parts_finished(eager)[0]
    # What rays left is no different from what would have been built first.
    finish(lazy)
    assert same_bits(lazy, eager)


def test_the_order_of_rays_changes_nothing():
    rays = list(zip(*rays_at(iso.Mesh(*SOUP), 200), strict=True))
    forth, back = build_accelerator("bih", *SOUP), build_accelerator("bih", *SOUP)
    for ray in rays:
        closest(forth, *ray)
    for ray in reversed(rays):
        closest(back, *ray)
    finish(forth)
    finish(back)
    assert same_bits(forth, back)


def test_threads_that_finish_the_same_parts_leave_the_same_hierarchy():
    """Eight threads go through all parts at once; each is finished by the one that comes first."""
    truth = finished(SOUP)
    for _ in range(5):
        built = build_accelerator("bih", *SOUP)
        with ThreadPoolExecutor(8) as pool:
            list(pool.map(lambda _, built=built: finish(built), range(8)))
        assert same_bits(built, truth)


@pytest.mark.parametrize("name", GEOMETRIES)
def test_every_triangle_stands_in_one_block(name):
    points, triangles = GEOMETRIES[name]
    built = finished((points, triangles))
    blocks = built.blocks.reshape(-1, BLOCK)
    blocks = blocks[(blocks != 0).any(axis=1)]
    numbers = blocks.view(np.int32)[:, NUMBER:].reshape(-1)
    assert np.array_equal(np.sort(numbers[numbers >= 0]), np.arange(len(triangles)))
    corners = blocks[:, :NUMBER].reshape(-1, 3, 3, LANES).transpose(0, 3, 1, 2).reshape(-1, 3, 3)
    there = numbers >= 0
    assert np.array_equal(corners[there], np.asarray(points, np.float32)[np.asarray(triangles)[numbers[there]]])
    assert np.isnan(corners[~there]).all()


@pytest.mark.parametrize("name", GEOMETRIES)
def test_parts_stay_within_their_share_of_memory(name):
    """No node and no block is written twice, or behind the end; every child is met once."""
    built = finished(GEOMETRIES[name])
    nodes = built.tables.arrays["nodes"].reshape(-1, NODE)
    codes = nodes.view(np.int32)[:, CHILD : CHILD + WIDTH]
    there = nodes[:, LOWER : LOWER + WIDTH] <= nodes[:, UPPER : UPPER + WIDTH]
    waiting, met, blocks = [0], [], []
    while waiting:
        node = waiting.pop()
        met.append(node)
        for code in codes[node][there[node]].tolist():
            if code >= 0:
                waiting.append(code)
            else:
                first, count = (-1 - code) >> 3, (-1 - code) & 7
                assert count > 0
                blocks += range(first, first + count)
    assert len(set(met)) == len(met)
    assert sorted(blocks) == np.flatnonzero((built.blocks.reshape(-1, BLOCK) != 0).any(axis=1)).tolist()


def test_triangles_that_coincide_are_halved():
    corners = np.tile(np.random.default_rng(0).normal(size=(1, 3, 3)), (4_001, 1, 1))
    mesh = iso.Mesh(*soup(corners))
    tracer = iso.Tracer(mesh, accelerator="bih")
    above = corners[0].mean(axis=0) + np.array([0, 0, 5])
    counts = tracer.count([above], [[0, 0, -1]])
    assert counts.depth[0] <= 12
    assert tracer.closest([above], [[0, 0, -1]]).hit[0]


def test_parts_that_need_too_much_memory_are_made_by_halves():
    """Each half as large again as the one before: by costs alone, a tree has a node for seven triangles there."""
    rng = np.random.default_rng(5)
    places = 1.5 ** np.arange(340)[:, None, None] * 1e-25
    geometry = soup(places + places * rng.normal(size=(340, 3, 3)) * 0.01)
    assert len(build_triangles(*geometry).nodes) // NODE > 340 // 8
    built = finished(geometry)
    nodes = built.tables.arrays["nodes"].reshape(-1, NODE)
    used = int((nodes[:, :CHILD] != 0).any(axis=1).sum())
    assert used <= built.tables.arrays["first_node"] + 340 // 8
    for place in places[-40:, 0, 0]:
        ray = np.array([place, place, 3 * place]), np.array([0, 0, -1])
        bvh = build_accelerator("bvh", *geometry)
        assert closest(built, *ray)[1] == closest(bvh, *ray, name="bvh")[1]


@pytest.mark.parametrize("threads", [1, 2, 7])
def test_pictures_are_the_same_for_any_number_of_threads(threads):
    mesh = icosphere(5)
    items = [iso.Item(mesh, iso.Matte("tomato")), iso.Item(mesh, iso.Mirror()).translate((1.5, 0.5, 1))]
    scene = iso.studio(iso.Scene(items))
    size = (60, 45)
    truth = iso.render(scene, iso.PathTrace(4), size=size)
    found = iso.render(scene, iso.PathTrace(4, accelerator="bih"), size=size, threads=threads)
    for channel, values in truth.channels.items():
        assert np.array_equal(found.channels[channel], values), channel
