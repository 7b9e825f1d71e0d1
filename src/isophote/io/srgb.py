"""8-bit sRGB of linear colours."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from isophote.scene.colour import linear_to_srgb

__all__ = ["to_srgb_bytes"]


def to_srgb_bytes(linear: npt.NDArray[np.floating[Any]]) -> npt.NDArray[np.uint8]:
    """Linear values to 8-bit sRGB, any shape, clipped to [0, 1]: the nearest of the 256 levels, ties upward; no NaN."""
    encoded = linear_to_srgb(np.clip(linear.astype(np.float64), 0.0, 1.0))
    levels: npt.NDArray[np.uint8] = np.floor(encoded * 255.0 + 0.5).astype(np.uint8)
    return levels
