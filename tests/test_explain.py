"""Explanations of pixels: their numbers add up to the picture's, by hand where that is easy, and can be read."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import isophote as iso
from command_line import run
from isophote.errors import RenderError
from scenes import box, plane

SIZE = (40, 30)


def table() -> iso.Scene:
    """A box, a glass ball and a mirror ball on a table under two lights and a sky."""
    items = [
        iso.Item(plane(8.0), iso.Matte((0.5, 0.6, 0.7))),
        iso.Item(box(0.8), iso.Plastic("tomato"), name="box").translate((-0.7, 0.41, 0)),
        iso.Item(iso.sphere(0.5), iso.Glass(ior=1.5), name="glass").translate((0.5, 0.55, 0.3)),
        iso.Item(iso.sphere(0.4), iso.Mirror(0.9)).translate((0.2, 0.42, -1)),
    ]
    lights = [iso.RectLight(size=(1, 1), power=40).at((0, 3, 0)), iso.PointLight((3, 3, 3), 80), iso.Sky("white", 0.2)]
    return iso.Scene(items, lights=lights, camera=iso.Camera((1, 1.6, 4), (0, 0.4, 0), fov_degrees=40))


def test_the_sum_is_the_colour_of_the_rendered_pixel() -> None:
    method = iso.RayTrace(samples=4, depth=5)
    image = iso.render(table(), method, size=SIZE, seed=2, progress=False)
    for pixel in [(0, 0), (20, 15), (26, 16), (12, 17), (22, 13), (39, 29)]:
        found = iso.explain(table(), pixel, method=method, size=SIZE, seed=2)
        shown = image.channels["colour"][pixel[1], pixel[0]]
        np.testing.assert_allclose(found.colour, shown, rtol=1e-5, atol=1e-7)
        np.testing.assert_allclose(found.added_up, shown, rtol=1e-5, atol=1e-7)


def test_each_ray_is_the_sum_of_its_terms_and_branches() -> None:
    found = iso.explain(table(), (26, 16), size=SIZE)
    assert {ray.kind for ray in found.rays} >= {"camera", "reflected", "refracted"}
    for number, ray in enumerate(found.rays):
        if ray.ended is not None:
            continue
        total = np.array(ray.emitted) + ray.ambient + sum((np.array(t.colour) for t in ray.lights), np.zeros(3))
        for branch in found.rays:
            if branch.parent == number:
                total += np.array(branch.weight) * branch.colour
        np.testing.assert_allclose(np.array(ray.tint) * total, ray.colour, rtol=1e-6, atol=1e-9)


def test_terms_are_those_worked_out_by_hand() -> None:
    # A matte ground seen from straight above, one point light: intensity over r², and ρ/π times the cosine.
    ground = iso.Item(plane(8.0), iso.Matte((0.5, 0.25, 0.125)))
    light = iso.PointLight((1, 2, 0), power=8 * np.pi)
    camera = iso.Camera((0, 3, 0), (0, 0, 0), up=(0, 0, -1), fov_degrees=1e-3)
    found = iso.explain(iso.Scene([ground], lights=[light], camera=camera), size=(1, 1))
    (ray,) = found.rays
    (term,) = ray.lights
    assert ray.met == "surface"
    assert ray.item == 0
    assert ray.distance == pytest.approx(3, rel=1e-5)
    assert ray.barycentric is not None
    corners = np.array([(-4, 0, -4), (-4, 0, 4), (4, 0, 4), (4, 0, -4)], float)
    assert sum(ray.barycentric) == pytest.approx(1)
    assert np.abs(np.array(ray.place)).max() < 1e-3 < np.abs(corners).max()
    np.testing.assert_allclose(ray.normal, (0, 1, 0), atol=1e-6)
    np.testing.assert_allclose(term.arriving, [2 / 5] * 3, rtol=1e-4)
    cosine = 2 / np.sqrt(5)
    np.testing.assert_allclose(term.value, np.array([0.5, 0.25, 0.125]) / np.pi * cosine, rtol=1e-4)
    np.testing.assert_allclose(found.colour, np.array([0.5, 0.25, 0.125]) / np.pi * cosine * 2 / 5, rtol=1e-4)


def test_text_and_data_say_the_same() -> None:
    found = iso.explain(table(), (26, 16), size=SIZE)
    text = str(found)
    assert 'items[2] "glass"' in text
    assert "refracted ray" in text
    assert "lights[0], RectLight" in text
    data = json.loads(json.dumps(found.data(), allow_nan=False))
    assert len(data["rays"]) == len(found.rays)
    assert data["colour"] == list(found.colour)
    assert data["rays"][0]["lights"] == []
    assert text.count("ray straight on") + text.count("flected ray") + text.count("fracted ray") == len(found.rays) - 1


def test_the_picture_shows_rays_in_their_colours() -> None:
    found = iso.explain(table(), (12, 17), size=SIZE)
    colour = found.picture((160, 120)).channels["colour"]
    red, green, blue = np.moveaxis(colour, 2, 0)
    assert ((red > 0.6) & (green > 0.3) & (blue < 0.25)).sum() > 10, "rays to lights are yellow"
    assert (colour.min(axis=2) > 0.7).sum() > 10, "the camera's ray is white"


def test_bare_shapes_and_missing_pixels() -> None:
    found = iso.explain(iso.sphere(1), size=(20, 20))
    assert found.pixel == (10, 10)
    assert found.rays[0].barycentric is None
    for pixel in [(20, 0), (-1, 0), (1.5, 2), "middle", (1, 2, 3)]:
        with pytest.raises(RenderError, match="pixel"):
            iso.explain(iso.sphere(1), pixel, size=(20, 20))  # type: ignore[arg-type]
    with pytest.raises(RenderError, match="RayTrace"):
        iso.explain(iso.sphere(1), method=iso.PathTrace())  # type: ignore[arg-type]


def test_the_command_explains(tmp_path: Path) -> None:
    file = tmp_path / "ball.py"
    file.write_text("import isophote as iso\nshape = iso.sphere(1)\n")
    told = run("explain", str(file), "--pixel", "10,12", "--size", "24x24", "-o", str(tmp_path / "rays.png"))
    assert told.exit_code == 0, told.output
    assert "camera ray 0" in told.output
    assert iso.load_image(tmp_path / "rays.png").size == (800, 600)
    data = json.loads(run("explain", str(file), "--size", "24x24", "--json").output)
    assert data["pixel"] == [12, 12]
    assert run("explain", str(file), "--pixel", "ten").exit_code == 2
    assert run("explain", str(file), "--pixel", "9999,0").exit_code == 1
