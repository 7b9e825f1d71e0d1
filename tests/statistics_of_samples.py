"""What tests of random samples share."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

__all__ = ["deviation", "stratified"]


def deviation(found: npt.ArrayLike, expected: npt.ArrayLike) -> float:
    """How many standard deviations Pearson's chi-square lies above its mean (Wilson, Hilferty 1931); a chance of 10⁻⁴
    is 3.72. Cells of fewer than 8 expected samples are put together."""
    f, e = (np.asarray(values, np.float64).reshape(-1) for values in (found, expected))
    rare = e < 8
    f, e = np.append(f[~rare], f[rare].sum()), np.append(e[~rare], e[rare].sum())
    if e[-1] == 0:
        assert f[-1] == 0
        f, e = f[:-1], e[:-1]
    degrees = len(e) - 1
    chi2 = float(((f - e) ** 2 / e).sum())
    return ((chi2 / degrees) ** (1 / 3) - (1 - 2 / (9 * degrees))) / (2 / (9 * degrees)) ** 0.5


def stratified(count: int) -> npt.NDArray[np.float32]:
    """(count², 2): one random point in each cell of the unit square, below 1."""
    cells = np.stack(np.meshgrid(np.arange(count), np.arange(count)), 2).reshape(-1, 2)
    points = (cells + np.random.default_rng(1).random(cells.shape)) / count
    return np.minimum(points, 1 - 2.0**-24).astype(np.float32)
