"""The sRGB transfer curve, both ways (IEC 61966-2-1)."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

__all__ = ["from_srgb", "to_srgb", "to_srgb_bytes"]


def to_srgb(linear: npt.NDArray[np.floating[Any]]) -> npt.NDArray[np.float64]:
    """Linear values to sRGB-encoded ones, any shape, both clipped to [0, 1].

    x ≤ 0.0031308: 12.92 x; else 1.055 x^(1/2.4) − 0.055.
    """
    x = np.clip(linear.astype(np.float64), 0.0, 1.0)
    return np.asarray(np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055))


def to_srgb_bytes(linear: npt.NDArray[np.floating[Any]]) -> npt.NDArray[np.uint8]:
    """Linear values to 8-bit sRGB, any shape: the nearest of the 256 levels, ties upward; no NaN."""
    return np.floor(to_srgb(linear) * 255.0 + 0.5).astype(np.uint8)


def from_srgb(encoded: npt.NDArray[np.floating[Any]]) -> npt.NDArray[np.float64]:
    """sRGB-encoded values in [0, 1] to linear ones, any shape.

    x ≤ 0.04045: x / 12.92; else ((x + 0.055) / 1.055)^2.4.
    """
    x = np.clip(encoded.astype(np.float64), 0.0, 1.0)
    return np.asarray(np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4))
