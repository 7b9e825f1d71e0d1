"""The bounding interval hierarchy: rays build what they need of it, and it is the same whoever comes first."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import isophote as iso
from accelerator_rays import rays_at
from isophote.accel.accelerator import Built, accelerator_of, build_accelerator
from isophote.accel.bih import finish, nodes_built
from isophote.kernels.accel.contract import LIMIT, PRIMITIVES, RAY_WORDS
from isophote.kernels.accel.layout import BLOCK, LANES, NUMBER
from scenes import icosphere
from trees import GEOMETRIES, Geometry, soup, sphere

SOUP = soup(
    np.random.default_rng(3).normal(size=(20_000, 1, 3)) + np.random.default_rng(4).normal(0, 0.02, (20_000, 3, 3))
)


def closest(built: Built, origin: np.ndarray, direction: np.ndarray) -> tuple[int, float]:
    """What the entry answers: a slot, and the distance."""
    ray = np.zeros(RAY_WORDS, np.float32)
    ray[:3], ray[3:6], ray[LIMIT] = origin, direction, np.inf
    entry = accelerator_of("bih").closest.compile().ctypes
    slot = entry(built.tables.words.ctypes.data, built.blocks.ctypes.data, ray.ctypes.data)
    assert (slot < 0) or ray.view(np.int32)[PRIMITIVES] > 0
    return slot, float(ray[LIMIT])


def finished(geometry: Geometry) -> Built:
    built = build_accelerator("bih", *geometry)
    finish(built)
    return built


def same_bits(a: Built, b: Built) -> bool:
    arrays = ("nodes", "ranges", "records")
    return a.blocks.tobytes() == b.blocks.tobytes() and all(
        a.tables.arrays[name].tobytes() == b.tables.arrays[name].tobytes() for name in arrays
    )


def test_building_splits_nothing_and_one_ray_little():
    geometry = sphere(160, 0.05)
    built = build_accelerator("bih", *geometry)
    assert nodes_built(built) == 0
    slot, distance = closest(built, np.array([3, 0.1, 0.2]), np.array([-1, 0, 0]))
    assert slot >= 0
    assert 1.5 < distance < 2.5
    assert 0 < nodes_built(built) < 0.01 * nodes_built(finished(geometry))


def test_rays_that_miss_everything_split_nothing():
    built = build_accelerator("bih", *SOUP)
    assert closest(built, np.array([100, 100, 100]), np.array([1, 0, 0]))[0] == -1
    assert nodes_built(built) == 0


@pytest.mark.parametrize("geometry", [sphere(60, 0.05), SOUP], ids=["sphere", "soup"])
def test_answers_are_those_of_the_whole_hierarchy(geometry):
    lazy, eager = build_accelerator("bih", *geometry), finished(geometry)
    rays = rays_at(iso.Mesh(*geometry), 300)
    before = 0
    for origin, direction in zip(*rays, strict=True):
        assert closest(lazy, origin, direction) == closest(eager, origin, direction)
        assert nodes_built(lazy) >= before
        before = nodes_built(lazy)
    assert before < nodes_built(eager)
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


def test_threads_that_split_the_same_nodes_leave_the_same_hierarchy():
    """Eight threads go through all nodes at once; each is split by the one that comes first."""
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
    numbers = blocks.view(np.int32)[:, NUMBER:].reshape(-1)
    assert np.array_equal(np.sort(numbers[numbers >= 0]), np.arange(len(triangles)))
    assert len(blocks) == -(-len(triangles) // LANES)
    assert nodes_built(built) == max(2 * len(blocks) - 1, 0)
    corners = blocks[:, :NUMBER].reshape(-1, 3, 3, LANES).transpose(0, 3, 1, 2).reshape(-1, 3, 3)
    there = numbers >= 0
    assert np.array_equal(corners[there], np.asarray(points, np.float32)[np.asarray(triangles)[numbers[there]]])
    assert np.isnan(corners[~there]).all()


def test_triangles_that_coincide_are_halved():
    corners = np.tile(np.random.default_rng(0).normal(size=(1, 3, 3)), (4_001, 1, 1))
    mesh = iso.Mesh(*soup(corners))
    tracer = iso.Tracer(mesh, accelerator="bih")
    above = corners[0].mean(axis=0) + np.array([0, 0, 5])
    counts = tracer.count([above], [[0, 0, -1]])
    assert counts.depth[0] <= 12
    assert tracer.closest([above], [[0, 0, -1]]).hit[0]


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
