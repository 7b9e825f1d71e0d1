"""Pictures looked up: known texels by wrap mode, filter, encoding and channel, beside the definition in NumPy."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest

import isophote as iso
from isophote.scene.colour import srgb_to_linear

Floats = npt.NDArray[np.float64]

WIDTH, HEIGHT = 5, 3
RNG = np.random.default_rng(7)
BYTES = RNG.integers(0, 256, (HEIGHT, WIDTH, 4)).astype(np.uint8)
FLOATS = RNG.uniform(0, 2, (HEIGHT, WIDTH, 4)).astype(np.float32)
PLACES = RNG.uniform(-3, 3, (400, 2)).astype(np.float32)


def linear(pixels: npt.NDArray[np.generic], space: str) -> Floats:
    """(h, w, 4): red, green, blue and alpha as light."""
    values = pixels.astype(np.float64) / (255 if pixels.dtype == np.uint8 else 1)
    values = values.reshape(*values.shape[:2], -1)
    colour = values[..., :3].repeat(3 if values.shape[2] == 1 else 1, axis=2)
    colour = srgb_to_linear(colour) if space == "srgb" else colour
    alpha = values[..., 3:] if values.shape[2] == 4 else np.ones((*values.shape[:2], 1))
    return np.concatenate([colour, alpha], axis=2)


def wrapped(i: npt.NDArray[np.int64], size: int, wrap: str) -> npt.NDArray[np.int64]:
    if wrap == "clamp":
        return np.clip(i, 0, size - 1)
    if wrap == "repeat":
        return i % size
    return np.where(i % (2 * size) < size, i % size, size - 1 - i % size)


def texels(values: Floats, x: npt.NDArray[np.int64], y: npt.NDArray[np.int64], wrap: str) -> Floats:
    height, width = values.shape[:2]
    return values[wrapped(y, height, wrap), wrapped(x, width, wrap)]


def nearest(values: Floats, uv: Floats, wrap: str) -> Floats:
    x, y = uv[:, 0] * values.shape[1], (1 - uv[:, 1]) * values.shape[0]
    return texels(values, np.floor(x).astype(int), np.floor(y).astype(int), wrap)


def bilinear(values: Floats, uv: Floats, wrap: str) -> Floats:
    x, y = uv[:, 0] * values.shape[1] - 0.5, (1 - uv[:, 1]) * values.shape[0] - 0.5
    i, j = np.floor(x).astype(int), np.floor(y).astype(int)
    a, b = (x - i)[:, None], (y - j)[:, None]
    top = texels(values, i, j, wrap) * (1 - a) + texels(values, i + 1, j, wrap) * a
    low = texels(values, i, j + 1, wrap) * (1 - a) + texels(values, i + 1, j + 1, wrap) * a
    return top * (1 - b) + low * b


@pytest.mark.parametrize("wrap", ["repeat", "clamp", "mirror"])
@pytest.mark.parametrize("space", ["srgb", "linear"])
@pytest.mark.parametrize(
    "pixels", [BYTES, BYTES[..., :3], BYTES[..., 0], FLOATS], ids=["rgba", "rgb", "grey", "floats"]
)
def test_texels_are_those_of_the_definition(wrap: str, space: str, pixels: npt.NDArray[np.generic]) -> None:
    values, places = linear(pixels, space), PLACES.astype(np.float64)
    picture = iso.ImageTexture(pixels, space, wrap, "bilinear")
    np.testing.assert_allclose(iso.texture_values(picture, PLACES), bilinear(values, places, wrap), atol=2e-5)
    picture = iso.ImageTexture(pixels, space, wrap, "nearest")
    found = iso.texture_values(picture, PLACES)
    # Places that rounding could put into the next texel are left out.
    inner = (np.abs((places * [WIDTH, HEIGHT]) % 1 - 0.5) < 0.499).all(axis=1)
    assert inner.sum() > 300
    np.testing.assert_allclose(found[inner], nearest(values, places, wrap)[inner], atol=2e-6)


def test_centres_of_pixels_show_the_pixels_themselves() -> None:
    x, y = np.meshgrid(np.arange(WIDTH), np.arange(HEIGHT))
    uv = np.stack([(x + 0.5) / WIDTH, 1 - (y + 0.5) / HEIGHT], axis=-1).reshape(-1, 2)
    for kind in ("nearest", "bilinear"):
        found = iso.texture_values(iso.ImageTexture(BYTES, "linear", "clamp", kind), uv)
        np.testing.assert_allclose(found.reshape(HEIGHT, WIDTH, 4), BYTES / 255, atol=1e-5)


def test_one_place_and_many() -> None:
    picture = iso.ImageTexture(BYTES)
    many = np.tile(np.float32([[0.3, 0.6]]), (70_000, 1))
    assert (iso.texture_values(picture, many) == iso.texture_values(picture, (0.3, 0.6))).all()
    assert iso.texture_values(picture).shape == (1, 4)
    assert iso.texture_values(picture, own=np.zeros((5, 3))).shape == (5, 4)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"uv": np.zeros((3, 3))}, r"uv must be \(n, 2\) or \(2\)"),
        ({"uv": np.zeros((3, 2)), "own": np.zeros((4, 3))}, r"\[3, 4\] numbers"),
        ({"uv": [np.nan, 0]}, "uv must be finite"),
        ({"uv": "here"}, "uv must be numbers"),
        ({"uv_axes": np.zeros((2, 3))}, r"uv_axes must be \(n, 2, 2\)"),
    ],
)
def test_what_makes_no_sense_is_told(given: dict[str, object], said: str) -> None:
    with pytest.raises(iso.SceneError, match=said):
        iso.texture_values(iso.ImageTexture(BYTES), **given)
