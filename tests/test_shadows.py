"""Shadows of ray tracing: hard edges where geometry puts them, penumbras by closed forms, errors that fall."""

from __future__ import annotations

import math

import numpy as np
import pytest

import isophote as iso
from ray_traced import block, colour, ray_trace
from scenes import icosphere, plane

WIDE = iso.Item(plane(40), iso.Matte(0.5))
# Covers all of x < 0 at height 1; seen from above it hides nothing of x > 0.
ROOF = iso.Item(iso.Mesh([(-20, 1, -20), (-20, 1, 20), (0, 1, 20), (0, 1, -20)], [(0, 1, 2, 3)]), iso.Matte(0.5))
PIXELS = 64
FROM_ABOVE = iso.OrthographicCamera((1, 9, 0), (1, 0, 0), (0, 0, -1), height=2)
ACROSS = (np.arange(PIXELS) + 0.5) / PIXELS * 2
BLACK_ROOF = iso.Item(ROOF.shape, iso.Matte(0.0))


def floor(lights: list, **settings: object) -> np.ndarray:
    """(h, w) of the floor from x = 0 to 2 under the roof's edge."""
    return colour(ray_trace([WIDE, BLACK_ROOF], lights, FROM_ABOVE, size=(PIXELS, PIXELS), **settings))[..., 0]


@pytest.mark.parametrize(
    ("light", "edge"),
    [
        # The line from the light over the roof's edge (0, 1) down to the floor.
        (iso.PointLight((-0.55, 3, 0), 100), 0.55 / 2),
        (iso.PointLight((-2.5, 4, 0), 100), 2.5 / 3),
        (iso.Sun((-1.3, 1, 0), 1), 1.3),
        (iso.SpotLight((-2.5, 4, 0), 100, target=(1, 0, 0), cone_degrees=140), 2.5 / 3),
    ],
    ids=["point", "farther point", "sun", "spot"],
)
def test_hard_edges(light, edge):
    """Dark before the edge, lit behind it, and in the pixel that the edge crosses in proportion to its lit part."""
    shaded, free = (
        floor([light], samples=64),
        colour(ray_trace([WIDE], [light], FROM_ABOVE, size=(PIXELS, PIXELS), samples=64))[..., 0],
    )
    lit = np.clip((ACROSS + 1 / PIXELS - edge) * PIXELS / 2, 0, 1)
    assert (shaded[:, lit == 0] == 0).all()
    assert np.array_equal(shaded[:, lit == 1], free[:, lit == 1])
    crossed = (lit > 0) & (lit < 1)
    assert crossed.sum() <= 1
    assert np.allclose((shaded / free)[:, crossed].mean(axis=0), lit[crossed], atol=0.02)


def lambert(corners: np.ndarray, point: np.ndarray) -> float:
    """∫ cosθ dω over a polygon above a floor (Lambert): ½ Σ angle of an edge · (its plane's normal · n)."""
    v = corners - point
    v = v / np.linalg.norm(v, axis=1)[:, None]
    total = 0.0
    for p, q in zip(v, np.roll(v, -1, axis=0), strict=True):
        across = np.cross(p, q)
        total += math.atan2(np.linalg.norm(across), p @ q) * (across / np.linalg.norm(across))[1]
    return abs(total) / 2


def penumbra(width: float, depth: float, middle: float, height: float) -> np.ndarray:
    """Radiance of the floor at z = 0 by a rectangle light of radiance 1 behind the roof: Lambert's formula over the
    part of the light that is above the line from the floor over the roof's edge."""
    result = []
    for x in ACROSS:
        behind = x - x * height
        low, high = max(middle - width / 2, behind), middle + width / 2
        if low >= high:
            result.append(0.0)
            continue
        corners = np.array([(a, height, b) for a, b in ((low, -1), (high, -1), (high, 1), (low, 1))]) * (
            1,
            1,
            depth / 2,
        )
        result.append(0.5 / math.pi * lambert(corners, np.array([x, 0, 0])))
    return np.array(result)


RECTANGLE = iso.RectLight(size=(2, 3), radiance=1).at((-1.5, 3, 0))


def test_penumbra_of_a_rectangle():
    exact = penumbra(2, 3, -1.5, 3)
    assert exact[0] == 0
    assert 0.5 < ACROSS[exact.argmax()] < 1.25
    row = floor([RECTANGLE], samples=64, light_samples=64)[PIXELS // 2 - 1 : PIXELS // 2 + 1].mean(axis=0)
    assert np.abs(row - exact).max() < 0.01 * exact.max()


def test_the_error_of_penumbras_falls_with_the_number_of_rays():
    """Faster than by the root: sixteen times the rays have less than a fifth of the error; by chance a fourth."""
    exact = penumbra(2, 3, -1.5, 3)
    errors = []
    for rays in (1, 4, 16, 64):
        row = floor([RECTANGLE], samples=1, light_samples=rays, pattern="sobol")[PIXELS // 2 - 2 : PIXELS // 2 + 2]
        errors.append(math.sqrt(((row - exact) ** 2).mean()))
    assert errors[2] < errors[0] / 5
    assert errors[3] < errors[1] / 5
    assert errors[3] < 0.02 * exact.max()


def test_disk_and_sphere_without_shadow():
    """At the foot of the axis: π r² / (r² + h²) of a disk, π r² / h² of a sphere, times ρ/π."""
    below = iso.OrthographicCamera((0.001, 1, 0), (0.001, 0, 0), (0, 0, -1), height=0.01)
    for light, form in (
        (iso.DiskLight(radius=0.7, radiance=3).at((0, 1.5, 0)), math.pi * 0.49 / (0.49 + 2.25)),
        (iso.SphereLight(radius=0.7, radiance=3).at((0, 1.9, 0)), math.pi * 0.49 / 1.9**2),
    ):
        found = colour(ray_trace([WIDE], [light], below, size=(4, 4), samples=16, light_samples=64)).mean()
        assert found == pytest.approx(0.5 / math.pi * 3 * form, rel=2e-3)


def test_a_shining_mesh_is_one_light():
    """A sphere of 320 triangles that shine: nearly the light of the sphere, by as many shadow rays as any light."""
    below = iso.OrthographicCamera((0.001, 1, 0), (0.001, 0, 0), (0, 0, -1), height=0.01)
    ball = iso.Item(icosphere(2, 0.7), iso.Emitter(3)).translate((0, 1.9, 0))
    image = ray_trace([WIDE, ball], [], below, size=(4, 4), samples=16, light_samples=64)
    assert colour(image).mean() == pytest.approx(0.5 / math.pi * 3 * math.pi * 0.49 / 1.9**2, rel=0.03)
    # One camera ray and at most 64 shadow rays a sample; places that face away need none.
    assert (image.channels["rays"] <= 16 * 65).all()
    assert (image.channels["rays"] > 16 * 20).all()


@pytest.mark.parametrize("pattern", ["blue-noise", "sobol", "antithetic", "jittered", "regular", "independent"])
def test_every_pattern_gives_the_same_light(pattern):
    exact = penumbra(2, 3, -1.5, 3)
    row = floor([RECTANGLE], samples=16, light_samples=16, pattern=pattern)[PIXELS // 2 - 4 : PIXELS // 2 + 4]
    assert np.abs(row.mean(axis=0) - exact).max() < 0.05 * exact.max()


def test_a_lamp_in_the_way_shadows():
    """A small disk light between a sun and the floor leaves a dark disk."""
    lamp = iso.DiskLight(radius=0.5, power=0).at((1, 2, 0))
    image = colour(
        ray_trace(
            [WIDE],
            [iso.Sun((0, 1, 0), 1), lamp],
            seed=3,
            camera=iso.OrthographicCamera((1, 1.9, 0), (1, 0, 0), (0, 0, -1), height=2),
            size=(40, 40),
            samples=16,
        )
    )[..., 0]
    radius = np.hypot(*np.meshgrid(*[(np.arange(40) + 0.5) / 20 - 1] * 2))
    assert (image[radius < 0.46] == 0).all()
    assert np.allclose(image[radius > 0.54], 0.5 / math.pi, rtol=1e-5)


SHEET = iso.Mesh([(-3, 1, -3), (-3, 1, 3), (3, 1, 3), (3, 1, -3)], [(0, 1, 2, 3)])
UNDER = iso.OrthographicCamera((0.5, 0.9, 0.3), (0.5, 0, 0.3), (0, 0, -1), height=0.01)


def through(item: iso.Item, shadows: str, light: object) -> np.ndarray:
    """Colour of a point of the floor behind something, over that without it."""
    settings = {"size": (2, 2), "samples": 4, "shadows": shadows}
    free, shaded = (colour(ray_trace(items, [light], UNDER, **settings)) for items in ([WIDE], [WIDE, item]))
    return (shaded / free).mean(axis=(0, 1))


@pytest.mark.parametrize("light", [iso.PointLight((0.5, 3, 1.3), 10), iso.Sun((0, 3, 1), 1)], ids=["point", "sun"])
def test_tinted_shadows_of_a_slab(light):
    """exp(−σ d / cosθ) straight through what does not bend light, times (1 − F)² at faces that reflect."""
    theta = math.atan(1 / 3)
    sigma = np.array([0.5, 1.0, 3.0])
    for n in (1.0, 1.5):
        plate = iso.Item(block((-3, 1, -3), (3, 1.4, 3)), iso.Glass(n, absorption=tuple(sigma)))
        share = float(iso.fresnel(theta, 1.0, n))
        # Not bent: the second face is met under the first one's angle, from inside.
        back = float(iso.fresnel(theta, n, 1.0))
        expected = np.exp(-sigma * 0.4 / math.cos(theta)) * (1 - share) * (1 - back)
        assert np.allclose(through(plate, "tinted", light), expected, rtol=1e-4)
        assert (through(plate, "opaque", light) == 0).all()


def test_tinted_shadows_of_sheets_and_what_blocks():
    sun = iso.Sun((0, 1, 0), 1)
    tint = (0.25, 0.5, 0.75)
    sheet = iso.Item(SHEET, iso.ThinGlass.tinted(tint, ior=1.0))
    assert np.allclose(through(sheet, "tinted", sun), tint, rtol=1e-5)
    for material in (iso.Matte(), iso.Mirror(), iso.Metal(roughness=0), iso.Plastic("white")):
        assert (through(iso.Item(SHEET, material), "tinted", sun) == 0).all()


def test_a_lamp_within_a_tinted_ball_shines_out():
    """A light in the middle of a ball of tinted glass without an edge: exp(−σ r) all around."""
    lamp = iso.PointLight((0.5, 3, 0.3), 10)
    ball = iso.Item(icosphere(4, 0.5), iso.Glass.tinted((0.2, 0.5, 0.8), at=0.5, ior=1.0)).translate((0.5, 3, 0.3))
    assert np.allclose(through(ball, "tinted", lamp), (0.2, 0.5, 0.8), rtol=5e-3)


def test_tinted_shadows_from_within_a_medium():
    """A floor under tinted water, lit from above it: the water on the way, and not the air."""
    water = iso.Item(block((-9, -1, -9), (9, 0.5, 9)), iso.Glass(1.0, absorption=(0.5, 1.0, 2.0)))
    sun = iso.Sun((0, 1, 0), 1)
    # Down to the floor and up again.
    assert np.allclose(through(water, "tinted", sun), np.exp(-np.array([0.5, 1.0, 2.0])), rtol=5e-4)
