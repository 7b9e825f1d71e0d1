"""Tables of what microfacets reflect in all, E(θ, roughness): in each node's data, made by lower/albedo.py.

A table has a row for each of ROUGHNESSES values of roughness, evenly from 0 to 1, of COSINES values at cosθ = t², t
even from 0 to 1; then the mean over the hemisphere, 2 ∫ E cosθ d(cosθ), for each roughness.
"""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.base.jit import device
from isophote.kernels.brdf.contract import datum

__all__ = ["COSINES", "ROUGHNESSES", "TABLE_WORDS", "mean_albedo", "table_albedo"]

ROUGHNESSES, COSINES = 24, 32
TABLE_WORDS = ROUGHNESSES * (COSINES + 1)

_ZERO, _ONE = np.float32(0), np.float32(1)
_ROWS, _COLUMNS = np.float32(ROUGHNESSES - 1), np.float32(COSINES - 1)
_LAST_ROW, _LAST_COLUMN = np.int64(ROUGHNESSES - 2), np.int64(COSINES - 2)


@device
def _row(roughness):
    """(row, fraction)."""
    x = min(max(roughness, _ZERO), _ONE) * _ROWS
    i = min(np.int64(x), _LAST_ROW)
    return i, x - np.float32(i)


@device
def table_albedo(lobe, first, roughness, cosine):
    """E(θ, roughness) by the table from datum `first` on, linear in between."""
    i, a = _row(roughness)
    y = math.sqrt(min(max(cosine, _ZERO), _ONE)) * _COLUMNS
    j = min(np.int64(y), _LAST_COLUMN)
    b = y - np.float32(j)
    at = first + i * COSINES + j
    upper = datum(lobe, at) * (_ONE - b) + datum(lobe, at + 1) * b
    lower = datum(lobe, at + COSINES) * (_ONE - b) + datum(lobe, at + COSINES + 1) * b
    return upper * (_ONE - a) + lower * a


@device
def mean_albedo(lobe, first, roughness):
    """The mean of `table_albedo` over the hemisphere."""
    i, a = _row(roughness)
    at = first + ROUGHNESSES * COSINES + i
    return datum(lobe, at) * (_ONE - a) + datum(lobe, at + 1) * a
