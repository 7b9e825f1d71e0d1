"""Denoising of pictures: by Open Image Denoise where it is installed, else by our own filter."""

from __future__ import annotations

import importlib
import importlib.util
from collections.abc import Mapping
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.errors import RenderError
from isophote.kernels.light.denoise import DENOISE, SCRATCH_PLANES, denoise_tile
from isophote.rendering.pool import Pool, Tile, tiles_of

__all__ = ["DENOISERS", "can_be_denoised", "checked_denoiser", "denoised_colour", "nearness"]

Floats: TypeAlias = npt.NDArray[np.float32]
Channels: TypeAlias = Mapping[str, npt.NDArray[Any]]

DENOISERS = ("auto", "filter", "oidn")
# Reach of the search and of patches, in pixels; how much of the variance a difference may have (k above).
_SEARCH, _PATCH, _STRENGTH = 8, 1, 0.4
_TILE = 64
# What features may differ by, squared, where they do not vary by themselves.
_TOLERANCES = {"albedo": 0.02, "normal": 0.04, "nearness": 0.002}
_DARK = 0.01


def checked_denoiser(value: object) -> str | None:
    """The denoiser that `denoise=` asks for, None for none. Raises `RenderError` where that cannot be."""
    if value is False:
        return None
    name = "auto" if value is True else value
    if name not in DENOISERS:
        raise RenderError(f"denoise must be True, False or one of {', '.join(DENOISERS)}, not {value!r}")
    if name == "oidn" and not _has_oidn():
        raise RenderError('the denoiser "oidn" needs Open Image Denoise: pip install "isophote[denoise]"')
    return str(name)


def _has_oidn() -> bool:
    return importlib.util.find_spec("pyoidn") is not None


def can_be_denoised(channels: Channels, denoiser: str) -> bool:
    """Whether a picture with these channels tells a denoiser what it asks for."""
    return "variance" in channels or denoiser == "oidn" or (denoiser == "auto" and _has_oidn())


def denoised_colour(
    channels: Channels, features: Channels | None = None, *, denoiser: str = "auto", threads: int | None = None
) -> tuple[Floats, str]:
    """The colour (h, w, 3) with less noise, and what took it away.

    `channels` are those of a picture, with "variance" of the mean; `features` (of `mean_features`) are used before its
    own. Raises `RenderError` for unknown denoisers, one that is not installed, and pictures without a variance.
    """
    name = checked_denoiser(denoiser)
    known = {**channels, **(features or {})}
    if name == "oidn" or (name == "auto" and _has_oidn()):
        return _by_oidn(known, clean=features is not None), "Open Image Denoise"
    if "variance" not in channels:
        raise RenderError('a picture without the channel "variance" does not tell what is noise in it')
    return _by_filter(known, Pool(threads)), "Isophote's filter"


def _by_oidn(channels: Channels, *, clean: bool) -> Floats:
    oidn = importlib.import_module("pyoidn")
    colour = np.nan_to_num(np.maximum(channels["colour"], 0), posinf=0.0)
    guides = {name: channels[name] for name in ("albedo", "normal") if name in channels}
    if "albedo" in guides:
        guides["albedo"] = np.clip(guides["albedo"], 0, 1)
    else:
        # Normals alone are not taken.
        guides = {}
    result: Floats = oidn.denoise(colour, **guides, hdr=True, clean_aux=clean and bool(guides))
    return result


def _by_filter(channels: Channels, pool: Pool) -> Floats:
    colour, variance = _mended(channels["colour"]), _mended(channels["variance"])
    albedo = _demodulating(channels)
    spread = _blurred(variance / albedo**2)
    result = _filtered(colour / albedo, spread, _feature_planes(channels, albedo), pool)
    # Without variance there is no noise.
    return np.where(spread.any(axis=2, keepdims=True), result * albedo, colour)


def _mended(values: npt.NDArray[Any]) -> Floats:
    """(h, w, k) where what is no number, or infinite, is the mean of its neighbours that are; 0 where none is."""
    given = np.asarray(values, np.float32)
    good = np.isfinite(given)
    if good.all():
        return given
    known = np.where(good, given, np.float32(0))
    share = _blurred(_blurred(good.astype(np.float32)))
    near = _blurred(_blurred(known)) / np.maximum(share, np.float32(1e-6))
    return np.where(good, given, near)


def _demodulating(channels: Channels) -> Floats:
    """(h, w, 3): what the colour is divided by, so that textures are not blurred: the albedo, 1 where it is dark."""
    shape = channels["colour"].shape
    if "albedo" not in channels:
        return np.ones(shape, np.float32)
    albedo = np.asarray(channels["albedo"], np.float32)
    dark = albedo.max(axis=2, keepdims=True) < _DARK
    return np.where(dark, np.float32(1), np.maximum(albedo, np.float32(_DARK)))


class _Features(NamedTuple):
    """(h, w, k) features, their variances, and the inverse squares of what they may differ by."""

    values: Floats
    spread: Floats
    scale: Floats


def _feature_planes(channels: Channels, albedo: Floats) -> _Features:
    features: list[Floats] = []
    spreads: list[Floats] = []
    scales: list[Floats] = []
    given = {"albedo": albedo, **{name: channels[name] for name in ("normal", "nearness") if name in channels}}
    if "nearness" not in given and "depth" in channels:
        given["nearness"] = nearness(channels["depth"])
    for name, values in given.items():
        planes = np.asarray(values, np.float32).reshape(*albedo.shape[:2], -1)
        spread = np.asarray(channels.get(f"{name} variance", np.zeros_like(planes)), np.float32).reshape(planes.shape)
        # A feature may differ as much as it does from one pixel to the next.
        features.append(planes)
        spreads.append(_blurred(spread))
        least = np.full_like(planes, _TOLERANCES[name])
        scales.append(np.reciprocal(np.maximum(np.maximum(_slope(planes), spreads[-1]), least)))
    return _Features(*(np.concatenate(parts, axis=2) for parts in (features, spreads, scales)))


def nearness(depth: npt.NDArray[Any]) -> Floats:
    """(h, w): the depth's inverse, in parts of its median; 0 where nothing is met."""
    inverse = np.where(np.isfinite(depth) & (depth > 0), 1 / np.maximum(depth, 1e-30), 0)
    middle = float(np.median(inverse[inverse > 0])) if (inverse > 0).any() else 1.0
    return (inverse / middle).astype(np.float32)


def _slope(planes: Floats) -> Floats:
    """(h, w, k): square of half the difference between the pixels on either side, along the steeper axis."""
    padded = np.pad(planes, [(1, 1), (1, 1), (0, 0)], mode="edge")
    down, across = padded[2:, 1:-1] - padded[:-2, 1:-1], padded[1:-1, 2:] - padded[1:-1, :-2]
    slope: Floats = np.maximum(down**2, across**2) / np.float32(4)
    return slope


def _blurred(values: Floats) -> Floats:
    """Mean over 3 × 3 pixels of (h, w, k)."""
    for axis in (0, 1):
        padded = np.pad(values, [(1, 1) if k == axis else (0, 0) for k in range(3)], mode="edge")
        size = values.shape[axis]
        values = np.mean([np.take(padded, range(k, k + size), axis) for k in range(3)], axis=0, dtype=np.float32)
    return values


def _filtered(colour: Floats, variance: Floats, features: _Features, pool: Pool) -> Floats:
    """`kernels.light.denoise` over the whole picture."""
    border = _SEARCH + _PATCH
    height, width = colour.shape[:2]

    def planes(values: Floats) -> Floats:
        """(h, w, k) as k padded planes below each other."""
        padded = np.pad(values, [(border, border), (border, border), (0, 0)], mode="edge")
        return np.ascontiguousarray(np.moveaxis(padded, 2, 0), np.float32).reshape(-1, width + 2 * border)

    inside = np.zeros((height + 2 * border, width + 2 * border), np.float32)
    inside[border:-border, border:-border] = 1
    result = np.zeros((3 * (height + 2 * border), width + 2 * border), np.float32)
    words = SCRATCH_PLANES * (_TILE + 2 * _PATCH) ** 2
    packed = DENOISE.pack(
        height=height + 2 * border,
        search=_SEARCH,
        patch=_PATCH,
        strength=_STRENGTH**2,
        colour=planes(colour),
        variance=planes(variance),
        feature=planes(features.values),
        spread=planes(features.spread),
        scale=planes(features.scale),
        inside=inside,
        result=result,
        scratch=np.zeros(words * pool.threads, np.float32),
    )

    def work(tile: Tile, thread: int) -> None:
        x0, x1, y0, y1 = (edge + border for edge in tile)
        denoise_tile(packed.words, words * thread, x0, x1, y0, y1)

    pool.run(work, tiles_of((width, height), _TILE), lambda done: None)
    if pool.interrupted:
        raise KeyboardInterrupt
    whole = result.reshape(3, height + 2 * border, width + 2 * border)
    return np.ascontiguousarray(np.moveaxis(whole[:, border:-border, border:-border], 0, 2))
