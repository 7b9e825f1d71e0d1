"""Lights as a table: how one is picked, sampled from a point, and how likely that was.

One switch over the kinds lives in `sample_light` and one in `light_density`; a test walks over all kinds.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from isophote.kernels.base.jit import device
from isophote.kernels.base.table import FLOAT_ROWS, FLOATS, INT, INT_ROWS, INTS, Table
from isophote.kernels.base.vec import dot, length, normalise, orthonormal, vec3
from isophote.kernels.base.warp import PI, to_cone, to_disk, to_triangle
from isophote.kernels.light import environment as sky
from isophote.kernels.light.environment import (
    environment_density,
    environment_radiance,
    sample_environment,
)
from isophote.kernels.light.light_tree_layout import LIGHT_TREE

__all__ = [
    "DISK",
    "ENVIRONMENT",
    "LIGHTS",
    "PARALLELOGRAM",
    "POINT",
    "SPHERE",
    "SPOT",
    "SUN",
    "TRIANGLE",
    "LightSample",
    "closest_lamp",
    "lamp_blocks",
    "lamp_normal",
    "lamp_radiance",
    "light_density",
    "pick_light",
    "sample_group",
    "sample_light",
    "spot_share",
]

TRIANGLE, PARALLELOGRAM, DISK, SPHERE, POINT, SUN, ENVIRONMENT, SPOT = 0, 1, 2, 3, 4, 5, 6, 7

# Columns of `Lights.values`: a place, two edges, the unit normal (spot: its axis), radiance (point: intensity, spot:
# intensity on the axis, sun: irradiance), the area, 1 for two sides, the radius of a sphere. A spot has the cosines of
# its inner and outer cone and its exponent in place of the first edge.
_PLACE, _EDGE1, _EDGE2, _NORMAL, _RADIANCE, _AREA, _TWO_SIDED, _RADIUS = (
    np.int64(column) for column in (0, 3, 6, 9, 12, 15, 16, 17)
)

_ZERO, _ONE, _TWO, _THREE = np.float32(0), np.float32(1), np.float32(2), np.float32(3)
_FAR, _ONE_BELOW = np.float32(np.inf), np.float32(1 - 2.0**-24)


# `kinds` (n,); `values` (n, 18), columns above; `cdf` (n + 1,): cumulative chances of being picked, from 0, or from the
# chance of the tree, where that picks among all lights but those infinitely far away; `lamps`: the disks and spheres,
# which rays meet without a tree; `numbers` (n,): the user's number of each light.
# `groups` (m, 4): the rows that are one light to the user, as first and count, 1 where that has a size, and its number;
# `shares` (n,): where a row's part begins within its group, in proportion to power, from 0 to 1.
# `painted` (n,), or empty where no texture varies a light: the row of `paint` (p, 18), or −1: texture coordinates at
# the first corner and along both edges, and the affine map to the shape's own space; `paint_materials` (p,): the
# material that has the texture; `tint`: the entry of trace/painted_lights.py.
LIGHTS = Table(
    "Lights",
    kinds=INTS,
    values=FLOAT_ROWS,
    cdf=FLOATS,
    lamps=INTS,
    numbers=INTS,
    groups=INT_ROWS,
    shares=FLOATS,
    environment=sky.ENVIRONMENT,
    tree=LIGHT_TREE,
    painted=INTS,
    paint=FLOAT_ROWS,
    paint_materials=INTS,
    tint=INT,
)


class LightSample(NamedTuple):
    """Unit direction to the light and its distance (inf: infinitely far), what arrives from there, density per
    steradian (0: the light is a single direction; negative: nothing arrives)."""

    x: float
    y: float
    z: float
    distance: float
    red: float
    green: float
    blue: float
    density: float


@device
def _triple(values, k, column):
    return vec3(values[k, column], values[k, column + 1], values[k, column + 2])


@device
def pick_light(lights, u):
    """(number, chance, u stretched again to [0, 1)) of the light that `u` falls on."""
    cdf = lights.cdf
    # Halving without a branch that could be guessed wrong.
    low, count = 0, cdf.rows - 1
    while count > 1:
        half = count >> 1
        low += half if cdf[low + half] <= u else 0
        count -= half
    chance = cdf[low + 1] - cdf[low]
    return low, chance, (u - cdf[low]) / chance


@device
def _nothing():
    return LightSample(_ZERO, _ONE, _ZERO, _ZERO, _ZERO, _ZERO, _ZERO, -_ONE)


@device
def _arrives(direction, distance, radiance, density):
    return LightSample(
        direction.x, direction.y, direction.z, distance, radiance.x, radiance.y, radiance.z, np.float32(density)
    )


@device
def _sample_flat(values, k, point, place):
    """A place on a flat light, seen from `point`."""
    to_light = place - point
    distance2 = dot(to_light, to_light)
    closeness = math.sqrt(_ONE / distance2)
    direction = to_light * closeness
    cosine = -dot(direction, _triple(values, k, _NORMAL))
    if values[k, _TWO_SIDED] != _ZERO:
        cosine = abs(cosine)
    # Nothing from behind, from the light's own plane, or from the place itself. No branch: it would be guessed wrong.
    density = distance2 / (cosine * values[k, _AREA]) if (cosine > _ZERO) & (closeness < _FAR) else -_ONE
    return _arrives(direction, distance2 * closeness, _triple(values, k, _RADIANCE), density)


@device
def _cone_of_sphere(values, k, point):
    """1 − cosine of the half angle under which a sphere is seen, as sin² / (1 + cos); negative from inside."""
    to_centre = _triple(values, k, _PLACE) - point
    distance2 = dot(to_centre, to_centre)
    radius = values[k, _RADIUS]
    if distance2 <= radius * radius:
        return -_ONE
    sine2 = radius * radius / distance2
    return sine2 / (_ONE + math.sqrt(_ONE - sine2))


@device
def _sample_sphere(values, k, point, u, v):
    """A direction uniform in the cone under which a sphere is seen from outside."""
    height = _cone_of_sphere(values, k, point)
    if height <= _ZERO:
        return _nothing()
    to_centre = _triple(values, k, _PLACE) - point
    distance = length(to_centre)
    axis = to_centre / distance
    local = to_cone(u, v, height)
    tangent, bitangent = orthonormal(axis)
    direction = tangent * local.x + bitangent * local.y + axis * local.z
    radius = values[k, _RADIUS]
    across2 = distance * distance * (local.x * local.x + local.y * local.y)
    reach = distance * local.z - math.sqrt(max(_ZERO, radius * radius - across2))
    return _arrives(direction, reach, _triple(values, k, _RADIANCE), _ONE / (_TWO * PI * height))


@device
def _sample_point(values, k, point):
    to_light = _triple(values, k, _PLACE) - point
    distance = length(to_light)
    return _arrives(to_light / distance, distance, _triple(values, k, _RADIANCE) / (distance * distance), _ZERO)


@device
def spot_share(cosine, inner, outer, exponent):
    """Intensity of a spot at an angle of this cosine from its axis, in parts of that on the axis: cosᵐ within the inner
    cone, smoothly to nothing at the outer one; both by their cosines."""
    if cosine < outer or cosine <= _ZERO:
        return _ZERO
    u = (cosine - outer) / (inner - outer) if cosine < inner else _ONE
    return u * u * (_THREE - _TWO * u) * math.pow(cosine, exponent)


@device
def _sample_spot(values, k, point):
    to_light = _triple(values, k, _PLACE) - point
    distance = length(to_light)
    direction = to_light / distance
    cosine = -dot(direction, _triple(values, k, _NORMAL))
    share = spot_share(cosine, values[k, _EDGE1], values[k, _EDGE1 + 1], values[k, _EDGE1 + 2])
    if share <= _ZERO:
        return _nothing()
    return _arrives(direction, distance, _triple(values, k, _RADIANCE) * (share / (distance * distance)), _ZERO)


@device
def sample_light(lights, k, point, u, v):
    """Light `k` as it is sampled from `point`."""
    kind, values = lights.kinds[k], lights.values
    if kind == TRIANGLE:
        a, b = to_triangle(u, v)
        place = _triple(values, k, _PLACE) + a * _triple(values, k, _EDGE1) + b * _triple(values, k, _EDGE2)
        return _sample_flat(values, k, point, place)
    if kind == PARALLELOGRAM:
        place = _triple(values, k, _PLACE) + u * _triple(values, k, _EDGE1) + v * _triple(values, k, _EDGE2)
        return _sample_flat(values, k, point, place)
    if kind == DISK:
        a, b = to_disk(u, v)
        place = _triple(values, k, _PLACE) + a * _triple(values, k, _EDGE1) + b * _triple(values, k, _EDGE2)
        return _sample_flat(values, k, point, place)
    if kind == SPHERE:
        return _sample_sphere(values, k, point, u, v)
    if kind == POINT:
        return _sample_point(values, k, point)
    if kind == SPOT:
        return _sample_spot(values, k, point)
    if kind == SUN:
        return _arrives(_triple(values, k, _NORMAL), _FAR, _triple(values, k, _RADIANCE), _ZERO)
    direction = sample_environment(lights.environment, u, v)
    density = environment_density(lights.environment, direction)
    if density <= _ZERO:
        return _nothing()
    return _arrives(direction, _FAR, environment_radiance(lights.environment, direction), density)


@device
def sample_group(lights, group, point, u, v):
    """(row, chance, sample) of the light that a group of rows is, as seen from `point`: `u` picks one of them in
    proportion to its power."""
    low, count = np.int64(lights.groups[group, 0]), np.int64(lights.groups[group, 1])
    end = low + count
    shares = lights.shares
    # As in pick_light.
    while count > 1:
        half = count >> 1
        low += half if shares[low + half] <= u else 0
        count -= half
    chance = (shares[low + 1] if low + 1 < end else _ONE) - shares[low]
    sample = sample_light(lights, low, point, min((u - shares[low]) / chance, _ONE_BELOW), v)
    return low, chance, sample


@device
def light_density(lights, k, point, to_light):
    """Density per steradian with which `sample_light` gives the direction of `to_light`, a vector from `point` to the
    place on light `k` (any length for the environment)."""
    kind, values = lights.kinds[k], lights.values
    if kind == SPHERE:
        height = _cone_of_sphere(values, k, point)
        return _ONE / (_TWO * PI * height) if height > _ZERO else _ZERO
    if kind == ENVIRONMENT:
        return environment_density(lights.environment, normalise(to_light))
    distance2 = dot(to_light, to_light)
    cosine = abs(dot(to_light, _triple(values, k, _NORMAL)))
    return distance2 * math.sqrt(distance2) / (max(cosine, np.float32(1e-12)) * values[k, _AREA])


@device
def lamp_normal(lights, k, point):
    """Unit outward normal of a disk or sphere light at a point on it."""
    if lights.kinds[k] == DISK:
        return _triple(lights.values, k, _NORMAL)
    return normalise(point - _triple(lights.values, k, _PLACE))


@device
def lamp_radiance(lights, k, point, direction):
    """What a disk or sphere light sends against the ray `direction` that meets it at `point`: nothing from behind."""
    if lights.values[k, _TWO_SIDED] == _ZERO and dot(direction, lamp_normal(lights, k, point)) >= _ZERO:
        return vec3(_ZERO, _ZERO, _ZERO)
    return _triple(lights.values, k, _RADIANCE)


@device
def _meet_disk(values, k, origin, direction, t_max):
    normal = _triple(values, k, _NORMAL)
    away = dot(direction, normal)
    if away == _ZERO:
        return t_max
    t = dot(_triple(values, k, _PLACE) - origin, normal) / away
    if not (t > _ZERO and t < t_max):
        return t_max
    arm = origin + t * direction - _triple(values, k, _PLACE)
    edge = _triple(values, k, _EDGE1)
    return t if dot(arm, arm) <= dot(edge, edge) else t_max


@device
def _meet_sphere(values, k, origin, direction, t_max):
    """Nearest root of |o + t d − c| = r, with the discriminant taken from the closest point, which does not cancel
    (Haines et al., "Precision Improvements for Ray/Sphere Intersection", Ray Tracing Gems 7, 2019)."""
    to_centre = _triple(values, k, _PLACE) - origin
    a = dot(direction, direction)
    b = dot(to_centre, direction)
    radius = values[k, _RADIUS]
    off = to_centre - direction * (b / a)
    discriminant = radius * radius - dot(off, off)
    if discriminant < _ZERO:
        return t_max
    c = dot(to_centre, to_centre) - radius * radius
    q = b + math.copysign(math.sqrt(a * discriminant), b)
    first, second = c / q, q / a
    near, far = min(first, second), max(first, second)
    t = near if near > _ZERO else far
    return t if (t > _ZERO and t < t_max) else t_max


@device
def closest_lamp(lights, origin, direction, t_max):
    """(t, number) of the first disk or sphere light at 0 < t < t_max; number −1 for none."""
    nearest = np.int64(-1)
    for i in range(lights.lamps.rows):
        k = np.int64(lights.lamps[i])
        if lights.kinds[k] == DISK:
            t = _meet_disk(lights.values, k, origin, direction, t_max)
        else:
            t = _meet_sphere(lights.values, k, origin, direction, t_max)
        if t < t_max:
            t_max, nearest = t, k
    return t_max, nearest


@device
def lamp_blocks(lights, origin, direction, t_max):
    """Whether a disk or sphere light stands in the way at 0 < t < t_max."""
    if lights.lamps.rows == 0:
        return False
    return closest_lamp(lights, origin, direction, t_max)[1] >= 0
