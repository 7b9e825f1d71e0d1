"""Cellular noise: how far it is to scattered points. Source: Worley, "A Cellular Texture Basis Function", 1996.

Every cell of the integer lattice holds one point. Cells are searched ring by ring around the place until none further
out can hold a nearer point, so that the answer is the one that a look at all points would give.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.entry import entry
from isophote.kernels.base.jit import exact_device
from isophote.kernels.base.random import mix
from isophote.kernels.texture.contract import open_place
from isophote.kernels.texture.lattice import (
    answer_number,
    cell_of,
    corner_key,
    datum,
    faded,
    footprint,
    own_place,
    row_key,
    seed_of,
    sheet_key,
    unit_of,
)

__all__ = ["BORDER", "CELL", "CHEBYSHEV", "EUCLIDEAN", "F1", "F2", "MANHATTAN", "worley", "worley_at"]

EUCLIDEAN, MANHATTAN, CHEBYSHEV = 0, 1, 2
F1, F2, BORDER, CELL = 0, 1, 2, 3

_SIZE, _SEED, _REACH, _METRIC, _FEATURE, _JITTER, _MEAN = (np.int64(k) for k in (0, 1, 3, 4, 5, 6, 7))
_U = np.uint32
_STEP = _U(0x9E3779B9)
_ZERO, _HALF, _ONE, _LARGE = np.float32(0), np.float32(0.5), np.float32(1), np.float32(1e30)


@exact_device
def _measure(x, y, z, metric):
    """A length, squared if it is Euclidean: what lengths are compared by."""
    if metric == EUCLIDEAN:
        return (x * x + y * y) + z * z
    x, y, z = abs(x), abs(y), abs(z)
    if metric == MANHATTAN:
        return (x + y) + z
    return max(x, max(y, z))


@exact_device
def _gap(cell, fraction):
    """How far it is along an axis from a place in cell 0 to cell number `cell`."""
    if cell > 0:
        return np.float32(cell) - fraction
    return max(fraction - np.float32(cell) - _ONE, _ZERO)


@exact_device
def _in_ring(ring, i, j):
    """Step along z, so that only cells of the ring are visited."""
    return np.int32(1) if abs(i) == ring or abs(j) == ring else np.int32(2) * ring


@exact_device
def worley_at(x, y, z, seed, metric, jitter, alone):
    """(distance to the nearest point, to the second nearest, the nearest one's number), for cells of size 1; `alone`
    asks for nothing of the second."""
    ci, x = cell_of(x)
    cj, y = cell_of(y)
    ck, z = cell_of(z)
    rim = min(min(min(x, _ONE - x), min(y, _ONE - y)), min(z, _ONE - z))
    first, second, number = _LARGE, _LARGE, _U(0)
    base = _HALF - _HALF * jitter
    for ring in range(np.int32(0), np.int32(8)):
        beyond = max(np.float32(ring) - _ONE + rim, _ZERO)
        if (beyond * beyond if metric == EUCLIDEAN else beyond) >= second:
            break
        for i in range(-ring, ring + np.int32(1)):
            for j in range(-ring, ring + np.int32(1)):
                for k in range(-ring, ring + np.int32(1), max(_in_ring(ring, i, j), np.int32(1))):
                    if _measure(_gap(i, x), _gap(j, y), _gap(k, z), metric) >= second:
                        continue
                    key = corner_key(ci + i, row_key(cj + j, sheet_key(ck + k, seed)))
                    key_y = mix(_U(key + _STEP))
                    key_z = mix(_U(key_y + _STEP))
                    distance = _measure(
                        (np.float32(i) + (base + jitter * unit_of(key))) - x,
                        (np.float32(j) + (base + jitter * unit_of(key_y))) - y,
                        (np.float32(k) + (base + jitter * unit_of(key_z))) - z,
                        metric,
                    )
                    if distance < first:
                        second = distance if alone else first
                        first, number = distance, mix(_U(key_z + _STEP))
                    elif distance < second and not alone:
                        second = distance
    if metric == EUCLIDEAN:
        return np.sqrt(first), np.sqrt(second), number
    return first, second, number


@entry
def worley(textures, node, record):
    """Data: size of a cell, seed, reach, metric, feature, jitter, mean of the feature."""
    place = open_place(textures, node, record)
    scale = _ONE / datum(place, _SIZE)
    x, y, z = own_place(place)
    metric, feature = np.int64(datum(place, _METRIC)), np.int64(datum(place, _FEATURE))
    seed, jitter = seed_of(place, _SEED), datum(place, _JITTER)
    alone = feature not in (F2, BORDER)
    first, second, number = worley_at(x * scale, y * scale, z * scale, seed, metric, jitter, alone)
    if feature == F1:
        value = first
    elif feature == F2:
        value = second
    elif feature == BORDER:
        value = second - first
    else:
        value = unit_of(number)
    value = min(value, _ONE)
    width, reach = footprint(place) * scale, datum(place, _REACH)
    return answer_number(place, faded(value, datum(place, _MEAN), width, reach))
