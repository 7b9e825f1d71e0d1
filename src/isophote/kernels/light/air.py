"""The air of a scene where it scatters light: how far rays go in it, what is left of them, and where they go then.

    T(d) = exp(−(σs + σa) d)        p(cosθ) = (1 − g²) / (4π (1 + g² − 2 g cosθ)^(3/2))

Henyey, Greenstein, "Diffuse Radiation in the Galaxy", Astrophysical Journal 93, 1941.
"""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.base.jit import device
from isophote.kernels.base.table import FLOAT, FLOATS, INT, Table
from isophote.kernels.base.vec import orthonormal, vec3
from isophote.kernels.base.warp import PI

__all__ = [
    "AIR",
    "free_flight",
    "left_of_light",
    "phase",
    "phase_direction",
    "reached",
    "scattered_at",
    "way_through_air",
]

# `scattering`, `absorption` (3,): coefficients in 1/m by channels; `box` (6,): the corners of what it fills, which may
# be infinite; `anisotropy`: g; `scatter`, `dim`: the entries of trace/air_rays.py, or 0 where the air is clear.
AIR = Table("Air", scattering=FLOATS, absorption=FLOATS, box=FLOATS, anisotropy=FLOAT, scatter=INT, dim=INT)

_ZERO, _ONE, _TWO = np.float32(0), np.float32(1), np.float32(2)
_FAR = np.float32(np.inf)
_QUARTER = np.float32(0.25)
# Of a smaller anisotropy the inversion would cancel, and it is not seen.
_ISOTROPIC = np.float32(1e-3)


@device
def _slab(low, high, origin, direction, near, far):
    if direction == _ZERO:
        return (near, far) if low <= origin and origin <= high else (near, -_ONE)
    a, b = (low - origin) / direction, (high - origin) / direction
    return max(near, min(a, b)), min(far, max(a, b))


@device
def way_through_air(air, origin, direction, end):
    """(near, far): the part of a ray before `end` that lies in the medium; far is not above near where none does."""
    box = air.box
    near, far = _ZERO, end
    near, far = _slab(box[0], box[3], origin.x, direction.x, near, far)
    near, far = _slab(box[1], box[4], origin.y, direction.y, near, far)
    return _slab(box[2], box[5], origin.z, direction.z, near, far)


@device
def _left(coefficient, distance):
    return np.float32(math.exp(-coefficient * distance)) if coefficient > _ZERO else _ONE


@device
def left_of_light(air, distance):
    """T after so many metres of the medium."""
    s, a = air.scattering, air.absorption
    return vec3(_left(s[0] + a[0], distance), _left(s[1] + a[1], distance), _left(s[2] + a[2], distance))


@device
def reached(air, shares, distance):
    """Densities by channels of a ray that is not scattered within a distance, each times its share."""
    s = air.scattering
    left = vec3(_left(s[0], distance), _left(s[1], distance), _left(s[2], distance))
    return shares * left


@device
def scattered_at(air, shares, distance):
    """Densities by channels of a ray that is scattered after a distance, each times its share."""
    return reached(air, shares, distance) * vec3(air.scattering[0], air.scattering[1], air.scattering[2])


@device
def free_flight(air, shares, u, v):
    """The distance by `u` to where light is scattered, of a channel that is picked by its share; infinite where that is
    never scattered."""
    at = v * (shares.x + shares.y + shares.z)
    channel = np.int64(at >= shares.x) + np.int64(at >= shares.x + shares.y)
    coefficient = air.scattering[channel]
    return np.float32(-math.log(_ONE - u)) / coefficient if coefficient > _ZERO else _FAR


@device
def phase(air, cosine):
    """p for the cosine between the ways of light before and after, per steradian."""
    g = air.anisotropy
    below = _ONE + g * g - _TWO * g * cosine
    return (_ONE - g * g) * _QUARTER / (PI * below * np.float32(math.sqrt(below)))


@device
def phase_direction(air, direction, x, y):
    """(direction, density) of light scattered out of a unit direction, by a point of the unit disk."""
    g = air.anisotropy
    u = min(x * x + y * y, _ONE)
    if abs(g) < _ISOTROPIC:
        cosine = _ONE - _TWO * u
    else:
        part = (_ONE - g * g) / (_ONE + g - _TWO * g * u)
        cosine = (_ONE + g * g - part * part) / (_TWO * g)
    cosine = min(max(cosine, -_ONE), _ONE)
    # Of the disk only the angle is left to use; its middle has none.
    size = np.float32(math.sqrt(max(_ZERO, _ONE - cosine * cosine))) / np.float32(math.sqrt(max(u, np.float32(1e-20))))
    tangent, bitangent = orthonormal(direction)
    into = tangent * (x * size) + bitangent * (y * size) + direction * cosine
    return into, phase(air, cosine)
