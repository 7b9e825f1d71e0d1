"""The film: where samples fall in a pixel, and how they add up.

A pixel's filter is sampled in proportion to its value, so that each sample counts for one pixel only and with weight
one (Ernst, Stamminger, Greiner: "Filter Importance Sampling", 2006). Pixels are therefore independent of each other,
whatever the tiles, and each adds its samples in their order.
"""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.base.jit import device
from isophote.kernels.base.warp import PI

__all__ = ["BOX", "GAUSSIAN", "TENT", "add_sample", "filter_offset"]

BOX, TENT, GAUSSIAN = 0, 1, 2

_HALF, _ONE, _TWO = np.float32(0.5), np.float32(1), np.float32(2)
_GAUSSIAN_SIGMA = np.float32(0.5)
_TINY = np.float32(1e-7)


@device
def _tent(u):
    return math.sqrt(_TWO * u) - _ONE if u < _HALF else _ONE - math.sqrt(_TWO - _TWO * u)


@device
def filter_offset(kind, u, v):
    """Place of a sample relative to the pixel's corner: box of width 1, tent of width 2, Gaussian of σ = ½."""
    if kind == BOX:
        return u, v
    if kind == TENT:
        return _HALF + _tent(u), _HALF + _tent(v)
    radius = _GAUSSIAN_SIGMA * math.sqrt(-_TWO * math.log(max(_ONE - u, _TINY)))
    return _HALF + radius * math.cos(_TWO * PI * v), _HALF + radius * math.sin(_TWO * PI * v)


@device
def add_sample(film, x, y, r, g, b):
    """Add one sample's radiance to its pixel."""
    total, squares = film.total, film.squares
    total[y, 3 * x] += r
    total[y, 3 * x + 1] += g
    total[y, 3 * x + 2] += b
    squares[y, 3 * x] += np.float64(r) * r
    squares[y, 3 * x + 1] += np.float64(g) * g
    squares[y, 3 * x + 2] += np.float64(b) * b
    film.count[y, x] += 1
