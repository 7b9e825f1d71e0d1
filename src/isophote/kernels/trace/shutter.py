"""The times of a tile's samples, in moments of an open shutter."""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import kernel
from isophote.kernels.base.sampler import pair, pixel_number
from isophote.kernels.trace.tables import FILM, PLAN

__all__ = ["count_moments"]

open_plan, open_film = PLAN.open, FILM.open

# The sampling dimension of time; those of paths count up from 0.
_TIME = np.int64(2**30)
_LAST = np.int64(1)


@kernel
def count_moments(plan_words, film_words, x0, x1, y0, y1, counts):
    """How many of the samples that each pixel x0 ≤ x < x1, y0 ≤ y < y1 is short of fall into each moment: added to
    `counts` (moments, pixels) uint32, pixels row by row."""
    plan, film = open_plan(plan_words), open_film(film_words)
    moments = counts.shape[0]
    pixel = 0
    for y in range(y0, y1):
        for x in range(x0, x1):
            at = y * plan.width + x
            number = pixel_number(x, y)
            for sample in range(film.count[at], film.target[at]):
                u, _ = pair(plan.pattern, plan.seed, number, sample, plan.samples, _TIME)
                moment = min(np.int64(u * np.float64(moments)), moments - _LAST)
                counts[moment, pixel] += np.uint32(1)
            pixel += 1
