"""Rays out of the camera.

A camera is one linear map from the film (px, py in pixels, y down) and the lens (a, b in the unit disk) to a ray:

    origin    = o + px ox + py oy + a oa + b ob
    direction = d + px dx + py dy + a da + b db

`camera` holds the ten vectors in this order as (10, 3) float32. A direction's part along the axis of view has
length 1, so that the distance t along it is the depth.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import device
from isophote.kernels.base.vec import maximum_component, vec3
from isophote.kernels.base.wide import spread

__all__ = ["camera_ray", "camera_rays", "has_lens"]

# NumPy integers: Numba would compile what takes a plain constant anew for each of its values.
_O, _OX, _OY, _OA, _OB, _D, _DX, _DY, _DA, _DB = (np.int64(row) for row in range(10))


@device
def _row(camera, k):
    return vec3(camera[k, 0], camera[k, 1], camera[k, 2])


@device
def camera_ray(camera, px, py, a, b):
    """(origin, direction) for a place on the film and one on the lens."""
    on_lens = a * _row(camera, _OA) + b * _row(camera, _OB)
    bent = a * _row(camera, _DA) + b * _row(camera, _DB)
    origin = _row(camera, _O) + px * _row(camera, _OX) + py * _row(camera, _OY) + on_lens
    direction = _row(camera, _D) + px * _row(camera, _DX) + py * _row(camera, _DY) + bent
    return origin, direction


@device
def has_lens(camera):
    """Whether it matters where on the lens a ray leaves."""
    most = np.float32(0)
    for k in (_OA, _OB, _DA, _DB):
        row = _row(camera, k)
        most = max(most, maximum_component(vec3(abs(row.x), abs(row.y), abs(row.z))))
    return most > 0


@device
def camera_rays(camera, px, py, a, b):
    """`camera_ray` for sixteen places at once."""
    on_lens = spread(_row(camera, _OA)) * a + spread(_row(camera, _OB)) * b
    bent = spread(_row(camera, _DA)) * a + spread(_row(camera, _DB)) * b
    origin = spread(_row(camera, _O)) + spread(_row(camera, _OX)) * px + spread(_row(camera, _OY)) * py + on_lens
    direction = spread(_row(camera, _D)) + spread(_row(camera, _DX)) * px + spread(_row(camera, _DY)) * py + bent
    return origin, direction
