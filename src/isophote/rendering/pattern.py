"""Sample patterns, to be looked at and used for integrals of one's own."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from isophote.errors import RenderError
from isophote.kernels.base.pattern import fill_pattern
from isophote.rendering.method import Size, checked_seed, checked_size
from isophote.rendering.passes import MOST_SAMPLES, PATTERNS

__all__ = ["sample_pattern"]

_MOST_POINTS = 2**27


def sample_pattern(
    pattern: str, samples: int, *, size: Size = (1, 1), dimension: int = 0, seed: int = 0
) -> npt.NDArray[np.float32]:
    """The points that pixels of a picture of `size` (width, height) take: (h, w, samples, 2), in [0, 1).

    `pattern` is one of `PathTrace`'s. Dimension 0 is the place in the pixel, 1 the place on the lens, and so on: points
    of different dimensions are unrelated. Raises `RenderError` for unknown patterns, and numbers out of range.
    """
    if pattern not in PATTERNS:
        raise RenderError(f"pattern must be one of {', '.join(PATTERNS)}, not {pattern!r}")
    width, height = checked_size(size)
    count = _whole("samples", samples, 1, MOST_SAMPLES)
    if width * height * count > _MOST_POINTS:
        raise RenderError(f"{width} × {height} pixels of {count:,} samples are more than {_MOST_POINTS:,} points")
    points = np.empty((height, width, count, 2), np.float32)
    fill_pattern(PATTERNS[pattern], checked_seed(seed), _whole("dimension", dimension, 0, 2**31 - 1), points)
    return points


def _whole(name: str, value: Any, least: int, most: int) -> int:
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or not least <= value <= most:
        raise RenderError(f"{name} must be a whole number from {least} to {most:,}, not {value!r}")
    return int(value)
