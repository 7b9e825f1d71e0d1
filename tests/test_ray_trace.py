"""Ray tracing after Whitted: direct light as the path tracer has it, mirrors to the depth, the same bits whatever the
threads, tiles and waves, and settings that make no sense."""

from __future__ import annotations

import numpy as np
import pytest

import isophote as iso
from scenes import box, icosphere, plane

MATTE = [
    iso.Item(plane(8), iso.Matte((0.7, 0.5, 0.3))),
    iso.Item(box(0.9), iso.Matte((0.9, 0.2, 0.2))).rotate("y", 0.4).translate((-0.8, 0.46, 0)),
]
CLEAR = [
    iso.Item(icosphere(2, 0.6, smooth=True), iso.Glass.tinted((0.5, 0.8, 0.6), at=1)).translate((0.7, 0.7, 0.3)),
    iso.Item(icosphere(2, 0.4, smooth=True), iso.Mirror(0.9)).translate((-0.2, 0.45, 1.1)),
    iso.Item(icosphere(2, 0.3, smooth=True), iso.Metal(roughness=0)).translate((0.3, 0.35, 1.5)),
]
CAMERA = iso.Camera((0, 2, 5), (0, 0.5, 0))
LIGHTS = [
    iso.RectLight(size=(1, 1), power=60).at((0, 2.5, 0)),
    iso.SpotLight((2, 3, 2), 30, target=(0, 0, 0), cone_degrees=50, inner_degrees=30),
    iso.Sky(strength=0.2),
]


def render(items, lights, camera=CAMERA, *, size=(48, 32), seed=1, threads=2, method=None, **settings) -> iso.Image:
    scene = iso.Scene(items, lights=lights, camera=camera)
    method = iso.RayTrace(**settings) if method is None else method
    return iso.render(scene, method, size=size, seed=seed, threads=threads, progress=False)


def shining_mesh() -> iso.Item:
    return iso.Item(icosphere(1, 0.3), iso.Emitter((5, 4, 3))).translate((1, 1.5, 0.5))


def environment() -> iso.Environment:
    pixels = np.random.default_rng(3).random((8, 16, 3)).astype(np.float32) ** 4
    return iso.Environment(iso.Texture(pixels))


@pytest.mark.parametrize(
    "lights",
    {
        "point": [iso.PointLight((1, 3, 1), 100)],
        "sun": [iso.Sun((1, 2, 1), 2)],
        "spot": [iso.SpotLight((1, 3, 1), 50, cone_degrees=60, exponent=3)],
        "rectangle": [iso.RectLight(size=(1, 2), power=40).at((0.5, 2.5, 0))],
        "disk": [iso.DiskLight(radius=0.6, power=40).at((0, 2, 1), target=(0, 0, 0))],
        "sphere": [iso.SphereLight(radius=0.3, power=40).at((0, 2, 1))],
        "mesh": [shining_mesh()],
        "environment": [environment()],
        "many": [*LIGHTS[:2], iso.PointLight((-2, 1, 2), 10, "tomato")],
    }.items(),
    ids=lambda item: item[0],
)
def test_direct_light_is_that_of_the_path_tracer(lights):
    """Whole pictures and single pixels within three standard errors of paths of two rays."""
    items = MATTE + [light for light in lights[1] if isinstance(light, iso.Item)]
    lamps = [light for light in lights[1] if not isinstance(light, iso.Item)]
    ours = render(items, lamps, samples=64, light_samples=4, size=(24, 16))
    path = render(items, lamps, size=(24, 16), method=iso.PathTrace(samples=256, max_depth=2), seed=5)
    difference = ours.channels["colour"].astype(float) - path.channels["colour"]
    variance = ours.channels["variance"].astype(float) + path.channels["variance"]
    assert path.channels["colour"].mean() > 0.02
    assert np.abs(difference.mean(axis=(0, 1))).max() < 3 * np.sqrt(variance.mean() / variance[..., 0].size) + 1e-5
    beyond = np.abs(difference) > 4 * np.sqrt(variance) + 2e-3 * path.channels["colour"] + 1e-5
    assert beyond.mean() < 0.01
