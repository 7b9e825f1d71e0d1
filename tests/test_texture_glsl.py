"""Procedural textures as GLSL: the same values as in renderings, kind by kind."""

from __future__ import annotations

import numpy as np
import pytest

import isophote as iso
from shaders import values

PLACES = np.random.default_rng(8).uniform(-3, 3, (4000, 3)).astype(np.float32)
TURN = iso.Transform.identity().scale(0.6).rotate((1, 2, 3), 0.7).translate((0.3, -0.2, 0.5))

TEXTURES = {
    "checker": iso.Checker(0.1, 0.9, 0.7),
    "stripes": iso.Stripes(0.2, iso.PerlinNoise(), 0.7, (1, 2, 2), 0.3),
    "grid": iso.Grid(size=0.7, width=0.2),
    "gradient": iso.Gradient([(-1, 0.2), (0.3, 0.9), (0.3, 0.1), (2, 0.5)], "linear", (1, 1, 0), between="smooth"),
    "angular": iso.Gradient([0.1, 0.9], "angular", "z"),
    "radial": iso.Waves("radial", "triangle", 0.8, "y", iso.SimplexNoise(), 0.6),
    "spherical": iso.Waves("spherical", "saw", 0.8),
    "value": iso.ValueNoise(size=0.6, seed=0xFEDCBA98),
    "perlin": iso.PerlinNoise(seed=3),
    "simplex": iso.SimplexNoise(size=1.3, seed=5),
    "worley": iso.WorleyNoise(seed=9),
    "borders": iso.WorleyNoise(seed=9, feature="f2-f1", metric="manhattan", jitter=0.7),
    "cells": iso.WorleyNoise(seed=9, feature="cell", metric="chebyshev"),
    "fbm": iso.Fbm(octaves=5),
    "turbulence": iso.Fbm(iso.ValueNoise(size=0.7), 4, kind="turbulence", lacunarity=2.1),
    "ridged": iso.Fbm(iso.SimplexNoise(), 4, 0.6, kind="ridged"),
    "ramp": iso.Ramp(iso.PerlinNoise(), [(0.3, 0.1), (0.5, 0.8), (0.7, 0.3)]),
    "placed": iso.PerlinNoise(transform=TURN),
    "world": iso.PerlinNoise(space="world", transform=TURN),
    "marble": iso.Marble(),
    "wood": iso.Wood(size=0.3),
    "formula": iso.Formula(lambda p: 0.5 + 0.5 * np.sin(3 * p[:, 0]) * p[:, 1] / 3, [0.0, 1.0]),
    "colours": iso.Formula(lambda p: np.stack([np.abs(p[:, 1]) / 3, p[:, 0], p[:, 2]], axis=1)),
    "isolines": iso.FieldTexture(iso.sphere(1.0) | iso.box(1.3), [0.2, 0.9], period=0.5),
}


@pytest.mark.parametrize("name", TEXTURES)
def test_shaders_have_the_same_values(name: str) -> None:
    texture = TEXTURES[name]
    source = f"{iso.texture_glsl(texture, 'colour')}\nfloat red(vec3 p) {{ return colour(p, p.xy, p).r; }}"
    found = values(source, "red", PLACES)
    expected = iso.texture_values(texture, uv=PLACES[:, :2], own=PLACES)[:, 0]
    # At hard edges, and where cells meet, rounding may take either side.
    assert (np.abs(found - expected) > 2e-4).mean() < 0.004
    assert np.median(np.abs(found - expected)) < 2e-6
    assert expected.std() > 0.02


def test_texture_coordinates_are_given_by_themselves() -> None:
    source = str(iso.texture_glsl(iso.PerlinNoise(space="uv"), "colour"))
    found = values(source + "\nfloat red(vec3 p) { return colour(vec3(0.0), p.xy, vec3(0.0)).r; }", "red", PLACES)
    expected = iso.texture_values(iso.PerlinNoise(space="uv"), uv=PLACES[:, :2])[:, 0]
    np.testing.assert_allclose(found, expected, atol=2e-6)


def test_pictures_and_bad_names_are_refused() -> None:
    with pytest.raises(iso.SceneError, match="has no formula"):
        iso.texture_glsl(iso.Ramp(iso.ImageTexture(np.zeros((1, 1), np.float32))))
    with pytest.raises(iso.SceneError, match="no name of a GLSL function"):
        iso.texture_glsl(iso.PerlinNoise(), "two words")
    with pytest.raises(iso.SceneError, match="no mere formula"):
        iso.texture_glsl(iso.FieldTexture(iso.distance_field(iso.to_mesh(iso.sphere(1), cell=0.5))))
