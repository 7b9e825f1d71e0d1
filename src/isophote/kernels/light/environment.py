"""Light from infinitely far away: a constant, or a picture over longitude and latitude.

Longitude φ and polar angle θ of a direction d (with +y up):
    u = ½ − atan2(x, z) / 2π + rotation,   v = acos(y) / π,   v = 0 at the picture's top row.
"""

from __future__ import annotations

import math

import numpy as np

from isophote.kernels.base.jit import device
from isophote.kernels.base.table import FLOAT, FLOAT_ROWS, FLOATS, INT, Table
from isophote.kernels.base.vec import vec3
from isophote.kernels.base.warp import PI

__all__ = ["ENVIRONMENT", "environment_density", "environment_radiance", "sample_environment"]

_HALF, _ONE, _TWO = np.float32(0.5), np.float32(1), np.float32(2)
_LEAST_SINE = np.float32(1e-6)


# `constant` (3,) is added everywhere; `texels` (height · width, 3), height = 0 where there is no picture;
# `row_shares` (height + 1,), `column_shares` (height, width + 1): cumulative light, by rows and within each row;
# `rotation`: turn of the picture about +y in radians.
ENVIRONMENT = Table(
    "Environment",
    constant=FLOATS,
    texels=FLOAT_ROWS,
    height=INT,
    width=INT,
    row_shares=FLOATS,
    column_shares=FLOAT_ROWS,
    rotation=FLOAT,
)


@device
def _to_uv(environment, d):
    u = _HALF - (math.atan2(d.x, d.z) - environment.rotation) / (_TWO * PI)
    v = math.acos(min(max(d.y, -_ONE), _ONE)) / PI
    return u - math.floor(u), v


@device
def environment_radiance(environment, d):
    """Radiance from the unit direction `d`, the picture's texels bilinearly joined."""
    constant = vec3(environment.constant[0], environment.constant[1], environment.constant[2])
    texels = environment.texels
    height, width = environment.height, environment.width
    if height == 0:
        return constant
    u, v = _to_uv(environment, d)
    x, y = u * np.float32(width) - _HALF, v * np.float32(height) - _HALF
    left, upper = math.floor(x), math.floor(y)
    a, b = np.float32(x - left), np.float32(y - upper)
    i0, i1 = np.int64(left) % width, (np.int64(left) + 1) % width
    j0 = min(max(np.int64(upper), 0), height - 1)
    j1 = min(max(np.int64(upper) + 1, 0), height - 1)
    sum_ = constant
    for at, weight in (
        (j0 * width + i0, (_ONE - a) * (_ONE - b)),
        (j0 * width + i1, a * (_ONE - b)),
        (j1 * width + i0, (_ONE - a) * b),
        (j1 * width + i1, a * b),
    ):
        sum_ = sum_ + vec3(texels[at, 0], texels[at, 1], texels[at, 2]) * weight
    return sum_


@device
def _interval(cdf, x):
    """Largest i with cdf[i] <= x among those of positive share; x in [0, 1)."""
    low, high = 0, cdf.rows - 1
    while high - low > 1:
        middle = (low + high) >> 1
        if cdf[middle] <= x:
            low = middle
        else:
            high = middle
    return low


@device
def environment_density(environment, d):
    """Density of `sample_environment` at the unit direction `d`, per steradian."""
    height, width = environment.height, environment.width
    u, v = _to_uv(environment, d)
    i = min(np.int64(u * np.float32(width)), width - 1)
    j = min(np.int64(v * np.float32(height)), height - 1)
    share = (environment.row_shares[j + 1] - environment.row_shares[j]) * (
        environment.column_shares[j, i + 1] - environment.column_shares[j, i]
    )
    sine = math.sqrt(max(_LEAST_SINE * _LEAST_SINE, _ONE - d.y * d.y))
    return share * np.float32(width * height) / (_TWO * PI * PI * sine)


@device
def sample_environment(environment, u, v):
    """A unit direction with probability in proportion to a texel's light."""
    height, width = environment.height, environment.width
    rows = environment.row_shares
    j = _interval(rows, v)
    y = (np.float32(j) + (v - rows[j]) / (rows[j + 1] - rows[j])) / np.float32(height)
    columns = environment.column_shares[j]
    i = _interval(columns, u)
    x = (np.float32(i) + (u - columns[i]) / (columns[i + 1] - columns[i])) / np.float32(width)
    azimuth = (_HALF - x) * _TWO * PI + environment.rotation
    sine = math.sin(PI * y)
    return vec3(sine * math.sin(azimuth), math.cos(PI * y), sine * math.cos(azimuth))
