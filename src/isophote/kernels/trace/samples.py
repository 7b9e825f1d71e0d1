"""The paths of a tile: camera rays at its beginning, sample numbers on the way, its pixels at the end."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from isophote.kernels.base.jit import device
from isophote.kernels.base.sampler import draw_pairs, pixel_number
from isophote.kernels.base.vec import length, vec3
from isophote.kernels.base.warp import to_disk
from isophote.kernels.light.film import add_sample, filter_offset, is_negative
from isophote.kernels.trace import wave as rows
from isophote.kernels.trace.camera import camera_ray
from isophote.kernels.trace.cone import start_cones
from isophote.kernels.trace.wave import set_row_vec3

__all__ = ["FIRST", "Tile", "are_neighbours", "develop", "draw", "start_paths"]

_ZERO, _HALF, _ONE = np.float32(0), np.float32(0.5), np.float32(1)
_FAR = np.float32(np.inf)

# Sampling dimensions (pairs of numbers): film, lens, then those of the method from FIRST on.
# NumPy integers: Numba would compile what takes a plain constant anew for each of its values.
_FILM, _LENS, FIRST = np.int64(0), np.int64(1), np.int64(2)
# Where fewer than one of so many pixels has a path, sixteen of them go every way.
_PATHS_A_PIXEL = np.int64(2)


class Tile(NamedTuple):
    """Pixels x0 ≤ x < x1, y0 ≤ y < y1."""

    x0: int
    x1: int
    y0: int
    y1: int


@device
def _choose_samples(plan, film, tile, place, wave):
    """The next samples that pixels of the tile are short of, from its pixel `place` on: at most as many as the wave
    holds. Returns (how many, pixel to go on at)."""
    floats, ints = wave.floats, wave.ints
    across = tile.x1 - tile.x0
    pixels = across * (tile.y1 - tile.y0)
    count = np.int64(0)
    if place >= pixels:
        return count, place
    x, y = tile.x0 + place % across, tile.y0 + place // across
    at = y * plan.width + x
    sample, last = film.count[at], film.target[at]
    number = pixel_number(x, y)
    while count < floats.columns:
        if sample < last:
            ints[rows.PIXEL, count] = number
            ints[rows.SAMPLE, count] = sample
            ints[rows.OWNER, count] = count
            ints[rows.PLACE, count] = at
            floats[rows.HIT_W1, count], floats[rows.HIT_W2, count] = x, y
            sample, count = sample + 1, count + 1
            continue
        # Counting on: divisions would take longer than all else here.
        place, x, at = place + 1, x + 1, at + 1
        if place == pixels:
            break
        if x == tile.x1:
            x, y, at = tile.x0, y + 1, at + plan.width - across
        sample, last = film.count[at], film.target[at]
        number = pixel_number(x, y)
    return count, place


@device
def start_paths(tables, plan, film, tile, place, wave):
    """Camera rays of the next paths of a tile, from its pixel `place` on, in wave columns 0 … count − 1.

    Returns (count, pixel to go on at); count is 0 when every pixel has as many samples as it shall have.
    """
    floats, ints = wave.floats, wave.ints
    count, place = _choose_samples(plan, film, tile, place, wave)
    draw(plan, wave, count, _FILM, rows.PICK_U)
    draw(plan, wave, count, _LENS, rows.LIGHT_U)
    offsets, crossings = plan.offsets, plan.crossings
    below = plan.width * plan.height
    for i in range(count):
        dx, dy = filter_offset(offsets, floats[rows.PICK_U, i]), filter_offset(offsets, floats[rows.PICK_V, i])
        ints[rows.PLACE, i] += below * is_negative(crossings, dx, dy)
        a, b = to_disk(floats[rows.LIGHT_U, i], floats[rows.LIGHT_V, i])
        px, py = floats[rows.HIT_W1, i] + (_HALF + dx), floats[rows.HIT_W2, i] + (_HALF + dy)
        origin, direction = camera_ray(tables.camera, px, py, a, b)
        set_row_vec3(floats, rows.ORIGIN, i, origin)
        set_row_vec3(floats, rows.DIRECTION, i, direction / length(direction))
        set_row_vec3(floats, rows.CARRIED, i, vec3(_ONE, _ONE, _ONE))
        set_row_vec3(floats, rows.RADIANCE, i, vec3(_ZERO, _ZERO, _ZERO))
        floats[rows.DENSITY, i] = _ZERO
        floats[rows.HIT_T, i] = _FAR
        wave.longs[rows.INSIDE, i] = plan.inside
    if tables.textures.nodes.rows > 0:
        start_cones(tables, plan, wave, count)
    return count, place


@device
def are_neighbours(count, begun, place):
    """Whether so many paths, of the pixels from `begun` to before `place`, leave the camera side by side."""
    return _PATHS_A_PIXEL * count >= place - begun


@device
def draw(plan, wave, count, dimension, row):
    """The pair of sample numbers `dimension` of each of the first `count` paths, into rows `row` and `row` + 1."""
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
def develop(plan, count, wave, film):
    """Add the wave's paths to the film, in their order."""
    floats, places = wave.floats, wave.ints[rows.PLACE]
    pixels = plan.width * plan.height
    for i in range(count):
        place = np.int64(places[i])
        r, g, b = floats[rows.RADIANCE, i], floats[rows.RADIANCE + 1, i], floats[rows.RADIANCE + 2, i]
        if place >= pixels:
            add_sample(film, place, r, g, b)
            place -= pixels
        add_sample(film, place, r, g, b)
