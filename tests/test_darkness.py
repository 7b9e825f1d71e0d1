"""Scenes in which nothing shines are told, once, with what mends them; those that shine, and bare shapes, are not."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import isophote as iso
from isophote.rendering.method import Job
from scenes import box, plane

CAMERA = iso.Camera((0, 2, 4), (0, 0, 0))
ITEMS = [iso.Item(plane(4), iso.Matte(0.5)), iso.Item(box(1), iso.Matte(0.5))]
METHODS = {
    "path tracing": iso.PathTrace(samples=1),
    "ray tracing": iso.RayTrace(samples=1),
    "sphere tracing": iso.SphereTrace(),
}
DARK = {
    "a point": iso.PointLight((0, 3, 0), 0),
    "a spot": iso.SpotLight((0, 3, 0), 0),
    "a sun": iso.Sun((0, 1, 0), 0),
    "a rectangle": iso.RectLight(power=0).at((0, 3, 0)),
    "a sphere": iso.SphereLight(radiance=0).at((0, 3, 0)),
    "a black lamp": iso.DiskLight(power=5, colour="black").at((0, 3, 0)),
    "a sky": iso.Sky("white", 0),
    "a black picture": iso.Environment(iso.ImageTexture(np.zeros((4, 8, 3), np.float32))),
    "a picture of no strength": iso.Environment(iso.ImageTexture(np.ones((4, 8, 3), np.float32)), strength=0),
}


def render(items: list[iso.Item], lights: list[object], method: object = METHODS["path tracing"]) -> iso.Image:
    return iso.render(iso.Scene(items, lights, CAMERA), method, size=(8, 6), progress=False, threads=1)


@pytest.mark.parametrize("name", DARK)
def test_a_scene_whose_lights_are_dark_is_told_once(name):
    reason = r"nothing in the scene shines.*is 0 of lights\[0\] \(\w+\), and"
    with pytest.warns(iso.IsophoteWarning, match=reason) as caught:
        image = render(ITEMS, [DARK[name]])
    assert len(caught) == 1
    assert image.channels["colour"].max() == 0


@pytest.mark.parametrize("name", METHODS)
def test_every_method_that_needs_light_tells(name):
    solid = [iso.Item(iso.sphere(1), iso.Matte(0.5))] if name == "sphere tracing" else ITEMS
    with pytest.warns(iso.IsophoteWarning, match="nothing in the scene shines") as caught:
        render(solid, [iso.PointLight((k, 3, 0), 0) for k in range(5)], METHODS[name])
    assert [str(warning.message) for warning in caught if "and 2 more" in str(warning.message)]


def test_a_scene_without_lights_is_told_where_nobody_adds_any():
    job = Job(iso.Scene(ITEMS, camera=CAMERA), (4, 3), 1, 1, lambda stage, fraction: None)
    with pytest.warns(iso.IsophoteWarning, match="it has no lights, and no material emits"):
        METHODS["path tracing"].render(job)


@pytest.mark.parametrize(
    "light", [iso.PointLight((0, 3, 0), 1), iso.Sky("red", 0.1), iso.RectLight(radiance=(0, 0, 1)).at((0, 3, 0))]
)
def test_scenes_that_shine_are_not(light):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        render(ITEMS, [DARK["a point"], light])


def test_what_emits_is_light_enough():
    glowing = iso.Item(box(1), iso.Principled("grey", emission=(0.1, 0, 0)))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        render([*ITEMS, glowing], [DARK["a sky"]])
        render([*ITEMS, iso.Item(box(1), iso.Emitter((0, 0, 1)))], [])


@pytest.mark.parametrize("subject", [box(1), iso.Scene(ITEMS), iso.Scene(ITEMS, camera=CAMERA)])
def test_the_studio_brings_its_own_light(subject):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        image = iso.render(subject, METHODS["path tracing"], size=(8, 6), progress=False, threads=1)
    assert image.channels["colour"].max() > 0


@pytest.mark.parametrize("method", [iso.AmbientOcclusion(samples=1), iso.Visits()])
def test_methods_that_need_no_light_do_not_tell(method):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        render(ITEMS, [DARK["a sky"]], method)
