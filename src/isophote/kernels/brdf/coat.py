"""A clear coat: what lies at the top of plastics and of all that is coated.

Its data: index of refraction, 1 where it is smooth, the table of what it reflects (albedo.py). The lobe's slot 0 is its
roughness.
"""

from __future__ import annotations

import numpy as np

from isophote.kernels.base.jit import device
from isophote.kernels.base.vec import dot, normalise, vec3
from isophote.kernels.brdf.albedo import mean_albedo, table_albedo
from isophote.kernels.brdf.contract import datum, number_slot
from isophote.kernels.brdf.microfacet import alpha_of, density_of_normals, masking, visible_normal
from isophote.kernels.light.bsdf import fresnel_dielectric

__all__ = ["coat_albedo", "coat_direction", "coat_highlight", "coat_inside", "coat_ior", "is_smooth"]

_ZERO, _HALF, _ONE, _TWO, _QUARTER = (np.float32(k) for k in (0, 0.5, 1, 2, 0.25))
_IOR, _SMOOTH, _TABLE, _ROUGHNESS = np.int64(0), np.int64(1), np.int64(2), np.int64(0)


@device
def coat_ior(lobe):
    """Index of refraction."""
    return datum(lobe, _IOR)


@device
def is_smooth(lobe):
    """Whether the coat reflects in a single direction."""
    return datum(lobe, _SMOOTH) > _HALF


@device
def coat_albedo(lobe, cosine):
    """What the coat reflects in all."""
    if is_smooth(lobe):
        share, _ = fresnel_dielectric(cosine, coat_ior(lobe))
        return share
    return table_albedo(lobe, _TABLE, number_slot(lobe, _ROUGHNESS), cosine)


@device
def coat_inside(lobe):
    """What of diffuse light from below the coat sends down again: 1 − (1 − Ē) / n², Ē the mean from above."""
    ior = coat_ior(lobe)
    roughness = _ZERO if is_smooth(lobe) else number_slot(lobe, _ROUGHNESS)
    return _ONE - (_ONE - mean_albedo(lobe, _TABLE, roughness)) / (ior * ior)


@device
def coat_highlight(lobe, out, into):
    """(f cosθ, density) of the coat alone; zeros where it is smooth."""
    if is_smooth(lobe) or into.z <= _ZERO:
        return _ZERO, _ZERO
    h = normalise(out + into)
    alpha = alpha_of(number_slot(lobe, _ROUGHNESS))
    density = masking(out, alpha, alpha) * density_of_normals(h, alpha, alpha) * _QUARTER / out.z
    share, _ = fresnel_dielectric(dot(out, h), coat_ior(lobe))
    return share * density * masking(into, alpha, alpha), density


@device
def coat_direction(lobe, out, x, y):
    """A direction that the coat reflects to."""
    if is_smooth(lobe):
        return vec3(-out.x, -out.y, out.z)
    alpha = alpha_of(number_slot(lobe, _ROUGHNESS))
    h = visible_normal(out, alpha, alpha, x, y)
    return h * (_TWO * dot(out, h)) - out
