"""Cellular noise: how far it is to scattered points. Source: Worley, "A Cellular Texture Basis Function", 1996.

Every cell of the integer lattice holds one point. Cells are searched ring by ring around the place, the nearer ones of
the first ring first, until none further out can hold a nearer point: the answer is that of a look at all points.
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
def _in_ring(ring, k, j):
    """Step along x, so that only cells of the ring are visited."""
    return np.int32(1) if abs(k) == ring or abs(j) == ring else np.int32(2) * ring


@exact_device
def _turn(turn, fraction):
    """The cell that an axis comes to by turns: its own, the one that is nearer, the one behind."""
    ahead = np.int32(1) if fraction >= _HALF else np.int32(-1)
    return np.int32(0) if turn == 0 else (ahead if turn == 1 else -ahead)


@exact_device
def _with_point(best, row, ci, cell, place, metric, jitter, alone):
    """`best`, (nearest, second nearest, number), with the point of one more cell of a row."""
    key = corner_key(ci + cell[0], row)
    key_y = mix(_U(key + _STEP))
    key_z = mix(_U(key_y + _STEP))
    base = _HALF - _HALF * jitter
    distance = _measure(
        (np.float32(cell[0]) + (base + jitter * unit_of(key))) - place[0],
        (np.float32(cell[1]) + (base + jitter * unit_of(key_y))) - place[1],
        (np.float32(cell[2]) + (base + jitter * unit_of(key_z))) - place[2],
        metric,
    )
    if distance < best[0]:
        return distance, distance if alone else best[0], mix(_U(key_z + _STEP))
    return best[0], min(best[1], distance) if not alone else best[1], best[2]


@exact_device
def _around(best, corner, place, seed, metric, jitter, alone):
    """`best` with the cells around the place's own and itself, nearer ones first, those too far left out."""
    for c in range(3):
        k = _turn(c, place[2])
        gap_z = _gap(k, place[2])
        if _measure(_ZERO, _ZERO, gap_z, metric) >= best[1]:
            continue
        sheet = sheet_key(corner[2] + k, seed)
        for b in range(3):
            j = _turn(b, place[1])
            gap_y = _gap(j, place[1])
            if _measure(_ZERO, gap_y, gap_z, metric) >= best[1]:
                continue
            row = row_key(corner[1] + j, sheet)
            for a in range(3):
                i = _turn(a, place[0])
                if _measure(_gap(i, place[0]), gap_y, gap_z, metric) < best[1]:
                    best = _with_point(best, row, corner[0], (i, j, k), place, metric, jitter, alone)
    return best


@exact_device
def _with_ring(best, ring, corner, place, seed, metric, jitter, alone):
    """`best` with the cells that are `ring` away along some axis, and no further along any."""
    for k in range(-ring, ring + np.int32(1)):
        for j in range(-ring, ring + np.int32(1)):
            row = row_key(corner[1] + j, sheet_key(corner[2] + k, seed))
            gap_y, gap_z = _gap(j, place[1]), _gap(k, place[2])
            for i in range(-ring, ring + np.int32(1), _in_ring(ring, k, j)):
                if _measure(_gap(i, place[0]), gap_y, gap_z, metric) < best[1]:
                    best = _with_point(best, row, corner[0], (i, j, k), place, metric, jitter, alone)
    return best


@exact_device
def worley_at(x, y, z, seed, metric, jitter, alone):
    """(distance to the nearest point, to the second nearest, the nearest one's number), for cells of size 1; `alone`
    asks for nothing of the second."""
    ci, x = cell_of(x)
    cj, y = cell_of(y)
    ck, z = cell_of(z)
    corner, place = (ci, cj, ck), (x, y, z)
    best = _around((_LARGE, _LARGE, _U(0)), corner, place, seed, metric, jitter, alone)
    rim = min(min(min(x, _ONE - x), min(y, _ONE - y)), min(z, _ONE - z))
    for ring in range(np.int32(2), np.int32(8)):
        if _measure(np.float32(ring) - _ONE + rim, _ZERO, _ZERO, metric) >= best[1]:
            break
        best = _with_ring(best, ring, corner, place, seed, metric, jitter, alone)
    if metric == EUCLIDEAN:
        return np.sqrt(best[0]), np.sqrt(best[1]), best[2]
    return best


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
