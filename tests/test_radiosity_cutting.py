"""Radiosity cuts patches where light peaks, wherever that is on them."""

from __future__ import annotations

import numpy as np
import pytest

import isophote as iso

HEIGHT, SIDE = 1.5, 1.0


def floor(half: float) -> iso.Item:
    corners = [(-half, 0, half), (half, 0, half), (half, 0, -half), (-half, 0, -half)]
    return iso.Item(iso.Mesh(corners, [(0, 1, 2, 3)]), iso.Matte(0.5))


def irradiance_below(x: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Of a square lamp of radiance 1 that faces down, by the closed form for its four corners (Hottel's configuration
    factor of a rectangle parallel to the surface, with one corner above it)."""

    def corner(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        p, q = a / HEIGHT, b / HEIGHT
        u, v = np.sqrt(1 + p * p), np.sqrt(1 + q * q)
        return (p / u * np.arctan(q / u) + q / v * np.arctan(p / v)) / 2

    half = SIDE / 2
    return sum(s * t * corner(s * half - x, t * half - z) for s in (-1, 1) for t in (-1, 1))


@pytest.mark.parametrize("half", [1.0, 6.0, 20.0])
@pytest.mark.parametrize("aside", [(0.0, 0.0), (0.37, -0.21)])
def test_light_under_a_lamp_is_that_of_the_closed_form(half: float, aside: tuple[float, float]) -> None:
    # Above the middle, all four quarters of the floor are lit alike.
    lamp = iso.RectLight(size=(SIDE, SIDE), radiance=(1, 1, 1)).at((aside[0], HEIGHT, aside[1]))
    found = iso.radiosity(iso.Scene([floor(half)], lights=[lamp]), iso.Radiosity(patch=0.1), progress=False)
    lit = (found.irradiance[:, 0] > 0) & (found.albedo[:, 0] > 0)
    centres = found.corners[lit].mean(axis=1)
    exact = irradiance_below(centres[:, 0] - aside[0], centres[:, 2] - aside[1])
    # Where most of the light is, patches are small, and their means the light in the middle.
    bright = exact > 0.05 * exact.max()
    assert bright.sum() > 50
    np.testing.assert_allclose(found.irradiance[lit, 0][bright], exact[bright], rtol=0.02)


@pytest.mark.parametrize("aside", [(0.0, 0.0), (7.3, -11.1)])
def test_small_lamps_over_wide_floors_are_followed_by_default(aside: tuple[float, float]) -> None:
    # A hundredth of this floor is longer than the spot of light on it.
    lamp = iso.RectLight(size=(0.2, 0.2), radiance=(1, 1, 1)).at((aside[0], 0.5, aside[1]))
    found = iso.radiosity(iso.Scene([floor(50.0)], lights=[lamp]), progress=False)
    arriving = (found.irradiance[:, 0] * found.areas)[found.item == 0].sum()
    # All of the lamp's light but what goes past the rim.
    assert arriving == pytest.approx(np.pi * 0.2**2, rel=0.01)
    # Below the lamp it is 0.1519; a patch of a hundredth of the diagonal would have 0.02 at most.
    assert 0.12 < found.irradiance[:, 0].max() < 0.1519


def test_even_light_cuts_nothing() -> None:
    found = iso.radiosity(iso.Scene([floor(6.0)], lights=[iso.Sun((0, 1, 0))]), progress=False)
    assert len(found.areas) == 2


@pytest.mark.parametrize("method", ["hierarchical", "gathering"])
def test_painted_lamps_shine_as_their_texture_says(method: str) -> None:
    # Half of the lamp is black, and the light below it is that of the other half.
    halves = iso.ImageTexture(np.array([[0.0, 1.0]], np.float32), filter="nearest")
    corners = np.array([(-0.5, HEIGHT, -0.5), (0.5, HEIGHT, -0.5), (0.5, HEIGHT, 0.5), (-0.5, HEIGHT, 0.5)])
    uvs = iso.Attribute([(0, 0), (1, 0), (1, 1), (0, 1)])
    whole = iso.Mesh(corners, [(0, 1, 2, 3)], attributes={"uv": uvs})
    right = iso.Mesh(np.maximum(corners, (0, -9, -9)), [(0, 1, 2, 3)])
    painted, plain = (
        iso.radiosity(iso.Scene([floor(1.0), lamp]), iso.Radiosity(patch=0.125, method=method), progress=False)
        for lamp in (
            iso.Item(whole, iso.Emitter(1.0, texture=halves)),
            iso.Item(right, iso.Emitter(1.0)),
        )
    )
    lights = [(one.irradiance[one.item == 0] * one.areas[one.item == 0, None]).sum(axis=0) for one in (painted, plain)]
    assert lights[1].max() > 0.1
    np.testing.assert_allclose(lights[0], lights[1], rtol=0.01)


def under_a_point(corners: np.ndarray, place: tuple[float, float, float]) -> np.ndarray:
    """Mean of h / (x² + h²)^3/2 over rectangles on the ground, the irradiance of a point of 1 W/sr:
    ∬ = atan (x y / (h √(x² + y² + h²))) from corner to corner."""
    x, y, h = corners[..., 0] - place[0], corners[..., 2] - place[2], place[1]
    x0, x1, y0, y1 = x.min(axis=1), x.max(axis=1), y.min(axis=1), y.max(axis=1)

    def corner(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return np.arctan2(a * b, h * np.sqrt(a * a + b * b + h * h))

    whole = corner(x1, y1) - corner(x0, y1) - corner(x1, y0) + corner(x0, y0)
    return whole / ((x1 - x0) * (y1 - y0))


@pytest.mark.parametrize(
    ("half", "place"),
    [(2.0, (0.0, 1.0, 0.0)), (20.0, (7.3, 0.5, -3.1)), (50.0, (0.0, 0.2, 0.0)), (1.0, (0.3, 0.05, 0.2))],
)
def test_patches_under_a_point_have_the_mean_of_its_closed_form(half: float, place: tuple[float, float, float]) -> None:
    point = iso.PointLight(place, power=4 * np.pi)
    found = iso.radiosity(iso.Scene([floor(half)], lights=[point]), progress=False)
    up = found.irradiance[:, 0] > 0
    exact = under_a_point(found.corners[up], place)
    np.testing.assert_allclose(found.irradiance[up, 0], exact, rtol=0.005)
    # The brightest place, which has 1 / h², is not blurred.
    assert found.irradiance.max() > 0.9 / place[1] ** 2


def test_spots_and_balls_are_followed_as_points_are() -> None:
    lights = [
        iso.SpotLight.of_intensity((3.0, 0.2, -2.0), 1.0, cone_degrees=160),
        iso.SphereLight(radius=0.02, radiance=1 / (np.pi * 0.02**2)).at((3.0, 0.2, -2.0)),
    ]
    for light in lights:
        found = iso.radiosity(iso.Scene([floor(30.0)], lights=[light]), progress=False)
        assert found.irradiance.max() == pytest.approx(25.0, rel=0.1)
        assert found.areas[found.irradiance[:, 0].argmax()] < 0.05**2


def test_shadows_of_a_point_have_the_part_that_is_lit() -> None:
    # A sheet half as high as the light shades a square twice its size; patches at the rim are lit in part.
    sheet = iso.Item(
        iso.Mesh([(-0.2, 0.5, 0.25), (0.3, 0.5, 0.25), (0.3, 0.5, -0.3), (-0.2, 0.5, -0.3)], [(0, 1, 2, 3)]),
        iso.Emitter(0.0),
    )
    scene = iso.Scene([floor(2.0), sheet], lights=[iso.PointLight((0, 1, 0), power=4 * np.pi)])
    found = iso.radiosity(scene, iso.Radiosity(patch=0.05), progress=False)
    up = (found.item == 0) & (found.irradiance[:, 0] > 0)
    ground = found.corners[up]
    low, high = ground[..., [0, 2]].min(axis=1), ground[..., [0, 2]].max(axis=1)
    shade = np.array([(-0.4, -0.6), (0.6, 0.5)])
    size = np.clip(np.minimum(high, shade[1]) - np.maximum(low, shade[0]), 0, None)
    lit = 1 - size.prod(axis=1) / (high - low).prod(axis=1)
    rim = (lit > 0.05) & (lit < 0.95)
    assert rim.sum() > 50
    middle = ground.mean(axis=1)
    exact = lit / (1 + middle[:, 0] ** 2 + middle[:, 2] ** 2) ** 1.5
    # Patches at the rim are small, and light changes little over them but for the shadow.
    np.testing.assert_allclose(found.irradiance[up, 0][rim], exact[rim], rtol=0.03, atol=0.003)
    assert np.sqrt(found.areas[up][rim]).max() < 0.1
