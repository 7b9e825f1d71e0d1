"""Rays that leave a surface must not meet it again, and closed walls must be tight: at any scale, anywhere."""

from __future__ import annotations

import numpy as np
import pytest

import isophote as iso
from isophote.lower import geometry as lower_geometry
from scenes import WHITE_SKY, box, icosphere, plane, render

SCALES = [1e-4, 1e-2, 1.0, 1e3, 1e5]
WHITE = iso.Matte((1, 1, 1))
BODIES = {"sphere": icosphere(5), "box": box(), "plane": plane(4)}
TURNED = iso.Transform.identity().rotate((1, 2, 3), 1.0)
STRETCHED = TURNED.scale((1.0, 0.2, 2.5)).rotate((3, -1, 1), 2.0)


def picture(item: iso.Item, lights: object, scale: float, offset: float, eye=(1.5, 2.5, 3.0), **settings) -> np.ndarray:
    """Colours of an item of about the size `scale`, moved by so many sizes, seen from a few sizes away."""
    move = np.array([1.0, -0.7, 0.4]) * offset * scale
    placed = item.scale(scale).translate(move)
    camera = iso.Camera(np.array(eye) * scale + move, move, fov_degrees=40)
    image = render([placed], lights, camera, size=(40, 40), **settings)
    assert (image.channels["item"] == 0).mean() > 0.1
    return image.channels["colour"]


def dark_pixels(item: iso.Item, scale: float, offset: float) -> int:
    """Pixels of a convex white body in a white sky that are not as bright as the sky."""
    return int((picture(item, [WHITE_SKY], scale, offset, samples=16) != 1).any(axis=2).sum())


@pytest.mark.parametrize("offset", [0, 100])
@pytest.mark.parametrize("scale", SCALES)
@pytest.mark.parametrize("name", BODIES)
def test_a_convex_body_never_shadows_itself(name, scale, offset):
    assert dark_pixels(iso.Item(BODIES[name], WHITE), scale, offset) == 0


@pytest.mark.parametrize("offset", [0, 100])
@pytest.mark.parametrize("scale", SCALES)
@pytest.mark.parametrize("name", BODIES)
@pytest.mark.parametrize("transform", [TURNED, STRETCHED])
def test_nor_does_an_instance_of_one(name, scale, offset, transform, monkeypatch):
    monkeypatch.setattr(lower_geometry, "_BAKED_TRIANGLES", 0)
    item = iso.Item(BODIES[name], WHITE, transform)
    move = np.array([1.0, -0.7, 0.4]) * offset * scale
    # A second one far below makes both instances.
    other = item.scale(scale).translate(move - np.array([0, 50 * scale, 0]))
    camera = iso.Camera(np.array([1.5, 2.5, 3.0]) * scale + move, move, fov_degrees=40)
    image = render([item.scale(scale).translate(move), other], [WHITE_SKY], camera, size=(40, 40), samples=16)
    seen = image.channels["item"] == 0
    assert seen.mean() > 0.05
    # The other one is small in the sky, but white too; only what meets itself is dark, and what lies between them.
    colour = image.channels["colour"]
    assert (colour[seen] > 0.97).all()
    upward = image.channels["normal"][..., 1] > 0.3
    assert (colour[seen & upward] == 1).all()


@pytest.mark.parametrize("offset", [0, 100])
@pytest.mark.parametrize("scale", SCALES)
@pytest.mark.parametrize("mesh", [box(4, inward=True), icosphere(3, 2.0)])
def test_no_light_leaks_into_a_closed_body(mesh, scale, offset):
    lights = [
        WHITE_SKY,
        iso.Sun((1, 2, 3), 100.0),
        iso.PointLight(np.array([5.0, 3, 1]) * scale + np.array([1.0, -0.7, 0.4]) * offset * scale, 1000 * scale**2),
    ]
    item = iso.Item(mesh, WHITE)
    assert not picture(item, lights, scale, offset, eye=(0.3, 0.4, 0.9), samples=64, max_depth=12).any()


@pytest.mark.parametrize("scale", SCALES)
def test_glass_does_not_meet_itself(scale):
    """A ray in a thin slab has two surfaces close by; lost refractions would darken a furnace."""
    item = iso.Item(box(), iso.Glass(1.5), iso.Transform.identity().scale((2, 0.01, 2)))
    colour = picture(item, [WHITE_SKY], scale, 0, samples=16, max_depth=1000)
    assert np.abs(colour - 1).max() < 1e-4


@pytest.mark.parametrize("factor", [1e-4, 1e4])
def test_the_error_of_a_place_is_that_of_the_world_not_of_the_units_of_a_mesh(factor, monkeypatch):
    """A plate from a mesh in other units, a millimetre below a lid: rays that leave it must start below the lid."""
    monkeypatch.setattr(lower_geometry, "_BAKED_TRIANGLES", 0)
    plate = iso.Item(iso.Mesh(plane(4).vertices / factor, plane(4).faces), WHITE).scale(factor)
    lid = iso.Item(plane(4), WHITE).translate((0, 1e-3, 0))
    camera = iso.Camera((0, 5e-4, 0), (0, 0, -0.02), fov_degrees=1)
    items = [plate, plate.translate((0, -9, 0)), lid]
    image = render(items, [iso.Sun((0, 1, 0), 1.0)], camera, samples=16, max_depth=2)
    assert (image.channels["item"] == 0).all()
    assert not image.channels["colour"].any()
