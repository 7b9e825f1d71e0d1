"""What the camera sees first, averaged over pixels as the reconstruction filter does: guides for denoising."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.kernels.base.table import Packed
from isophote.rendering.denoise import nearness
from isophote.rendering.method import Size, first_hit_channels
from isophote.rendering.pixel_filter import PixelFilter, filter_table
from isophote.rendering.pool import Pool

__all__ = ["PLACES", "mean_features"]

Array: TypeAlias = npt.NDArray[Any]

PLACES = 16
"""Places in a pixel and on the lens, and times, that features are means over."""

# Steps of a lattice that has each of 16 even places along each of its dimensions: film, lens and time.
_STEPS, _TIME_STEP = (1, 7, 5, 11), 3
_DARK = 0.01


def mean_features(scenes: Sequence[Packed], size: Size, chosen: PixelFilter, threads: int | None) -> dict[str, Array]:
    """Means over 16 places of each pixel and of the lens: "albedo", "normal" (h, w, 3) and "nearness" (h, w). `scenes`
    are one, or what moves at `PLACES` even times.

    What reflects nothing has the albedo 1. "albedo variance" and so on are the variances of these means.
    """
    pool = Pool(threads)
    offsets = filter_table(chosen).offsets
    steps = np.linspace(0, 1, len(offsets))
    sums: dict[str, Array] = {}
    for k in range(PLACES):
        u = [(k * step % PLACES + 0.5) / PLACES for step in _STEPS]
        x, y = (0.5 + float(np.interp(value, steps, offsets)) for value in u[:2])
        radius, angle = math.sqrt(u[2]), 2 * math.pi * u[3]
        lens = radius * math.cos(angle), radius * math.sin(angle)
        for name, values in _features(scenes[_TIME_STEP * k % len(scenes)], size, (x, y, *lens), pool).items():
            total, squares = sums.setdefault(name, np.zeros((2, *values.shape)))
            total += values
            squares += values.astype(np.float64) ** 2
    if pool.interrupted:
        raise KeyboardInterrupt
    found: dict[str, Array] = {}
    for name, (total, squares) in sums.items():
        mean = total / PLACES
        found[name] = mean.astype(np.float32)
        found[f"{name} variance"] = (np.maximum(squares / PLACES - mean**2, 0) / (PLACES - 1)).astype(np.float32)
    return found


def _features(scene: Packed, size: Size, place: tuple[float, float, float, float], pool: Pool) -> dict[str, Array]:
    channels = first_hit_channels(scene, size, pool, place, PLACES)
    albedo = channels["albedo"]
    dark = albedo.max(axis=2, keepdims=True) < _DARK
    return {
        "albedo": np.where(dark, np.float32(1), albedo),
        "normal": channels["normal"],
        "nearness": nearness(channels["depth"]),
    }
