"""What a method leaves out of a scene is told, once, where the method is called; what it shows is not."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import isophote as iso
from isophote.errors import IsophoteWarning
from scenes import box, plane

CAMERA = iso.Camera((0, 2, 4), (0, 0, 0))
LAMP = iso.PointLight((0, 3, 1), 40)
FOG = iso.Medium(0.2)
RED = iso.Matte("crimson")
BUMPY = iso.Bump(RED, iso.PerlinNoise(size=0.2), 0.1)
CUT = iso.Cutout(RED, 0.3)


def render(material: object, method: object, medium: iso.Medium | None = None, light: object = LAMP) -> iso.Image:
    items = [iso.Item(plane(4), iso.Matte(0.5)), iso.Item(box(1), material)]
    scene = iso.Scene(items, [light], CAMERA, medium=medium)
    return iso.render(scene, method, size=(24, 18), progress=False)


@pytest.mark.parametrize(
    ("method", "material", "medium", "told"),
    [
        (iso.RayTrace(samples=1), RED, FOG, "RayTrace knows of no fog.*PathTrace shows it"),
        (iso.SphereTrace(), RED, FOG, "SphereTrace knows of no fog"),
        (iso.Radiosity(patch=0.5), RED, FOG, "Radiosity knows of no fog"),
        (iso.Radiosity(patch=0.5), CUT, None, r"Radiosity takes surfaces for whole: the holes of items\[1\] are"),
        (iso.Radiosity(patch=0.5), BUMPY, None, r"Radiosity knows of no relief: .* bumps of items\[1\] are"),
    ],
)
def test_what_a_method_leaves_out_is_told_where_it_is_called(method, material, medium, told):
    with pytest.warns(IsophoteWarning, match=told) as found:
        render(material, method, medium)
    assert [warning.filename for warning in found] == [__file__] * len(found)
    assert len(found) == 1


def test_radiosity_without_a_picture_tells_too():
    scene = iso.Scene([iso.Item(box(1), CUT)], [LAMP], medium=FOG)
    with pytest.warns(IsophoteWarning) as found:
        iso.radiosity(scene, iso.Radiosity(patch=0.5), progress=False)
    assert {warning.filename for warning in found} == {__file__}
    assert any("fog" in str(warning.message) for warning in found)


@pytest.mark.parametrize("material", [RED, CUT, BUMPY])
@pytest.mark.parametrize("method", [iso.PathTrace(1), iso.RayTrace(samples=1), iso.SphereTrace()])
def test_what_is_shown_is_not_told(method, material):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        render(material, method, FOG if isinstance(method, iso.PathTrace) else None)


@pytest.mark.parametrize("light", [iso.Sky("white"), iso.Sun((0, 1, 0))])
def test_a_medium_that_swallows_all_light_is_told(light):
    with pytest.warns(IsophoteWarning, match="no bounds.*all of it is black: give Medium"):
        image = render(RED, iso.PathTrace(1), FOG, light)
    assert not image.channels["colour"].any()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        bounded = iso.Medium(0.2, bounds=[(-1, -1, -1), (1, 1, 1)])
        assert render(RED, iso.PathTrace(1), bounded, light).channels["colour"].any()


def test_sphere_tracing_turns_normals_as_ray_tracing_does():
    whole, bumpy = (render(material, iso.SphereTrace(shadows="none")) for material in (RED, BUMPY))
    ray = render(BUMPY, iso.RayTrace(samples=1))
    seen = whole.channels["item"] == 1
    assert np.abs(whole.channels["normal"] - bumpy.channels["normal"])[seen].max() > 0.1
    assert np.allclose(bumpy.channels["normal"][seen], ray.channels["normal"][seen], atol=1e-3)


@pytest.mark.parametrize("material", [BUMPY, iso.Coated(RED), iso.Principled("crimson"), iso.Mix(RED, RED)])
def test_radiosity_takes_any_material_for_a_matte_one_of_its_colour(material):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", IsophoteWarning)
        expected, found = (render(one, iso.Radiosity(patch=0.5)) for one in (RED, material))
    assert np.array_equal(expected.channels["colour"], found.channels["colour"])


def test_radiosity_sees_the_picture_on_a_principled_surface():
    picture = iso.ImageTexture(np.full((2, 2, 3), (0.8, 0.2, 0.1), np.float32))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", IsophoteWarning)
        painted = render(iso.Principled(1.0, colour_texture=picture), iso.Radiosity(patch=0.5))
        plain = render(iso.Matte((0.8, 0.2, 0.1)), iso.Radiosity(patch=0.5))
    assert np.allclose(painted.channels["colour"], plain.channels["colour"], rtol=1e-5)
