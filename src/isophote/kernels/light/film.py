"""The film: where samples fall in a pixel, and how they add up.

A pixel's filter f(x) f(y) is sampled in proportion to its absolute value, so that each sample counts for one pixel only
(Ernst, Stamminger, Greiner: "Filter Importance Sampling", 2006). Pixels are therefore independent of each other,
whatever the tiles, and each adds its samples in their order. Where a filter is negative, samples are added to a second
film below the first as well, to be taken away when the picture is made.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import device

__all__ = ["add_sample", "filter_offset", "is_negative"]


@device
def filter_offset(offsets, u):
    """Distance from a pixel's middle along one axis, by the inverse of the distribution of |f| at even steps."""
    steps = offsets.rows - 1
    place = u * np.float32(steps)
    k = np.int64(place)
    below = offsets[k]
    return below + (place - np.float32(k)) * (offsets[k + 1] - below)


@device
def _sign_changes(crossings, x):
    """How many of the filter's zeros lie within |x|."""
    count = np.int64(0)
    for k in range(crossings.rows):
        count += np.int64(abs(x) > crossings[k])
    return count


@device
def is_negative(crossings, x, y):
    """1 where the filter f(x) f(y) is negative, else 0; `crossings` are the distances at which f changes its sign."""
    return (_sign_changes(crossings, x) + _sign_changes(crossings, y)) & np.int64(1)


@device
def add_sample(film, place, r, g, b):
    """Add one sample's radiance to row `place` of the film."""
    total, squares = film.total, film.squares
    total[place, 0] += r
    total[place, 1] += g
    total[place, 2] += b
    squares[place, 0] += np.float64(r) * r
    squares[place, 1] += np.float64(g) * g
    squares[place, 2] += np.float64(b) * b
    film.count[place] += 1
