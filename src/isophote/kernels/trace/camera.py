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
from isophote.kernels.base.vec import vec3

__all__ = ["camera_ray"]

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
