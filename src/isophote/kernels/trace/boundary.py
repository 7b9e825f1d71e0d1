"""Boundaries between clear media as rays meet them."""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import device
from isophote.kernels.base.vec import dot, store_vec3, vec3
from isophote.kernels.brdf import contract
from isophote.kernels.light.bsdf import GLASS, LINKED, fresnel_dielectric
from isophote.kernels.light.medium import medium_ior
from isophote.kernels.trace.shading import seen_normal

__all__ = ["goes_smoothly", "set_relative_index", "split_ray"]

_ZERO, _ONE = np.float32(0), np.float32(1)


@device
def goes_smoothly(tables, material, boundary):
    """Whether a ray meets a smooth boundary of clear media: facets of a rough one that does not bend light are none."""
    kind = tables.materials.kinds[material]
    if kind == GLASS:
        return True
    if kind != LINKED or tables.media.of_material[material] == 0:
        return False
    return medium_ior(tables.media, boundary.before) == medium_ior(tables.media, boundary.behind)


@device
def set_relative_index(tables, material, boundary, entering, scratch):
    """Give rough glass, once prepared, its index of refraction relative to the medium around it; the first of its
    parameters."""
    if tables.media.of_material[material] == 0:
        return
    ratio = medium_ior(tables.media, boundary.behind) / medium_ior(tables.media, boundary.before)
    ior = ratio if entering else _ONE / ratio
    store_vec3(scratch, contract.PARAMETERS, vec3(ior, ior, ior))


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
