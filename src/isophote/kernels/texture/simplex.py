"""Simplex noise: bumps with gradients at the points of a lattice of tetrahedra.

Sources: Perlin, "Noise Hardware", SIGGRAPH course 2001; Gustavson, "Simplex Noise Demystified", 2005. Bumps end where
(1/2 − r²)⁴ does, which is within the tetrahedra around their lattice point: the noise is smooth everywhere.
"""

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
    row_key,
    seed_of,
    sheet_key,
)

__all__ = ["simplex", "simplex_at"]

_SIZE, _SEED, _REACH = np.int64(0), np.int64(1), np.int64(3)
_ZERO, _HALF, _ONE = np.float32(0), np.float32(0.5), np.float32(1)
_THIRD, _SIXTH, _EIGHT = np.float32(1 / 3), np.float32(1 / 6), np.float32(8)
# Makes −1 to 1 of the values.
_SCALE = np.float32(76.8)


@exact_device
def _bump(i, j, k, seed, x, y, z):
    """(value, derivatives) of what lattice point (i, j, k) adds (x, y, z) away from it."""
    t = _HALF - ((x * x + y * y) + z * z)
    if t <= _ZERO:
        return _ZERO, _ZERO, _ZERO, _ZERO
    gx, gy, gz = edge_vector(corner_key(i, row_key(j, sheet_key(k, seed))))
    ramp = (gx * x + gy * y) + gz * z
    t2 = t * t
    t4 = t2 * t2
    steep = _EIGHT * (t2 * t) * ramp
    return t4 * ramp, t4 * gx - steep * x, t4 * gy - steep * y, t4 * gz - steep * z


@exact_device
def simplex_at(x, y, z, seed):
    """(value from −1 to 1, its three derivatives)."""
    i, x = cell_of(x)
    j, y = cell_of(y)
    k, z = cell_of(z)
    # The lattice is of cubes, squeezed along their diagonal: p + (x + y + z) / 3 goes back to cubes. Of the whole part,
    # the sum is divided as whole numbers are, so that nothing is lost far from the origin.
    total = np.int64(i) + np.int64(j) + np.int64(k)
    thirds = total // 3
    rest = np.float32(total - 3 * thirds)
    i, j, k = np.int32(i + thirds), np.int32(j + thirds), np.int32(k + thirds)
    shift = ((x + y) + z + rest) * _THIRD
    di, _ = cell_of(x + shift)
    dj, _ = cell_of(y + shift)
    dk, _ = cell_of(z + shift)
    back = (np.float32(di + dj + dk) + rest) * _SIXTH
    i, j, k = i + di, j + dj, k + dk
    x, y, z = (x - np.float32(di)) + back, (y - np.float32(dj)) + back, (z - np.float32(dk)) + back
    # From corner to corner of the tetrahedron: first along the largest coordinate, last along the least.
    x_first, y_first = x >= y and x >= z, y > x and y >= z
    x_least, y_least = x < y and x < z, y <= x and y < z
    a1, b1 = np.int32(x_first), np.int32(y_first)
    c1 = np.int32(1) - a1 - b1
    a2, b2 = np.int32(1) - np.int32(x_least), np.int32(1) - np.int32(y_least)
    c2 = np.int32(2) - a2 - b2
    value, dx, dy, dz = _bump(i, j, k, seed, x, y, z)
    for corner in range(1, 4):
        a = a1 if corner == 1 else (a2 if corner == 2 else np.int32(1))
        b = b1 if corner == 1 else (b2 if corner == 2 else np.int32(1))
        c = c1 if corner == 1 else (c2 if corner == 2 else np.int32(1))
        off = np.float32(corner) * _SIXTH
        added = _bump(
            i + a,
            j + b,
            k + c,
            seed,
            (x - np.float32(a)) + off,
            (y - np.float32(b)) + off,
            (z - np.float32(c)) + off,
        )
        value, dx, dy, dz = value + added[0], dx + added[1], dy + added[2], dz + added[3]
    return value * _SCALE, dx * _SCALE, dy * _SCALE, dz * _SCALE


@entry
def simplex(textures, node, record):
    """Data: size of a cell, seed, reach."""
    place = open_place(textures, node, record)
    scale = _ONE / datum(place, _SIZE)
    x, y, z = own_place(place)
    value, _, _, _ = simplex_at(x * scale, y * scale, z * scale, seed_of(place, _SEED))
    value = faded(value, _ZERO, footprint(place) * scale, datum(place, _REACH))
    return answer_number(place, min(max(_HALF + _HALF * value, _ZERO), _ONE))
