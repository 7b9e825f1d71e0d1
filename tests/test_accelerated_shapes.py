"""Accelerators over exact primitives and fields: what brute force finds, by each of them, and what rays visit."""

from __future__ import annotations

import numpy as np
import pytest

import isophote as iso
from isophote.accel.accelerator import ACCELERATORS, accelerator_of, build_things
from isophote.errors import GeometryError
from isophote.lower.primitive_table import primitive_of
from isophote.shapes.primitive.extent import ball_around, balls_around, box_around, boxes_around
from scenes import icosphere

OTHERS = [name for name in ACCELERATORS if name != "bvh"]


def placed(shape: object, rng: np.random.Generator) -> iso.Item:
    """A shape somewhere in the cube from −1 to 1, turned and scaled unevenly."""
    item = iso.Item(shape).scale(tuple(rng.uniform(0.05, 0.25, 3)))
    for axis in "xyz":
        item = item.rotate(axis, float(rng.uniform(0, 6)))
    return item.translate(rng.uniform(-1, 1, 3))


def mixed(count: int, seed: int = 1) -> list[iso.Item]:
    """Exact primitives of every kind, a plane, fields that are marched, and a mesh, all through each other."""
    rng = np.random.default_rng(seed)
    outline = [(-1, -1, 0), (1, -1, 0), (0.2, 0, 0), (1, 1, 0), (-1, 1, 0)]
    saddle = iso.Quadric((1, -1, 0, 0, 0, 0, 0, 0, -1, 0), [(-1, -1, -1), (1, 1, 1)])
    kinds = [
        iso.sphere(1),
        iso.torus(1, 0.3),
        iso.cylinder(0.5, 1.5),
        iso.cone(1, 1.5),
        iso.box((1, 1.5, 0.5)),
        iso.Disk(1),
        iso.Polygon(outline),
        iso.Polygon(outline[:2] + outline[3:]),
        saddle,
    ]
    items = [placed(kinds[k % len(kinds)], rng) for k in range(count)]
    items += [placed(iso.rounded_box((1, 1.2, 0.8), 0.2), rng) for _ in range(3)]
    items += [placed(iso.link(0.5, 0.2, 1.8), rng), placed(icosphere(2), rng), iso.Item(iso.plane("y", -1.5))]
    return items


def rays(count: int, seed: int = 2) -> tuple[np.ndarray, np.ndarray]:
    """From about the cube into it, some along axes, and some from far away."""
    rng = np.random.default_rng(seed)
    origins = rng.uniform(-1.6, 1.6, (count, 3))
    directions = rng.uniform(-1, 1, (count, 3)) - origins
    along = rng.random(count) < 0.2
    directions[along] *= rng.random((along.sum(), 3)) < 0.4
    directions[(directions == 0).all(axis=1)] = (0, 0, -1)
    far = rng.random(count) < 0.1
    origins[far] -= 300 * directions[far]
    return origins, directions


@pytest.mark.parametrize("name", ACCELERATORS)
def test_mixed_scenes_as_by_brute_force(name):
    items = mixed(40)
    origins, directions = rays(3000)
    truth = iso.Tracer(iso.Scene(items), accelerator="brute").closest(origins, directions)
    tracer = iso.Tracer(iso.Scene(items), accelerator=name)
    for coherent in (False, True):
        found = tracer.closest(origins, directions, coherent=coherent)
        assert found.distance.tobytes() == truth.distance.tobytes()
        for field in ("item", "primitive", "normal", "uv"):
            assert np.array_equal(getattr(found, field), getattr(truth, field)), field
    assert np.array_equal(tracer.occluded(origins, directions), truth.hit)
    limit = 0.6 * np.where(truth.hit, truth.distance, 1)
    assert not tracer.occluded(origins, directions, limit).any()
    assert len(np.unique(truth.item)) > 40


@pytest.mark.parametrize("name", [*ACCELERATORS, "brute"])
def test_counts_of_primitives_and_fields(name):
    """Two hundred spheres, some fields, and a plane that every ray asks."""
    rng = np.random.default_rng(3)
    items = [iso.Item(iso.sphere(0.05)).translate(place) for place in rng.uniform(-1, 1, (200, 3))]
    items += [placed(iso.rounded_box((1, 1.2, 0.8), 0.2), rng) for _ in range(5)]
    tracer = iso.Tracer(iso.Scene([*items, iso.Item(iso.plane("y", -1.5))]), accelerator=name)
    origins, directions = rays(500)
    counts, hits = tracer.count(origins, directions), tracer.closest(origins, directions)
    if name == "brute":
        assert (counts.primitives == 206).all()
        return
    assert (counts.primitives >= 1).all()
    assert (counts.primitives[hits.hit & (hits.item < 205)] >= 2).all()
    assert counts.primitives.mean() < 20
    assert (counts.nodes[hits.hit & (hits.item < 205)] >= 1).all()
    away = tracer.count([[0, 5, 0]], [[0, 1, 0]])
    assert (away.primitives[0], away.depth[0]) == (1, 0)


def test_counts_are_those_of_the_tree_that_pictures_go_through():
    """A ray along a row of spheres meets the first; one beside it meets none, and is tested against few."""
    items = [iso.Item(iso.sphere(0.4)).translate((k, 0, 0)) for k in range(64)]
    tracer = iso.Tracer(iso.Scene(items))
    counts = tracer.count([[-3, 0, 0], [-3, 0.45, 0]], [[1, 0, 0], [1, 0, 0]])
    assert counts.primitives.tolist() == [1, 0]
    assert counts.nodes[0] <= 4
    assert counts.nodes[1] == 1


@pytest.mark.parametrize("name", OTHERS)
def test_a_picture_is_the_same_by_every_accelerator(name):
    scene = iso.studio(iso.Scene(mixed(20)[:-1]))
    for method in (iso.PathTrace, iso.RayTrace):
        pictures = [iso.render(scene, method(2, accelerator=kind), size=(24, 18)) for kind in ("bvh", name)]
        for channel in ("colour", "depth", "normal", "item"):
            assert np.array_equal(pictures[0].channels[channel], pictures[1].channels[channel]), channel


@pytest.mark.parametrize("name", ACCELERATORS)
def test_same_bits_over_boxes_for_any_number_of_threads(name):
    rng = np.random.default_rng(4)
    lower = rng.uniform(-1, 1, (20_000, 3)).astype(np.float32)
    upper = lower + rng.uniform(0, 0.1, lower.shape).astype(np.float32)
    alone, together = (build_things(name, lower, upper, threads) for threads in (1, 3))
    assert alone.blocks.tobytes() == together.blocks.tobytes()
    for field, values in alone.tables.arrays.items():
        assert np.asarray(values).tobytes() == np.asarray(together.tables.arrays[field]).tobytes(), field


@pytest.mark.parametrize("name", [*ACCELERATORS, "brute"])
def test_bad_boxes_are_refused_and_none_can_be_built_over(name):
    with pytest.raises(GeometryError, match="lower corner"):
        build_things(name, [[0, 0, 1]], [[1, 1, 0]])
    with pytest.raises(GeometryError, match="finite"):
        build_things(name, [[0, 0, np.nan]], [[1, 1, 1]])
    built = build_things(name, np.zeros((0, 3)), np.zeros((0, 3)))
    assert built.bounds[0, 0] > built.bounds[1, 0]
    assert accelerator_of(name).things.address


def test_boxes_and_balls_of_many_primitives_are_those_of_each():
    primitives = [primitive_of(item.shape).placed(item.transform.matrix) for item in mixed(45)[:45]]
    boxes = boxes_around(primitives)
    middles, radii = balls_around(primitives, boxes)
    for primitive, box, middle, radius in zip(primitives, boxes, middles, radii, strict=True):
        assert np.array_equal(box, box_around(primitive))
        own = ball_around(primitive)
        assert np.allclose(middle, own[0], rtol=0, atol=1e-15)
        assert radius == pytest.approx(own[1], rel=1e-14)
