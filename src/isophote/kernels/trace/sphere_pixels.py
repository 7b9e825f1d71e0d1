"""Sixteen pixels at once: what sphere tracing knows of each."""

from __future__ import annotations

import numpy as np

from isophote.kernels.accel.geometry import Hit
from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import load_float, load_int, store_float, store_int
from isophote.kernels.base.vec import vec3

__all__ = ["PIXEL_ROWS", "keep_hit", "kept_hit", "lane_vec3", "set_lane_vec3"]

# Rows of sixteen words. Of the ray: origin, unit direction; of what is met: distance, weights of the triangle's
# corners, slot and instance (whole numbers; slot −1: nothing), place, normal on the side that is seen, error of the
# place, colour of the material; light gathered, how open the surroundings are, a value near the surface, and depth for
# each length of the ray.
(
    ORIGIN,
    DIRECTION,
    DISTANCE,
    WEIGHT1,
    WEIGHT2,
    SLOT,
    INSTANCE,
    PLACE,
    NORMAL,
    ERROR,
    COLOUR,
    GATHERED,
    OPEN,
    NEARBY,
    DEPTH_SCALE,
) = (np.int64(16 * row) for row in (0, 3, 6, 7, 8, 9, 10, 11, 14, 17, 18, 21, 24, 25, 26))
PIXEL_ROWS = 27

_LANES = np.int64(16)


@device
def lane_vec3(rows, row, lane):
    """The vector in a row and the two behind it."""
    at = row + lane
    return vec3(load_float(rows, at), load_float(rows, at + _LANES), load_float(rows, at + 2 * _LANES))


@device
def set_lane_vec3(rows, row, lane, v):
    """Store a vector in a row and the two behind it."""
    at = row + lane
    store_float(rows, at, v.x)
    store_float(rows, at + _LANES, v.y)
    store_float(rows, at + 2 * _LANES, v.z)


@device
def keep_hit(rows, lane, hit):
    """Store what a lane's ray meets."""
    store_float(rows, DISTANCE + lane, hit.t)
    store_float(rows, WEIGHT1 + lane, hit.weight1)
    store_float(rows, WEIGHT2 + lane, hit.weight2)
    store_int(rows, SLOT + lane, np.int32(hit.slot))
    store_int(rows, INSTANCE + lane, np.int32(hit.instance))


@device
def kept_hit(rows, lane):
    """The `Hit` that a lane's ray meets."""
    return Hit(
        load_float(rows, DISTANCE + lane),
        load_float(rows, WEIGHT1 + lane),
        load_float(rows, WEIGHT2 + lane),
        np.int64(load_int(rows, SLOT + lane)),
        np.int64(load_int(rows, INSTANCE + lane)),
    )
