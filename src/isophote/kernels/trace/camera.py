"""Rays out of the camera.

A camera is one linear map from the film (px, py in pixels, y down) and the lens (a, b in the unit disk) to a ray:

    origin    = o + px ox + py oy + a oa + b ob
    direction = d + px dx + py dy + a da + b db

`camera` holds the ten vectors in this order as (10, 3) float32. A direction's part along the axis of view has
length 1, so that the distance t along it is the depth.
"""

from __future__ import annotations

from isophote.kernels.base.jit import device
from isophote.kernels.base.vec import vec3

__all__ = ["camera_ray"]


@device
def _row(camera, k):
    return vec3(camera[k, 0], camera[k, 1], camera[k, 2])


@device
def camera_ray(camera, px, py, a, b):
    """(origin, direction) for a place on the film and one on the lens."""
    origin = _row(camera, 0) + px * _row(camera, 1) + py * _row(camera, 2) + a * _row(camera, 3) + b * _row(camera, 4)
    direction = (
        _row(camera, 5) + px * _row(camera, 6) + py * _row(camera, 7) + a * _row(camera, 8) + b * _row(camera, 9)
    )
    return origin, direction
