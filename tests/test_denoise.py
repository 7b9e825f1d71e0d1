"""Denoising: what it takes away, what it leaves alone, and that it is the sum that it says it is."""

from __future__ import annotations

import importlib.util
import sys
from types import SimpleNamespace

import numpy as np
import pytest

import isophote as iso
from isophote.errors import RenderError
from isophote.kernels.light.denoise import DENOISE, SCRATCH_PLANES, denoise_tile
from isophote.lower.scene import lower_scene
from isophote.rendering import denoise
from isophote.rendering.features import mean_features
from scenes import box, icosphere, plane, render

RNG = np.random.default_rng(11)
ITEMS = [
    iso.Item(plane(8), iso.Matte((0.7, 0.5, 0.3))),
    iso.Item(icosphere(3, 0.6, smooth=True), iso.Matte((0.3, 0.6, 0.7))).translate((0.7, 0.6, 0.3)),
    iso.Item(box(0.9), iso.Matte((0.9, 0.2, 0.2))).rotate("y", 0.4).translate((-0.8, 0.46, 0)),
]
LIGHTS = [iso.RectLight(size=(1, 1), power=60).at((0, 2.5, 0)), iso.Sky(strength=0.2)]
CAMERA = iso.Camera((0, 2, 5), (0, 0.5, 0))


def rmse(a: np.ndarray, b: np.ndarray) -> float:
    return float(np.sqrt(np.mean((a.astype(np.float64) - b) ** 2)))


def noisy(clean: np.ndarray, deviation: float, **channels: np.ndarray) -> iso.Image:
    """A picture with noise of a known variance."""
    noise = RNG.normal(0, deviation, clean.shape).astype(np.float32)
    return iso.Image({"colour": clean + noise, "variance": np.full_like(clean, deviation**2), **channels})


# --- the sum --------------------------------------------------------------------------------------


def by_definition(colour, variance, feature, spread, scale, search, patch, strength):
    """The kernel's formula, pixel by pixel, of (h, w, k) arrays; patches go on beyond the border."""
    border = search + patch
    height, width = colour.shape[:2]
    c, v, f, s = (
        np.pad(a, [(border, border)] * 2 + [(0, 0)], mode="edge").astype(np.float64)
        for a in (colour, variance, feature, spread)
    )
    result = np.zeros(colour.shape)
    for y in range(height):
        for x in range(width):
            total, weights = np.zeros(3), 0.0
            for dy in range(-search, search + 1):
                for dx in range(-search, search + 1):
                    if not (0 <= y + dy < height and 0 <= x + dx < width):
                        continue
                    py, px = y + border, x + border
                    own = np.s_[py - patch : py + patch + 1, px - patch : px + patch + 1]
                    other = np.s_[py + dy - patch : py + dy + patch + 1, px + dx - patch : px + dx + patch + 1]
                    difference = (c[own] - c[other]) ** 2 - (v[own] + np.minimum(v[own], v[other]))
                    d = (difference / (1e-10 + strength**2 * (v[own] + v[other]))).mean()
                    a, b = (py, px), (py + dy, px + dx)
                    of_features = ((f[a] - f[b]) ** 2 - (s[a] + np.minimum(s[a], s[b]))) * scale[y, x]
                    w = max(0.0, 1 - max(0.0, d, of_features.max()) / 8) ** 8
                    total, weights = total + w * c[b], weights + w
            result[y, x] = total / weights
    return result


def test_the_kernel_is_the_sum_that_it_says_it_is():
    colour, feature = RNG.random((9, 11, 3)).astype(np.float32), RNG.random((9, 11, 2)).astype(np.float32)
    variance, spread = RNG.random((9, 11, 3)).astype(np.float32) * 0.2, RNG.random((9, 11, 2)).astype(np.float32) * 0.1
    scale = RNG.random((9, 11, 2)).astype(np.float32) * 9
    search, patch, strength = 3, 1, 0.7
    border = search + patch

    def planes(a):
        padded = np.pad(a, [(border, border)] * 2 + [(0, 0)], mode="edge")
        return np.ascontiguousarray(np.moveaxis(padded, 2, 0)).reshape(-1, 11 + 2 * border)

    inside = np.pad(np.ones((9, 11), np.float32), border)
    result = np.zeros((3 * (9 + 2 * border), 11 + 2 * border), np.float32)
    arrays = {"colour": colour, "variance": variance, "feature": feature, "spread": spread, "scale": scale}
    packed = DENOISE.pack(
        height=9 + 2 * border,
        search=search,
        patch=patch,
        strength=strength**2,
        inside=inside,
        result=result,
        scratch=np.zeros(SCRATCH_PLANES * 11 * 13, np.float32),
        **{name: planes(a) for name, a in arrays.items()},
    )
    for x0, x1, y0, y1 in ((0, 6, 0, 9), (6, 11, 0, 4), (6, 11, 4, 9)):
        denoise_tile(packed.words, 0, x0 + border, x1 + border, y0 + border, y1 + border)
    found = np.moveaxis(result.reshape(3, 9 + 2 * border, -1), 0, 2)[border:-border, border:-border]
    expected = by_definition(colour, variance, feature, spread, scale, search, patch, strength)
    assert np.abs(found - expected).max() < 2e-5
    assert np.abs(expected - colour).max() > 0.1


# --- what is taken away, and what is left ---------------------------------------------------------


def test_flat_noise_is_averaged_away():
    clean = np.full((80, 90, 3), 0.5, np.float32)
    image = noisy(clean, 0.1)
    found = image.denoised("filter").channels["colour"]
    assert rmse(found, clean) < 0.15 * rmse(image.channels["colour"], clean)
    assert found.mean() == pytest.approx(image.channels["colour"].mean(), rel=2e-3)


def test_what_has_no_noise_stays_as_it_is():
    colour = RNG.random((40, 50, 3)).astype(np.float32)
    image = iso.Image({"colour": colour, "variance": np.zeros_like(colour)})
    assert np.array_equal(image.denoised("filter").channels["colour"], colour)
    flat = iso.Image({"colour": np.full_like(colour, 0.3), "variance": np.full_like(colour, 0.01)})
    assert np.allclose(flat.denoised("filter").channels["colour"], 0.3, rtol=1e-5)


def test_textures_and_edges_of_features_are_kept():
    """A chequer of albedo, and a step of the light where the normal turns: noise goes, neither is blurred."""
    y, x = np.mgrid[:64, :64]
    albedo = np.where((x // 4 + y // 4) % 2, 0.9, 0.3)[..., None] * np.ones(3)
    left = (x < 30)[..., None]
    light = np.where(left, 1.0, 0.5)
    normal = np.where(left, (1.0, 0, 0), (0, 1.0, 0))
    clean = (albedo * light).astype(np.float32)
    image = noisy(clean, 0.15, albedo=albedo, normal=normal)
    found = image.denoised("filter").channels["colour"]
    assert rmse(found, clean) < 0.2 * 0.15
    # On either side of each edge, and of the step: as far apart as they were.
    for edge in (28, 29, 30, 31, 32):
        assert np.allclose(found[:, edge].mean(axis=0), clean[:, edge].mean(axis=0), rtol=0.05)
    blind = iso.Image({name: image.channels[name] for name in ("colour", "variance")}).denoised("filter")
    assert rmse(blind.channels["colour"], clean) > 2 * rmse(found, clean)


def test_strong_edges_of_colour_are_kept_without_features():
    x = np.arange(64)
    clean = np.repeat(np.where(x < 32, 0.2, 1.0)[None, :, None], 64, axis=0).repeat(3, axis=2).astype(np.float32)
    image = noisy(clean, 0.05)
    found = image.denoised("filter").channels["colour"]
    assert np.abs(found.mean(axis=0) - clean.mean(axis=0)).max() < 0.03
    assert rmse(found, clean) < 0.3 * 0.05


@pytest.mark.parametrize("samples", [4, 16])
@pytest.mark.parametrize("method", [iso.PathTrace, iso.RayTrace])
def test_rendered_pictures_come_closer_to_the_truth(samples, method):
    scene = iso.Scene(ITEMS, LIGHTS, CAMERA)
    common = {"size": (96, 72), "progress": False}
    settings = {"light_samples": 1} if method is iso.RayTrace else {}
    truth = iso.render(scene, method(samples=1024, **settings), seed=9, **common).channels["colour"]
    image = iso.render(scene, method(samples=samples, **settings), seed=1, **common)
    cleaner = iso.render(scene, method(samples=samples, **settings), seed=1, denoise="filter", **common)
    before, own = rmse(image.channels["colour"], truth), rmse(image.denoised("filter").channels["colour"], truth)
    after = rmse(cleaner.channels["colour"], truth)
    limit = 0.75 if method is iso.PathTrace else 1.0
    assert after < limit * before
    assert own < 0.95 * before
    assert cleaner.channels["colour"].mean() == pytest.approx(image.channels["colour"].mean(), rel=0.01)
    assert cleaner.metadata["denoised"] == "by Isophote's filter"
    assert "variance" not in cleaner.channels
    assert np.array_equal(cleaner.channels["depth"], image.channels["depth"])


def test_neither_threads_nor_tiles_change_the_result(monkeypatch):
    image = render(ITEMS, LIGHTS, CAMERA, samples=4, size=(70, 45))
    first = image.denoised("filter", threads=1)
    assert image.denoised("filter", threads=3) == first
    for tile in (7, 200):
        monkeypatch.setattr(denoise, "_TILE", tile)
        assert image.denoised("filter", threads=2) == first


def test_pixels_that_are_no_numbers_do_not_spread():
    clean = np.full((30, 30, 3), 0.5, np.float32)
    image = noisy(clean, 0.05)
    colour, variance = image.channels["colour"].copy(), image.channels["variance"].copy()
    colour[10, 10], variance[10, 10] = np.nan, np.nan
    colour[20, 20], variance[20, 20] = np.inf, np.inf
    found = iso.Image({"colour": colour, "variance": variance}).denoised("filter").channels["colour"]
    assert np.isfinite(found).all()
    away = np.ones((30, 30), bool)
    away[10, 10] = away[20, 20] = False
    assert np.abs(found[away] - 0.5).max() < 0.08


# --- features -------------------------------------------------------------------------------------


def test_mean_features_are_those_of_many_places():
    """A half-covered pixel has half of each side's albedo; a pixel of one thing has what its middle has."""
    edge = iso.Item(plane(40), iso.Matte((0.8, 0.4, 0.2))).translate((-20, 0, 0))
    camera = iso.OrthographicCamera((0, 3, 0), (0, 0, 0), up=(0, 0, -1), height=1)
    scene = iso.Scene([edge], [iso.Sky()], camera)
    found = mean_features([lower_scene(scene, (9, 9), None)], (9, 9), iso.PixelFilter("box"), None)
    assert np.allclose(found["albedo"][:, :4], (0.8, 0.4, 0.2), atol=1e-6)
    assert np.allclose(found["albedo"][:, 5:], 1)
    assert np.allclose(found["albedo"][:, 4], (0.9, 0.7, 0.6), atol=0.05)
    assert np.allclose(found["normal"][:, :4], (0, 1, 0), atol=1e-6)
    assert not found["albedo variance"][:, :4].any()
    assert (found["albedo variance"][:, 4] > 5e-4).all()


# --- Open Image Denoise, and input ----------------------------------------------------------------


def test_open_image_denoise_is_given_what_it_takes(monkeypatch):
    given = {}

    def stand_in(colour, **settings):
        given.update(settings, colour=colour)
        return colour * 0.5

    monkeypatch.setitem(sys.modules, "pyoidn", SimpleNamespace(denoise=stand_in, __spec__=SimpleNamespace()))
    scene = iso.Scene(ITEMS, LIGHTS, CAMERA)
    image = iso.render(scene, iso.PathTrace(2), size=(24, 16), seed=1, progress=False, denoise=True)
    assert image.metadata["denoised"] == "by Open Image Denoise"
    for name in ("colour", "albedo", "normal"):
        assert given[name].dtype == np.float32
        assert given[name].shape == (16, 24, 3)
        assert np.isfinite(given[name]).all()
    assert 0 <= given["albedo"].min() <= given["albedo"].max() <= 1
    assert given["hdr"] is True
    assert given["clean_aux"] is True
    assert np.array_equal(image.channels["colour"], given["colour"] * 0.5)


@pytest.mark.skipif(importlib.util.find_spec("pyoidn") is None, reason="Open Image Denoise is not installed")
def test_open_image_denoise_takes_noise_away():
    image = render(ITEMS, LIGHTS, CAMERA, samples=4, size=(96, 72))
    truth = render(ITEMS, LIGHTS, CAMERA, samples=1024, size=(96, 72), seed=9).channels["colour"]
    assert rmse(image.denoised("oidn").channels["colour"], truth) < 0.7 * rmse(image.channels["colour"], truth)


def test_denoisers_that_cannot_be_are_refused(monkeypatch):
    image = noisy(np.full((8, 8, 3), 0.5, np.float32), 0.1)
    with pytest.raises(RenderError, match="one of auto, filter, oidn"):
        image.denoised("magic")
    with pytest.raises(RenderError, match="one of auto, filter, oidn"):
        iso.render(box(), iso.PathTrace(1), size=(4, 4), denoise="strongly")
    with pytest.raises(RenderError, match="variance"):
        iso.Image({"colour": np.zeros((4, 4, 3))}).denoised("filter")
    monkeypatch.setattr(denoise, "_has_oidn", lambda: False)
    with pytest.raises(RenderError, match="isophote\\[denoise\\]"):
        image.denoised("oidn")
