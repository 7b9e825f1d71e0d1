"""Shapes that are no meshes, in radiosity: their areas, and the light on them, are those of meshes of them."""

from __future__ import annotations

import numpy as np
import pytest

import isophote as iso
from isophote.errors import RenderError
from scenes import plane

LAMP = iso.PointLight((0.3, 3, 0.5), 100)
GROUND = iso.Item(plane(4), iso.Matte(0.6))
CAMERA = iso.Camera((0, 2, 5), (0, 0.5, 0))
RING = [(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0)]
HOLES = [[(0.5, 0.5, 0), (1, 0.5, 0), (1, 1, 0)], [(1.2, 1.2, 0), (1.2, 1.8, 0), (1.8, 1.2, 0)]]


def solved(*items: iso.Item, patch: float = 0.3) -> iso.RadiositySolution:
    return iso.radiosity(iso.Scene([GROUND, *items], [LAMP], CAMERA), iso.Radiosity(patch=patch), progress=False)


@pytest.mark.parametrize(
    ("item", "area"),
    [
        (iso.Item(iso.box((1, 2, 0.5))), 2 * (1 * 2 + 2 * 0.5 + 0.5 * 1)),
        (iso.Item(iso.box(1).rotate("y", 0.4).mirror("x").translate((3, 1, 0))), 6.0),
        (iso.Item(iso.box(1)).scale((2, 1, 1)), 2 * (2 + 2 + 1)),
        # Surfaces without thickness have two sides.
        (iso.Item(iso.Disk(0.7)).rotate("x", 0.3), 2 * np.pi * 0.49),
        (iso.Item(iso.Polygon(RING)), 8.0),
        (iso.Item(iso.Polygon(RING, HOLES)), 2 * (4 - 0.125 - 0.18)),
        (iso.Item(iso.Polygon([(0, 0, 0), (2, 0, 0), (0.5, 0.5, 0), (0, 2, 0)])), 2 * 1.0),
    ],
    ids=["box", "turned box", "stretched box", "disk", "polygon", "holes", "concave"],
)
def test_flat_shapes_have_patches_of_their_own_area(item: iso.Item, area: float) -> None:
    found = solved(item.translate((0, 0.5, 0)))
    assert found.areas[found.item == 1].sum() == pytest.approx(area, rel=1e-6)


def test_a_box_is_lit_as_the_mesh_of_it_on_its_outside() -> None:
    corners = [[x, y, z] for x in (-0.5, 0.5) for y in (0, 1) for z in (-0.5, 0.5)]
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    for placed in (iso.box(1).translate((0, 0.5, 0)), iso.box(1).mirror("z").translate((0, 0.5, 0))):
        of_field, of_mesh = solved(iso.Item(placed)), solved(iso.Item(iso.Mesh(corners, quads)))
        means = [
            np.average(one.radiosity[one.item == 1, 0], weights=one.areas[one.item == 1]) for one in (of_field, of_mesh)
        ]
        assert means[0] == pytest.approx(means[1], rel=0.01)
        assert (of_field.item == 1).sum() == pytest.approx((of_mesh.item == 1).sum(), rel=0.2)


@pytest.mark.parametrize("ground", [iso.plane(), iso.slab(0.2).translate((0, -0.1, 0))])
def test_an_endless_ground_is_lit_by_the_cosine_law(ground: iso.Field) -> None:
    ball = iso.Item(iso.sphere(0.1).translate((0, 8, 0)), iso.Matte(0.0))
    scene = iso.Scene([iso.Item(ground, iso.Matte(0.5)), ball], [iso.PointLight((0, 2, 0), 100)], CAMERA)
    found = iso.radiosity(scene, iso.Radiosity(patch=0.25, error=0.003), progress=False)
    tops = np.nanmean(found.corners[:, :, 1], axis=1) > -1e-3
    middles = np.nanmean(found.corners, axis=1)
    lit = tops & (found.item == 0) & (found.irradiance[:, 0] > 0)
    near = lit & (np.hypot(middles[:, 0], middles[:, 2]) < 2)
    away = np.hypot(middles[near][:, 0], middles[near][:, 2])
    exact = 100 / (4 * np.pi) * 2 / (away**2 + 4) ** 1.5
    error = found.irradiance[near, 0] / exact - 1
    assert near.sum() > 20
    assert np.abs(np.average(error, weights=found.areas[near])) < 0.02


def test_small_things_do_not_fall_through_large_cells() -> None:
    found = solved(iso.Item(iso.sphere(0.03)).translate((0, 0.5, 0)), iso.Item(iso.sphere(3)).scale(0.01), patch=0.5)
    for number in (1, 2):
        assert found.areas[found.item == number].sum() == pytest.approx(4 * np.pi * 0.03**2, rel=0.2)


def test_shapes_that_cannot_be_cut_into_patches_are_told_with_what_mends_it() -> None:
    with pytest.raises(RenderError, match=r"items\[1\]: of endless shapes .* iso.box"):
        solved(iso.Item(iso.cylinder(0.2)))
    with pytest.raises(RenderError, match=r"items\[1\]: a Quadric has no surface .* give a field or a mesh"):
        solved(iso.Item(iso.Quadric((1, 1, 1, 0, 0, 0, 0, 0, 0, -1), [(-1, -1, -1), (1, 1, 1)])))
    with pytest.raises(RenderError, match="no item has bounds"):
        iso.radiosity(iso.Scene([iso.Item(iso.plane())], [LAMP]), progress=False)


@pytest.mark.parametrize("camera", [CAMERA, iso.OrthographicCamera((0, 2, 5), (0, 0.5, 0), height=8)])
def test_behind_all_patches_the_sky_is_seen_as_in_path_tracing(camera) -> None:
    picture = np.random.default_rng(2).random((8, 16, 3)).astype(np.float32)
    skies = [iso.Sky((0.1, 0.2, 0.3), 2.0), iso.Environment(iso.ImageTexture(picture), 0.5, rotation=0.7)]
    scene = iso.Scene([GROUND], skies, camera)
    size = (32, 24)
    traced = iso.render(scene, iso.PathTrace(samples=16, pattern="regular"), size=size, progress=False)
    found = iso.render(scene, iso.Radiosity(patch=1.0), size=size, progress=False)
    beyond = np.isinf(found.channels["depth"])
    assert beyond.sum() > 100
    difference = np.abs(found.channels["colour"] - traced.channels["colour"])[beyond]
    assert np.quantile(difference, 0.9) < 0.02
