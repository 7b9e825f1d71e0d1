"""The paths of a tile: camera rays at its beginning, sample numbers on the way, its pixels at the end."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from isophote.kernels.base.jit import device
from isophote.kernels.base.sampler import draw_pairs
from isophote.kernels.base.vec import length, vec3
from isophote.kernels.base.warp import to_disk
from isophote.kernels.light.film import add_sample, filter_offset
from isophote.kernels.trace import wave as rows
from isophote.kernels.trace.camera import camera_ray
from isophote.kernels.trace.wave import set_row_vec3

__all__ = ["FIRST", "Tile", "develop", "draw", "start_paths"]

_ZERO, _ONE = np.float32(0), np.float32(1)
_FAR = np.float32(np.inf)

# Sampling dimensions (pairs of numbers): film, lens, then those of the method from FIRST on.
# NumPy integers: Numba would compile what takes a plain constant anew for each of its values.
_FILM, _LENS, FIRST = np.int64(0), np.int64(1), np.int64(2)


class Tile(NamedTuple):
    """Pixels x0 ≤ x < x1, y0 ≤ y < y1 and samples first ≤ s < last of each."""

    x0: int
    x1: int
    y0: int
    y1: int
    first: int
    last: int


@device
def start_paths(tables, plan, tile, first, count, wave):
    """Camera rays of wave columns 0 … count − 1, the paths numbered `first` on within the tile."""
    floats, ints = wave.floats, wave.ints
    samples = tile.last - tile.first
    across = tile.x1 - tile.x0
    place, sample = first // samples, first % samples
    x, y = place % across, place // across
    for i in range(count):
        px, py = tile.x0 + x, tile.y0 + y
        ints[rows.PIXEL, i] = py * plan.width + px
        ints[rows.SAMPLE, i] = tile.first + sample
        ints[rows.OWNER, i] = i
        floats[rows.HIT_W1, i], floats[rows.HIT_W2, i] = px, py
        # Counting on: divisions would take longer than all else here.
        sample += 1
        if sample == samples:
            sample, x = 0, x + 1
            if x == across:
                x, y = 0, y + 1
    draw(plan, wave, count, _FILM, rows.PICK_U)
    draw(plan, wave, count, _LENS, rows.LIGHT_U)
    for i in range(count):
        dx, dy = filter_offset(plan.filter, floats[rows.PICK_U, i], floats[rows.PICK_V, i])
        a, b = to_disk(floats[rows.LIGHT_U, i], floats[rows.LIGHT_V, i])
        px, py = floats[rows.HIT_W1, i] + dx, floats[rows.HIT_W2, i] + dy
        origin, direction = camera_ray(tables.camera, px, py, a, b)
        set_row_vec3(floats, rows.ORIGIN, i, origin)
        set_row_vec3(floats, rows.DIRECTION, i, direction / length(direction))
        set_row_vec3(floats, rows.CARRIED, i, vec3(_ONE, _ONE, _ONE))
        set_row_vec3(floats, rows.RADIANCE, i, vec3(_ZERO, _ZERO, _ZERO))
        floats[rows.DENSITY, i] = _ZERO
        floats[rows.HIT_T, i] = _FAR


@device
def draw(plan, wave, count, dimension, row):
    floats, ints = wave.floats, wave.ints
    draw_pairs(
        plan.pattern,
        plan.seed,
        ints[rows.PIXEL],
        ints[rows.SAMPLE],
        plan.samples,
        dimension,
        count,
        floats[row],
        floats[row + 1],
    )


@device
def develop(plan, tile, first, count, wave, film):
    """Add the wave's paths to the film, in their order."""
    floats = wave.floats
    samples = tile.last - tile.first
    across = tile.x1 - tile.x0
    for i in range(count):
        place = (first + i) // samples
        x, y = tile.x0 + place % across, tile.y0 + place // across
        add_sample(film, x, y, floats[rows.RADIANCE, i], floats[rows.RADIANCE + 1, i], floats[rows.RADIANCE + 2, i])
