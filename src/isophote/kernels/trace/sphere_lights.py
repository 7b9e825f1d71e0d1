"""Lights of sphere tracing: points, spots, suns, and area lights as the light of their middles."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from isophote.kernels.base.jit import device
from isophote.kernels.base.vec import dot, length, vec3
from isophote.kernels.light.emitter import spot_share

__all__ = ["COLUMNS", "FLAT", "POINT", "ROUND", "SPOT", "SUN", "light_from"]

# Kinds: a point, a sun, a flat light, a sphere, a spot.
POINT, SUN, FLAT, ROUND, SPOT = 0, 1, 2, 3, 4
# Columns: kind, place (sun: unit direction), unit normal, intensity W/sr (sun: irradiance; area lights: that along the
# normal, radiance times area), radius of a disk of the same area, 1 for two sides. A spot has
# its axis for the normal, and in the last three the cosines of its inner and outer cone and its exponent.
_KIND, _PLACE, _NORMAL, _COLOUR, _RADIUS, _TWO_SIDED = (np.int64(column) for column in (0, 1, 4, 7, 10, 11))
COLUMNS = 13

_ZERO, _ONE = np.float32(0), np.float32(1)
_FAR = np.float32(np.inf)


class Arriving(NamedTuple):
    """Unit direction to a light, distance (inf: beyond all), irradiance of a surface that faces it, tangent of the half
    angle that it is seen under."""

    direction: object
    distance: float
    irradiance: object
    width: float


@device
def _triple(lights, k, column):
    return vec3(lights[k, column], lights[k, column + 1], lights[k, column + 2])


@device
def light_from(lights, k, place, width):
    """What arrives of light `k` at a place; lights without a size are seen under `width`."""
    kind, colour = lights[k, _KIND], _triple(lights, k, _COLOUR)
    if kind == SUN:
        return Arriving(_triple(lights, k, _PLACE), _FAR, colour, width)
    to_light = _triple(lights, k, _PLACE) - place
    distance = max(length(to_light), np.float32(1e-30))
    direction = to_light / distance
    faces = _ONE
    if kind == FLAT:
        faces = -dot(direction, _triple(lights, k, _NORMAL))
        faces = abs(faces) if lights[k, _TWO_SIDED] != _ZERO else max(faces, _ZERO)
    if kind == SPOT:
        cosine = -dot(direction, _triple(lights, k, _NORMAL))
        faces = spot_share(cosine, lights[k, _RADIUS], lights[k, _RADIUS + 1], lights[k, _RADIUS + 2])
    elif kind != POINT:
        # The light's outline as it is seen: a flat one is narrower from the side.
        width = lights[k, _RADIUS] * math.sqrt(faces) / distance
    return Arriving(direction, distance, colour * (faces / (distance * distance)), width)
