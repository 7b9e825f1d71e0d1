"""What the camera sees first, averaged over pixels as the reconstruction filter does: guides for denoising."""

from __future__ import annotations

import math
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from isophote.kernels.base.table import Packed
from isophote.rendering.denoise import nearness
from isophote.rendering.method import Size, first_hit_channels
from isophote.rendering.pixel_filter import PixelFilter, filter_table
from isophote.rendering.pool import Pool

__all__ = ["mean_features"]

Array: TypeAlias = npt.NDArray[Any]

_PLACES = 16
# Steps of a lattice in four dimensions that has each of 16 even places along each of them.
_STEPS = (1, 7, 5, 11)
_DARK = 0.01


def mean_features(scene: Packed, size: Size, chosen: PixelFilter, threads: int | None) -> dict[str, Array]:
    """Means over 16 places of each pixel and of the lens: "albedo", "normal" (h, w, 3) and "nearness" (h, w).

    What reflects nothing has the albedo 1. "albedo variance" and so on are the variances of these means.
    """
    pool = Pool(threads)
    offsets = filter_table(chosen).offsets
    steps = np.linspace(0, 1, len(offsets))
    sums: dict[str, Array] = {}
    for k in range(_PLACES):
        u = [(k * step % _PLACES + 0.5) / _PLACES for step in _STEPS]
        x, y = (0.5 + float(np.interp(value, steps, offsets)) for value in u[:2])
        radius, angle = math.sqrt(u[2]), 2 * math.pi * u[3]
        lens = radius * math.cos(angle), radius * math.sin(angle)
        for name, values in _features(scene, size, (x, y, *lens), pool).items():
            total, squares = sums.setdefault(name, np.zeros((2, *values.shape)))
            total += values
            squares += values.astype(np.float64) ** 2
    if pool.interrupted:
        raise KeyboardInterrupt
    found: dict[str, Array] = {}
    for name, (total, squares) in sums.items():
        mean = total / _PLACES
        found[name] = mean.astype(np.float32)
        found[f"{name} variance"] = (np.maximum(squares / _PLACES - mean**2, 0) / (_PLACES - 1)).astype(np.float32)
    return found


def _features(scene: Packed, size: Size, place: tuple[float, float, float, float], pool: Pool) -> dict[str, Array]:
    channels = first_hit_channels(scene, size, pool, place)
    albedo = channels["albedo"]
    dark = albedo.max(axis=2, keepdims=True) < _DARK
    return {
        "albedo": np.where(dark, np.float32(1), albedo),
        "normal": channels["normal"],
        "nearness": nearness(channels["depth"]),
    }
