"""Gradient noise. Source: Perlin, "Improving Noise", SIGGRAPH 2002."""

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
    edge_vector,
    faded,
    footprint,
    own_place,
    quintic,
    row_key,
    seed_of,
    sheet_key,
)

__all__ = ["perlin", "perlin_at"]

_SIZE, _SEED, _REACH = np.int64(0), np.int64(1), np.int64(3)
_ZERO, _HALF, _ONE = np.float32(0), np.float32(0.5), np.float32(1)


@exact_device
def _ramp(key, x, y, z):
    """(value, slopes) of the ramp through a lattice point, (x, y, z) away from it."""
    gx, gy, gz = edge_vector(key)
    return (gx * x + gy * y) + gz * z, gx, gy, gz


@exact_device
def _between(a, b, weight):
    """A value and its slopes, so far from `a` to `b`."""
    return (
        a[0] + (b[0] - a[0]) * weight,
        a[1] + (b[1] - a[1]) * weight,
        a[2] + (b[2] - a[2]) * weight,
        a[3] + (b[3] - a[3]) * weight,
    )


@exact_device
def _row(row, i, x, y, z, u, du):
    a = _ramp(corner_key(i, row), x, y, z)
    b = _ramp(corner_key(i + np.int32(1), row), x - _ONE, y, z)
    value, along_x, along_y, along_z = _between(a, b, u)
    return value, along_x + (b[0] - a[0]) * du, along_y, along_z


@exact_device
def _sheet(sheet, i, j, x, y, z, u, du, v, dv):
    a = _row(row_key(j, sheet), i, x, y, z, u, du)
    b = _row(row_key(j + np.int32(1), sheet), i, x, y - _ONE, z, u, du)
    value, along_x, along_y, along_z = _between(a, b, v)
    return value, along_x, along_y + (b[0] - a[0]) * dv, along_z


@exact_device
def perlin_at(x, y, z, seed):
    """(value from −1 to 1, but for 4 %, and its three derivatives); 0 at the points of the lattice."""
    i, x = cell_of(x)
    j, y = cell_of(y)
    k, z = cell_of(z)
    u, du = quintic(x)
    v, dv = quintic(y)
    w, dw = quintic(z)
    a = _sheet(sheet_key(k, seed), i, j, x, y, z, u, du, v, dv)
    b = _sheet(sheet_key(k + np.int32(1), seed), i, j, x, y, z - _ONE, u, du, v, dv)
    value, along_x, along_y, along_z = _between(a, b, w)
    return value, along_x, along_y, along_z + (b[0] - a[0]) * dw


@entry
def perlin(textures, node, record):
    """Data: size of a cell, seed, reach."""
    place = open_place(textures, node, record)
    scale = _ONE / datum(place, _SIZE)
    x, y, z = own_place(place)
    value, _, _, _ = perlin_at(x * scale, y * scale, z * scale, seed_of(place, _SEED))
    value = faded(value, _ZERO, footprint(place) * scale, datum(place, _REACH))
    return answer_number(place, min(max(_HALF + _HALF * value, _ZERO), _ONE))
