"""Value noise: random numbers at the points of the integer lattice, and smoothly between them."""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.entry import entry
from isophote.kernels.base.jit import exact_device
from isophote.kernels.texture.contract import open_place
from isophote.kernels.texture.lattice import (
    answer_number,
    cell_of,
    corner_key,
    datum,
    faded,
    footprint,
    own_place,
    quintic,
    row_key,
    seed_of,
    sheet_key,
    unit_of,
)

__all__ = ["value_noise", "value_noise_at"]

_SIZE, _SEED, _REACH = np.int64(0), np.int64(1), np.int64(3)
_HALF, _ONE = np.float32(0.5), np.float32(1)


@exact_device
def _row(row, i, u, du):
    """(value, derivative along x) on a row of the lattice."""
    a = unit_of(corner_key(i, row))
    rise = unit_of(corner_key(i + np.int32(1), row)) - a
    return a + rise * u, rise * du


@exact_device
def _sheet(sheet, i, j, u, du, v, dv):
    """(value, derivatives along x and y) on a sheet of the lattice."""
    a, ax = _row(row_key(j, sheet), i, u, du)
    b, bx = _row(row_key(j + np.int32(1), sheet), i, u, du)
    return a + (b - a) * v, ax + (bx - ax) * v, (b - a) * dv


@exact_device
def value_noise_at(x, y, z, seed):
    """(value from 0 to 1, its three derivatives)."""
    i, fx = cell_of(x)
    j, fy = cell_of(y)
    k, fz = cell_of(z)
    u, du = quintic(fx)
    v, dv = quintic(fy)
    w, dw = quintic(fz)
    a, ax, ay = _sheet(sheet_key(k, seed), i, j, u, du, v, dv)
    b, bx, by = _sheet(sheet_key(k + np.int32(1), seed), i, j, u, du, v, dv)
    return a + (b - a) * w, ax + (bx - ax) * w, ay + (by - ay) * w, (b - a) * dw


@entry
def value_noise(textures, node, record):
    """Data: size of a cell, seed, reach."""
    place = open_place(textures, node, record)
    scale = _ONE / datum(place, _SIZE)
    x, y, z = own_place(place)
    value, _, _, _ = value_noise_at(x * scale, y * scale, z * scale, seed_of(place, _SEED))
    return answer_number(place, faded(value, _HALF, footprint(place) * scale, datum(place, _REACH)))
