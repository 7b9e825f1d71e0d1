"""Textures that are formulas, in pictures and at places: patterns, mixtures, ramps, spaces, and what is refused."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest

import isophote as iso

Floats = npt.NDArray[np.float64]

RNG = np.random.default_rng(3)
PLACES = RNG.uniform(-4, 4, (500, 3)).astype(np.float32)


def red(texture: iso.Texture, own: npt.ArrayLike = PLACES, **more: npt.ArrayLike) -> npt.NDArray[np.float32]:
    return iso.texture_values(texture, own=own, **more)[:, 0]


def picture(items: list[iso.Item], camera: iso.Camera, method: object = None) -> npt.NDArray[np.float32]:
    """The albedo that is seen."""
    scene = iso.Scene(items, [iso.Sky("white", 1.0)], camera)
    return iso.render(scene, method or iso.PathTrace(samples=1), size=(48, 36), seed=1).channels["albedo"]


def test_checkers_alternate_along_all_axes() -> None:
    cells = np.floor(PLACES + 2.0**-10).sum(axis=1) % 2
    expected = np.where(cells[:, None] == 0, (1.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    found = iso.texture_values(iso.Checker((1, 0, 0), (0, 0, 1)), own=PLACES)
    np.testing.assert_array_equal(found[:, :3], expected)


def test_ground_with_checkers_has_one_colour_in_each_square() -> None:
    ground = iso.Item(iso.plane(), iso.Matte(iso.Checker("white", "black")))
    seen = picture([ground], iso.Camera((0.5, 3, 0.5), (0.5, 0, 0.5), up=(0, 0, -1), fov_degrees=12))
    np.testing.assert_array_equal(seen, 1.0)


@pytest.mark.parametrize("shape", [iso.box(1.0), iso.to_mesh(iso.box(1.0), cell=0.2)], ids=["field", "mesh"])
def test_patterns_go_with_their_item(shape: iso.Field | iso.Mesh) -> None:
    noise = iso.Matte(iso.PerlinNoise(size=0.3))
    turn = iso.Transform.identity().rotate((1, 2, 3), 0.8).translate((5, -2, 1))
    eye, target = turn.apply([[2, 1.5, 2.5], [0, 0, 0]])
    moved = iso.Camera(eye, target, up=turn.matrix[:3, 1], fov_degrees=35)
    still = iso.Camera((2, 1.5, 2.5), (0, 0, 0), fov_degrees=35)
    here = picture([iso.Item(shape, noise)], still)
    there = picture([iso.Item(shape, noise, turn)], moved)
    assert here.std() > 0.02
    # Both have their own rounding, and pixels at edges may see one face or the other.
    assert np.median(np.abs(here - there)) < 1e-5
    assert (np.abs(here - there) > 1e-3).mean() < 0.01
