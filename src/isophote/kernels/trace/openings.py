"""Rays into the hemispheres above points."""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.base.jit import device
from isophote.kernels.base.sampler import SOBOL, draw_pairs
from isophote.kernels.base.table import DOUBLE_BOXES, FLOAT, FLOAT_ROWS, FLOATS, INT, Table
from isophote.kernels.base.vec import orthonormal, vec3
from isophote.kernels.base.warp import to_disk
from isophote.kernels.trace import wave as rows
from isophote.kernels.trace.wave import set_row_vec3

__all__ = ["COSINE", "GIVEN", "OPENINGS", "UNIFORM", "aim", "draw_around_z", "lifted", "normal_of"]

# How directions are found: by chance in proportion to the cosine, by chance evenly over the hemisphere, or as given.
COSINE, UNIFORM, GIVEN = 0, 1, 2

# `points`, `normals` (n, 3); `bias` (n,): how far rays start above the points. `samples` rays of length `reach` for
# each. `directions` (samples, 4), where they are given: around +z, with the weight of each. `open` (n, 4): sums of
# weights of the free rays, and of their directions times weight.
OPENINGS = Table(
    "Openings",
    points=FLOAT_ROWS,
    normals=FLOAT_ROWS,
    bias=FLOATS,
    samples=INT,
    seed=INT,
    warp=INT,
    reach=FLOAT,
    directions=FLOAT_ROWS,
    open=DOUBLE_BOXES,
)

_ZERO, _ONE, _TWO = np.float32(0), np.float32(1), np.float32(2)
_DIMENSION = np.int64(0)
_SOBOL = np.int64(SOBOL)


@device
def draw_around_z(openings, wave, first, count):
    """Point and sample of each column, from ray number `first` on, and its direction around +z unless it is given."""
    ints, floats = wave.ints, wave.floats
    point = first // openings.samples
    sample = first - point * openings.samples
    for i in range(count):
        ints[rows.PIXEL, i], ints[rows.SAMPLE, i] = point, sample
        # Counting on: divisions would take a tenth of the time of all else.
        sample += 1
        if sample == openings.samples:
            point, sample = point + 1, np.int64(0)
    if openings.warp != GIVEN:
        pixels, samples = ints[rows.PIXEL], ints[rows.SAMPLE]
        u, v = floats[rows.LIGHT_U], floats[rows.LIGHT_V]
        draw_pairs(_SOBOL, openings.seed, pixels, samples, openings.samples, _DIMENSION, count, u, v)
        _around_z(openings, wave, count)


@device
def normal_of(openings, k):
    """The normal of point `k`."""
    return _row(openings.normals, k)


@device
def lifted(openings, k):
    """Where rays above point `k` start."""
    return _row(openings.points, k) + _row(openings.normals, k) * openings.bias[k]


@device
def _row(values, k):
    """Row `k` of (n, 3) values."""
    return vec3(values[k, 0], values[k, 1], values[k, 2])


@device
def _around_z(openings, wave, count):
    """From places in the unit square, in the rows LIGHT_U and LIGHT_V, to directions around +z: x and y stay there,
    z goes to the row of the weights."""
    u, v, z = wave.floats[rows.LIGHT_U], wave.floats[rows.LIGHT_V], wave.floats[rows.DENSITY]
    for i in range(count):
        u[i], v[i] = to_disk(u[i], v[i])
    if openings.warp == UNIFORM:
        # A ring of the disk becomes a ring of the hemisphere of as large a share (Shirley, Chiu 1997).
        for i in range(count):
            square = u[i] * u[i] + v[i] * v[i]
            wide = math.sqrt(max(_ZERO, _TWO - square))
            u[i], v[i], z[i] = u[i] * wide, v[i] * wide, _ONE - square
    else:
        for i in range(count):
            z[i] = math.sqrt(max(_ZERO, _ONE - u[i] * u[i] - v[i] * v[i]))


@device
def aim(openings, wave, k, first, last):
    """The rays of columns first ≤ i < last, all above point `k`, and the weights of their samples."""
    normal, start = normal_of(openings, k), lifted(openings, k)
    tangent, bitangent = orthonormal(normal)
    floats = wave.floats
    _fill(floats[rows.SHADOW_ORIGIN], first, last, start.x)
    _fill(floats[rows.SHADOW_ORIGIN + 1], first, last, start.y)
    _fill(floats[rows.SHADOW_ORIGIN + 2], first, last, start.z)
    _fill(floats[rows.SHADOW_END], first, last, openings.reach)
    if openings.warp == GIVEN:
        given = openings.directions
        for i in range(first, last):
            j = np.int64(wave.ints[rows.SAMPLE, i])
            direction = tangent * given[j, 0] + bitangent * given[j, 1] + normal * given[j, 2]
            set_row_vec3(floats, rows.SHADOW_DIRECTION, i, direction)
            floats[rows.DENSITY, i] = given[j, 3]
        return
    _turn(floats, rows.SHADOW_DIRECTION, first, last, tangent.x, bitangent.x, normal.x)
    _turn(floats, rows.SHADOW_DIRECTION + 1, first, last, tangent.y, bitangent.y, normal.y)
    _turn(floats, rows.SHADOW_DIRECTION + 2, first, last, tangent.z, bitangent.z, normal.z)
    _fill(floats[rows.DENSITY], first, last, _ONE)


@device
def _fill(row, first, last, value):
    for i in range(first, last):
        row[i] = value


@device
def _turn(floats, row, first, last, tangent, bitangent, normal):
    """One component of directions, told by what each of the frame's axes has of it."""
    x, y, z, out = floats[rows.LIGHT_U], floats[rows.LIGHT_V], floats[rows.DENSITY], floats[row]
    for i in range(first, last):
        out[i] = tangent * x[i] + bitangent * y[i] + normal * z[i]
