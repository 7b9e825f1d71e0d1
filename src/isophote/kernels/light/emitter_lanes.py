"""Lights as sixteen places see them at once: flat ones with four corners, points and suns; others go one by one."""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import device
from isophote.kernels.base.simd import absolute, select, splat16, square_root
from isophote.kernels.base.vec import vec3
from isophote.kernels.base.wide import spread, wide_dot
from isophote.kernels.light.emitter import PARALLELOGRAM, POINT, SUN

__all__ = ["sample_lanes", "sampled_in_lanes"]

# Columns of `Lights.values` (emitter.py).
_PLACE, _EDGE1, _EDGE2, _NORMAL, _RADIANCE, _AREA, _TWO_SIDED = (np.int64(k) for k in (0, 3, 6, 9, 12, 15, 16))
_ZERO, _ONE, _FAR = np.float32(0), np.float32(1), np.float32(np.inf)


@device
def sampled_in_lanes(lights, group):
    """Whether a group of rows is one light of a kind that `sample_lanes` knows, and no texture varies it."""
    if lights.groups[group, 1] != 1:
        return False
    row = np.int64(lights.groups[group, 0])
    kind = lights.kinds[row]
    plain = lights.painted.rows == 0 or lights.painted[row] < 0
    return plain and kind in (PARALLELOGRAM, POINT, SUN)


@device
def _triple(values, k, column):
    return vec3(values[k, column], values[k, column + 1], values[k, column + 2])


@device
def sample_lanes(lights, k, place, u, v, share):
    """(direction, distance, arriving, factor) of light `k` as `sample_light` gives it: what arrives, and one over the
    density times `share`, 0 where nothing arrives; of single directions 1."""
    values, kind = lights.values, lights.kinds[k]
    radiance, one = spread(_triple(values, k, _RADIANCE)), splat16(_ONE)
    normal = spread(_triple(values, k, _NORMAL))
    if kind == SUN:
        return normal, splat16(_FAR), radiance, one
    target = spread(_triple(values, k, _PLACE))
    if kind == PARALLELOGRAM:
        target = target + spread(_triple(values, k, _EDGE1)) * u + spread(_triple(values, k, _EDGE2)) * v
    to_light = target - place
    distance2 = wide_dot(to_light, to_light)
    closeness = one / square_root(distance2)
    direction, distance = to_light * closeness, distance2 * closeness
    if kind == POINT:
        return direction, distance, radiance / distance2, one
    cosine = splat16(_ZERO) - wide_dot(direction, normal)
    cosine = absolute(cosine) if values[k, _TWO_SIDED] != _ZERO else cosine
    factor = cosine * splat16(values[k, _AREA] * share) / distance2
    # Nothing from behind, from the light's own plane, or from the place itself.
    shines = (cosine > splat16(_ZERO)) & (closeness < splat16(_FAR))
    return direction, distance, radiance, select(shines, factor, splat16(_ZERO))
