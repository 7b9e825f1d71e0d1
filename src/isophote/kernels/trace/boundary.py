"""The two rays that leave a smooth boundary between clear media."""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import device
from isophote.kernels.base.vec import dot
from isophote.kernels.light.bsdf import fresnel_dielectric
from isophote.kernels.trace.shading import seen_normal

__all__ = ["split_ray"]

_ZERO = np.float32(0)


@device
def _split(direction, normal, ratio):
    """(share, reflected, refracted) at a boundary with this normal."""
    cosine = -dot(direction, normal)
    facing = normal if cosine > _ZERO else -normal
    cosine = abs(cosine)
    share, inside = fresnel_dielectric(cosine, ratio)
    reflected = direction + facing * (cosine + cosine)
    refracted = direction / ratio + facing * (cosine / ratio - inside)
    return share, reflected, refracted


@device
def split_ray(surface, direction, ratio):
    """(share, reflected, refracted): what a boundary reflects of a ray, and where that and the rest go; `ratio` is the
    index of refraction behind it over that before it.

    By the shading normal, unless that would lead a ray to the wrong side of the true surface.
    """
    share, reflected, refracted = _split(direction, seen_normal(surface, direction), ratio)
    side = dot(direction, surface.normal)
    if dot(reflected, surface.normal) * side > _ZERO or dot(refracted, surface.normal) * side < _ZERO:
        return _split(direction, surface.normal, ratio)
    return share, reflected, refracted
