"""Pictures averaged over footprints: pyramids, and filters beside means by brute force."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import isophote as iso
from isophote.kernels.texture.contract import IN_FLOATS, PLAIN, SRGB
from isophote.lower.pictures import pyramid
from isophote.scene.colour import srgb_to_linear

Floats = npt.NDArray[np.float64]

FILTERED = ("trilinear", "ewa")
RNG = np.random.default_rng(5)


def halving(size: int) -> Floats:
    """(size // 2, size): shares of texels in halves of them, by the overlap of intervals."""
    n = max(size // 2, 1)
    edges, halves = np.arange(size + 1) / size, np.arange(n + 1) / n
    low = np.maximum(edges[None, :-1], halves[:-1, None])
    high = np.minimum(edges[None, 1:], halves[1:, None])
    return np.maximum(high - low, 0) * n


@given(st.integers(1, 21), st.integers(1, 21))
@settings(max_examples=30, deadline=None)
def test_levels_are_means_over_what_they_cover(width: int, height: int) -> None:
    texels = np.random.default_rng(width + 100 * height).random((height * width, 4)).astype(np.float32)
    levels = pyramid(texels, width, height, IN_FLOATS)
    assert len(levels) == 1 + int(np.floor(np.log2(max(width, height))))
    wanted = texels.reshape(height, width, 4).astype(np.float64)
    for level in levels:
        np.testing.assert_allclose(level.reshape(wanted.shape), wanted, atol=2e-6)
        np.testing.assert_allclose(level.mean(axis=0), texels.mean(axis=0, dtype=float), rtol=2e-6)
        wanted = np.einsum("yj,xi,jic->yxc", halving(wanted.shape[0]), halving(wanted.shape[1]), wanted)


@pytest.mark.parametrize("encoding", [SRGB, PLAIN])
def test_levels_of_bytes_are_means_of_light_rounded_once(encoding: int) -> None:
    texels = RNG.integers(0, 256, (24 * 17, 4)).astype(np.uint8)
    steps = np.arange(256) / 255
    decode = srgb_to_linear(steps) if encoding == SRGB else steps
    light = np.concatenate([decode[texels[:, :3]], steps[texels[:, 3:]]], axis=1)
    exact = pyramid(light.astype(np.float32), 24, 17, IN_FLOATS)
    for level, wanted in zip(pyramid(texels, 24, 17, encoding)[1:], exact[1:], strict=True):
        colours = np.interp(wanted[:, :3], decode, np.arange(256))
        assert np.abs(level[:, :3] - colours).max() <= 0.51
        assert np.abs(level[:, 3] - wanted[:, 3] * 255).max() <= 0.51


def values(texture: iso.ImageTexture, uv: object, a: object, b: object) -> npt.NDArray[np.float32]:
    return iso.texture_values(texture, uv, uv_axes=np.array([a, b], np.float32))


@pytest.mark.parametrize("kind", FILTERED)
@pytest.mark.parametrize("wrap", ["repeat", "mirror", "clamp"])
def test_what_is_the_same_everywhere_stays_so(kind: str, wrap: str) -> None:
    texture = iso.ImageTexture(np.full((13, 7, 4), (10, 200, 90, 128), np.uint8), wrap=wrap, filter=kind)
    wanted = [*srgb_to_linear(np.array([10, 200, 90]) / 255), 128 / 255]
    for size in (0.0, 1e-3, 0.03, 0.2, 1.0, 50.0, 1e18):
        found = values(texture, RNG.uniform(-2, 2, (50, 2)), (size, size / 3), (0.01 * size, -size / 20))
        np.testing.assert_allclose(found, np.tile(wanted, (50, 1)), atol=3e-3)


@pytest.mark.parametrize("kind", FILTERED)
def test_a_slope_is_seen_where_it_is_looked_at(kind: str) -> None:
    """A symmetric mean of a linear function is its value in the middle."""
    x, y = np.meshgrid((np.arange(128) + 0.5) / 128, 1 - (np.arange(128) + 0.5) / 128)
    texture = iso.ImageTexture(np.stack([x, y, x + y], -1).astype(np.float32), wrap="clamp", filter=kind)
    uv = RNG.uniform(0.35, 0.65, (200, 2))
    for a, b in [((0.01, 0.0), (0.0, 0.01)), ((0.03, 0.02), (-0.004, 0.006)), ((0.0, 0.02), (0.002, 0.0))]:
        found = values(texture, uv, a, b)
        # Ellipses that lie unevenly among few texels lean a little.
        np.testing.assert_allclose(found[:, :2], uv, atol=2.5e-3)


@pytest.mark.parametrize("kind", FILTERED)
def test_small_footprints_are_bilinear_and_large_ones_the_mean(kind: str) -> None:
    pixels, uv = RNG.integers(0, 256, (19, 30, 4)).astype(np.uint8), RNG.uniform(-2, 2, (100, 2))
    texture, plain = iso.ImageTexture(pixels, filter=kind), iso.ImageTexture(pixels, filter="bilinear")
    np.testing.assert_array_equal(values(texture, uv, (0.005, 0), (0, 0.005)), iso.texture_values(plain, uv))
    mean = [*srgb_to_linear(pixels[..., :3] / 255).mean(axis=(0, 1)), pixels[..., 3].mean() / 255]
    np.testing.assert_allclose(values(texture, uv, (3, 0), (0, 3)), np.tile(mean, (100, 1)), atol=5e-3)


AXES = {
    "round": ((0.02, 0.0), (0.0, 0.02)),
    "4 to 1": ((0.04, 0.0), (0.0, 0.01)),
    "12 to 1, aslant": ((0.06, 0.05), (-0.004, 0.005)),
    "sheared": ((0.04, 0.03), (0.03, 0.03)),
}


@pytest.mark.parametrize("name", AXES)
@pytest.mark.parametrize("wrap", ["repeat", "mirror", ("clamp", "repeat")])
def test_ellipses_give_about_the_mean_over_the_pixel(name: str, wrap: object) -> None:
    """Beside the mean over the parallelogram of the axes, of a picture with details of all sizes."""
    pixels = RNG.random((128, 128, 3)) * 0.5 + np.kron(RNG.random((16, 16, 3)), np.ones((8, 8, 1))) * 0.5
    texture = iso.ImageTexture(pixels.astype(np.float32), wrap=wrap)
    a, b = np.array(AXES[name])
    # The last texels of a clamped picture's means go on, which are not the last of the picture.
    uv = RNG.uniform(0.15, 0.85, (60, 2)) if isinstance(wrap, tuple) else RNG.uniform(-0.3, 1.3, (60, 2))
    steps = (np.arange(64) + 0.5) / 32 - 1
    offsets = (steps[:, None, None] * a + steps[None, :, None] * b).reshape(-1, 2)
    plain = iso.ImageTexture(texture.pixels, wrap=wrap, filter="bilinear")
    wanted = iso.texture_values(plain, (uv[:, None] + offsets).reshape(-1, 2)).reshape(60, -1, 4).mean(axis=1)
    found = values(texture, uv, a, b)
    error, spread = np.abs(found - wanted)[:, :3], iso.texture_values(plain, uv)[:, :3] - wanted[:, :3]
    assert np.sqrt((error**2).mean()) < 0.25 * np.sqrt((spread**2).mean())


def test_elliptical_means_beat_square_ones_where_pixels_are_long() -> None:
    pixels = RNG.random((256, 256, 3)).astype(np.float32)
    a, b = np.array([(0.05, 0.0), (0.0, 0.004)])
    uv = RNG.random((80, 2))
    steps = (np.arange(64) + 0.5) / 32 - 1
    offsets = (steps[:, None, None] * a + steps[None, :, None] * b).reshape(-1, 2)
    plain = iso.ImageTexture(pixels, filter="bilinear")
    wanted = iso.texture_values(plain, (uv[:, None] + offsets).reshape(-1, 2)).reshape(80, -1, 4).mean(axis=1)
    errors = {kind: values(iso.ImageTexture(pixels, filter=kind), uv, a, b) - wanted for kind in FILTERED}
    assert np.square(errors["ewa"]).mean() < 0.25 * np.square(errors["trilinear"]).mean()


@pytest.mark.parametrize("axes", [((0.01, 0), (0, 0.01)), ((0.05, 0.02), (0, 0.01)), ((0.2, 0.0), (0.01, 0.02))])
def test_a_repeated_picture_may_begin_anywhere(axes: tuple[object, object]) -> None:
    pixels = RNG.random((64, 64, 3)).astype(np.float32)
    uv = RNG.random((100, 2)).astype(np.float32)
    moved = np.roll(pixels, (-32, 32), axis=(0, 1))
    found = values(iso.ImageTexture(moved), uv + 0.5, *axes)
    np.testing.assert_allclose(found, values(iso.ImageTexture(pixels), uv, *axes), atol=2e-4)


def test_thin_pictures_and_long_footprints_end_soon() -> None:
    for shape in ((1, 4096, 3), (4096, 1, 3), (2, 1000, 3)):
        texture = iso.ImageTexture(RNG.random(shape).astype(np.float32))
        found = values(texture, RNG.random((500, 2)), (0.4, 30.0), (3.0, 0.2))
        assert np.isfinite(found).all()
        assert np.abs(found[:, 0] - texture.pixels[..., 0].mean()).max() < 0.3
