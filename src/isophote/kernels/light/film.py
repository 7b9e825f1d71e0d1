"""The film: where samples fall in a pixel, and how they add up.

A pixel's filter f(x) f(y) is sampled in proportion to its absolute value, so that each sample counts for one pixel only
(Ernst, Stamminger, Greiner: "Filter Importance Sampling", 2006). Pixels are therefore independent of each other,
whatever the tiles, and each adds its samples in their order. Where a filter is negative, samples are added to a second
film below the first as well, to be taken away when the picture is made.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import device

__all__ = ["add_samples", "filter_offset", "is_negative"]


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
def add_samples(film, place, red, green, blue, first, last):
    """Add the radiance of samples first … last − 1, one after another, to row `place` of the film."""
    total, squares = film.total, film.squares
    r, g, b = total[place, 0], total[place, 1], total[place, 2]
    r2, g2, b2 = squares[place, 0], squares[place, 1], squares[place, 2]
    for i in range(first, last):
        x, y, z = np.float64(red[i]), np.float64(green[i]), np.float64(blue[i])
        r, g, b = r + x, g + y, b + z
        r2, g2, b2 = r2 + x * x, g2 + y * y, b2 + z * z
    total[place, 0], total[place, 1], total[place, 2] = r, g, b
    squares[place, 0], squares[place, 1], squares[place, 2] = r2, g2, b2
    film.count[place] += last - first
