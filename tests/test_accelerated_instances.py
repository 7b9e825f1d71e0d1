"""Instances by every accelerator: what finds them is of the kind that was asked for, and finds what the tree finds."""

from __future__ import annotations

import numpy as np
import pytest

import isophote as iso
from isophote.accel.accelerator import ACCELERATORS, REFERENCE, accelerator_of
from isophote.lower.scene import lower_scene
from scenes import icosphere, plane

OTHERS = [name for name in (*ACCELERATORS, REFERENCE) if name != "bvh"]
FIELDS = ("distance", "item", "primitive", "uv", "normal")
_PLACE = iso.Transform.identity()


def _crowd(count: int) -> iso.Scene:
    """Copies of a mesh, too many triangles to be one object, turned and stretched; on a ground."""
    mesh, rng = icosphere(3), np.random.default_rng(7)
    items = [iso.Item(plane(60)).translate((0, -12, 0))]
    for place, angle, size in zip(
        rng.uniform(-20, 20, (count, 3)), rng.uniform(0, 6, count), rng.uniform(0.3, 1.5, (count, 3)), strict=True
    ):
        items.append(iso.Item(mesh).scale(size).rotate("y", float(angle)).translate(place * (1, 0.5, 1)))
    return iso.Scene(items)


def _rays(count: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(8)
    directions = rng.normal(size=(count, 3))
    directions[: count // 4] *= rng.random((count // 4, 3)) < 0.4
    directions[(directions == 0).all(axis=1)] = (0, -1, 0)
    return rng.uniform(-30, 30, (count, 3)), directions


@pytest.mark.parametrize("name", OTHERS)
def test_a_thousand_instances_are_found_by_the_accelerator_itself(name):
    scene = _crowd(1_000 if name != REFERENCE else 100)
    geometry = lower_scene(iso.studio(scene), (1, 1), 1, name).arrays["geometry"]
    assert geometry.arrays["boxes"].arrays["things"] == accelerator_of(name).things.address
    assert len(geometry.arrays["top_nodes"]) == 0
    rays = _rays(2_000)
    tree, found = iso.Tracer(scene), iso.Tracer(scene, accelerator=name)
    truth, hits = tree.closest(*rays), found.closest(*rays)
    assert 0.2 < truth.hit.mean() < 1
    for field in FIELDS:
        assert np.array_equal(getattr(hits, field), getattr(truth, field)), field
    limits = np.random.default_rng(9).uniform(0, 10, len(rays[0]))
    assert np.array_equal(found.occluded(*rays, limits), tree.occluded(*rays, limits))


@pytest.mark.parametrize("name", OTHERS)
def test_pictures_of_instances_are_the_same_bit_for_bit(name):
    scene = iso.studio(_crowd(60))
    pictures = [iso.render(scene, iso.PathTrace(2, accelerator=kind), size=(48, 36)) for kind in ("bvh", name)]
    for channel in ("colour", "depth", "normal", "item"):
        assert np.array_equal(pictures[0].channels[channel], pictures[1].channels[channel]), channel


@pytest.mark.parametrize("name", OTHERS)
def test_what_moves_is_found_where_it_is(name):
    mesh = icosphere(2)
    still = [iso.Item(mesh).translate((x, 0, -2)) for x in (-3, 0, 3)]
    moving = [
        iso.Item(mesh, transform=iso.Motion({0: _PLACE.translate((x, -1, 0)), 1: _PLACE.translate((x, 1, 0))}))
        for x in (-2, 1)
    ]
    camera = iso.Camera((0, 1, 9), (0, 0, 0), fov_degrees=45, shutter=(0, 1))
    scene = iso.studio(iso.Scene([*still, *moving], camera=camera))
    pictures = [iso.render(scene, iso.PathTrace(2, accelerator=kind), size=(40, 30)) for kind in ("bvh", name)]
    assert np.array_equal(pictures[0].channels["colour"], pictures[1].channels["colour"])


@pytest.mark.parametrize("name", [*ACCELERATORS, REFERENCE])
def test_rays_count_boxes_of_instances_as_nodes_and_not_as_triangles(name):
    scene = _crowd(100)
    tracer = iso.Tracer(scene, accelerator=name)
    rays = _rays(500)
    counts = tracer.count(*rays)
    hit = tracer.closest(*rays).hit
    assert (counts.primitives[hit] >= 1).all()
    assert (counts.primitives >= 0).all()
    if name == REFERENCE:
        faces = len(icosphere(3).faces)
        # Every ray against every triangle: of a hundred meshes, and two of the ground.
        assert (counts.primitives == 100 * faces + 2).all()
    else:
        assert counts.primitives.mean() < 60
        assert counts.nodes.mean() > 1
