"""What tests of random samples share."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

__all__ = ["stratified"]


def stratified(count: int) -> npt.NDArray[np.float32]:
    """(count², 2): one random point in each cell of the unit square, below 1."""
    cells = np.stack(np.meshgrid(np.arange(count), np.arange(count)), 2).reshape(-1, 2)
    points = (cells + np.random.default_rng(1).random(cells.shape)) / count
    return np.minimum(points, 1 - 2.0**-24).astype(np.float32)
