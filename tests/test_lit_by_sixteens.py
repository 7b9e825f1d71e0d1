"""Surfaces lit sixteen at a time show what they show one by one, as they are taken where a pixel is explained."""

from __future__ import annotations

import numpy as np
import pytest

import isophote as iso
from scenes import box, plane

SIZE = (36, 24)
LAMPS = {
    "rectangle": [iso.RectLight(size=(1, 2), power=60).at((0.3, 3, 1))],
    "both sides of a rectangle": [iso.RectLight(size=(1, 1), power=60, two_sided=True).at((0.2, 0.9, 0.4))],
    "point and sun": [iso.PointLight((2, 3, 2), 90), iso.Sun((1, 2, 0.5), 1.5)],
    "sphere, disk and spot": [
        iso.SphereLight(radius=0.3, power=50).at((-1, 3, 1)),
        iso.DiskLight(radius=0.4, power=30).at((1, 3, 1)),
        iso.SpotLight((0, 4, 2), 60, target=(0, 0, 0)),
    ],
    "all under a sky": [
        iso.SphereLight(radius=0.3, power=50).at((-1, 3, 1)),
        iso.RectLight(size=(1, 2), power=60).at((0.3, 3, 1)),
        iso.PointLight((2, 3, 2), 90),
        iso.Sky((0.3, 0.4, 0.6)),
    ],
}


def coarse_ball() -> iso.Mesh:
    """A ball of few faces whose normals are blended: at its rim rays see fronts of faces and backs of normals."""
    rings, sides = 5, 7
    angles = np.pi * (np.arange(1, rings) / rings)[:, None], 2 * np.pi * (np.arange(sides) / sides)[None]
    low, turn = np.broadcast_arrays(*angles)
    around = np.stack([np.sin(low) * np.cos(turn), np.cos(low), np.sin(low) * np.sin(turn)], axis=2).reshape(-1, 3)
    vertices = np.concatenate([around, [(0, 1, 0), (0, -1, 0)]])
    top, bottom, last = len(around), len(around) + 1, (rings - 2) * sides
    faces = [(top, (k + 1) % sides, k) for k in range(sides)]
    faces += [(bottom, last + k, last + (k + 1) % sides) for k in range(sides)]
    for ring in range(rings - 2):
        for k in range(sides):
            a, b = ring * sides + k, ring * sides + (k + 1) % sides
            faces += [(a, b, b + sides), (a, b + sides, a + sides)]
    return iso.Mesh(vertices, np.array(faces), attributes={"normal": vertices})


def scene(lamps: list[object]) -> iso.Scene:
    """Plain surfaces of every kind, and others between them."""
    ball = coarse_ball()
    items = [
        iso.Item(plane(8.0), iso.Matte((0.5, 0.6, 0.7))),
        iso.Item(ball, iso.Matte((0.8, 0.5, 0.3))).scale(0.5).translate((-0.8, 0.6, 0.2)),
        iso.Item(box(0.6), iso.Matte((0.3, 0.8, 0.3))).translate((0.1, 0.31, -0.6)),
        iso.Item(box(0.5), iso.Plastic("tomato")).translate((0.2, 0.26, 0.7)),
        iso.Item(iso.sphere(0.4), iso.Matte(0.6)).translate((0.9, 0.42, 0.2)),
    ]
    items += [iso.Item(ball, iso.Matte(0.4)).scale((0.2, 0.3, 0.2)).translate((x, 0.3, 1.2)) for x in (-0.4, 0.6)]
    return iso.Scene(items, lights=lamps, camera=iso.Camera((0.6, 1.6, 4), (0, 0.4, 0), fov_degrees=40))


@pytest.mark.parametrize("lamps", LAMPS)
def test_pixels_are_what_their_explanations_add_up_to(lamps: str) -> None:
    subject, method = scene(LAMPS[lamps]), iso.RayTrace(samples=3, light_samples=3)
    image = iso.render(subject, method, size=SIZE, seed=5, progress=False)
    colour, items = image.channels["colour"], image.channels["item"]
    assert set(range(len(subject.items))) <= set(items.ravel().tolist())
    rng = np.random.default_rng(3)
    for item in range(len(subject.items)):
        ys, xs = np.nonzero(items == item)
        for at in rng.choice(len(ys), min(5, len(ys)), replace=False):
            found = iso.explain(subject, (int(xs[at]), int(ys[at])), method=method, size=SIZE, seed=5)
            np.testing.assert_allclose(found.added_up, colour[ys[at], xs[at]], rtol=1e-5, atol=1e-6)
