"""A log of rays: what each met, which lights it was shown, and what follows from it for its parent.

A row is made for a ray when it is sent out, and filled when it has been traced. A log without rows takes nothing down;
one that is too short goes on counting, so that it can be made long enough.

The colour of a ray is tint · (emitted + ambient + Σ arriving · value · factor of the lights that are seen
+ Σ weight · colour of its branches).
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.surface import face_number
from isophote.kernels.base.jit import device
from isophote.kernels.base.table import FLOAT_ROWS, LONG_ROWS, LONGS, Table
from isophote.kernels.base.vec import vec3
from isophote.kernels.trace import wave as rows
from isophote.kernels.trace.wave import row_vec3

__all__ = [
    "CAMERA",
    "LOG",
    "PASSED",
    "REFLECTED",
    "REFRACTED",
    "log_branch",
    "log_camera",
    "log_hit",
    "log_light",
    "log_terms",
    "log_visible",
]

# Kinds of rays: the last goes straight on, through what does not bend it.
CAMERA, REFLECTED, REFRACTED, PASSED = np.int64(0), np.int64(1), np.int64(2), np.int64(3)
# Why a ray was not traced.
TRACED, ENDED_BY_DEPTH, ENDED_BY_WEIGHT = np.int64(0), np.int64(1), np.int64(2)
# What a ray met.
NOTHING, LAMP, SURFACE = np.int64(0), np.int64(1), np.int64(2)

# Columns of `rays` …
ORIGIN, DIRECTION, WEIGHT, DISTANCE, CORNERS, PLACE, NORMAL, SHADING, UV, TINT, EMITTED, AMBIENT = (
    np.int64(column) for column in (0, 3, 6, 9, 10, 12, 15, 18, 21, 23, 26, 29)
)
RAY_COLUMNS = 32
# … of `ray_numbers` …
PARENT, KIND, LEVEL, ENDED, SAMPLE, FILM_PLACE, MET, ITEM, PRIMITIVE = (np.int64(column) for column in range(9))
RAY_NUMBERS = 9
# … of `lights` …
TOWARDS, REACH, ARRIVING, VALUE, FACTOR = (np.int64(column) for column in (0, 3, 4, 7, 10))
LIGHT_COLUMNS = 11
# … and of `light_numbers`.
RAY, LIGHT, TRIAL, SEEN = (np.int64(column) for column in range(4))
LIGHT_NUMBERS = 4

_ZERO, _ONE = np.float32(0), np.float32(1)
_NONE = np.int64(-1)

# `counts` (2,): rays and lights so far, also those that found no row.
LOG = Table("RayLog", rays=FLOAT_ROWS, ray_numbers=LONG_ROWS, lights=FLOAT_ROWS, light_numbers=LONG_ROWS, counts=LONGS)


@device
def _set(table, row, column, v):
    table[row, column], table[row, column + 1], table[row, column + 2] = v.x, v.y, v.z


@device
def _row(table, row, column):
    """The vector in three columns of a row."""
    return vec3(table[row, column], table[row, column + 1], table[row, column + 2])


@device
def log_branch(log, parent, kind, level, ended, origin, direction, weight):
    """A row for a ray that is sent out, or −1."""
    if log.rays.rows == 0:
        return _NONE
    row = log.counts[0]
    log.counts[0] = row + 1
    if row >= log.rays.rows:
        return _NONE
    _set(log.rays, row, ORIGIN, origin)
    _set(log.rays, row, DIRECTION, direction)
    _set(log.rays, row, WEIGHT, weight)
    _set(log.rays, row, TINT, vec3(_ONE, _ONE, _ONE))
    numbers = log.ray_numbers
    numbers[row, PARENT], numbers[row, KIND], numbers[row, LEVEL], numbers[row, ENDED] = parent, kind, level, ended
    numbers[row, SAMPLE] = numbers[parent, SAMPLE] if parent >= 0 else _NONE
    numbers[row, ITEM], numbers[row, PRIMITIVE] = _NONE, _NONE
    return row


@device
def log_camera(log, wave, i):
    """A row for the camera ray in wave column `i`, or −1."""
    origin, direction = row_vec3(wave.floats, rows.ORIGIN, i), row_vec3(wave.floats, rows.DIRECTION, i)
    row = log_branch(log, _NONE, CAMERA, np.int64(0), TRACED, origin, direction, vec3(_ONE, _ONE, _ONE))
    if row >= 0:
        log.ray_numbers[row, SAMPLE] = np.int64(wave.ints[rows.SAMPLE, i])
        log.ray_numbers[row, FILM_PLACE] = np.int64(wave.ints[rows.PLACE, i])
    return row


@device
def log_terms(log, row, met, number, distance, tint, emitted, ambient):
    """What a ray met, with its number for the user, and what it gathers there apart from lights and branches."""
    if row < 0:
        return
    log.ray_numbers[row, MET], log.ray_numbers[row, ITEM] = met, number
    log.rays[row, DISTANCE] = distance
    _set(log.rays, row, TINT, tint)
    _set(log.rays, row, EMITTED, emitted)
    _set(log.rays, row, AMBIENT, ambient)


@device
def log_hit(log, row, tables, hit, surface):
    """The surface that a ray met."""
    if row < 0:
        return
    values, numbers = log.rays, log.ray_numbers
    values[row, CORNERS], values[row, CORNERS + 1] = hit.weight1, hit.weight2
    _set(values, row, PLACE, surface.place)
    _set(values, row, NORMAL, surface.normal)
    _set(values, row, SHADING, surface.shading)
    values[row, UV], values[row, UV + 1] = surface.u, surface.v
    numbers[row, PRIMITIVE] = face_number(tables.surfaces, surface.item, surface.triangle)


@device
def log_light(log, ray, light, trial, into, distance, arriving, value, factor):
    """A row for one sample of one light, seen or not, or −1."""
    if ray < 0:
        return _NONE
    row = log.counts[1]
    log.counts[1] = row + 1
    if row >= log.lights.rows:
        return _NONE
    _set(log.lights, row, TOWARDS, into)
    log.lights[row, REACH] = distance
    _set(log.lights, row, ARRIVING, arriving)
    _set(log.lights, row, VALUE, value)
    log.lights[row, FACTOR] = factor
    log.light_numbers[row, RAY], log.light_numbers[row, LIGHT] = ray, light
    log.light_numbers[row, TRIAL], log.light_numbers[row, SEEN] = trial, np.int64(0)
    return row


@device
def log_visible(log, row, left):
    """Take down that light comes through from where it shines, and what is left of it."""
    if row >= 0:
        log.light_numbers[row, SEEN] = 1
        _set(log.lights, row, ARRIVING, _row(log.lights, row, ARRIVING) * left)
