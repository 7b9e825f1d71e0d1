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
