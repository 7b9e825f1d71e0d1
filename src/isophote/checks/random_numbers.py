"""Sample patterns: even in the square, stratified as they should be, and unrelated from dimension to dimension."""

from __future__ import annotations

from functools import partial

import numpy as np

from isophote.checks.check import Check, Effort, Measured, mean_of
from isophote.checks.statistics import chi_square_deviation
from isophote.rendering.passes import PATTERNS
from isophote.rendering.pattern import sample_pattern

__all__ = ["CHECKS"]

_EVEN = "random numbers: χ² of points in 16 × 16 cells, in standard deviations"
_FULL = "random numbers: pixels whose 64 Sobol points miss one of the 64 cells of a shape"
_UNRELATED = "random numbers: correlation of a dimension with the next"
_ERROR = "random numbers: ∫ x y over the square by 16 points a pixel"

_CELLS, _DEVIATIONS = 16, 5.0
# Regular points lie in the middles of cells, and are no random numbers.
_RANDOM = [name for name in PATTERNS if name != "regular"]


def _even(pattern: str, effort: Effort) -> Measured:
    """One point a pixel, so that pixels are independent."""
    size = (256, 256 * effort.factor)
    points = sample_pattern(pattern, 1, size=size, seed=effort.seed).reshape(-1, 2)
    cells = (points * _CELLS).astype(int)
    found = np.bincount(cells[:, 0] * _CELLS + cells[:, 1], minlength=_CELLS**2)
    deviation = chi_square_deviation(found, np.full(_CELLS**2, len(points) / _CELLS**2))
    return Measured(deviation, 0, _DEVIATIONS, at_most=True)


def _stratified(rows: int, columns: int, effort: Effort) -> Measured:
    """64 points of Owen's scrambled sequence lie one in each of 64 equal cells, whichever powers of two their sides
    are."""
    points = sample_pattern("sobol", 64, size=(32, 32 * effort.factor), seed=effort.seed).reshape(-1, 64, 2)
    cells = (points[..., 0] * columns).astype(int) + columns * (points[..., 1] * rows).astype(int)
    full = (np.sort(cells, axis=1) == np.arange(64)).all(axis=1)
    return Measured(float((~full).sum()), 0, 0)


def _unrelated(pattern: str, effort: Effort) -> Measured:
    size = (256, 256 * effort.factor)
    first, second = (sample_pattern(pattern, 1, size=size, dimension=k, seed=effort.seed) for k in (0, 1))
    # Of variance 1.
    product = 12 * (first.reshape(-1, 2)[:, 0] - 0.5) * (second.reshape(-1, 2)[:, 0] - 0.5)
    return mean_of(product, 0, 0)


def _integral(pattern: str, effort: Effort) -> Measured:
    points = sample_pattern(pattern, 16, size=(64, 64 * effort.factor), seed=effort.seed).astype(np.float64)
    return mean_of((points[..., 0] * points[..., 1]).mean(axis=2), 0.25, 1e-7)


CHECKS = [
    *(Check(_EVEN, name, partial(_even, name)) for name in _RANDOM),
    *(
        Check(_FULL, f"{rows} × {64 // rows}", partial(_stratified, rows, 64 // rows))
        for rows in (1, 2, 4, 8, 16, 32, 64)
    ),
    *(Check(_UNRELATED, name, partial(_unrelated, name)) for name in _RANDOM),
    *(Check(_ERROR, name, partial(_integral, name)) for name in _RANDOM),
]
