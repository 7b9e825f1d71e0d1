"""The paths of a tile: camera rays at its beginning, sample numbers on the way, its pixels at the end."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from isophote.kernels.base.jit import device
from isophote.kernels.base.sampler import draw_pairs, pixel_number
from isophote.kernels.base.simd import splat16, square_root
from isophote.kernels.base.warp import to_disk
from isophote.kernels.base.wide import load_lanes, store_lanes, store_wide, wide, wide_dot
from isophote.kernels.light.film import add_samples, filter_offset, is_negative
from isophote.kernels.trace import wave as rows
from isophote.kernels.trace.camera import camera_rays, has_lens
from isophote.kernels.trace.cone import start_cones
from isophote.kernels.trace.wave import LANES

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
def _place_on_film(plan, wave, count):
    """Move samples from their pixels' corners to where the filter has them, in rows HIT_W1 and HIT_W2."""
    floats, ints = wave.floats, wave.ints
    draw(plan, wave, count, _FILM, rows.PICK_U)
    offsets, crossings = plan.offsets, plan.crossings
    below = plan.width * plan.height
    for i in range(count):
        dx, dy = filter_offset(offsets, floats[rows.PICK_U, i]), filter_offset(offsets, floats[rows.PICK_V, i])
        if crossings.rows > 0:
            ints[rows.PLACE, i] += below * is_negative(crossings, dx, dy)
        floats[rows.HIT_W1, i] += _HALF + dx
        floats[rows.HIT_W2, i] += _HALF + dy


@device
def _leave_camera(plan, camera, wave, count):
    """Rays through places on the film, sixteen at a time."""
    floats, lens = wave.floats, has_lens(camera)
    if lens:
        draw(plan, wave, count, _LENS, rows.LIGHT_U)
        for i in range(count):
            floats[rows.LIGHT_U, i], floats[rows.LIGHT_V, i] = to_disk(floats[rows.LIGHT_U, i], floats[rows.LIGHT_V, i])
    zero, one = splat16(_ZERO), splat16(_ONE)
    ones, nothing = wide(one, one, one), wide(zero, zero, zero)
    for i in range(0, count, LANES):
        px, py = load_lanes(floats, rows.HIT_W1, i), load_lanes(floats, rows.HIT_W2, i)
        a = load_lanes(floats, rows.LIGHT_U, i) if lens else zero
        b = load_lanes(floats, rows.LIGHT_V, i) if lens else zero
        origin, direction = camera_rays(camera, px, py, a, b)
        store_wide(floats, rows.ORIGIN, i, origin)
        store_wide(floats, rows.DIRECTION, i, direction / square_root(wide_dot(direction, direction)))
        store_wide(floats, rows.CARRIED, i, ones)
        store_wide(floats, rows.RADIANCE, i, nothing)
        store_lanes(floats, rows.DENSITY, i, zero)
        store_lanes(floats, rows.HIT_T, i, splat16(_FAR))


@device
def start_paths(tables, plan, film, tile, place, wave):
    """Camera rays of the next paths of a tile, from its pixel `place` on, in wave columns 0 … count − 1.

    Returns (count, pixel to go on at); count is 0 when every pixel has as many samples as it shall have.
    """
    count, place = _choose_samples(plan, film, tile, place, wave)
    # Without paths there may be no tables (rendering/warm.py).
    if count == 0:
        return count, place
    _place_on_film(plan, wave, count)
    _leave_camera(plan, tables.camera, wave, count)
    inside = wave.longs[rows.INSIDE]
    for i in range(count):
        inside[i] = plan.inside
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
    places = wave.ints[rows.PLACE]
    red, green, blue = wave.floats[rows.RADIANCE], wave.floats[rows.RADIANCE + 1], wave.floats[rows.RADIANCE + 2]
    pixels = plan.width * plan.height
    i = np.int64(0)
    while i < count:
        place, end = places[i], i + 1
        while end < count and places[end] == place:
            end += 1
        here = np.int64(place)
        if here >= pixels:
            add_samples(film, here, red, green, blue, i, end)
            here -= pixels
        add_samples(film, here, red, green, blue, i, end)
        i = end
