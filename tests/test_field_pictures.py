"""Fields in path-traced pictures: beside meshes, in glass, in furnaces, the same bits for any threads."""

from __future__ import annotations

import numpy as np
import pytest

import isophote as iso
from scenes import WHITE_SKY, box, icosphere, plane, render

WHITE = iso.Matte((1, 1, 1))


def followed(shape: iso.Field) -> iso.Field:
    """The same shape, followed as a field: a bare solid is traced as an exact primitive, one that was offset is not."""
    return shape.offset(0)


LIGHTS = [iso.RectLight(size=(1, 1), power=60).at((1, 3, 2), target=(0, 0, 0)), iso.Sky(strength=0.3)]
CAMERA = iso.Camera((1.5, 1.6, 3.0), (0, 0, 0), fov_degrees=40)


def difference(a: iso.Image, b: iso.Image) -> tuple[float, float]:
    """Of two pictures: the relative difference of their means, and the part of the values beyond 4 σ."""
    p, q = (image.channels["colour"].astype(np.float64) for image in (a, b))
    sigma = np.sqrt(a.channels["variance"].astype(np.float64) + b.channels["variance"])
    return abs(p.mean() / q.mean() - 1), float((np.abs(p - q) > 4 * sigma + 0.01 * q.mean()).mean())


@pytest.mark.parametrize(
    "material", [iso.Matte("tomato"), iso.Mirror(), iso.Glass(1.5)], ids=lambda m: type(m).__name__
)
@pytest.mark.parametrize("shape", ["sphere", "box"])
def test_a_field_looks_as_the_mesh_of_its_shape(shape: str, material: object) -> None:
    fields = {"sphere": followed(iso.sphere(0.8)), "box": followed(iso.box(1.1))}
    meshes = {"sphere": icosphere(6, 0.8, smooth=True), "box": box(1.1)}
    floor = iso.Item(plane(8)).translate((0, -0.81, 0))
    pictures = [
        render([iso.Item(each, material), floor], LIGHTS, CAMERA, size=(48, 36), samples=256, seed=seed)
        for seed, each in enumerate((fields[shape], meshes[shape]))
    ]
    mean, beyond = difference(*pictures)
    assert mean < 0.01
    assert beyond < 0.02
    a, b = (image.channels for image in pictures)
    assert (a["item"] == b["item"]).mean() > 0.998
    same = (a["item"] == b["item"]) & (a["item"] == 0)
    assert np.abs(a["depth"][same] - b["depth"][same]).max() < 2e-3
    assert np.median(np.abs(a["normal"] - b["normal"])[same]) < 1e-3
    assert (a["primitive"][same] == 0).all()
    assert not a["uv"][same].any()
    assert np.array_equal(a["albedo"][same], b["albedo"][same])


CONVEX = {
    "sphere": followed(iso.sphere(0.8)),
    "box": followed(iso.box(1.2)),
    "blend": iso.box(1.0).intersection(iso.sphere(0.65), blend=0.2),
    "capsule": iso.capsule(0.4, 1.0),
}


@pytest.mark.parametrize("offset", [0, 100])
@pytest.mark.parametrize("scale", [1e-4, 1.0, 1e5])
@pytest.mark.parametrize("name", CONVEX)
def test_a_convex_field_never_shadows_itself(name: str, scale: float, offset: float) -> None:
    move = np.array([1.0, -0.7, 0.4]) * offset * scale
    item = iso.Item(CONVEX[name], WHITE).scale(scale).translate(move)
    camera = iso.Camera(np.array([1.5, 2.5, 3.0]) * scale + move, move, fov_degrees=40)
    image = render([item], [WHITE_SKY], camera, size=(40, 40), samples=16)
    assert (image.channels["item"] == 0).mean() > 0.05
    assert np.abs(image.channels["colour"] - 1).max() < 1e-5


def test_no_light_leaks_into_a_closed_field() -> None:
    hollow = iso.box(4.0) - iso.box(3.9)
    camera = iso.Camera((0.3, 0.4, 0.9), (0, 0, 0), fov_degrees=60)
    lights = [WHITE_SKY, iso.Sun((1, 2, 3), 100.0), iso.PointLight((5, 3, 1), 1000.0)]
    image = render([iso.Item(hollow, WHITE)], lights, camera, size=(40, 40), samples=64, max_depth=12)
    assert not image.channels["colour"].any()


@pytest.mark.parametrize("shape", [followed(iso.box((2, 0.01, 2))), followed(iso.sphere(0.9))], ids=["slab", "ball"])
def test_glass_loses_no_light(shape: iso.Field) -> None:
    """In a white furnace glass is as bright as all around; a ray that missed its way out would be darker."""
    camera = iso.Camera((1.5, 2.5, 3.0), (0, 0, 0), fov_degrees=40)
    image = render([iso.Item(shape, iso.Glass(1.5))], [WHITE_SKY], camera, size=(40, 40), samples=16, max_depth=1000)
    assert np.abs(image.channels["colour"] - 1).max() < 1e-4


def test_shadow_edges_stand_where_geometry_has_them() -> None:
    """A ball above a plane, lit by a point: the shadow is a conic, whose edge is found pixel by pixel."""
    items = [iso.Item(followed(iso.plane()), WHITE), iso.Item(followed(iso.sphere(0.5)).translate((0, 1, 0)), WHITE)]
    camera = iso.OrthographicCamera((0, 0.4, 0), (0, 0, 0), up=(0, 0, -1), height=4.0)
    light = np.array([0.0, 3.0, 0.5])
    image = render(items, [iso.PointLight(light, 100.0)], camera, size=(128, 128), samples=1, max_depth=2)
    half = 2.0
    x = (np.arange(128) + 0.5) / 128 * 4 - half
    place = np.stack([*np.meshgrid(x, x), np.zeros((128, 128))], axis=-1)[..., [0, 2, 1]]
    to_ball, ray = np.array([0, 1, 0]) - light, place - light
    ray /= np.linalg.norm(ray, axis=-1, keepdims=True)
    along = ray @ to_ball
    apart = np.sqrt(to_ball @ to_ball - along**2)
    dark = image.channels["colour"][..., 0] == 0
    # Samples lie within their pixels, so the edge may be off by one.
    sure = np.abs(apart - 0.5) > 0.03
    assert (dark == (apart < 0.5))[sure].all()
    assert dark.any()


def test_a_field_that_shines_lights_what_is_around() -> None:
    """A ball of radiance L seen under the half angle α from below lights a floor by π L sin²α."""
    ball = iso.Item(followed(iso.sphere(0.5)).translate((0, 1, 0)), iso.Emitter((2, 2, 2)))
    floor = iso.Item(plane(0.02), WHITE)
    camera = iso.Camera((0, 0.2, 0.0), (0, 0, 0), up=(0, 0, -1), fov_degrees=2)
    image = render([ball, floor], [], camera, size=(8, 8), samples=4096, max_depth=2)
    assert image.channels["colour"].mean() == pytest.approx(2 * 0.5**2, rel=0.02)


def test_the_same_bits_for_any_threads() -> None:
    items = [
        iso.Item(followed(iso.plane()), iso.Matte((0.7, 0.5, 0.3))),
        iso.Item(iso.sphere(0.6) - iso.box(0.7), iso.Glass(1.5)).translate((0.7, 0.7, 0.3)),
        iso.Item(followed(iso.torus(0.5, 0.2)), iso.Matte("tomato")).rotate("x", 0.4).translate((-0.8, 0.46, 0)),
        iso.Item(icosphere(2, 0.3), iso.Mirror()).translate((0, 0.3, 1)),
    ]
    pictures = [render(items, LIGHTS, CAMERA, size=(50, 35), samples=7, threads=threads) for threads in (1, 2, 3)]
    for image in pictures[1:]:
        for name, channel in image.channels.items():
            assert channel.tobytes() == pictures[0].channels[name].tobytes(), name


def test_a_bare_field_gets_a_studio() -> None:
    part = (iso.sphere(1) & iso.box(1.5)) - iso.cylinder(0.5)
    image = iso.render(part, iso.PathTrace(samples=4), size=(48, 36), progress=False)
    assert set(np.unique(image.channels["item"])) == {0, 1}
    assert image.channels["colour"].min() > 0
